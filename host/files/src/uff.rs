//! Universal files (UFF): frequency response functions in dataset 58, ASCII and binary (58b).
//!
//! A universal file is a sequence of *datasets*, each between two lines `    -1`. Dataset 58 holds one
//! function at a *response* DOF due to a *reference* DOF. [`UffFile::parse`] reads all functions without
//! conversion; [`Function::accelerance`] converts one to SI accelerance, (m/s²)/N. Dataset 164 (units) is
//! evaluated wherever it stands, all others are skipped.
//!
//! The reader accepts any bytes: it never panics, and never allocates more than a small multiple of the
//! input's length.

mod columns;
mod contradiction;
mod error;
mod function;
mod lines;
mod of_layout;
mod unit_system;
mod units;
mod values;
mod write;
mod write_model;

use std::path::Path;

use nalgebra::Complex;

pub use crate::units::Quantity;
pub use error::{UffError, UffFault};
pub use of_layout::functions_of;
pub use write::{Encoding, write, write_described};
pub use write_model::{BODY_AXES, ModelNode, write_nodes, write_units};

use crate::encoding::Text;
use function::read_function;
use lines::Lines;
use unit_system::UnitSystem;
pub use units::{UnderstoodFunction, UnitSource};

/// Largest universal file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 27;
/// Most functions of a file: a thousand responses to a hundred forces.
pub const MOST_FUNCTIONS: usize = 100_000;
/// Most points of all functions of a file, which fit into the memory of small computers.
pub const MOST_POINTS: usize = 1 << 23;

/// The contents of a universal file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UffFile {
    /// Every function (dataset 58) that has values, in the order of the file.
    pub functions: Vec<Function>,
    /// The functions without values.
    pub empty: Vec<Function>,
    /// Remarks on anything unusual in the file.
    pub notes: Vec<String>,
}

/// A node and a direction in the numbering of UFF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeDirection {
    /// Number of the node.
    pub node: i64,
    /// ±1, ±2, ±3 for a translation along ±x, ±y, ±z; ±4 to ±6 for rotations; 0 for a scalar.
    pub direction: i64,
}

/// A function as the file stores it.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Number of its dataset in the file, from 1.
    pub dataset: usize,
    /// The line at which it begins, from 1.
    pub line: usize,
    /// The byte at which it begins, from 0.
    pub byte: usize,
    /// Function type; 4 is a frequency response function.
    pub function_type: i64,
    /// Where the response was measured.
    pub response: NodeDirection,
    /// Where the force acted.
    pub reference: NodeDirection,
    /// Names of the components of response and reference; empty for one without a name.
    pub components: [String; 2],
    /// Abscissa, in the unit of the file.
    pub abscissa: Vec<f64>,
    /// Ordinate, in the unit of the file.
    pub ordinate: Vec<Complex<f64>>,
    /// Quantity and unit of the abscissa.
    pub abscissa_axis: AxisProperties,
    /// Quantity and unit of the ordinate's numerator.
    pub numerator_axis: AxisProperties,
    /// Quantity and unit of the ordinate's denominator.
    pub denominator_axis: AxisProperties,
    /// Minimum and increment of an even abscissa of several points.
    even: Option<[f64; 2]>,
    /// The units of the last dataset 164 before this one, else of the first after it, if there is any.
    units: Option<UnitSystem>,
}

/// Records 8 to 10 of dataset 58.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AxisProperties {
    /// Specific data type: 8 displacement, 11 velocity, 12 acceleration, 13 excitation force,
    /// 18 frequency.
    pub data_type: i64,
    /// Label of the unit, empty when none is given; a text that is no unit where the record leaves it in doubt.
    pub unit: String,
    /// Line and byte of its record in the file.
    line: usize,
    byte: usize,
}

/// An accelerance, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Frf {
    /// Where the response was measured.
    pub response: NodeDirection,
    /// Where the force acted.
    pub reference: NodeDirection,
    /// Frequencies of the bins, Hz.
    pub frequency_hz: Vec<f64>,
    /// Accelerance, (m/s²)/N, bin by bin.
    pub accelerance: Vec<Complex<f64>>,
}

impl UffFile {
    /// Reads a universal file.
    ///
    /// # Errors
    /// When the file cannot be read, is truncated or corrupt; the message names file and dataset.
    pub fn read(path: &Path) -> massline_result::Result<Self> {
        let file = path.display();
        let bytes = crate::file::read(path, MAX_BYTES).map_err(|error| {
            massline_result::Error::input("uff_not_readable", crate::file::unreadable(path, &error))
        })?;
        Self::parse(&bytes).map_err(|error| massline_result::Error::from(error).within(file))
    }

    /// Reads the bytes of a universal file.
    ///
    /// # Errors
    /// When the bytes are truncated or corrupt; the error has the number of the dataset, the line and the
    /// byte.
    pub fn parse(bytes: &[u8]) -> Result<Self, UffError> {
        let decoded = decoded_utf16(bytes);
        let mut lines = Lines::new(decoded.as_deref().unwrap_or(bytes));
        let mut file = Self::default();
        let mut systems: Vec<UnitSystem> = Vec::new();
        let mut points = 0;
        loop {
            if lines.at_end() {
                break;
            }
            while lines.peek().is_some_and(|line| line.trim_ascii().is_empty()) {
                lines.next();
            }
            lines.open_dataset();
            if !lines.next().is_some_and(lines::is_delimiter) {
                return Err(lines.error(UffFault::NoDelimiter));
            }
            let Some(kind) = lines.next() else {
                return Err(lines.error(UffFault::Truncated { wanted: "the dataset's type" }));
            };
            match kind_of(kind) {
                Some(58) => {
                    let function = read_function(kind, &mut lines, systems.last().copied())?;
                    points += function.ordinate.len();
                    if points > MOST_POINTS {
                        return Err(function.error(UffFault::TooManyPoints));
                    }
                    let list = match function.ordinate.is_empty() {
                        true => &mut file.empty,
                        false => &mut file.functions,
                    };
                    if list.len() == MOST_FUNCTIONS {
                        return Err(function.error(UffFault::TooManyFunctions));
                    }
                    list.push(function);
                }
                Some(164) => {
                    let system = unit_system::read_units(&mut lines, &mut file.notes)?;
                    if !systems.last().is_some_and(|last| last.equals(&system)) {
                        systems.push(system);
                    }
                }
                Some(_) => lines.skip_to_delimiter()?,
                None => return Err(lines.error(UffFault::NoType)),
            }
        }
        if lines.dataset() == 0 {
            return Err(lines.error(UffFault::Empty));
        }
        file.notes.extend(note_of_systems(&systems));
        // Datasets may stand in any order: the first units also hold for the functions before them.
        let first = systems.first().copied();
        for function in file.functions.iter_mut().chain(&mut file.empty) {
            function.units = function.units.or(first);
        }
        Ok(file)
    }
}

/// Most datasets of units that a note names.
const NAMED: usize = 4;

/// Says which functions the datasets 164 hold for, where they differ.
fn note_of_systems(systems: &[UnitSystem]) -> Option<String> {
    let names: Vec<String> =
        systems.iter().take(NAMED).map(|system| system.dataset.to_string()).collect();
    let more = if systems.len() > NAMED { " and others" } else { "" };
    (systems.len() > 1).then(|| {
        format!(
            "datasets {}{more}, each a dataset 164, state different units: each holds for the functions after it, the \
             first also for those before it; labels of units precede all of them",
            names.join(" and ")
        )
    })
}

/// The bytes of a file in UTF-16 with a byte order mark as UTF-8; none for other files.
fn decoded_utf16(bytes: &[u8]) -> Option<Vec<u8>> {
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    let text = is_utf16.then(|| Text::decode(bytes).ok())??;
    Some(text.text.into_owned().into_bytes())
}

/// The type of a dataset: the number at the beginning of its first line.
fn kind_of(line: &[u8]) -> Option<u32> {
    let text = line.trim_ascii();
    let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
    std::str::from_utf8(text.get(..digits)?).ok()?.parse().ok()
}

impl Function {
    /// The accelerance, converted to SI: `H = (iω)ⁿ·Y` with n = 0, 1, 2 for acceleration, velocity and
    /// displacement over force. `quantity` overrides the response quantity of the file, whose units hold all the same:
    /// those of the labels, else of dataset 164, else SI.
    ///
    /// # Errors
    /// When this is not a frequency response function, or its quantities or units are not those of a motion
    /// over a force.
    pub fn accelerance(&self, quantity: Option<Quantity>) -> Result<Frf, UffError> {
        self.converted(quantity).map(|(frf, _)| frf)
    }

    /// The accelerance, as [`Function::accelerance`], and what the function was understood to be.
    pub fn converted(
        &self,
        quantity: Option<Quantity>,
    ) -> Result<(Frf, UnderstoodFunction), UffError> {
        if !self.is_frequency_response() {
            let function_type = self.function_type;
            return Err(self.error(UffFault::FunctionType { found: function_type }));
        }
        self.check_increment()?;
        let units = units::conversion(self, quantity)?;
        let frequency_hz: Vec<f64> = self.abscissa.iter().map(|x| x * units.hertz).collect();
        let accelerance = frequency_hz
            .iter()
            .zip(&self.ordinate)
            .map(|(&f, &y)| {
                let s = Complex::new(0.0, std::f64::consts::TAU * f);
                let motion = match units.understood.quantity {
                    Quantity::Acceleration => y,
                    Quantity::Velocity => y * s,
                    Quantity::Displacement => y * s * s,
                };
                motion * units.ordinate
            })
            .collect();
        let (response, reference) = (self.response, self.reference);
        Ok((Frf { response, reference, frequency_hz, accelerance }, units.understood))
    }

    /// True for a frequency response function.
    pub fn is_frequency_response(&self) -> bool {
        self.function_type == function::FREQUENCY_RESPONSE
    }

    /// True for a coherence.
    pub fn is_coherence(&self) -> bool {
        self.function_type == function::COHERENCE
    }

    /// True for a record over time.
    pub fn is_time_response(&self) -> bool {
        self.function_type == function::TIME_RESPONSE
    }

    /// The ordinate of a record over time, in the unit of the file.
    pub fn time_samples(&self) -> Vec<f64> {
        self.ordinate.iter().map(|y| y.re).collect()
    }

    /// The factor from the ordinate of a record over time to N or m/s² by dataset 164; `None` without that
    /// dataset, and for another quantity.
    pub fn time_factor(&self) -> Option<f64> {
        units::time_factor(self)
    }

    /// Refuses an abscissa that does not rise.
    ///
    /// # Errors
    /// When its increment is zero or negative, or vanishes beside the minimum.
    pub fn check_increment(&self) -> Result<(), UffError> {
        match self.even {
            Some([minimum, value]) if minimum + value <= minimum => {
                Err(self.error(UffFault::Increment { value, minimum }))
            }
            _ => Ok(()),
        }
    }

    /// An error about one of its axes.
    fn axis_error(&self, axis: &AxisProperties, fault: UffFault) -> UffError {
        UffError { line: axis.line, byte: axis.byte, ..self.error(fault) }
    }

    /// An error about this function.
    pub fn error(&self, fault: UffFault) -> UffError {
        UffError { dataset: self.dataset, line: self.line, byte: self.byte, fault }
    }
}

/// The name of a function type.
pub fn function_type_name(function_type: i64) -> &'static str {
    function::TYPE_NAMES
        .get(usize::try_from(function_type).unwrap_or(usize::MAX))
        .copied()
        .unwrap_or("unknown")
}

#[cfg(test)]
mod foreign_tests;
#[cfg(test)]
mod tests;
