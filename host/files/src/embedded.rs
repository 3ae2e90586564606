//! Results inside an HTML report: how the page holds them, and how they are read again.
//!
//! A report holds the archive or the document of each of its results, so that it can be solved, exported and drawn like
//! the file that it was made of. Of several results, `report.html#result-2` is the second one; in a browser the same
//! address leads to its place in the page. Only the records of single hits are left out: they would take most of the
//! page.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::file;

/// What stands before the number of a result, and before and after its JSON text. HTML that follows a title or another
/// text cannot have it, because there `<` is escaped.
const OPEN: &str = "<script type=\"application/json\" id=\"data-";
const CLOSE: &str = "</script>";
/// The first bytes of a report.
pub const DOCTYPE: &str = "<!DOCTYPE html>";
/// What stands before the number of a result behind the name of a report.
const FRAGMENT: &str = "#result-";

/// The element that holds a result, a JSON text; the results of a page are numbered from 1.
pub fn element(number: usize, json: &str) -> String {
    // In a JSON text, `<` stands in strings only; nothing in the element can then end it.
    let json = json.trim_end().replace('<', "\\u003c");
    format!("{OPEN}{number}\">{json}{CLOSE}")
}

/// The results in a page.
fn results(page: &str) -> Vec<&str> {
    let after = page.split(OPEN).skip(1);
    let inside = after.filter_map(|rest| {
        let (_, json) = rest.split_once("\">")?;
        Some(json.split_once(CLOSE)?.0)
    });
    inside.collect()
}

/// The bytes of a file of at most `most` bytes; of a report, those of its result.
///
/// # Errors
/// As [`file::read`]; for a page without a result, and for one with several results of which none is named.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let (file, number) = named(path);
    let bytes = file::read(&file, most)?;
    if !bytes.starts_with(DOCTYPE.as_bytes()) {
        return match number {
            None => Ok(bytes),
            Some(_) => Err(io::Error::other("only a report of massline has results by number")),
        };
    }
    let page = String::from_utf8_lossy(&bytes);
    let results = results(&page);
    let (count, name) = (results.len(), file.display());
    let choice = match (count, number) {
        (0, _) if !page.trim_end().ends_with("</html>") => Err(
            "this page holds no result of massline: its end is missing, so copy or write it again"
                .to_owned(),
        ),
        (0, _) => Err("this page holds no result of massline".to_owned()),
        (1, None) => Ok(1),
        (_, None) => {
            Err(format!("this report holds {count} results; name one, such as {name}{FRAGMENT}1"))
        }
        (_, Some(number)) if (1..=count).contains(&number) => Ok(number),
        (1, Some(number)) => Err(format!(
            "this report holds one result, {name}{FRAGMENT}1, and {number} is none of it"
        )),
        (_, Some(number)) => Err(format!(
            "this report holds {count} results, {name}{FRAGMENT}1 to {FRAGMENT}{count}, and {number} is none of them"
        )),
    };
    let number = choice.map_err(io::Error::other)?;
    Ok(results[number - 1].as_bytes().to_vec())
}

/// Whether the result in a report begins like this; false for any other file, and a pipe is not read.
pub fn begins_with(path: &Path, first: &str, most: u64) -> bool {
    if !is_page(path) {
        return false;
    }
    let (file, number) = named(path);
    let Ok(bytes) = file::read(&file, most) else { return false };
    let page = String::from_utf8_lossy(&bytes);
    let place = number.unwrap_or(1).saturating_sub(1);
    results(&page).get(place).is_some_and(|result| result.starts_with(first))
}

/// Whether a file is a page, such as a report; a pipe is not read.
pub fn is_page(path: &Path) -> bool {
    let (file, _) = named(path);
    let mut head = [0; DOCTYPE.len()];
    file.is_file()
        && File::open(&file).and_then(|mut file| file.read_exact(&mut head)).is_ok()
        && head == *DOCTYPE.as_bytes()
}

/// A name for files that are made of a result: that of its file without the extension, with its number in a report.
pub fn stem(path: &Path) -> String {
    let (file, number) = named(path);
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    number.map_or_else(|| stem.clone().into_owned(), |number| format!("{stem}-result-{number}"))
}

/// True when a result is in the file of this path.
pub fn is_file_of(result: &Path, path: &Path) -> bool {
    let [result, path] = [named(result).0.as_path(), path].map(std::fs::canonicalize);
    result.ok().zip(path.ok()).is_some_and(|(result, path)| result == path)
}

/// The file of a name, and the number of the result behind it; a file that exists under the whole name is that file.
fn named(path: &Path) -> (PathBuf, Option<usize>) {
    let whole = (path.to_owned(), None);
    let Some(text) = path.to_str().filter(|_| !path.exists()) else { return whole };
    let Some((file, number)) = text.rsplit_once(FRAGMENT) else { return whole };
    number.parse().map_or(whole, |number| (file.into(), Some(number)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page with these results.
    fn page(results: &[&str]) -> String {
        let elements = (1..).zip(results).map(|(number, json)| element(number, json));
        format!("{DOCTYPE}<title>&lt;script></title>{}", elements.collect::<String>())
    }

    fn read_page(page: &str, fragment: &str) -> io::Result<String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("report.html");
        std::fs::write(&file, page).unwrap();
        let path = format!("{}{fragment}", file.display());
        read(Path::new(&path), 1 << 20).map(|bytes| String::from_utf8(bytes).unwrap())
    }

    #[test]
    fn a_result_reads_back_whatever_its_texts_are() {
        let title = "a</script><script>alert(1)</script><!-- \u{202e}";
        let json = serde_json::json!({ "title": title }).to_string();
        let read = read_page(&page(&[&json]), "").unwrap();
        assert!(!read.contains('<'));
        let value: serde_json::Value = serde_json::from_str(&read).unwrap();
        assert_eq!(value["title"], title);
    }

    #[test]
    fn of_several_results_one_is_named() {
        let both = page(&["{\"a\":1}", "{\"a\":2}"]);
        assert_eq!(read_page(&both, "#result-2").unwrap(), "{\"a\":2}");
        let message = |page: &str, fragment| read_page(page, fragment).unwrap_err().to_string();
        assert!(message(&both, "").contains("report.html#result-1"));
        let third = message(&both, "#result-3");
        assert!(
            third.contains("2 results") && third.contains("#result-2, and 3 is none"),
            "{third}"
        );
        assert!(message(&both, "#result-0").contains("and 0"));
        assert!(message(&page(&[]), "").contains("no result"));
        assert!(message("{}", "#result-1").contains("only a report"));
    }

    #[test]
    fn files_that_are_made_of_a_result_are_called_after_its_number() {
        assert_eq!(stem(Path::new("a/frame.massline")), "frame");
        assert_eq!(stem(Path::new("a/both.html#result-2")), "both-result-2");
    }

    #[test]
    fn a_file_that_is_no_report_is_read_as_it_is() {
        assert_eq!(read_page("{\"a\":1}", "").unwrap(), "{\"a\":1}");
    }
}
