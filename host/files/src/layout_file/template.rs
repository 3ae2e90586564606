//! The output of `layout new`.

use massline_shared::layout::{
    HitPolicy, TARGET_KEYS, TEST_KEYS, TestForm, TestProfile, TestSettings, TestValue,
    UncertaintyKey, UncertaintyUnit, uncertainty_keys,
};

use super::keyed::alternatives;

/// The template without the keys that massline-shared lists.
const FRAME: &str = include_str!("template.toml");
/// The lines of the frame behind which keys of tables stand.
const TEST: &str = "\n[test]\n";
const POLICY: &str = "\n[policy]\n";
const BUDGET: &str = "\nlearn = true                      # correct this budget from the data; false uses it as it \
     is\n";
const TARGET: &str = "\n# [target]\n";
/// Where comments begin, and where their lines end.
const COLUMN: usize = 34;
const WIDTH: usize = 100;

/// The hits of the frame, and more of them for the suspension profile, so that each of the six modes is moved by one.
const HITS: &str = "hits = [\"1:+Y\", \"2:+Z\", \"4:+X\"]";
const MORE_HITS: &str = "hits = [\"1:+Y\", \"2:+Z\", \"4:+X\", \"3:+Z\", \"4:-Y\"]";

/// A commented layout file of this profile to start from; it is valid and can be used for a measurement.
pub fn template(profile: TestProfile) -> String {
    let defaults = TestSettings::of_profile(profile);
    let test = TEST_KEYS.iter().map(|key| {
        let stated = format!("{} = {}", key.name, value_text(defaults.value(key)));
        match key.form {
            TestForm::Word(choice) => {
                comment_line(&stated, &format!("{}; {}", alternatives(choice.words()), key.meaning))
            }
            TestForm::Number(_) | TestForm::Range(_) => comment_line(&stated, key.meaning),
        }
    });
    let policy = HitPolicy::CODES.iter().map(|&code| {
        format!("{} = \"{}\"\n", code.name(), HitPolicy::default_treatment(code).name())
    });
    let target = TARGET_KEYS
        .iter()
        .map(|key| comment_line(&format!("# {} = {}", key.name, key.example), key.meaning));
    let tables = [
        (TEST, test.collect::<String>()),
        (POLICY, policy.collect()),
        (BUDGET, uncertainty_keys().map(budget_line).collect()),
        (TARGET, target.collect()),
    ];
    let frame = match profile {
        TestProfile::MassLine => FRAME.to_owned(),
        TestProfile::Suspension => FRAME.replacen(HITS, MORE_HITS, 1),
    };
    let with = |text: String, (heading, keys): (&str, String)| {
        text.replacen(heading, &format!("{heading}{keys}"), 1)
    };
    tables.into_iter().fold(frame, with)
}

/// A value as a layout file writes it.
fn value_text(value: TestValue) -> String {
    match value {
        TestValue::Count(count) => count.to_string(),
        TestValue::Number(number) => format!("{number:?}"),
        TestValue::Range(ends) => format!("{ends:?}"),
        TestValue::Word(word) => format!("\"{word}\""),
    }
}

/// A line with a comment, which goes on below where it is long.
fn comment_line(stated: &str, comment: &str) -> String {
    let mut lines = vec![format!("{stated:COLUMN$}#")];
    for word in comment.split(' ') {
        let last = lines.last_mut().expect("there is a first line");
        match last.chars().count() + 1 + word.chars().count() <= WIDTH {
            true => last.extend([" ", word]),
            false => lines.push(format!("{:COLUMN$}# {word}", "")),
        }
    }
    lines.join("\n") + "\n"
}

/// The line of a key of `[uncertainty]` with its default.
fn budget_line(key: &UncertaintyKey) -> String {
    let unit = match key.unit {
        UncertaintyUnit::Relative => ", relative",
        // The key has it.
        UncertaintyUnit::Meters | UncertaintyUnit::Radians => "",
    };
    let only = if key.only_modes { "; for the suspension modes only" } else { "" };
    let stated = format!("{} = {}", key.name, key.default);
    comment_line(&stated, &format!("{}{unit}{only}", key.meaning))
}
