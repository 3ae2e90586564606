//! What can be wrong with a universal file, and where.

use thiserror::Error;

use super::function_type_name;

/// Why a universal file or one of its functions is not taken. All of these are bad input.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("dataset {dataset}, line {line} (byte {byte}): {fault}")]
pub struct UffError {
    /// Which dataset of the file, from 1.
    pub dataset: usize,
    /// Line of the text, from 1; the data of a binary dataset count as none.
    pub line: usize,
    /// Byte of the file, from 0.
    pub byte: usize,
    /// What is wrong and what to do.
    pub fault: UffFault,
}

/// What is wrong with a universal file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UffFault {
    /// No dataset at all.
    #[error("the file holds no dataset; a universal file begins with a line \"    -1\"")]
    Empty,
    /// Something else than a dataset.
    #[error(
        "a line \"    -1\" should begin a dataset here; the file is corrupt or no universal file, \
         export it again"
    )]
    NoDelimiter,
    /// A dataset without a number.
    #[error("the dataset's type should stand here; the file is corrupt, export it again")]
    NoType,
    /// The file ends inside a dataset.
    #[error("the file is truncated: {wanted} should come; copy or export it again")]
    Truncated {
        /// What is missing.
        wanted: &'static str,
    },
    /// Fewer values than the header tells.
    #[error(
        "the file is truncated: the header tells {wanted} values, {found} are there; copy or export \
         it again"
    )]
    TooFewValues {
        /// How many there should be.
        wanted: usize,
        /// How many there are at most.
        found: usize,
    },
    /// More values than the header tells.
    #[error("the header tells {wanted} values and there are more; export the file again")]
    TooManyValues {
        /// How many there should be.
        wanted: usize,
    },
    /// Text where a number should be.
    #[error("\"{text}\" is not a number; {field} should stand here, the file is corrupt")]
    NotANumber {
        /// What should stand here.
        field: &'static str,
        /// What stands here.
        text: String,
    },
    /// A number that the format does not know.
    #[error("{value} is no {field}; {known}")]
    Unknown {
        /// What should stand here.
        field: &'static str,
        /// What stands here.
        value: i64,
        /// What is possible.
        known: &'static str,
    },
    /// The binary data are not followed by the end of the dataset.
    #[error(
        "the data are corrupt: \"    -1\" should follow the {bytes} bytes that the header tells; a \
         transfer in text mode does this, copy the file in binary mode or export it as ASCII"
    )]
    BinaryLength {
        /// Bytes that the header tells.
        bytes: usize,
    },
    /// Not a frequency response.
    #[error(
        "function type {found} ({}) is no frequency response; export functions of type 4",
        function_type_name(*found)
    )]
    FunctionType {
        /// What it is.
        found: i64,
    },
    /// A quantity that a frequency response of this kind cannot have.
    #[error("the {axis} is {} (data type {found}); {wanted}", data_type_name(*found))]
    WrongQuantity {
        /// Abscissa, ordinate numerator or ordinate denominator.
        axis: &'static str,
        /// Its specific data type.
        found: i64,
        /// What is possible.
        wanted: &'static str,
    },
    /// A unit that is not known or not of the axis' quantity.
    #[error("\"{unit}\" is no unit of {quantity} that is known; {known}")]
    WrongUnit {
        /// The label in the file.
        unit: String,
        /// What it should measure.
        quantity: &'static str,
        /// What is possible.
        known: &'static str,
    },
    /// Units of dataset 164 that cannot be.
    #[error("the unit factor {value} of dataset 164 cannot be; it must be positive")]
    UnitFactor {
        /// The factor.
        value: f64,
    },
}

impl UffFault {
    /// The stable word of this fault in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Truncated { .. } | Self::TooFewValues { .. } => "uff_truncated",
            Self::FunctionType { .. } => "uff_wrong_function_type",
            Self::WrongQuantity { .. } | Self::WrongUnit { .. } | Self::UnitFactor { .. } => {
                "uff_wrong_units"
            }
            _ => "uff_corrupt",
        }
    }
}

impl From<UffError> for crate::Error {
    fn from(error: UffError) -> Self {
        Self::input(error.fault.code(), error.to_string())
    }
}

fn data_type_name(data_type: i64) -> &'static str {
    match data_type {
        0 => "unknown",
        1 => "general",
        2 => "stress",
        3 => "strain",
        5 => "temperature",
        6 => "heat flux",
        8 => "displacement",
        9 => "reaction force",
        11 => "velocity",
        12 => "acceleration",
        13 => "excitation force",
        15 => "pressure",
        16 => "mass",
        17 => "time",
        18 => "frequency",
        19 => "rpm",
        20 => "order",
        _ => "no known quantity",
    }
}
