//! The macro that turns the rows of the table of codes into [`Code`](super::Code).
//!
//! Each column becomes a function of its own, so a program links only the texts that it shows.

/// Panel text for [`Code::Unknown`](super::Code::Unknown).
pub(super) const UNKNOWN_WORDS: &str = "Update this rig: it\ndoes not know this\ncode.";

/// Sentence for [`Code::Unknown`](super::Code::Unknown).
pub(super) const UNKNOWN_SENTENCE: &str = "the rig reports code {code} ({severity}, {value}), which this \
     program does not know; update it";

macro_rules! codes {
    ($(
        $(#[doc = $doc:literal])*
        $variant:ident = $number:literal, $name:literal, $kind:ident, $unit:ident $(($decimals:literal))?;
        $words:literal;
        $sentence:literal;
    )*) => {
        use super::codes::{UNKNOWN_SENTENCE, UNKNOWN_WORDS};
        use super::{SubjectKind, ValueUnit};

        /// A named fact about a layout, a hit, the data or a result.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Code {
            $($(#[doc = $doc])* $variant,)*
            /// A code from a newer rig that this program does not know, with its number.
            Unknown(u16),
        }

        /// The rows of the table.
        enum Row { $($variant),* }

        impl Code {
            /// Every code that this program knows.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The stable number.
            pub fn number(self) -> u16 {
                match self {
                    $(Self::$variant => $number,)*
                    Self::Unknown(number) => number,
                }
            }

            /// The code with this number.
            pub fn from_number(number: u16) -> Self {
                match number {
                    $($number => Self::$variant,)*
                    _ => Self::Unknown(number),
                }
            }

            /// The stable name in reports and JSON. For [`Code::Unknown`] it does not contain the number;
            /// [`Display`](core::fmt::Display) does.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                    Self::Unknown(_) => "unknown_code",
                }
            }

            /// What it means, in a sentence or two.
            pub fn meaning(self) -> &'static str {
                let text = match self {
                    $(Self::$variant => concat!($($doc),*),)*
                    Self::Unknown(_) => "A code from a newer rig that this program does not know.",
                };
                // What subject and value are is for whoever writes the code.
                let ends = [text.find(" Subject:"), text.find(" Value:")];
                text[..ends.into_iter().flatten().min().unwrap_or(text.len())].trim()
            }

            /// What subjects of this code refer to.
            pub fn subject_kind(self) -> SubjectKind {
                match self {
                    $(Self::$variant => SubjectKind::$kind,)*
                    Self::Unknown(_) => SubjectKind::Whole,
                }
            }

            /// Unit of the value.
            pub fn value_unit(self) -> ValueUnit {
                match self {
                    $(Self::$variant => ValueUnit::$unit $(($decimals))?,)*
                    Self::Unknown(_) => ValueUnit::None,
                }
            }

            /// Text on the panel: at most three lines of 21 ASCII characters, separated by `
            /// `.
            pub fn words(self) -> &'static str {
                // One text, because a table of addresses would take another kilobyte of a rig's flash.
                const ALL: &str = concat!($($words, "\0"),*);
                let row = match self {
                    $(Self::$variant => Row::$variant as usize,)*
                    Self::Unknown(_) => return UNKNOWN_WORDS,
                };
                ALL.split('\0').nth(row).unwrap_or(UNKNOWN_WORDS)
            }

            /// Sentence for reports, with the remedy. Placeholders: `{subject}`, `{value}` with its unit; for
            /// a response `{hit}` and `{response}`; for [`Code::Unknown`] `{code}` and `{severity}`.
            pub fn sentence(self) -> &'static str {
                match self {
                    $(Self::$variant => $sentence,)*
                    Self::Unknown(_) => UNKNOWN_SENTENCE,
                }
            }
        }
    };
}
