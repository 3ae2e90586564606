//! Errors of universal files, with the place of each.

use thiserror::Error;

use super::{MOST_FUNCTIONS, MOST_POINTS, function_type_name};

/// Why a universal file or one of its functions is rejected. All of these are bad input.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("dataset {dataset}, line {line} (byte {byte}): {fault}")]
pub struct UffError {
    /// Number of the dataset in the file, from 1.
    pub dataset: usize,
    /// Line of the text, from 1; binary data do not count as lines.
    pub line: usize,
    /// Byte of the file, from 0.
    pub byte: usize,
    /// The fault, with what to do about it.
    pub fault: UffFault,
}

/// What is wrong with a universal file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UffFault {
    /// The file has no dataset.
    #[error("the file holds no dataset; a universal file begins with a line of -1")]
    Empty,
    /// Something other than a dataset.
    #[error(
        "a line of -1, in columns 5 and 6, should begin a dataset here; the file is corrupt or not a universal file, \
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
    /// Fewer values than the header states.
    #[error(
        "the file is truncated: the header states {wanted} values, {found} are there; copy or export \
         it again"
    )]
    TooFewValues {
        /// How many there should be.
        wanted: usize,
        /// The largest number that the file can hold.
        found: usize,
    },
    /// More values than the header states.
    #[error("the header states {wanted} values and there are more; export the file again")]
    TooManyValues {
        /// How many there should be.
        wanted: usize,
    },
    /// More points than are held in memory.
    #[error("the file has more than {MOST_POINTS} points; export fewer functions or fewer lines")]
    TooManyPoints,
    /// More functions than are held in memory.
    #[error("the file has more than {MOST_FUNCTIONS} functions; export fewer")]
    TooManyFunctions,
    /// Text where a number should be.
    #[error("\"{}\" is not a number, and {field} should stand here: the file is cut off or damaged; export it \
         again", .text.escape_debug())]
    NotANumber {
        /// What is expected here.
        field: &'static str,
        /// The text found.
        text: String,
    },
    /// An integer that is not a value of this field.
    #[error("{value} is not a valid {field}; {known}")]
    Unknown {
        /// The field.
        field: &'static str,
        /// The value found.
        value: i64,
        /// The possible values.
        known: &'static str,
    },
    /// The binary data are not followed by the end of the dataset.
    #[error(
        "the data are corrupt: a line of -1 should follow the {bytes} bytes that the header states; a \
         transfer in text mode does this, copy the file in binary mode or export it as ASCII"
    )]
    BinaryLength {
        /// Number of bytes that the header states.
        bytes: usize,
    },
    /// Binary numbers in the other byte order.
    #[error(
        "the header states {stated} numbers, by which {absurd} of the {values} values are below 1e-20 or above 1e20; \
         as {other} numbers they are not: the byte order in the first line of the dataset is wrong, correct it or \
         export the function as ASCII"
    )]
    ByteOrder {
        /// The order that the header states.
        stated: &'static str,
        /// The order of the numbers.
        other: &'static str,
        /// How many values no measurement has.
        absurd: usize,
        /// How many values there are.
        values: usize,
    },
    /// An abscissa that does not rise.
    #[error(
        "the increment of the abscissa (record 7) is {value}, and it must be positive and not vanish beside the \
         minimum of {minimum}; export the function again"
    )]
    Increment {
        /// The increment.
        value: f64,
        /// The minimum.
        minimum: f64,
    },
    /// The function is not a frequency response.
    #[error(
        "function type {found} ({}) is not a frequency response; export functions of type 4",
        function_type_name(*found)
    )]
    FunctionType {
        /// Its function type.
        found: i64,
    },
    /// A quantity that is invalid for this axis of a frequency response.
    #[error("the {axis} is {} (data type {found}); {wanted}", data_type_name(*found))]
    WrongQuantity {
        /// Abscissa, ordinate numerator or ordinate denominator.
        axis: &'static str,
        /// Its specific data type.
        found: i64,
        /// The possible quantities.
        wanted: &'static str,
    },
    /// A unit that is unknown or is not a unit of the axis' quantity.
    #[error("\"{unit}\" is not a known unit of {quantity}; {known} are")]
    WrongUnit {
        /// The label in the file.
        unit: String,
        /// The quantity that the unit should measure.
        quantity: &'static str,
        /// The known units.
        known: &'static str,
    },
    /// A unit that is understood and of no use.
    #[error(
        "\"{unit}\": {fault}; export the functions in units of the quantity, such as m/s^2 and N"
    )]
    UnusableUnit {
        /// The label in the file.
        unit: String,
        /// Why it is of no use.
        fault: String,
    },
    /// An amplitude over an effective value.
    #[error(
        "\"{unit}\": one part of the ratio is an effective value (rms), the other a peak; export both alike"
    )]
    MixedAmplitudes {
        /// The label of the denominator.
        unit: String,
    },
    /// Invalid unit factors in dataset 164.
    #[error("the unit factor {value} of dataset 164 cannot be; it must be positive")]
    UnitFactor {
        /// The factor.
        value: f64,
    },
}

impl UffFault {
    /// The stable identifier of this fault in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Truncated { .. } | Self::TooFewValues { .. } => "uff_truncated",
            Self::TooManyPoints | Self::TooManyFunctions => "uff_too_long",
            Self::FunctionType { .. } => "uff_wrong_function_type",
            Self::WrongQuantity { .. }
            | Self::WrongUnit { .. }
            | Self::UnusableUnit { .. }
            | Self::MixedAmplitudes { .. }
            | Self::UnitFactor { .. } => "uff_wrong_units",
            _ => "uff_corrupt",
        }
    }
}

impl From<UffError> for massline_result::Error {
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
