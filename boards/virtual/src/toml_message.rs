//! The messages of the TOML reader in words for the owner of a file.

/// Types of values in the words of the reader, and in those of TOML.
const TYPES: [(&str, &str); 18] = [
    ("a sequence", "a list in brackets"),
    ("sequence", "a list in brackets"),
    ("a map", "a table"),
    ("map", "a table"),
    ("a boolean", "true or false"),
    ("boolean", "true or false"),
    ("a string", "a text in quotes"),
    ("string", "a text in quotes"),
    ("floating point", "a number"),
    ("f64", "a number"),
    ("f32", "a number"),
    ("integer", "a whole number"),
    ("i64", "a whole number"),
    ("u64", "a whole number"),
    ("u32", "a whole number"),
    ("u16", "a whole number"),
    ("u8", "a whole number"),
    ("usize", "a whole number"),
];

/// What a message of the reader means to whoever wrote the file.
pub fn plain(message: &str) -> String {
    if message == "duplicate key" {
        return "this key is in the file twice; delete one".into();
    }
    let parts =
        message.strip_prefix("invalid type: ").and_then(|rest| rest.rsplit_once(", expected "));
    let Some((found, expected)) = parts else { return message.to_owned() };
    let named = |word: &str| TYPES.iter().find(|(of_reader, _)| *of_reader == word).map(|of| of.1);
    // `string "1"`, `` integer `1` ``, or a kind alone.
    let found = match found.split_once(' ') {
        Some(("string", value)) => value,
        _ => match found.split_once(" `") {
            Some((_, value)) => value.trim_end_matches('`'),
            None => named(found).unwrap_or(found),
        },
    };
    match named(expected) {
        Some(expected) => format!("{found} stands where {expected} should"),
        None => format!("{found} stands here, expected {expected}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_in_the_words_of_a_file() {
        for (of_reader, said) in [
            (
                "invalid type: string \"1\", expected i64",
                "\"1\" stands where a whole number should",
            ),
            (
                "invalid type: integer `3`, expected a string",
                "3 stands where a text in quotes should",
            ),
            (
                "invalid type: floating point `2.5`, expected u16",
                "2.5 stands where a whole number should",
            ),
            ("invalid type: boolean `true`, expected f64", "true stands where a number should"),
            (
                "invalid type: map, expected a sequence",
                "a table stands where a list in brackets should",
            ),
            (
                "invalid type: string \"a, expected b\", expected an array of length 3",
                "\"a, expected b\" stands here, expected an array of length 3",
            ),
            (
                "invalid type: string \"a `b`\", expected f64",
                "\"a `b`\" stands where a number should",
            ),
            ("missing field `id`", "missing field `id`"),
        ] {
            assert_eq!(plain(of_reader), said);
        }
    }
}
