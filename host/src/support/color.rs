//! Colours of the help and of usage errors, which clap writes.

use std::ffi::OsString;

use clap::builder::styling::{AnsiColor, Style, Styles};
use clap::{Command, ValueEnum};

use crate::output::{ColorChoice, Output, harmless};

/// The tones of [`crate::output::Tone`]: headings are bold, errors red, warnings yellow.
const STYLES: Styles = Styles::styled()
    .header(Style::new().bold())
    .usage(Style::new().bold())
    .literal(AnsiColor::Green.on_default())
    .error(AnsiColor::Red.on_default())
    .valid(AnsiColor::Green.on_default())
    .invalid(AnsiColor::Yellow.on_default());

/// What `--color` says. It is needed before the arguments are parsed, whose errors are coloured too; a wrong value is
/// refused when they are.
pub(crate) fn chosen(arguments: &[OsString]) -> Option<ColorChoice> {
    let words: Vec<_> = arguments.iter().skip(1).map(|word| word.to_string_lossy()).collect();
    let options = words.iter().take_while(|word| *word != "--");
    let stated =
        options.zip(words.iter().skip(1).map(Some).chain([None])).filter_map(|(word, next)| {
            match word.strip_prefix("--color") {
                Some("") => next.map(|value| value.to_string()),
                Some(value) => value.strip_prefix('=').map(str::to_owned),
                None => None,
            }
        });
    stated.last().and_then(|value| ColorChoice::from_str(&value, false).ok())
}

/// The command line with this program's colours. Whether they are wanted is decided in one place, [`Output`]: left to
/// itself, clap would colour a dumb terminal where the variable `CI` is set.
pub(crate) fn in_color(command: Command, wanted: bool) -> Command {
    let choice = if wanted { clap::ColorChoice::Always } else { clap::ColorChoice::Never };
    command.styles(STYLES).color(choice)
}

/// Prints help, version or a usage error.
pub(crate) fn print(usage: &clap::Error, arguments: &[OsString], output: &mut Output) {
    // clap repeats arguments as they are.
    let strange = arguments.iter().any(|word| word.to_string_lossy().contains(char::is_control));
    if strange && usage.use_stderr() {
        output.note(harmless(usage.to_string().trim_end()));
    } else {
        // A failure to write cannot be reported anywhere.
        let _ = usage.print();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice_of(words: &[&str]) -> ColorChoice {
        let words: Vec<_> = words.iter().map(OsString::from).collect();
        chosen(&words).unwrap_or_default()
    }

    #[test]
    fn the_last_choice_before_the_end_of_the_options_counts() {
        assert_eq!(choice_of(&["massline", "demo"]), ColorChoice::Auto);
        assert_eq!(choice_of(&["massline", "--color", "never", "demo"]), ColorChoice::Never);
        assert_eq!(choice_of(&["massline", "demo", "--color=always"]), ColorChoice::Always);
        assert_eq!(
            choice_of(&["massline", "--color=always", "--color", "never"]),
            ColorChoice::Never
        );
        assert_eq!(choice_of(&["massline", "--", "--color=always"]), ColorChoice::Auto);
        assert_eq!(choice_of(&["massline", "--color"]), ColorChoice::Auto);
        assert_eq!(choice_of(&["massline", "--color=sometimes"]), ColorChoice::Auto);
    }
}
