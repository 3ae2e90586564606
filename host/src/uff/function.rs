//! The header of dataset 58.

use nalgebra::Complex;

use super::error::{UffError, UffFault};
use super::lines::Lines;
use super::units::UnitSystem;
use super::values::{Binary, Shape, read_ascii, read_binary, real};
use super::{AxisProperties, Function, MOST_POINTS, NodeDirection};

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
    let binary = binary_header(kind, lines)?;
    for _ in 0..5 {
        lines.text("an ID line of dataset 58")?;
    }
    let (function_type, response, reference) = dof_record(lines)?;
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
                lines.text("a header line of dataset 58")?;
            }
            read_binary(lines, &shape, binary)?
        }
        None => read_ascii(lines, &shape)?,
    };
    lines.skip_to_delimiter()?;
    let (abscissa, ordinate) = split(&values, &shape);
    let (line, byte) = lines.dataset_place();
    Ok(Function {
        dataset: lines.dataset(),
        line,
        byte,
        function_type,
        response,
        reference,
        abscissa,
        ordinate,
        abscissa_axis,
        numerator_axis,
        denominator_axis,
        units,
    })
}

/// The binary format that the first line states, with the number of additional header lines; `None` when the
/// data are text.
fn binary_header(kind: &[u8], lines: &Lines<'_>) -> Result<Option<(Binary, i64)>, UffError> {
    let text = String::from_utf8_lossy(kind);
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

/// Record 6: type and DOFs, `2(I5,I10),2(1X,10A1,I10,I4)`.
fn dof_record(lines: &mut Lines<'_>) -> Result<(i64, NodeDirection, NodeDirection), UffError> {
    let text = lines.text("record 6, the DOFs,")?;
    let function_type = field(lines, &text, 0, 5, "the function type")?;
    let words: Vec<&str> = text.split_whitespace().collect();
    let fixed = [(41, 10), (51, 4), (66, 10), (76, 4)]
        .map(|(from, width)| column(&text, from, width).and_then(integer));
    // A name longer than its field shifts the columns after it; the fields are then found by counting words.
    let counted = [5, 6, 8, 9].map(|k: usize| words.get(k).copied().and_then(integer));
    let numbers = all(fixed)
        .or_else(|| all(counted))
        .ok_or_else(|| not_a_number(lines, "response and reference DOFs", &text))?;
    let [node, direction, ref_node, ref_direction] = numbers;
    let reference = NodeDirection { node: ref_node, direction: ref_direction };
    Ok((function_type, NodeDirection { node, direction }, reference))
}

/// Record 7: format of the data, `3I10,3E13.5`.
fn shape_record(lines: &mut Lines<'_>) -> Result<Shape, UffError> {
    let text = lines.text("record 7, the form of the data,")?;
    let form = field(lines, &text, 0, 10, "the ordinate data type")?;
    let points = field(lines, &text, 10, 10, "the number of values")?;
    let spacing = field(lines, &text, 20, 10, "the abscissa spacing")?;
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
    let points = usize::try_from(points).ok().filter(|&n| n > 0).ok_or_else(|| {
        let known = "at least one is needed";
        lines.error(UffFault::Unknown { field: "number of values", value: points, known })
    })?;
    if points > MOST_POINTS {
        return Err(lines.error(UffFault::TooManyPoints));
    }
    let even = match spacing {
        0 => None,
        1 => {
            let minimum = real_field(lines, &text, 30, 13, "the abscissa minimum")?;
            Some([minimum, real_field(lines, &text, 43, 13, "the abscissa increment")?])
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
    let text = lines.text("records 8 to 11, the axes,")?;
    let data_type = field(lines, &text, 0, 10, "the specific data type")?;
    let unit = column(&text, 47, 20).unwrap_or_default().trim();
    let unit = if unit.eq_ignore_ascii_case("none") { "" } else { unit };
    let (line, byte) = lines.place();
    Ok(AxisProperties { data_type, unit: unit.to_owned(), line, byte })
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

/// Characters `from..from + width` of a line, `None` when it is shorter or empty there.
fn column(text: &str, from: usize, width: usize) -> Option<&str> {
    let mut places = text.char_indices().map(|(at, _)| at).chain([text.len()]);
    let start = places.nth(from)?;
    let end = if width == 0 { start } else { places.nth(width - 1).unwrap_or(text.len()) };
    text.get(start..end).filter(|column| !column.trim().is_empty())
}

fn all(values: [Option<i64>; 4]) -> Option<[i64; 4]> {
    let [a, b, c, d] = values;
    Some([a?, b?, c?, d?])
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
    text: &str,
    from: usize,
    width: usize,
    name: &'static str,
) -> Result<i64, UffError> {
    let text = column(text, from, width).unwrap_or_default();
    integer(text).ok_or_else(|| not_a_number(lines, name, text))
}

fn real_field(
    lines: &Lines<'_>,
    text: &str,
    from: usize,
    width: usize,
    name: &'static str,
) -> Result<f64, UffError> {
    let text = column(text, from, width).unwrap_or_default();
    real(text).filter(|v| v.is_finite()).ok_or_else(|| not_a_number(lines, name, text))
}
