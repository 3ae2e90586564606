use serde::Deserialize;

use super::error::MOST_SHOWN;
use super::*;

#[derive(Deserialize, Debug)]
#[serde(rename_all = "snake_case")]
enum Weighting {
    Force,
    Acceleration,
}

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "the title is not looked at")]
struct File {
    #[serde(default)]
    count: u16,
    #[serde(default)]
    gain: f64,
    #[serde(default)]
    title: String,
    #[serde(default)]
    axis: [f64; 3],
    #[serde(default)]
    nodes: Vec<u16>,
    weighting: Option<Weighting>,
    part: Option<Part>,
    #[serde(default)]
    node: Vec<Part>,
    located: Option<Spanned<Part>>,
}

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct Part {
    id: u16,
    position_m: Option<[f64; 3]>,
}

const NUMBER: &str = "one value stands after the `=`: a number has a decimal point and no unit (0.5), a list has \
                      brackets and commas ([1, 2, 3]), and a remark begins with #";
const WORD: &str =
    "one value stands after the `=`: a text in straight quotes, or true or false in small letters";
const BRACES: &str = "in braces stand `key = value` with commas between them";
const ONCE: &str = "this name stands above already: put these keys there, or, where there can be several such tables, \
                    write the name of each in double brackets";
const LINE: &str =
    "a line is `key = value`, or the name of a table in brackets, or a remark that begins with #";
const TEXT: &str = "a text ends with the quotes that it begins with, and one with a backslash stands in single quotes";
const COMMA: &str = "a comma or a closing bracket is missing before this, or in a line above";
const CONTROL: &str = "an invisible character stands here; delete it";

fn refused(text: &str) -> TomlError {
    read::<File>(text).expect_err(text)
}

/// Asserts what is said of each text: line, key and message.
#[track_caller]
fn check(cases: &[(&str, usize, &str, &str)]) {
    for (text, line, key, message) in cases {
        let error = refused(text);
        let refusal = (error.line(text), error.key.as_str(), error.message.as_str());
        assert_eq!(refusal, (*line, *key, *message), "{text}");
    }
}

#[test]
fn a_value_of_another_kind_is_shown_with_what_belongs_there() {
    let count = "stands where a whole number from 0 to 65535 should";
    for written in ["\"1\"", "1e3", "-1", "70000", "2026-01-01", "[1]"] {
        check(&[(&format!("\ncount = {written}"), 2, "count", &format!("{written} {count}"))]);
    }
    for written in ["true", "\"a `b`, expected c\"", "[1, 2]", "{ a = 1 }", "0x"] {
        let message = format!("{written} stands where a number should");
        check(&[(&format!("gain = {written}"), 1, "gain", &message)]);
    }
    check(&[
        (
            "count = 2.0",
            1,
            "count",
            "2.0 stands where a whole number from 0 to 65535 should, without a decimal point",
        ),
        ("count = 99999999999999999999", 1, "count", "99999999999999999999 is too large"),
        ("gain = -1e309", 1, "gain", "-1e309 is too large"),
        ("axis = [\n[0, 1],\n2, 3]", 2, "axis", "[0, 1] stands where a number should"),
        (
            "nodes = [\n[1],\n2]",
            2,
            "nodes",
            "[1] stands where a whole number from 0 to 65535 should",
        ),
        ("node = [\n[1],\n[2]]", 2, "node", "[1] stands where a table should"),
        (
            "nodes.x = 1",
            1,
            "nodes",
            "one table stands where a list should: of several tables the name of each is in double brackets, \
             and other lists are written `nodes = [1, 2]`",
        ),
        (
            "[[nodes]]\nx = 1",
            1,
            "nodes",
            "a table stands where a whole number from 0 to 65535 should: write `nodes = …`",
        ),
        (
            "[[title]]\nx = 1",
            1,
            "title",
            "a table stands where a text in quotes should: write `title = …`",
        ),
        ("count = [\n1]", 1, "count", "[… stands where a whole number from 0 to 65535 should"),
        ("title = 3", 1, "title", "3 stands where a text in quotes should"),
        ("axis = 3", 1, "axis", "3 stands where a list of 3 values in brackets should"),
        ("axis = [[0, 0, 1], 2, 3]", 1, "axis", "[0, 0, 1] stands where a number should"),
        ("axis = [0,\n1,\n\"2\"]", 3, "axis", "\"2\" stands where a number should"),
        ("nodes = { a = 1 }", 1, "nodes", "{ a = 1 } stands where a list in brackets should"),
        ("nodes = 2026-01-01", 1, "nodes", "2026-01-01 stands where a list in brackets should"),
        ("weighting = 3", 1, "weighting", "3 stands where a text in quotes should"),
        (
            "weighting = { force = 1 }",
            1,
            "weighting",
            "{ force = 1 } stands where a text in quotes should",
        ),
        (
            "[[node]]\nid = 1\n[[node]]\nid = true",
            4,
            "node.id",
            "true stands where a whole number from 0 to 65535 should",
        ),
        (
            "weighting = \"mass\"",
            1,
            "weighting",
            "`mass` is not known here; write `force` or `acceleration`",
        ),
    ]);
}

#[test]
fn a_list_is_no_table_and_has_its_length() {
    check(&[
        ("part = [1]", 1, "part", "[1] stands where a table should"),
        ("part = [1, [0, 0, 0]]", 1, "part", "[1, [0, 0, 0]] stands where a table should"),
        ("node = [[1], [2]]", 1, "node", "[1] stands where a table should"),
        ("located = [1]", 1, "located", "[1] stands where a table should"),
        ("axis = [0, 1]", 1, "axis", "2 values stand where 3 should"),
        ("axis = [0, 1, 2, 3]", 1, "axis", "4 values stand where 3 should"),
        (
            "[part]\nid = 1\nposition_m = [1, 2, 3, 4]",
            3,
            "part.position_m",
            "4 values stand where 3 should",
        ),
    ]);
}

#[test]
fn names_and_headings_of_tables() {
    check(&[
        (
            "gains = 3",
            1,
            "gains",
            "there is no key `gains` here, but `count`, `gain`, `title`, `axis`, `nodes`, `weighting`, `part`, `node` \
             or `located`",
        ),
        ("[part]", 1, "part", "the key `id` is missing"),
        ("count = 1\n[[node]]", 2, "node", "the key `id` is missing"),
        (
            "[[part]]\nid = 1",
            1,
            "part",
            "there is one such table only: write its name in single brackets",
        ),
        (
            "[node]\nid = 1",
            1,
            "node",
            "one table stands where a list should: of several tables the name of each is in double brackets, and other \
             lists are written `node = [1, 2]`",
        ),
        ("[gain]\nid = 1", 1, "gain", "a table stands where a number should: write `gain = …`"),
        ("[part]\nid = 1\n[part]\nid = 2", 3, "", ONCE),
        ("node = []\n[[node]]\nid = 1", 2, "", ONCE),
        ("gain = 1\ngain = 2", 2, "gain", "this key is in the file twice; delete one"),
        ("[node]\nid = 1\n[[node]]\nid = 2", 3, "", ONCE),
    ]);
}

#[test]
fn what_is_no_toml_is_shown_with_what_would_be() {
    for written in [
        "0.5.1",
        "1.",
        ".5",
        "1e",
        "+-1",
        "2026-13-01",
        "−1",
        "(1, 2)",
        "[1 2 3]",
        "[1; 2; 3]",
        "1, 2, 3",
        "0,5",
        "1 kg",
        "1 %",
        "= 3",
        "007",
        "1__0",
        "0X1",
        "[1,, 2]",
    ] {
        check(&[(
            &format!("gain = {written}"),
            1,
            "gain",
            &format!("{written} cannot be read: {NUMBER}"),
        )]);
    }
    for written in ["yes", "TRUE", "half", "“a”", "∞"] {
        check(&[(
            &format!("gain = {written}"),
            1,
            "gain",
            &format!("{written} cannot be read: {WORD}"),
        )]);
    }
    for written in ["\"C:\\data\"", "\"abc", "'abc"] {
        check(&[(
            &format!("title = {written}"),
            1,
            "title",
            &format!("{written} cannot be read: {TEXT}"),
        )]);
    }
    for line in
        ["gain", "gain: 2", "gain 2", "[part", "[[node]", "[]", "[part]]", "= 3", "{ a = 1 }"]
    {
        let error = refused(&format!("count = 1\n{line}"));
        assert_eq!(error.message, format!("{line} cannot be read: {LINE}"), "{line}");
        assert_eq!(
            (error.line(&format!("count = 1\n{line}")), error.key.as_str()),
            (2, ""),
            "{line}"
        );
    }
    check(&[
        ("gain =", 1, "gain", "there is no value after the `=`"),
        (
            "part = { id = 1 id = 2 }",
            1,
            "part",
            &format!("{{ id = 1 id = 2 }} cannot be read: {BRACES}"),
        ),
        (
            "part = { id = 1 }\npart.id = 2",
            2,
            "part.id",
            "the part of this key before its last dot has a value above already",
        ),
        ("gain =\u{a0}1", 1, "gain", CONTROL),
        ("axis = [1, 2, 3", 1, "axis", COMMA),
        ("axis = [\n 1\n 2\n 3]", 3, "axis", COMMA),
        ("axis = [1, 2, 3\ngain = 1", 2, "gain", COMMA),
        ("axis = [\n 1,\n yes,\n 3]", 3, "axis", &format!("yes, cannot be read: {WORD}")),
        ("title = \"\"\"a\nb", 2, "title", &format!("b cannot be read: {TEXT}")),
        ("gain = \u{1}", 1, "gain", CONTROL),
        ("gain = 1\r2", 1, "gain", CONTROL),
        ("# a\u{1}b", 1, "", CONTROL),
    ]);
    assert!(refused(&format!("gain = {}", "[".repeat(1000))).message.contains("too many brackets"));
}

#[test]
fn what_is_right_is_read() {
    let text = "count = 1_000\ngain = 0x10\naxis = [1, 2.5, -3e-1]\nweighting = \"force\"\npart = { id = 7 }\n\
                located = { id = 8, position_m = [0, 0, 1] }\n[[node]]\nid = 9";
    let file = read::<File>(text).unwrap();
    let read = (file.count, file.gain, file.axis, file.nodes.len());
    assert_eq!(read, (1000, 16.0, [1.0, 2.5, -0.3], 0));
    assert!(matches!(file.weighting, Some(Weighting::Force)));
    assert_eq!((file.part.unwrap().id, file.node[0].id), (7, 9));
    let located = file.located.unwrap();
    assert_eq!(&text[located.span()], "{ id = 8, position_m = [0, 0, 1] }");
    assert_eq!(located.get_ref().position_m, Some([0.0, 0.0, 1.0]));
}

#[test]
fn a_long_value_is_shortened() {
    let message = refused(&format!("gain = \"{}\"", "x".repeat(1000))).message;
    let words = "… stands where a number should";
    assert_eq!(message.chars().count(), MOST_SHOWN + words.chars().count());
}

/// A number that is checked after it has been read.
#[derive(Debug, serde::Deserialize)]
#[serde(try_from = "f64")]
struct PositiveNumber;

impl TryFrom<f64> for PositiveNumber {
    type Error = String;

    fn try_from(value: f64) -> Result<Self, String> {
        (value > 0.0).then_some(Self).ok_or_else(|| format!("{value} is not positive"))
    }
}

#[test]
fn a_value_that_is_refused_after_it_was_read_is_told_with_its_own_line() {
    #[derive(Debug, serde::Deserialize)]
    #[allow(dead_code)]
    struct Table {
        one: PositiveNumber,
        several: [PositiveNumber; 3],
    }
    let refused = |text: &str| {
        let error = read::<Table>(text).unwrap_err();
        (error.line(text), error.key, error.message)
    };
    let several = "several = [1,\n  2,\n  3]\n";
    let refusal = (4, "one".into(), "-1 is not positive".into());
    assert_eq!(refused(&format!("{several}one = -1.0")), refusal);
    let in_list = "one = 1.0\nseveral = [1.0,\n  2.0,\n  -3.0]\n";
    assert_eq!(refused(in_list), (4, "several".into(), "-3 is not positive".into()));
}
