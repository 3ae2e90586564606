//! Files as other programs write them: units, their places and encodings, and words for no number.

use nalgebra::Complex;

use super::contradiction::OtherUnit;
use super::*;
use crate::units::POUND_FORCE;
use massline_shared::STANDARD_GRAVITY as G;

/// What every function holds: `Y` at 10 and 20 Hz.
const Y: [f64; 2] = [3.0, -1.5];

/// Type, name and unit of an axis.
type Axis<'a> = (i64, &'a str, &'a [u8]);

/// A function whose numerator and denominator have these types, names and units.
fn dataset(numerator: Axis<'_>, denominator: Axis<'_>) -> Vec<u8> {
    let mut bytes = b"    -1\n    58\nFRF\nNONE\nNONE\nNONE\nNONE\n".to_vec();
    bytes.extend(
        b"    4         0    0         0       NONE         1   1       NONE         2   3\n",
    );
    bytes.extend(b"         5         2         1  1.00000E+01  1.00000E+01  0.00000E+00\n");
    let frequency = (18, "Frequency", &b"Hz"[..]);
    for (data_type, name, unit) in [frequency, numerator, denominator, (0, "NONE", b"NONE")] {
        // Fields of 20 bytes, as printf("%-20s") pads them.
        let pad = " ".repeat(20_usize.saturating_sub(name.len()));
        bytes.extend(format!("{data_type:10}    0    0    0 {name}{pad} ").bytes());
        bytes.extend(unit);
        bytes.push(b'\n');
    }
    bytes.extend(
        format!("{:13.5E}{:13.5E}{:13.5E}{:13.5E}\n    -1\n", Y[0], 0.0, Y[1], 0.0).bytes(),
    );
    bytes
}

fn units_of(code: i64, length: f64, force: f64) -> Vec<u8> {
    let system =
        format!("{code:10}{:20}{:10}\n{length:25.17E}{force:25.17E}{:25.17E}", "units", 1, 1.0);
    format!("    -1\n   164\n{system}\n{:25.17E}\n    -1\n", 0.0).into_bytes()
}

/// The factor from the file to SI of the first function, or the error.
fn factor(bytes: &[u8], quantity: Option<Quantity>) -> Result<f64, UffError> {
    let file = UffFile::parse(bytes)?;
    let frf = file.functions[0].accelerance(quantity)?;
    assert_eq!(frf.frequency_hz, [10.0, 20.0]);
    let factors: Vec<Complex<f64>> = frf.accelerance.iter().zip(Y).map(|(h, y)| h / y).collect();
    assert!((factors[0] - factors[1]).norm() < 1e-9 * factors[0].norm(), "{factors:?}");
    Ok(factors[0].re)
}

fn understood(bytes: &[u8]) -> UnderstoodFunction {
    UffFile::parse(bytes).unwrap().functions[0].converted(None).unwrap().1
}

fn check(bytes: &[u8], quantity: Option<Quantity>, expected: f64) {
    let value = factor(bytes, quantity).unwrap();
    // The numbers of the file have six digits and the factors more.
    assert!((value / expected - 1.0).abs() < 1e-9, "{value} for {expected}");
}

const ACCELERANCE: Option<Quantity> = Some(Quantity::Acceleration);

#[test]
fn a_stated_quantity_leaves_the_units_in_force() {
    check(&dataset((0, "Acceleration", b"g/N"), (0, "NONE", b"NONE")), ACCELERANCE, G);
    check(&dataset((1, "Acceleration", b"g"), (1, "Force", b"lbf")), ACCELERANCE, G / POUND_FORCE);
    check(
        &dataset((12, "Acceleration", b"G"), (13, "Force", b"lbF")),
        ACCELERANCE,
        G / POUND_FORCE,
    );
    check(&dataset((0, "NONE", b"mm/s^2"), (0, "NONE", b"KN")), ACCELERANCE, 1e-6);
    let millimetres = units_of(5, 1e3, 1e3);
    let unlabelled = dataset((1, "NONE", b"NONE"), (1, "NONE", b"NONE"));
    check(&[&millimetres[..], &units_of(9, 1e3, 1.0), &unlabelled].concat(), ACCELERANCE, 1e-3);
    let error = factor(&dataset((0, "x", b"furlong"), (0, "", b"N")), ACCELERANCE).unwrap_err();
    assert!(
        error.to_string().contains("\"furlong\" is not a known unit of acceleration"),
        "{error}"
    );
    // Without it, a ratio says by itself that the denominator is a force.
    check(&dataset((12, "Acceleration", b"g/N"), (0, "NONE", b"NONE")), None, G);
}

#[test]
fn a_unit_is_read_or_refused() {
    for (motion, force, expected) in [
        (&b"m s-2"[..], &b"N"[..], 1.0),
        (b"m.s^-2", b"KN", 1e-3),
        (b"g's", b"N", G),
        (b"mg", b"N", 1e-3 * G),
        (b"1/kg", b"N", 1.0),
        (b"m/(N s^2)", b"NONE", 1.0),
        (b"m/s^2 rms", b"N rms", 1.0),
        (b"(1/N)*(m/s\xb2)", b"N", 1.0),
        (b"m/s\xb2", b"N", 1.0),
        ("m/s²".as_bytes(), b"N", 1.0),
        (b"g/lbf", b"lbf", G / POUND_FORCE),
        (b"in/s^2", b"kip", 0.0254 / (1e3 * POUND_FORCE)),
    ] {
        check(&dataset((12, "Acceleration", motion), (13, "Force", force)), None, expected);
    }
    for (motion, force, words) in [
        (&b"m/s^2"[..], &b"V"[..], "needs the sensitivity"),
        (b"counts", b"N", "needs the sensitivity"),
        (b"g pk-pk", b"N", "peak-to-peak"),
        (b"g rms", b"N peak", "rms"),
        (b"g/N", b"lbf", "\"lbf\" is not a known unit of force"),
        (b"1/kg", b"lbf", "\"lbf\" is not a known unit of force"),
        (b"m/s^2", b"mn", "\"mn\" is not a known unit of force"),
        (b"N", b"m/s^2", "is not a known unit"),
        (b"\xb2", b"N", "is not a known unit"),
    ] {
        let error = factor(&dataset((12, "a", motion), (13, "f", force)), None).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
        assert_eq!(error.fault.code(), "uff_wrong_units");
    }
}

#[test]
fn names_in_other_alphabets_move_no_unit() {
    for name in ["Kraft Stößel", "加速度", "Accélération", "力", "Ускорение"] {
        check(&dataset((12, name, b"mm/s^2"), (13, name, b"kN")), None, 1e-6);
        check(&dataset((12, name, b"g"), (13, name, b"lbf")), None, G / POUND_FORCE);
    }
    let error =
        factor(&dataset((12, "Acceleration", b"g"), (13, "Force of the hammer 1", b"kN")), None);
    assert!(error.unwrap_err().to_string().contains("is not a known unit of force"));
}

#[test]
fn dataset_164_holds_wherever_it_stands_and_a_label_precedes_it() {
    let unlabelled = dataset((12, "NONE", b"NONE"), (13, "NONE", b"NONE"));
    let inches = units_of(7, 39.370_078_740_157_48, 0.224_808_943_099_71);
    let expected = 0.0254 / POUND_FORCE;
    for order in [[&inches, &unlabelled], [&unlabelled, &inches]] {
        let bytes = order.map(Vec::as_slice).concat();
        check(&bytes, None, expected);
        let understood = understood(&bytes);
        assert_eq!(
            (understood.unit.as_str(), understood.source),
            ("(in/s^2)/lbf", UnitSource::Dataset164)
        );
        assert_eq!(understood.contradiction, None);
    }
    // A label and the dataset: the label holds, and the contradiction is kept.
    let labelled = dataset((12, "NONE", b"m/s^2"), (13, "NONE", b"N"));
    let bytes = [&labelled[..], &inches].concat();
    check(&bytes, None, 1.0);
    let contradiction = understood(&bytes).contradiction.unwrap();
    assert_eq!(contradiction.dataset, 2);
    assert!((contradiction.factor / expected - 1.0).abs() < 1e-6, "{contradiction:?}");
    // Code and factors of different units: the code holds. Reciprocals are the other custom.
    for (length, force, factor) in
        [(1.0, 1.0, Some(POUND_FORCE / 0.0254)), (39.37, 0.2248, None), (0.0254, 4.448, None)]
    {
        let bytes = [&unlabelled[..], &units_of(7, length, force)].concat();
        check(&bytes, None, expected);
        let conflict = understood(&bytes).contradiction;
        assert_eq!(conflict.is_some(), factor.is_some(), "{length}");
        if let Some((conflict, factor)) = conflict.zip(factor) {
            assert!(
                conflict.source == OtherUnit::Factors
                    && (conflict.factor / factor - 1.0).abs() < 1e-6,
                "{conflict:?}"
            );
        }
    }
    check(&[&unlabelled[..], &units_of(10, 1e3, 1.0)].concat(), None, 1e-3);
    // Of a function whose motion has a label only the force counts.
    let motion = dataset((12, "NONE", b"in/s^2"), (13, "NONE", b"NONE"));
    let conflict = understood(&[&motion[..], &units_of(7, 1.0, 1.0)].concat()).contradiction;
    let factor = conflict.filter(|conflict| conflict.source == OtherUnit::Factors).unwrap().factor;
    assert!((factor / POUND_FORCE - 1.0).abs() < 1e-6, "{factor}");
    // One part by its label, the other by the dataset.
    let half = [&dataset((12, "NONE", b"in/s^2"), (13, "NONE", b"NONE"))[..], &inches].concat();
    check(&half, None, expected);
    assert_eq!(understood(&half).source, UnitSource::LabelAndDataset164);
    // Without either, SI is assumed.
    check(&unlabelled, None, 1.0);
    assert_eq!(
        (understood(&unlabelled).source, understood(&unlabelled).unit.as_str()),
        (UnitSource::Assumed, "(m/s^2)/N")
    );
}

#[test]
fn datasets_164_that_differ_hold_for_the_functions_after_them_and_are_named() {
    let unlabelled = dataset((12, "NONE", b"NONE"), (13, "NONE", b"NONE"));
    let (meters, millimetres) = (units_of(1, 1.0, 1.0), units_of(9, 1e3, 1.0));
    let bytes =
        [&unlabelled, &millimetres, &unlabelled, &meters, &unlabelled].map(Vec::as_slice).concat();
    let file = UffFile::parse(&bytes).unwrap();
    let factors: Vec<f64> = file
        .functions
        .iter()
        .map(|f| f.accelerance(None).unwrap().accelerance[0].re / Y[0])
        .collect();
    assert_eq!(factors, [1e-3, 1e-3, 1.0]);
    assert!(
        file.notes[0].contains("datasets 2 and 4") && file.notes[0].contains("different units"),
        "{:?}",
        file.notes
    );
    let twice = [&meters, &unlabelled, &meters].map(Vec::as_slice).concat();
    assert!(UffFile::parse(&twice).unwrap().notes.is_empty());
}

#[test]
fn what_surrounds_the_datasets_costs_nothing() {
    let plain = dataset((12, "Acceleration", b"m/s^2"), (13, "Force", b"N"));
    let whole = UffFile::parse(&plain).unwrap().functions[0].ordinate.clone();
    let utf16: Vec<u8> =
        String::from_utf8_lossy(&plain).encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [
        [b"\xef\xbb\xbf", &plain[..]].concat(),
        [&plain[..], b"\x1a"].concat(),
        [plain.trim_ascii_end(), b"\x1a"].concat(),
        [&plain[..], b"\x1a\x1a\x1a\x1a\r\n"].concat(),
        [&plain[..], b"\n\n\0\0\0"].concat(),
        [b"\xff\xfe", &utf16[..]].concat(),
    ] {
        assert_eq!(UffFile::parse(&bytes).unwrap().functions[0].ordinate, whole);
    }
    assert!(UffFile::parse(&[&plain[..], b"\x1amore"].concat()).is_err());
}

#[test]
fn a_function_without_values_is_set_aside() {
    let plain = dataset((12, "Acceleration", b"m/s^2"), (13, "Force", b"N"));
    let text = String::from_utf8_lossy(&plain);
    let shape = "         5         2         1";
    let empty = text.replacen(shape, "         5         0         1", 1);
    let (head, _) = empty.rsplit_once("   3.0").unwrap();
    let empty = format!("{}\n    -1\n", head.trim_end());
    let file = UffFile::parse(format!("{empty}{text}{empty}").as_bytes()).unwrap();
    assert_eq!((file.functions.len(), file.empty.len()), (1, 2));
    assert_eq!(file.empty[1].dataset, 3);
}

#[test]
fn components_and_dofs_are_read_by_bytes_and_by_characters() {
    let plain = dataset((12, "Acceleration", b"m/s^2"), (13, "Force", b"N"));
    let text = String::from_utf8_lossy(&plain);
    let old = "      NONE         1   1       NONE         2   3";
    for (record, components) in [
        (" Body              1   1 Tisch             2   3".to_owned(), ["Body", "Tisch"]),
        (
            format!(" {:10}{:10}{:4} {:10}{:10}{:4}", "Körper", 1, 1, "Bühne", 2, 3),
            ["Körper", "Bühne"],
        ),
        (
            " Körper            1   1 Bühne             2   3"
                .replace("Körper ", "Körper")
                .replace("Bühne ", "Bühne"),
            ["Körper", "Bühne"],
        ),
    ] {
        let changed = text.replacen(old, &record, 1);
        assert_ne!(changed, text);
        let function = &UffFile::parse(changed.as_bytes()).unwrap().functions[0];
        assert_eq!(function.components, components);
        assert_eq!(function.response, NodeDirection { node: 1, direction: 1 });
        assert_eq!(function.reference, NodeDirection { node: 2, direction: 3 });
    }
}
