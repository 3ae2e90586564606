//! Help texts that wrap at the width of the terminal.

use clap::Command;

/// Joins the lines of each paragraph of the notes after the options, so that they wrap at the width of the terminal and
/// not where the source does; examples and lists are indented and stay as they are.
pub(crate) fn reflowed(command: Command) -> Command {
    let notes = command.get_after_help().map(|text| joined(&text.to_string()));
    let command = match notes {
        Some(notes) => command.after_help(notes),
        None => command,
    };
    command.mut_subcommands(reflowed)
}

fn joined(text: &str) -> String {
    let mut paragraphs = String::new();
    let mut open = false;
    for line in text.lines() {
        let prose = !line.is_empty() && !line.starts_with(' ') && !line.ends_with(':');
        match (open && prose, paragraphs.is_empty()) {
            (true, _) => paragraphs.push(' '),
            (false, false) => paragraphs.push('\n'),
            (false, true) => {}
        }
        paragraphs += line;
        open = prose;
    }
    paragraphs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_are_joined_and_examples_are_not() {
        let text = "One sentence\nin two lines.\n\nNext.\n\nExamples:\n  massline demo\n  massline solve\n\nExit \
             codes:\n  0 done";
        let wanted = "One sentence in two lines.\n\nNext.\n\nExamples:\n  massline demo\n  massline solve\n\nExit \
             codes:\n  0 done";
        assert_eq!(joined(text), wanted);
    }
}
