use nalgebra::Complex;

use super::*;

/// Written by pyuff; `generate.py` beside it documents what each function holds.
const VARIANTS: &[u8] = include_bytes!("../../../../tests/data/uff/variants.uff");

fn variant(k: usize) -> Function {
    UffFile::parse(VARIANTS).unwrap().functions[k].clone()
}

/// The accelerance that every variant holds.
fn expected(k: usize) -> Complex<f64> {
    Complex::new(2.0, -0.5) * (k + 1) as f64
}

fn check(function: &Function, tolerance: f64) {
    let frf = function.accelerance(None).unwrap();
    assert_eq!(frf.frequency_hz.len(), 12);
    for (k, (&f, &h)) in frf.frequency_hz.iter().zip(&frf.accelerance).enumerate() {
        // Exact, because the header's six digits can express 10 Hz.
        assert_eq!(f, 10.0 * (k + 1) as f64);
        let error = (h - expected(k)).norm() / expected(k).norm();
        assert!(error < tolerance, "line {k}: {error:e}");
    }
}

#[test]
fn pyuff_s_forms_are_read() {
    // ASCII doubles have 12 digits, singles 6; binary is exact except for the conversion.
    let [double, single] = [1e-11, 5e-6];
    for (k, tolerance) in [
        (0, double),
        (1, 1e-15),
        (2, double),
        (3, 1e-15),
        (4, single),
        (5, single),
        (6, 1e-15),
        (7, double),
        (8, double),
        (9, double),
        (10, double),
        (17, double),
    ] {
        check(&variant(k), tolerance);
    }
}

#[test]
fn real_functions_are_read() {
    for k in [11, 12] {
        let function = variant(k);
        let real: Vec<f64> = function.ordinate.iter().map(|y| y.re).collect();
        let expected: Vec<f64> = (1..=12).map(|k| f64::from(2 * k)).collect();
        assert_eq!(real, expected);
        assert!(function.ordinate.iter().all(|y| y.im == 0.0));
    }
}

#[test]
fn node_and_direction_are_read_even_where_a_long_name_moves_the_columns() {
    let function = variant(0);
    assert_eq!(function.response, NodeDirection { node: 1, direction: 1 });
    assert_eq!(function.reference, NodeDirection { node: 2, direction: 3 });
    // Names longer than their fields shift the columns.
    assert_eq!(variant(17).reference, NodeDirection { node: 2, direction: 3 });
}

#[test]
fn what_is_no_frf_is_named() {
    let error = |k: usize| variant(k).accelerance(None).unwrap_err();
    assert!(error(13).to_string().contains("function type 6 (coherence)"), "{}", error(13));
    assert!(error(14).to_string().contains("stress (data type 2)"), "{}", error(14));
    assert!(error(15).to_string().contains("\"furlong\" is not a known unit of acceleration"));
    assert!(error(16).to_string().contains("denominator is displacement"));
    // Four datasets of nodes and units precede the functions.
    assert_eq!(error(13).dataset, 18);
    assert!(error(13).to_string().starts_with("dataset 18, line "));
}

#[test]
fn the_user_may_say_what_the_response_is() {
    let frf = variant(14).accelerance(Some(Quantity::Acceleration)).unwrap();
    // The file has 12 digits.
    assert!((frf.accelerance[3] - expected(3)).norm() < 1e-10);
    // A label is no unit of another quantity.
    let error = variant(9).accelerance(Some(Quantity::Velocity)).unwrap_err();
    assert!(error.to_string().contains("\"mm/s^2\" is not a known unit of velocity"), "{error}");
    let mobility = variant(0).accelerance(Some(Quantity::Velocity)).unwrap();
    let s = Complex::new(0.0, std::f64::consts::TAU * 10.0);
    assert!((mobility.accelerance[0] - expected(0) * s).norm() < 1e-10);
}

#[test]
fn units_of_dataset_164_are_used() {
    let text = String::from_utf8_lossy(VARIANTS).into_owned();
    let first = text.find("    58 ").unwrap();
    let second = text[first..].find("\n    -1\n").unwrap() + first;
    let function = &text[first..second];
    let function = function.replacen("m/s^2", "NONE ", 1);
    let millimetres = "         5   mm (milli newton)         1\n\
                       1.0D+03 1.0D+03 1.0D+00\n 0.0D+00";
    let file = format!("    -1\n   164\n{millimetres}\n    -1\n    -1\n{function}\n    -1\n");
    let file = UffFile::parse(file.as_bytes()).unwrap();
    assert!(file.notes.is_empty(), "{:?}", file.notes);
    // mm/s² per mN is m/s² per N.
    let frf = file.functions[0].accelerance(None).unwrap();
    assert!((frf.accelerance[0] - expected(0)).norm() < 1e-10);
    let own = "         9          user made         1\n1.0D+03 1.0D+00 1.0D+00\n 0.0D+00";
    let file = format!("    -1\n   164\n{own}\n    -1\n    -1\n{function}\n    -1\n");
    let frf = UffFile::parse(file.as_bytes()).unwrap().functions[0].accelerance(None).unwrap();
    assert!((frf.accelerance[0] - expected(0) * 1e-3).norm() < 1e-10);
}

#[test]
fn factors_that_do_not_belong_to_the_code_are_noted() {
    let feet = "    -1\n   164\n         1            SI units         1\n   3.28D+00   2.2D-01   \
                1.8D+00\n   4.6D+02\n    -1\n";
    let file = UffFile::parse(feet.as_bytes()).unwrap();
    assert!(file.notes[0].contains("do not belong to units code 1"), "{:?}", file.notes);
}

#[test]
fn every_truncation_is_an_error_or_ends_between_datasets() {
    let whole = UffFile::parse(VARIANTS).unwrap();
    // Truncates the file at every length within the first functions, and at a sample of the rest.
    for length in (0..6000).chain((6000..VARIANTS.len()).step_by(17)) {
        match UffFile::parse(&VARIANTS[..length]) {
            Err(error) => {
                assert!(error.byte <= length && error.dataset <= whole.functions.len() + 4);
            }
            // Complete datasets, perhaps without the last line end.
            Ok(part) => {
                assert!(VARIANTS[..length].trim_ascii_end().ends_with(b"-1"), "{length}");
                assert!(part.functions.len() <= whole.functions.len());
            }
        }
    }
}

#[test]
fn a_truncated_function_tells_where() {
    let place = VARIANTS.windows(4).position(|w| w == b"  58").unwrap();
    let error = UffFile::parse(&VARIANTS[..place + 1300]).unwrap_err();
    assert_eq!(error.dataset, 5);
    assert!(error.to_string().contains("truncated"), "{error}");
    assert_eq!(error.fault.code(), "uff_truncated");
}

#[test]
fn a_header_that_lies_costs_no_memory() {
    let text = String::from_utf8_lossy(VARIANTS).into_owned();
    let first = text.find("    -1\n    58 ").unwrap();
    let end = text[first + 8..].find("\n    -1\n").unwrap() + first + 16;
    let stating = |points: &str| {
        let stated = format!("6{points:>10}         1");
        let lie = text[first..end].replacen("6        12         1", &stated, 1);
        assert_ne!(lie, text[first..end]);
        UffFile::parse(lie.as_bytes()).unwrap_err()
    };
    let error = stating("8000000");
    assert!(matches!(error.fault, UffFault::TooFewValues { wanted: 16_000_000, .. }), "{error}");
    assert_eq!(stating("999999999").fault, UffFault::TooManyPoints);
    let lie = text[first..end].replacen("6        12         1", "6        11         1", 1);
    let error = UffFile::parse(lie.as_bytes()).unwrap_err();
    assert_eq!(error.fault, UffFault::TooManyValues { wanted: 22 });
}

#[test]
fn corrupt_text_is_named_with_its_line() {
    let text = String::from_utf8_lossy(VARIANTS).into_owned();
    let first = text.find("    -1\n    58 ").unwrap();
    let end = text[first + 8..].find("\n    -1\n").unwrap() + first + 16;
    let corrupt = text[first..end].replacen("4.00000000000e+00", "4.0000x000000e+00", 1);
    let error = UffFile::parse(corrupt.as_bytes()).unwrap_err();
    assert_eq!(error.line, 14);
    assert!(error.to_string().starts_with("dataset 1, line 14 (byte "), "{error}");
    let corrupt = text[first..end].replacen("        12         1", "        1z         1", 1);
    assert_eq!(UffFile::parse(corrupt.as_bytes()).unwrap_err().line, 9);
    // A line break within the fixed columns is no line break of the message.
    let error = UffFault::NotANumber { field: "data values", text: "4.0\r\n5".into() };
    assert!(error.to_string().starts_with(r#""4.0\r\n5" is not a number"#), "{error}");
    let error = UffFile::parse(b"hello\n").unwrap_err();
    assert!(!error.to_string().contains("  "), "nothing that a wrapped line would tear: {error}");
    assert_eq!(error.fault, UffFault::NoDelimiter);
    assert_eq!(UffFile::parse(b"\n \n").unwrap_err().fault, UffFault::Empty);
}

#[test]
fn a_binary_dataset_that_lost_a_byte_is_refused() {
    let place = VARIANTS.windows(3).position(|w| w == b"58b").unwrap();
    let mut corrupt = VARIANTS.to_vec();
    corrupt.remove(place + 1100);
    let error = UffFile::parse(&corrupt).unwrap_err();
    assert_eq!(error.fault, UffFault::BinaryLength { bytes: 192 });
}

#[test]
fn touching_columns_are_read() {
    let text = String::from_utf8_lossy(VARIANTS).into_owned();
    let first = text.find("    -1\n    58 ").unwrap();
    let end = text[first + 8..].find("\n    -1\n").unwrap() + first + 16;
    // E20.12 with a sign and a three-digit exponent fills its column.
    let dense = text[first..end].replacen(
        "   2.00000000000e+00  -5.00000000000e-01",
        "2.0000000000000E+000-5.00000000000E-001",
        1,
    );
    assert_ne!(dense, text[first..end]);
    assert_eq!(UffFile::parse(dense.as_bytes()).unwrap().functions[0].ordinate[0], expected(0));
}

#[test]
fn big_endian_singles_and_mixed_widths_are_read() {
    let text = String::from_utf8_lossy(VARIANTS).into_owned();
    let first = text.find("    -1\n    58 ").unwrap();
    let header: Vec<&str> = text[first..].lines().take(13).collect();
    let build = |kind: &str, shape: &str, data: &[u8]| {
        let mut lines: Vec<String> = header.iter().map(|l| (*l).to_owned()).collect();
        lines[1] = kind.to_owned();
        lines[8] = format!("{shape}{}", &header[8][30..]);
        let mut bytes = (lines.join("\n") + "\n").into_bytes();
        bytes.extend(data);
        bytes.extend(b"    -1\n");
        bytes
    };
    let big = "    58b     2     2          11          16     0     0           0           0";
    let little = big.replacen("b     2", "b     1", 1);
    let data: Vec<u8> = [2.0_f32, -0.5, 4.0, -1.0].iter().flat_map(|v| v.to_be_bytes()).collect();
    let file = build(big, "         5         2         1", &data);
    let read = UffFile::parse(&file).unwrap().functions[0].clone();
    assert_eq!(read.ordinate, [expected(0), expected(1)]);
    assert_eq!(read.abscissa, [10.0, 20.0]);
    // The format's own form of an uneven abscissa: single precision, beside doubles.
    let mut data = Vec::new();
    for (x, y) in [(10.0_f32, expected(0)), (25.0, expected(1))] {
        data.extend(x.to_le_bytes());
        data.extend(y.re.to_le_bytes());
        data.extend(y.im.to_le_bytes());
    }
    let file = build(&little, "         6         2         0", &data);
    let read = UffFile::parse(&file).unwrap().functions[0].clone();
    assert_eq!(read.ordinate, [expected(0), expected(1)]);
    assert_eq!(read.abscissa, [10.0, 25.0]);
    let ibm = big.replacen("     2     2 ", "     2     3 ", 1);
    let error = UffFile::parse(&build(&ibm, "         6         2         0", &data)).unwrap_err();
    assert!(error.to_string().contains("IEEE 754"), "{error}");
}

#[test]
fn what_is_written_reads_back() {
    let frf = |frequency_hz: Vec<f64>| {
        let accelerance = (0..frequency_hz.len()).map(expected).collect();
        let response = NodeDirection { node: 12, direction: -3 };
        let reference = NodeDirection { node: 4, direction: 2 };
        Frf { response, reference, frequency_hz, accelerance }
    };
    let even = frf((0..7).map(|k| 10.0 + 2.5 * f64::from(k)).collect());
    let uneven = frf(vec![10.0, 11.0, 13.5, 20.0]);
    let fine = frf((0..5).map(|k| 1.0 + f64::from(k) / 3.0).collect());
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let bytes = write(&[even.clone(), uneven.clone(), fine.clone()], encoding);
        let file = UffFile::parse(&bytes).unwrap();
        let read: Vec<Frf> = file.functions.iter().map(|f| f.accelerance(None).unwrap()).collect();
        assert_eq!(read[..2], [even.clone(), uneven.clone()], "{encoding:?}");
        for (got, wanted) in read[2].frequency_hz.iter().zip(&fine.frequency_hz) {
            // ASCII has six digits.
            assert!((got - wanted).abs() < 5e-6 * wanted);
        }
    }
}
