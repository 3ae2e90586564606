//! Colours, and text that a terminal shows but does not obey.

use std::borrow::Cow;

use massline_result::Verdict;

/// When text is coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ColorChoice {
    /// On a terminal that shows colours, unless NO_COLOR is set.
    #[default]
    Auto,
    /// Always, also into a pipe.
    Always,
    /// Never.
    Never,
}

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
pub(super) const RESET: &str = "\x1b[0m";

impl Tone {
    /// The text in this tone; where nothing is coloured, [`Output`](super::Output) takes it out again.
    pub fn mark(self, text: impl std::fmt::Display) -> String {
        format!("{}{text}{RESET}", self.escape())
    }

    pub(super) fn escape(self) -> &'static str {
        match self {
            Self::Strong => "\x1b[1m",
            Self::Good => "\x1b[32m",
            Self::Warning => "\x1b[33m",
            Self::Bad => "\x1b[31m",
        }
    }
}

/// The text without tones.
pub(super) fn plain(text: &str) -> String {
    let tones = [Tone::Strong, Tone::Good, Tone::Warning, Tone::Bad].map(Tone::escape);
    tones.into_iter().chain([RESET]).fold(text.to_owned(), |text, tone| text.replace(tone, ""))
}

/// A JSON text whose strings name their control characters by number; serde_json writes those above 0x7e as they are.
pub(super) fn escaped(json: &str) -> Cow<'_, str> {
    if !json.contains(char::is_control) {
        return json.into();
    }
    let mut text = String::new();
    for c in json.chars() {
        if c.is_control() {
            text += &format!("\\u{:04x}", u32::from(c));
        } else {
            text.push(c);
        }
    }
    text.into()
}

/// True for a character that a terminal obeys: control characters, and those that turn the direction of the text after them.
fn is_obeyed(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && !matches!(c, '\n' | '\t'))
}

/// The text without the characters of files, rigs and systems that a terminal would obey; those of [`Tone`] stay.
pub(crate) fn harmless(text: &str) -> Cow<'_, str> {
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
