//! Errors of layout files, with the place of each.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use massline_shared::diagnosis::Code;
use massline_toml::{TomlError, line_of};
use thiserror::Error;

use crate::file;

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The key of that line, empty when it has none.
    pub key: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)?;
        if self.key.is_empty() { Ok(()) } else { write!(f, ": {}", self.key) }
    }
}

impl Place {
    /// The place of the bytes `span` of `text`; `key` when given, else the key of the line.
    pub fn of(file: &str, text: &str, span: Option<Range<usize>>, key: &str) -> Self {
        let start = span.map_or(0, |s| s.start).min(text.len());
        let line = line_of(text, start);
        let key = if key.is_empty() { key_of_line(text, line) } else { key.to_owned() };
        Self { file: file.to_owned(), line, key }
    }

    /// The place of a TOML error.
    pub fn of_toml_error(file: &str, text: &str, error: &TomlError) -> Self {
        Self { file: file.to_owned(), line: error.line(text), key: error.key.clone() }
    }
}

/// The key before the first `=` of a line, or the heading of a table.
fn key_of_line(text: &str, line: usize) -> String {
    let line = text.lines().nth(line.saturating_sub(1)).unwrap_or("").trim();
    match line.split_once('=') {
        Some((key, _)) if !key.trim_start().starts_with(['#', '[', '{', '"']) => {
            key.trim().to_owned()
        }
        None if line.starts_with('[') => line.to_owned(),
        _ => String::new(),
    }
}

/// Why a layout file is rejected. All of these are bad input.
#[derive(Debug, Error)]
pub enum LayoutFileError {
    /// The file cannot be read.
    #[error("{}", file::unreadable(file, source))]
    Read {
        /// The file as the user named it.
        file: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file is not TOML, or does not have the structure of a layout.
    #[error(
        "{place}: {message}; correct this line (`massline layout new` writes a commented example, \
         `massline layout schema` every key)"
    )]
    Malformed {
        /// Place in the file.
        place: Place,
        /// The TOML reader's message.
        message: String,
    },
    /// An invalid value.
    #[error("{place}: {fault}")]
    Fault {
        /// Place in the file.
        place: Place,
        /// The fault, with what to do about it.
        fault: Fault,
    },
}

impl LayoutFileError {
    /// The exit code of a program that ends with this error: 2, bad input.
    pub fn exit_code(&self) -> u8 {
        2
    }

    /// The diagnosis code, when this fault has one.
    pub fn code(&self) -> Option<Code> {
        match self {
            Self::Fault { fault, .. } => fault.code(),
            _ => None,
        }
    }

    /// Place of the error, when it is in the text.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Read { .. } => None,
            Self::Malformed { place, .. } | Self::Fault { place, .. } => Some(place),
        }
    }
}

/// An invalid value, with what to do about it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// A sensor or hit names a node that does not exist.
    #[error(
        "node {node} is not in the layout (nodes: {known}); add a [[node]] with id = {node} or \
         name another node"
    )]
    UnknownNode {
        /// The node number in question.
        node: i64,
        /// The nodes that exist.
        known: String,
    },
    /// Two nodes have the same number.
    #[error("node {node} is there twice, first in line {first}; give every node its own number")]
    DuplicatedNode {
        /// The number.
        node: i64,
        /// Line of its first use.
        first: usize,
    },
    /// A node number outside of the range of the rig and of UFF.
    #[error("{node} is not a node number; use a whole number from 1 to 65535")]
    NodeNumber {
        /// The number.
        node: i64,
    },
    /// A DOF that cannot be parsed.
    #[error(
        "\"{text}\" is not a DOF; write node:±axis, for example 1:+Y for a force along local +y of \
         node 1"
    )]
    Dof {
        /// The text in the file.
        text: String,
    },
    /// A DOF without a sign.
    #[error("a hit needs the sign of its direction; write {plus} or {minus}", plus = text.replace('±', "+"),
            minus = text.replace('±', "-"))]
    NoSign {
        /// The text in the file, with ± where the sign belongs.
        text: String,
    },
    /// A layout without sensors or without hits.
    #[error(
        "the layout does not have this key; write sensors = [1, 2, 3] and hits = [\"1:+Y\", …] with the \
         numbers of its nodes, or let `massline layout suggest` choose them"
    )]
    Missing,
    /// A direction that cannot be parsed.
    #[error(
        "\"{text}\" is not a direction; write sign and local axis, for example \"+X\" or \"-Z\""
    )]
    Direction {
        /// The text in the file.
        text: String,
    },
    /// Two hits have the same DOF.
    #[error("the hit {dof} is there twice; remove one (the rig repeats hits by itself)")]
    DuplicatedHit {
        /// The DOF.
        dof: String,
    },
    /// An axis is not of unit length.
    #[error(
        "the local {axis} axis has length {length:.6}; an axis is a unit vector, divide it by its \
         length"
    )]
    AxisNotUnit {
        /// x or y.
        axis: char,
        /// Its length.
        length: f64,
    },
    /// The axes are not orthogonal.
    #[error(
        "the local x and y axes are not orthogonal (their angle is {degrees:.3} degrees); give two \
         orthogonal unit vectors, z is x × y"
    )]
    AxesNotOrthogonal {
        /// The angle between them, degrees.
        degrees: f64,
    },
    /// Two sensors on the same node.
    #[error(
        "node {node} carries two sensors; put every sensor on a node of its own (a second [[node]] \
         with its own position)"
    )]
    TwoSensorsOnOneNode {
        /// The node.
        node: i64,
    },
    /// More sensors or hits than the program supports.
    #[error("{count} {what} are too many; at most {most} are taken")]
    TooMany {
        /// sensors or hits.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// NaN or infinity.
    #[error("a value is {value}, not a finite number; write a decimal number in SI units")]
    NotFinite {
        /// The value.
        value: f64,
    },
    /// Gravity of another length than on Earth.
    #[error("its length is {magnitude} m/s², and on Earth it is 9.75 to 9.85{hint}")]
    GravityLength {
        /// Its length, m/s².
        magnitude: f64,
        /// What it may be, and what to do.
        hint: &'static str,
    },
    /// A number that is out of range.
    #[error("{value} is out of range; give {wanted}")]
    OutOfRange {
        /// The value.
        value: f64,
        /// The allowed range.
        wanted: &'static str,
    },
    /// The band of the suspension modes cannot be found from the data.
    #[error(
        "the band of the suspension profile is not found from the data; give [lowest, highest] in Hz, or leave it out \
         for 0.5 to 12.4 Hz"
    )]
    BandOfSuspension,
    /// A control character, which a terminal would obey.
    #[error("the text has the control character {found:?}; delete it")]
    ControlCharacter {
        /// The character.
        found: char,
    },
    /// The inertia tensor is not symmetric.
    #[error(
        "the tensor is not symmetric; give the 3 × 3 inertia tensor about the centre of mass with \
         J_xy = −∫xy dm at both places"
    )]
    NotSymmetric,
    /// The expected values are not those of a physical body.
    #[error(
        "no body has this inertia tensor: its principal moments must be positive and each at most \
         the sum of the two others; check the signs of the products J_xy = −∫xy dm"
    )]
    NoBody,
}

impl Fault {
    /// The diagnosis code, when there is one.
    pub fn code(&self) -> Option<Code> {
        match self {
            Self::UnknownNode { .. } => Some(Code::UnknownNode),
            Self::AxisNotUnit { .. } | Self::AxesNotOrthogonal { .. } => {
                Some(Code::AxesNotOrthonormal)
            }
            Self::TwoSensorsOnOneNode { .. } => Some(Code::TwoSensorsOnOneNode),
            Self::NotFinite { .. } => Some(Code::LayoutNotFinite),
            Self::OutOfRange { .. } | Self::GravityLength { .. } => Some(Code::SettingOutOfRange),
            _ => None,
        }
    }
}

impl From<LayoutFileError> for massline_result::Error {
    fn from(error: LayoutFileError) -> Self {
        let other = match &error {
            LayoutFileError::Read { .. } => "layout_not_readable",
            _ => "layout_malformed",
        };
        let code = error.code().map_or(other, Code::name);
        Self::input(code, error.to_string())
    }
}
