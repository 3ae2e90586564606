//! MATLAB 5 file: the matrices of the other numeric formats, and texts with units, frame and convention.
//!
//! Written here because no library in Rust writes the format (MathWorks, "MAT-File Format", level 5): a header of 128
//! bytes, then an element for each matrix. An element is a tag (type, number of bytes), the data, and zeros up to a
//! multiple of eight bytes; the element of a matrix holds four more: flags, size, name, values by columns.

use super::heading;
use super::subject::ExportedResult;
use massline_result::Result;

const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;

/// Classes of a matrix.
const CHARACTERS: u32 = 4;
const DOUBLES: u32 = 6;

/// A file. What the result does not have is NaN.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let body = &exported.body;
    let placement = &exported.placement;
    let about = format!("MATLAB 5.0 MAT-file, Platform: any, written by {}", heading::PROGRAM);
    let mut bytes = format!("{about:116.116}").into_bytes();
    // No subsystem data; version 1.0; the order of the bytes.
    bytes.extend([0; 8]);
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend(b"IM");
    let ten = |values: Option<super::Vector10>| match values {
        Some(values) => values.iter().copied().collect(),
        None => vec![f64::NAN; 10],
    };
    let [low, high] = exported.interval().map_or([None; 2], |ends| ends.map(Some));
    let covariance = exported.covariance().map(|c| c.as_slice().to_vec());
    let column = [10, 1];
    for (name, size, values) in [
        ("value", column, ten(Some(exported.theta()))),
        ("sigma", column, ten(exported.sigma())),
        ("low95", column, ten(low)),
        ("high95", column, ten(high)),
        ("covariance", [10, 10], covariance.unwrap_or(vec![f64::NAN; 100])),
        ("mass", [1, 1], vec![body.mass]),
        ("center_of_mass", [3, 1], body.center_of_mass.as_slice().to_vec()),
        ("inertia", [3, 3], body.inertia.as_slice().to_vec()),
        ("frame_origin", [3, 1], placement.origin.as_slice().to_vec()),
        ("frame_axes", [3, 3], placement.axes.as_slice().to_vec()),
    ] {
        let values: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
        matrix(&mut bytes, name, DOUBLES, size, (DOUBLE, values));
    }
    characters(&mut bytes, "order", &heading::order());
    for (name, text) in super::npz::texts(exported) {
        characters(&mut bytes, name, &[&text]);
    }
    Ok(bytes)
}

/// A matrix of characters with a text in each row, padded with blanks.
fn characters(bytes: &mut Vec<u8>, name: &str, texts: &[&str]) {
    let rows: Vec<Vec<u16>> = texts.iter().map(|text| text.encode_utf16().collect()).collect();
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    let at = |row: &Vec<u16>, k: usize| row.get(k).copied().unwrap_or(u16::from(b' '));
    let by_columns = (0..width).flat_map(|k| rows.iter().map(move |row| at(row, k)));
    let values = by_columns.flat_map(u16::to_le_bytes).collect();
    matrix(bytes, name, CHARACTERS, [rows.len(), width], (UINT16, values));
}

fn matrix(
    bytes: &mut Vec<u8>,
    name: &str,
    class: u32,
    size: [usize; 2],
    (kind, values): (u32, Vec<u8>),
) {
    let mut inner = Vec::new();
    element(&mut inner, UINT32, &[class.to_le_bytes(), [0; 4]].concat());
    element(&mut inner, INT32, &size.map(|n| (n as i32).to_le_bytes()).concat());
    element(&mut inner, INT8, name.as_bytes());
    element(&mut inner, kind, &values);
    element(bytes, MATRIX, &inner);
}

fn element(bytes: &mut Vec<u8>, kind: u32, data: &[u8]) {
    bytes.extend(kind.to_le_bytes());
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_begin_at_multiples_of_eight_bytes() {
        let mut bytes = Vec::new();
        matrix(&mut bytes, "mass", DOUBLES, [1, 1], (DOUBLE, 1.5_f64.to_le_bytes().into()));
        // Tag 8, flags 16, size 16, name 16, value 16.
        assert_eq!(bytes.len(), 72);
        assert_eq!(bytes[..8], [14, 0, 0, 0, 64, 0, 0, 0]);
        assert_eq!(bytes[64..], 1.5_f64.to_le_bytes());
    }

    #[test]
    fn texts_are_matrices_of_characters_by_columns() {
        let mut bytes = Vec::new();
        characters(&mut bytes, "order", &["cx", "m"]);
        let values: Vec<u8> = [b'c', 0, b'm', 0, b'x', 0, b' ', 0].into();
        assert!(bytes.ends_with(&values), "{bytes:?}");
    }
}
