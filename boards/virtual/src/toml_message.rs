//! The messages of the TOML reader in words for the owner of a file.

/// Types of values in the words of the reader, and in those of the owner.
const TYPES: [(&str, &str); 14] = [
    ("a sequence", "a list in brackets"),
    ("sequence", "a list in brackets"),
    ("a map", "a table"),
    ("map", "a table"),
    ("a boolean", "true or false"),
    ("a string", "a text in quotes"),
    ("f64", "a number"),
    ("f32", "a number"),
    ("i64", "a whole number"),
    ("u64", "a whole number"),
    ("u32", "a whole number"),
    ("u16", "a whole number"),
    ("u8", "a whole number"),
    ("usize", "a whole number"),
];

/// What the reader says where its grammar ends, and what the owner of a file can do.
const GRAMMAR: [(&str, &str); 6] = [
    (
        "string values must be quoted",
        "this is no number and no text: a number has a decimal point and no unit, a text has quotes",
    ),
    (
        "unexpected key or value",
        "one value stands after the `=`, a number with a decimal point; put `#` before a remark",
    ),
    ("invalid mantissa", "a number has digits before and after its decimal point, such as 0.5"),
    ("missing comma between array elements", "a comma or a closing bracket is missing before this"),
    ("key with no value", "this key has no value; write key = value"),
    ("unclosed array", "a closing bracket is missing"),
];

/// Most characters of a value that are shown.
const MOST_SHOWN: usize = 40;

/// What is wrong with a TOML text, to whoever wrote it.
pub fn plain(text: &str, error: &toml::de::Error) -> String {
    let message = error.message();
    let span = error.span().unwrap_or_default();
    let written = shown(text.get(span.clone()).unwrap_or_default());
    let before = text.get(..span.start).unwrap_or_default();
    // The heading of a table, where the place is in one.
    let heading = format!("{}{written}", before.rsplit('\n').next().unwrap_or_default());
    if message == "duplicate key" {
        return match heading.trim_start().starts_with('[') {
            true => "this name stands above already; of several tables each is [[name]]".into(),
            false => "this key is in the file twice; delete one".into(),
        };
    }
    if let Some((_, advice)) = GRAMMAR.iter().find(|(of_reader, _)| message.starts_with(of_reader))
    {
        return (*advice).to_owned();
    }
    if let Some(names) = message.strip_prefix("unknown variant ") {
        return match names.split_once(", expected ") {
            Some((name, known)) => format!("{name} is not known here; write {known}"),
            None => message.to_owned(),
        };
    }
    if let Some(names) = message.strip_prefix("unknown field ") {
        return match names.split_once(", expected ") {
            Some((name, known)) => format!("there is no key {name} here, but {known}"),
            None => message.to_owned(),
        };
    }
    if heading.trim_start().starts_with("[[") && !message.starts_with("missing field") {
        return "there is one such table only: write its name in single brackets".into();
    }
    if heading.trim_start().starts_with('[') && message.ends_with("expected a sequence") {
        return "there can be several such tables: write the name of each in double brackets"
            .into();
    }
    // What an enumeration of names is asked for.
    if message.starts_with("wanted ") || message.starts_with("expected table") {
        return format!("{written} stands where a text in quotes should");
    }
    if let Some((found, expected)) = message
        .strip_prefix("invalid length ")
        .and_then(|lengths| lengths.split_once(", expected an array of length "))
    {
        return format!("{found} values stand where {expected} should");
    }
    let is_value = ["invalid type: ", "invalid value: ", "invalid length "]
        .iter()
        .any(|kind| message.starts_with(kind));
    match message.rsplit_once(", expected ") {
        Some((_, expected)) if is_value && !written.is_empty() => {
            format!("{written} stands where {} should", named(expected))
        }
        _ => message.to_owned(),
    }
}

/// A type in the words of the owner of a file.
fn named(expected: &str) -> String {
    if let Some(length) = expected.strip_prefix("an array of length ") {
        return format!("a list of {length} values in brackets");
    }
    let known = TYPES.iter().find(|(of_reader, _)| *of_reader == expected);
    known.map_or(expected, |(_, words)| words).to_owned()
}

/// A part of a text on one line, shortened.
fn shown(part: &str) -> String {
    let line = part.lines().next().unwrap_or_default().trim_end();
    match line.chars().count() > MOST_SHOWN || line.len() < part.trim_end().len() {
        true => line.chars().take(MOST_SHOWN).chain(['…']).collect(),
        false => line.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Deserialize, Debug)]
    #[serde(rename_all = "snake_case")]
    enum Weighting {
        Force,
        Acceleration,
    }

    #[derive(Deserialize, Debug)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only the errors of reading it are looked at")]
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
    }

    #[derive(Deserialize, Debug)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only the errors of reading it are looked at")]
    struct Part {
        id: u16,
    }

    #[test]
    fn each_error_is_in_the_words_of_a_file() {
        let cases = [
            ("count = \"1\"", "\"1\" stands where a whole number should"),
            ("count = 2.5", "2.5 stands where a whole number should"),
            ("count = 1e3", "1e3 stands where a whole number should"),
            ("count = -1", "-1 stands where a whole number should"),
            ("count = 70000", "70000 stands where a whole number should"),
            (
                "count = 99999999999999999999",
                "99999999999999999999 stands where a whole number should",
            ),
            ("count = 2026-01-01", "2026-01-01 stands where a whole number should"),
            ("count = [\n1]", "[… stands where a whole number should"),
            ("gain = true", "true stands where a number should"),
            ("gain = \"a `b`, expected c\"", "\"a `b`, expected c\" stands where a number should"),
            (
                "gain = 1 %",
                "this is no number and no text: a number has a decimal point and no unit, a text has quotes",
            ),
            (
                "gain = 0,5",
                "one value stands after the `=`, a number with a decimal point; put `#` before a remark",
            ),
            ("gain = .5", "a number has digits before and after its decimal point, such as 0.5"),
            (
                "gain = half",
                "this is no number and no text: a number has a decimal point and no unit, a text has quotes",
            ),
            ("title = 3", "3 stands where a text in quotes should"),
            ("axis = 3", "3 stands where a list of 3 values in brackets should"),
            ("axis = [0, 1]", "2 values stand where 3 should"),
            ("axis = [[0, 0, 1]]", "[0, 0, 1] stands where a number should"),
            ("nodes = { a = 1 }", "{ a = 1 } stands where a list in brackets should"),
            ("nodes = 2026-01-01", "2026-01-01 stands where a list in brackets should"),
            ("nodes = [1\n2]", "a comma or a closing bracket is missing before this"),
            ("weighting = \"mass\"", "`mass` is not known here; write `force` or `acceleration`"),
            ("weighting = 3", "3 stands where a text in quotes should"),
            ("weighting = { force = 1 }", "1 stands where a text in quotes should"),
            (
                "weighting = { a = 1, b = 2 }",
                "{ a = 1, b = 2 } stands where a text in quotes should",
            ),
            (
                "gains = 3",
                "there is no key `gains` here, but one of `count`, `gain`, `title`, `axis`, `nodes`, \
              `weighting`, `part`, `node`",
            ),
            ("[[part]]\nid = 1", "there is one such table only: write its name in single brackets"),
            (
                "[node]\nid = 1",
                "there can be several such tables: write the name of each in double brackets",
            ),
            ("gain = 1\ngain = 2", "this key is in the file twice; delete one"),
            (
                "[node]\nid = 1\n[[node]]\nid = 2",
                "this name stands above already; of several tables each is [[name]]",
            ),
            ("[part]", "missing field `id`"),
        ];
        let said = cases.map(|(text, _)| {
            let error = toml::from_str::<File>(text).expect_err(text);
            (text, plain(text, &error))
        });
        assert_eq!(said, cases.map(|(text, said)| (text, said.to_owned())));
    }

    #[test]
    fn a_long_value_is_shortened() {
        let text = format!("gain = \"{}\"", "x".repeat(1000));
        let error = toml::from_str::<File>(&text).expect_err("a text is no number");
        assert_eq!(
            plain(&text, &error).chars().count(),
            MOST_SHOWN + "… stands where a number should".chars().count()
        );
    }
}
