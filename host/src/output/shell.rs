//! Words of a command that a person copies into a shell.

use std::path::Path;

/// A path as one word of a command: in quotes, where a shell would take it for several words or for something else, and
/// never like an option.
pub fn shell_path(path: &Path) -> String {
    let text = path.display().to_string();
    shell_word(&if text.starts_with('-') { format!("./{text}") } else { text })
}

/// The command that is running, with another option.
pub fn this_command_with(option: &str) -> String {
    let words = std::env::args_os().skip(1).map(|word| shell_word(&word.to_string_lossy()));
    let words: Vec<String> = std::iter::once("massline".to_owned()).chain(words).collect();
    // After `--` there are no options.
    let end = words.iter().position(|word| word == "--").unwrap_or(words.len());
    let (before, after) = words.split_at(end);
    [before, &[option.to_owned()], after].concat().join(" ")
}

/// A text as one word of a command.
pub fn shell_word(text: &str) -> String {
    // Only on Windows does a backslash part folders.
    let is_plain =
        |c: char| c.is_alphanumeric() || "-_./:+,=@%".contains(c) || cfg!(windows) && c == '\\';
    let is_safe = |c: char| !"\"$`\\!".contains(c);
    match text {
        plain if !plain.is_empty() && plain.chars().all(is_plain) => plain.to_owned(),
        // Double quotes are those of every system.
        words if words.chars().all(is_safe) => format!("\"{words}\""),
        other => format!("'{}'", other.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_quoted_where_it_has_to_be() {
        for (text, word) in [
            ("frame.massline", "frame.massline"),
            ("tests/frame 2.massline", "\"tests/frame 2.massline\""),
            ("a&b", "\"a&b\""),
            ("$HOME", "'$HOME'"),
            ("it's $5", "'it'\\''s $5'"),
            ("", "\"\""),
            #[cfg(not(windows))]
            ("a\\b", "'a\\b'"),
            #[cfg(windows)]
            ("a\\b", "a\\b"),
        ] {
            assert_eq!(shell_word(text), word);
        }
        assert_eq!(shell_path(Path::new("-x.massline")), "./-x.massline");
    }
}
