//! Every citation of the theory names a section that `shared/THEORY.md` has.
//!
//! A citation is the word "theory", a comma, "section" and one or more section numbers, in any text file
//! of the repository; it may span several lines of a comment. Cross-references inside the theory are
//! checked as well.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Begins a citation in other files.
const CITATION: &str = "theory, section";
/// Begins a cross-reference inside the theory.
const CROSS_REFERENCE: &str = "section";
/// There were 62 citations when this test was written. Far fewer mean that the search is broken.
const FEWEST: usize = 40;

/// The tracked source and documentation files.
fn sources(root: &Path) -> Vec<PathBuf> {
    let listed = Command::new("git")
        .args(["ls-files", "-z", "--", "*.rs", "*.md", "*.toml", "*.py"])
        .current_dir(root)
        .output()
        .expect("git lists the files");
    assert!(listed.status.success(), "git ls-files: {}", listed.status);
    let names = String::from_utf8(listed.stdout).expect("file names are UTF-8");
    names.split_terminator('\0').map(|name| root.join(name)).collect()
}

/// A text without line breaks and comment markers.
struct FlatText {
    text: String,
    /// Offset of each line.
    lines: Vec<usize>,
}

impl FlatText {
    fn new(text: &str) -> Self {
        let mut flat = Self { text: String::new(), lines: Vec::new() };
        for line in text.lines() {
            flat.lines.push(flat.text.len());
            let line = line.trim().trim_start_matches(['/', '!', '#', '*', '>']);
            for word in line.split_whitespace() {
                flat.text.push_str(&word.to_lowercase());
                flat.text.push(' ');
            }
        }
        flat
    }

    /// The numbers after each `phrase`, with their lines. A phrase without a number is not a citation.
    fn cited(&self, phrase: &str) -> Vec<(usize, String)> {
        let mut citations = Vec::new();
        for (at, _) in self.text.match_indices(phrase) {
            let line = self.lines.partition_point(|&start| start <= at);
            let rest = &self.text[at + phrase.len()..];
            let (several, rest) = rest.strip_prefix('s').map_or((false, rest), |rest| (true, rest));
            let count = if several { usize::MAX } else { 1 };
            citations.extend(numbers(rest).into_iter().take(count).map(|number| (line, number)));
        }
        citations
    }
}

/// Parses ` 4`, ` 6 and 7` or ` 2, 4.1 and 9` into section numbers.
fn numbers(text: &str) -> Vec<String> {
    let mut sections = Vec::new();
    for word in text.split(' ').skip(1) {
        let number = word.trim_end_matches(|c: char| !c.is_ascii_digit());
        let is_number = number.split('.').all(|part| part.parse::<u8>().is_ok());
        match word {
            "and" | "to" if !sections.is_empty() => {}
            _ if is_number => {
                sections.push(number.to_owned());
                // After a comma another number may follow; any other punctuation ends the citation.
                if !matches!(&word[number.len()..], "" | ",") {
                    break;
                }
            }
            _ => break,
        }
    }
    sections
}

/// The section numbers of the headings: `## 4 Title`, `### 6.1 Title`.
fn headings(theory: &str) -> BTreeSet<String> {
    let numbers = theory.lines().filter_map(|line| line.strip_prefix("##"));
    numbers
        .filter_map(|rest| rest.trim_start_matches('#').split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_citation_of_the_theory_resolves() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let theory = root.join("shared/THEORY.md");
    let text = std::fs::read_to_string(&theory).expect("the theory");
    let sections = headings(&text);
    let mut citations = 0;
    let mut unresolved = Vec::new();
    let mut look_up = |file: &Path, cited: Vec<(usize, String)>| {
        for (line, number) in cited {
            if !sections.contains(&number) {
                let file = file.strip_prefix(root).unwrap_or(file).display();
                unresolved.push(format!("{file}:{line}: the theory has no section {number}"));
            }
        }
    };
    for file in sources(root) {
        // A deleted file that is still tracked is skipped.
        let Ok(text) = std::fs::read_to_string(&file) else { continue };
        let cited = FlatText::new(&text).cited(CITATION);
        citations += cited.len();
        look_up(&file, cited);
    }
    look_up(&theory, FlatText::new(&text).cited(CROSS_REFERENCE));
    println!("{citations} citations of the theory");
    assert!(unresolved.is_empty(), "{}", unresolved.join("\n"));
    assert!(citations >= FEWEST, "only {citations} citations found");
}

#[test]
fn the_theory_has_its_twelve_sections() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let text = std::fs::read_to_string(root.join("shared/THEORY.md")).expect("the theory");
    let sections = headings(&text);
    let missing: Vec<_> = (1..=12).filter(|n: &u8| !sections.contains(&n.to_string())).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn a_citation_may_be_broken_over_lines_and_name_several_sections() {
    let text = [
        "/// As told in the (theory,",
        "/// section 4). Theory, sections 2,",
        "//! 6.1 and 9; marks 5.",
    ]
    .join("\n");
    let cited = FlatText::new(&text).cited(CITATION);
    let expected = [(1, "4"), (2, "2"), (2, "6.1"), (2, "9")];
    assert_eq!(cited, expected.map(|(line, number)| (line, number.to_owned())));
}

#[test]
fn a_number_of_something_else_is_no_section() {
    let citation_count = |text: &str| FlatText::new(text).cited(CITATION).len();
    assert_eq!(citation_count("theory, section four"), 0);
    assert_eq!(citation_count("Matrix Computations, section 5"), 0);
    assert_eq!(citation_count("theory, section 9, 12 Hz"), 1);
}
