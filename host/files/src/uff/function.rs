//! The header of dataset 58.

use nalgebra::Complex;

use super::columns::{Columns, unit_label};
use super::error::{UffError, UffFault};
use super::lines::Lines;
use super::unit_system::UnitSystem;
use super::values::{Binary, Shape, read_ascii, read_binary, real};
use super::{AxisProperties, Function, MOST_POINTS, NodeDirection};
use crate::encoding::label;
use crate::units::is_unstated;

/// The function type of a record over time.
pub(super) const TIME_RESPONSE: i64 = 1;
/// The function type of a frequency response function.
pub(super) const FREQUENCY_RESPONSE: i64 = 4;
/// The function type of a coherence.
pub(super) const COHERENCE: i64 = 6;

/// Names of the function types, from 0.
pub(super) const TYPE_NAMES: [&str; 28] = [
    "general or unknown",
    "time response",
    "auto spectrum",
    "cross spectrum",
    "frequency response function",
    "transmissibility",
    "coherence",
    "auto correlation",
    "cross correlation",
    "power spectral density",
    "energy spectral density",
    "probability density function",
    "spectrum",
    "cumulative frequency distribution",
    "peaks valley",
    "stress/cycles",
    "strain/cycles",
    "orbit",
    "mode indicator function",
    "force pattern",
    "partial power",
    "partial coherence",
    "eigenvalue",
    "eigenvector",
    "shock response spectrum",
    "finite impulse response filter",
    "multiple coherence",
    "order function",
];

/// Number of header lines of a dataset 58.
const HEADER_LINES: i64 = 11;
/// Largest number of header lines that a binary dataset may state.
const MOST_HEADER_LINES: i64 = 100;

/// Reads a dataset 58 from after its first line `kind` to its end.
pub(super) fn read_function(
    kind: &[u8],
    lines: &mut Lines<'_>,
    units: Option<UnitSystem>,
) -> Result<Function, UffError> {
    let (line, byte) = lines.dataset_place();
    let binary = binary_header(kind, lines)?;
    for _ in 0..5 {
        lines.record("an ID line of dataset 58")?;
    }
    let dofs = dof_record(lines)?;
    let shape = shape_record(lines)?;
    let mut axes =
        [const { AxisProperties { data_type: 0, unit: String::new(), line: 0, byte: 0 } }; 4];
    for axis in &mut axes {
        *axis = axis_record(lines)?;
    }
    let [abscissa_axis, numerator_axis, denominator_axis, _] = axes;
    let values = match binary {
        Some((binary, extra)) => {
            for _ in 0..extra {
                lines.record("a header line of dataset 58")?;
            }
            read_binary(lines, &shape, binary)?
        }
        None => read_ascii(lines, &shape)?,
    };
    lines.skip_to_delimiter()?;
    let (abscissa, ordinate) = split(&values, &shape);
    Ok(Function {
        dataset: lines.dataset(),
        line,
        byte,
        function_type: dofs.function_type,
        response: dofs.response,
        reference: dofs.reference,
        components: dofs.components,
        abscissa,
        ordinate,
        abscissa_axis,
        numerator_axis,
        denominator_axis,
        even: shape.even.filter(|_| shape.points > 1),
        units,
    })
}

/// The binary format that the first line states, with the number of additional header lines; `None` when the
/// data are text.
fn binary_header(kind: &[u8], lines: &Lines<'_>) -> Result<Option<(Binary, i64)>, UffError> {
    let text = label(kind);
    let mut fields = text.split_ascii_whitespace();
    let head = fields.next().unwrap_or_default();
    if head == "58" {
        return Ok(None);
    }
    if !head.eq_ignore_ascii_case("58b") {
        return Err(lines.error(UffFault::NoType));
    }
    let mut next = |field| match fields.next() {
        Some(text) => integer(text).ok_or_else(|| not_a_number(lines, field, text)),
        None => Err(lines.error(UffFault::Truncated { wanted: "a field of the binary header" })),
    };
    let order = next("the byte order")?;
    let format = next("the floating point format")?;
    let header = next("the number of header lines")?;
    let big_endian = match order {
        1 => false,
        2 => true,
        value => {
            let known = "1 is little-endian, 2 big-endian";
            return Err(lines.error(UffFault::Unknown { field: "byte order", value, known }));
        }
    };
    if format != 2 {
        let (field, known) = ("floating point format", "only 2, IEEE 754, is read");
        return Err(lines.error(UffFault::Unknown { field, value: format, known }));
    }
    if !(HEADER_LINES..=MOST_HEADER_LINES).contains(&header) {
        let (field, known) = ("number of header lines", "dataset 58 has 11");
        return Err(lines.error(UffFault::Unknown { field, value: header, known }));
    }
    Ok(Some((Binary { big_endian }, header - HEADER_LINES)))
}

/// Record 6.
struct Dofs {
    function_type: i64,
    response: NodeDirection,
    reference: NodeDirection,
    /// Names of the components of response and reference.
    components: [String; 2],
}

impl Dofs {
    /// The DOFs by fixed columns, `2(I5,I10),2(1X,10A1,I10,I4)`.
    fn in_columns(columns: &Columns<'_>) -> Option<Self> {
        let place = |from: usize| {
            let direction = columns.integer(from + 20, 4).filter(|d| (-6..=6).contains(d));
            Some(NodeDirection { node: columns.integer(from + 10, 10)?, direction: direction? })
        };
        Some(Self {
            function_type: columns.integer(0, 5)?,
            response: place(31)?,
            reference: place(56)?,
            components: [31, 56].map(|from| component(&columns.text(from, 10))),
        })
    }

    /// The DOFs by counting words: a name that is longer than its field shifts the columns after it.
    fn by_words(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let integer = |k: usize| words.get(k)?.parse().ok();
        let place =
            |k: usize| Some(NodeDirection { node: integer(k)?, direction: integer(k + 1)? });
        Some(Self {
            function_type: integer(0)?,
            response: place(5)?,
            reference: place(8)?,
            components: [words.get(4)?, words.get(7)?].map(|name| component(name)),
        })
    }

    fn are_at(&self, other: &Self) -> bool {
        (self.response, self.reference) == (other.response, other.reference)
    }
}

/// The name of a component; empty for one without a name.
fn component(name: &str) -> String {
    if is_unstated(name) { String::new() } else { name.to_owned() }
}

/// Reads record 6: type and DOFs.
fn dof_record(lines: &mut Lines<'_>) -> Result<Dofs, UffError> {
    let record = lines.record("record 6, the DOFs,")?;
    let by_bytes = Columns::by_bytes(record);
    // The blanks between the fields tell their columns from others that happen to hold numbers.
    let by_characters = Columns::by_characters(record);
    let layouts = [Some(&by_bytes), by_characters.as_ref()];
    let separated = layouts.into_iter().flatten().filter(|columns| columns.are_blank([30, 55]));
    let mut readings = separated.filter_map(Dofs::in_columns);
    let text = label(record);
    let refused = |field| not_a_number(lines, field, &text);
    match (readings.next(), readings.next()) {
        (Some(dofs), Some(other)) if !dofs.are_at(&other) => Err(refused(
            "response and reference DOFs that do not depend on how letters are counted",
        )),
        (Some(dofs), _) => Ok(dofs),
        (None, _) => Dofs::in_columns(&by_bytes)
            .or_else(|| Dofs::by_words(&text))
            .ok_or_else(|| refused("response and reference DOFs")),
    }
}

/// Record 7: format of the data, `3I10,3E13.5`.
fn shape_record(lines: &mut Lines<'_>) -> Result<Shape, UffError> {
    let record = lines.record("record 7, the form of the data,")?;
    let columns = Columns::by_bytes(record);
    let form = field(lines, &columns, 0, 10, "the ordinate data type")?;
    let points = field(lines, &columns, 10, 10, "the number of values")?;
    let spacing = field(lines, &columns, 20, 10, "the abscissa spacing")?;
    let (complex, double) = match form {
        2 => (false, false),
        4 => (false, true),
        5 => (true, false),
        6 => (true, true),
        value => {
            let known = "2, 4, 5 and 6 are real and complex, single and double";
            return Err(lines.error(UffFault::Unknown {
                field: "ordinate data type",
                value,
                known,
            }));
        }
    };
    let points = usize::try_from(points).map_err(|_| {
        let known = "it cannot be negative";
        lines.error(UffFault::Unknown { field: "number of values", value: points, known })
    })?;
    if points > MOST_POINTS {
        return Err(lines.error(UffFault::TooManyPoints));
    }
    let even = match spacing {
        0 => None,
        1 => {
            let minimum = real_field(lines, &columns, 30, 13, "the abscissa minimum")?;
            Some([minimum, real_field(lines, &columns, 43, 13, "the abscissa increment")?])
        }
        value => {
            let (field, known) = ("abscissa spacing", "0 is uneven, 1 even");
            return Err(lines.error(UffFault::Unknown { field, value, known }));
        }
    };
    Ok(Shape { complex, double, points, even })
}

/// Records 8 to 11: quantity and unit of an axis, `I10,3I5,2(1X,20A1)`.
fn axis_record(lines: &mut Lines<'_>) -> Result<AxisProperties, UffError> {
    let record = lines.record("records 8 to 11, the axes,")?;
    let data_type = field(lines, &Columns::by_bytes(record), 0, 10, "the specific data type")?;
    let (line, byte) = lines.place();
    Ok(AxisProperties { data_type, unit: unit_label(record), line, byte })
}

/// Splits the values of the file into abscissa and ordinate.
fn split(values: &[f64], shape: &Shape) -> (Vec<f64>, Vec<Complex<f64>>) {
    let mut abscissa = Vec::with_capacity(shape.points);
    let mut ordinate = Vec::with_capacity(shape.points);
    for (k, point) in values.chunks_exact(shape.per_point()).enumerate() {
        let rest = match shape.even {
            Some([minimum, increment]) => {
                abscissa.push(minimum + increment * k as f64);
                point
            }
            None => {
                abscissa.extend(point.first());
                point.get(1..).unwrap_or_default()
            }
        };
        let part = |k: usize| rest.get(k).copied().unwrap_or(0.0);
        ordinate.push(Complex::new(part(0), part(1)));
    }
    (abscissa, ordinate)
}

fn integer(text: &str) -> Option<i64> {
    text.trim().parse().ok()
}

fn not_a_number(lines: &Lines<'_>, field: &'static str, text: &str) -> UffError {
    let text = text.chars().take(80).collect();
    lines.error(UffFault::NotANumber { field, text })
}

/// An integer in fixed columns.
fn field(
    lines: &Lines<'_>,
    columns: &Columns<'_>,
    from: usize,
    width: usize,
    name: &'static str,
) -> Result<i64, UffError> {
    let integer = columns.integer(from, width);
    integer.ok_or_else(|| not_a_number(lines, name, &columns.text(from, width)))
}

fn real_field(
    lines: &Lines<'_>,
    columns: &Columns<'_>,
    from: usize,
    width: usize,
    name: &'static str,
) -> Result<f64, UffError> {
    let text = columns.text(from, width);
    real(&text).filter(|v| v.is_finite()).ok_or_else(|| not_a_number(lines, name, &text))
}
