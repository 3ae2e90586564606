//! What is made of the rows of the table of codes.
//!
//! Each column is a function of its own, so that a program links only the texts that it shows.

/// The words of a panel for [`Code::Unknown`](super::Code::Unknown).
pub(super) const UNKNOWN_WORDS: &str = "Update this rig: it\ndoes not know this\ncode.";

/// The sentence for [`Code::Unknown`](super::Code::Unknown).
pub(super) const UNKNOWN_SENTENCE: &str = "the rig reports code {code} ({severity}, {value}), which this program does not know; update it";

macro_rules! codes {
    ($(
        $(#[$doc:meta])*
        $variant:ident = $number:literal, $name:literal, $kind:ident, $unit:ident $(($decimals:literal))?;
        $words:literal;
        $sentence:literal;
    )*) => {
        use super::codes::{UNKNOWN_SENTENCE, UNKNOWN_WORDS};
        use super::{SubjectKind, ValueUnit};

        /// A named fact about a layout, a hit, the data or a result.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Code {
            $($(#[$doc])* $variant,)*
            /// The number of a code that a newer rig has sent and this program does not know.
            Unknown(u16),
        }

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

            /// The code of a number.
            pub fn from_number(number: u16) -> Self {
                match number {
                    $($number => Self::$variant,)*
                    _ => Self::Unknown(number),
                }
            }

            /// The stable name in reports and JSON; that of [`Code::Unknown`] says no number, which
            /// [`Display`](core::fmt::Display) does.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                    Self::Unknown(_) => "unknown_code",
                }
            }

            /// What it is about.
            pub fn subject_kind(self) -> SubjectKind {
                match self {
                    $(Self::$variant => SubjectKind::$kind,)*
                    Self::Unknown(_) => SubjectKind::Whole,
                }
            }

            /// The unit of its value.
            pub fn value_unit(self) -> ValueUnit {
                match self {
                    $(Self::$variant => ValueUnit::$unit $(($decimals))?,)*
                    Self::Unknown(_) => ValueUnit::None,
                }
            }

            /// What a panel says: at most three lines of 21 ASCII characters, parted by `\n`.
            pub fn words(self) -> &'static str {
                match self {
                    $(Self::$variant => $words,)*
                    Self::Unknown(_) => UNKNOWN_WORDS,
                }
            }

            /// What a report says, and what to do. Placeholders: `{subject}`, `{value}` with its unit; of
            /// a response `{hit}` and `{response}`; of [`Code::Unknown`] `{code}` and `{severity}`.
            pub fn sentence(self) -> &'static str {
                match self {
                    $(Self::$variant => $sentence,)*
                    Self::Unknown(_) => UNKNOWN_SENTENCE,
                }
            }
        }
    };
}
