//! Colours, and text that a terminal shows but does not obey.

use std::borrow::Cow;

use massline_result::Verdict;

/// The tone of a piece of text: how a terminal with colours shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// A heading.
    Strong,
    /// Success.
    Good,
    /// A warning.
    Warning,
    /// An error.
    Bad,
}

impl From<Verdict> for Tone {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Good => Self::Good,
            Verdict::UseWithCare => Self::Warning,
            Verdict::DoNotUse => Self::Bad,
        }
    }
}

/// Ends a [`Tone`].
pub const RESET: &str = "\x1b[0m";

impl Tone {
    /// The text in this tone; [`plain`] takes it out again.
    pub fn mark(self, text: impl std::fmt::Display) -> String {
        format!("{}{text}{RESET}", self.escape())
    }

    /// What a terminal takes for the begin of this tone.
    pub fn escape(self) -> &'static str {
        match self {
            Self::Strong => "\x1b[1m",
            Self::Good => "\x1b[32m",
            Self::Warning => "\x1b[33m",
            Self::Bad => "\x1b[31m",
        }
    }
}

/// The text without tones.
pub fn plain(text: &str) -> String {
    let tones = [Tone::Strong, Tone::Good, Tone::Warning, Tone::Bad].map(Tone::escape);
    tones.into_iter().chain([RESET]).fold(text.to_owned(), |text, tone| text.replace(tone, ""))
}

/// True for a character that a terminal obeys: control characters, and those that turn the direction of the text after
/// them.
fn is_obeyed(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && !matches!(c, '\n' | '\t'))
}

/// The text without the characters of files, rigs and systems that a terminal would obey; those of [`Tone`] stay.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let obeyed = is_obeyed;
    if !text.contains(obeyed) {
        return text.into();
    }
    let tones = [Tone::Strong, Tone::Good, Tone::Warning, Tone::Bad].map(Tone::escape);
    let mut clean = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(obeyed) {
        clean += &rest[..at];
        let tail = &rest[at..];
        let own = tones.into_iter().chain([RESET]).find(|tone| tail.starts_with(tone));
        clean += own.unwrap_or("\u{fffd}");
        rest = &tail[own.map_or_else(|| tail.chars().next().map_or(0, char::len_utf8), str::len)..];
    }
    (clean + rest).into()
}
