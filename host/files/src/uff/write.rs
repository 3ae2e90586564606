//! Writes frequency response functions as dataset 58.

use std::fmt::Write;

use super::{Frf, NodeDirection};

/// The encoding of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Text, 12 digits.
    Ascii,
    /// Dataset 58b, little-endian doubles.
    Binary,
}

/// A universal file with these accelerances, complex and double precision, SI.
///
/// Equidistant frequencies that the header's six digits can express are stored as minimum and increment;
/// others are stored point by point (six digits in ASCII).
pub fn write(frfs: &[Frf], encoding: Encoding) -> Vec<u8> {
    write_described(frfs, encoding, ["NONE"; 2])
}

/// As [`write()`], with two lines of at most 80 characters that describe every function.
pub fn write_described(frfs: &[Frf], encoding: Encoding, about: [&str; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for frf in frfs {
        write_one(frf, encoding, about, &mut bytes);
    }
    bytes
}

fn write_one(frf: &Frf, encoding: Encoding, [first, second]: [&str; 2], bytes: &mut Vec<u8>) {
    let even = even(&frf.frequency_hz);
    let points = frf.frequency_hz.len().min(frf.accelerance.len());
    let values = 2 + usize::from(even.is_none());
    let mut text = String::from("    -1\n    58");
    // Writing to a String cannot fail.
    let _ = match encoding {
        Encoding::Ascii => writeln!(text, "{:74}", ""),
        Encoding::Binary => {
            let length = points * values * 8;
            writeln!(text, "b{:6}{:6}{:12}{length:12}{:6}{:6}{:12}{:12}", 1, 2, 11, 0, 0, 0, 0)
        }
    };
    for line in ["accelerance", first, second, "NONE", "NONE"] {
        let _ = writeln!(text, "{line:80.80}");
    }
    let dof = |d: NodeDirection| format!(" {:10}{:10}{:4}", "NONE", d.node, d.direction);
    let (response, reference) = (dof(frf.response), dof(frf.reference));
    let _ = writeln!(text, "{:5}{:10}{:5}{:10}{response}{reference}", 4, 0, 0, 0);
    let [minimum, increment] = even.unwrap_or([0.0; 2]);
    let spacing = u8::from(even.is_some());
    let [minimum, increment, z] = [minimum, increment, 0.0].map(|v| scientific(v, 13, 5));
    let _ = writeln!(text, "{:10}{points:10}{spacing:10}{minimum}{increment}{z}", 6);
    let axes = [(18, "Frequency", "Hz"), (12, "Acceleration", "m/s^2"), (13, "Force", "N")];
    for (data_type, label, unit) in axes.into_iter().chain([(0, "NONE", "NONE")]) {
        let _ = writeln!(text, "{data_type:10}{:5}{:5}{:5} {label:20} {unit:20}", 0, 0, 0);
    }
    bytes.extend(text.as_bytes());
    let points = frf.frequency_hz.iter().zip(&frf.accelerance);
    match encoding {
        Encoding::Binary => {
            for (f, h) in points {
                let abscissa = even.is_none().then_some(*f);
                for value in abscissa.into_iter().chain([h.re, h.im]) {
                    bytes.extend(value.to_le_bytes());
                }
            }
        }
        Encoding::Ascii => {
            for (k, (f, h)) in points.enumerate() {
                if even.is_none() {
                    bytes.extend(scientific(*f, 13, 5).as_bytes());
                }
                for value in [h.re, h.im] {
                    bytes.extend(scientific(value, 20, 11).as_bytes());
                }
                let last = k + 1 == frf.frequency_hz.len().min(frf.accelerance.len());
                if even.is_none() || k % 2 == 1 || last {
                    bytes.push(b'\n');
                }
            }
        }
    }
    bytes.extend(b"    -1\n");
}

/// Formats as Fortran's `E13.5` and the like; Rust writes exponents without sign and padding.
pub(super) fn scientific(value: f64, width: usize, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    let text = match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let exponent: i32 = exponent.parse().unwrap_or(0);
            let sign = if exponent < 0 { '-' } else { '+' };
            format!("{mantissa}e{sign}{:02}", exponent.abs())
        }
        None => text,
    };
    format!("{text:>width$}")
}

/// Minimum and increment of frequencies that the header's six digits can express.
fn even(frequency: &[f64]) -> Option<[f64; 2]> {
    let (&first, &last) = (frequency.first()?, frequency.last()?);
    let increment =
        if frequency.len() > 1 { (last - first) / (frequency.len() - 1) as f64 } else { 0.0 };
    let rounded = |v: f64| scientific(v, 13, 5).trim().parse::<f64>().ok();
    let (minimum, step) = (rounded(first)?, rounded(increment)?);
    // The tolerance covers the rounding error of a double after a few operations.
    let same = |(k, &f): (usize, &f64)| (minimum + step * k as f64 - f).abs() <= 1e-12 * f.abs();
    frequency.iter().enumerate().all(same).then_some([minimum, step])
}
