//! All formats, with a body whose products of inertia are all different from zero.

use massline_shared::body::RigidBody;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::{Hit, HostLayout, Sensor};
use serde_json::{Value, json};

use super::*;
use crate::words::{estimate_of, message};
use massline_files::uff::{BODY_AXES, Frf, NodeDirection};

/// The three-bar frame, rounded.
const THETA: [f64; 10] =
    [1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706];

/// Takes away what an answer says of its errors.
pub(super) fn make_bare(answer: &mut Value) {
    for key in ["covariance", "interval95"] {
        answer[key] = Value::Null;
    }
    for key in ["mass_kg", "center_of_mass_m", "inertia_kg_m2"] {
        answer[key]["sigma"] = Value::Null;
    }
}

/// A document with the answers of two methods.
pub(super) fn document() -> Value {
    let sigma = [1e-2, 6e-4, 8e-4, 7e-4, 1.4e-4, 7e-5, 1.4e-4, 7e-5, 4e-5, 6e-5];
    // Neighbours in the order are correlated by a quarter.
    let correlation = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 1.0,
        1 => 0.25,
        _ => 0.0,
    };
    let covariance = Matrix10::from_fn(|i, j| sigma[i] * sigma[j] * correlation(i, j));
    let estimate = |method| Estimate {
        method,
        body: RigidBody::from_theta(&Vector10::from(THETA)),
        covariance: Some(covariance),
        condition: 8.0,
        consistency: None,
        learned: None,
        diagnostics: Diagnostics::new(),
    };
    let methods = [Method::MaximumLikelihood, Method::InertiaRestraint];
    json!({
        "schema_version": 1,
        "verdict": "good",
        "verdict_reasons": [],
        "results": methods.map(|method| estimate_of(&estimate(method), message)),
    })
}

/// The same as a result with nodes and responses.
pub(super) fn exported() -> ExportedResult {
    read(&|_| ())
}

/// The same of a document that was changed.
fn read(change: &dyn Fn(&mut Value)) -> ExportedResult {
    let mut document = document();
    change(&mut document);
    let bytes = document.to_string();
    let mut exported = of_document(bytes.as_bytes(), "frame.json", None).unwrap();
    let node = |(id, position)| Node { id, position, axes: Some(BODY_AXES) };
    exported.test.nodes =
        [(1, [0.0, 0.0, 0.0]), (2, [0.2, -0.2, 0.0]), (3, [0.2, 0.0, 0.0]), (4, [0.2, -0.2, 0.15])]
            .map(node)
            .into();
    exported.test.nodes[3].axes = Some([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]);
    exported.test.responses = Some(responses());
    exported
}

/// One hit against the turned x axis of node 4, and two sensors, the second along axes of its own and at unequal
/// frequencies.
fn responses() -> Responses {
    let mut layout = HostLayout::default();
    let turned = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    for (node, position, axes) in [(1, [0.0; 3], BODY_AXES), (2, [0.2, -0.2, 0.0], turned)] {
        layout.sensors.push(Sensor::new(node, position, axes));
    }
    let hit = Hit::new("4:-X".parse().unwrap(), [0.2, -0.2, 0.15], [-0.6, -0.8, 0.0]);
    layout.hits.push(hit);
    let frf = |node, frequency_hz: [f64; 3], direction: i64| Frf {
        response: NodeDirection { node, direction },
        reference: NodeDirection { node: 4, direction: -1 },
        frequency_hz: frequency_hz.into(),
        accelerance: [1.0, 2.0, 3.0]
            .map(|x| nalgebra::Complex::new(x, -x / 8.0) * direction as f64)
            .into(),
    };
    let even = [1, 2, 3].map(|direction| frf(1, [10.0, 10.5, 11.0], direction));
    let uneven = [1, 2, 3].map(|direction| frf(2, [10.0, 12.5, 20.0], direction));
    Responses { frfs: [even, uneven].concat(), layout, decay_per_s: 1.5 }
}

fn text(format: Format, exported: &ExportedResult) -> String {
    String::from_utf8(format.write(exported).unwrap()).unwrap()
}

#[test]
fn every_format_writes_and_every_text_states_convention_units_and_method() {
    let exported = exported();
    for format in Format::value_variants() {
        let bytes = format.write(&exported).unwrap();
        assert!(!bytes.is_empty(), "{format:?}");
        if format.is_binary() || format.holds_responses() {
            continue;
        }
        // Lines are wrapped, and comments begin with signs.
        let text = String::from_utf8(bytes).unwrap();
        let words: Vec<&str> =
            text.split(|c: char| c.is_whitespace() || "$#*".contains(c)).collect();
        let text: String = words.concat();
        for part in ["J_xy=-(integralofxydm)", "kgm^2", "maximum-likelihood", "frame.json"] {
            assert!(text.contains(part), "{format:?} lacks {part}: {text}");
        }
    }
}

#[test]
fn robots_take_the_elements_of_the_tensor() {
    let exported = exported();
    let urdf = text(Format::Urdf, &exported);
    assert!(urdf.contains(r#"<origin xyz="0.169 -0.089 0.02" rpy="0 0 0"/>"#), "{urdf}");
    assert!(urdf.contains(r#"ixx="0.011134" ixy="0.004253" ixz="-0.000956""#), "{urdf}");
    assert!(urdf.contains(r#"iyy="0.006762" iyz="0.002706" izz="0.013942""#), "{urdf}");
    let sdf = text(Format::Sdf, &exported);
    assert!(sdf.contains("<pose>0.169 -0.089 0.02 0 0 0</pose>"), "{sdf}");
    assert!(sdf.contains("<ixz>-0.000956</ixz>"), "{sdf}");
    let mjcf = text(Format::Mjcf, &exported);
    let full = r#"fullinertia="0.011134 0.006762 0.013942 0.004253 -0.000956 0.002706""#;
    assert!(mjcf.contains(full), "{mjcf}");
    let mjcf = text(Format::Mjcf, &exported.in_frame(Frame::Principal).unwrap());
    assert!(mjcf.contains("diaginertia=") && mjcf.contains(r#"pos="0.0 0.0 0.0""#), "{mjcf}");
}

#[test]
fn conm2_takes_the_products_with_the_other_sign() {
    let text = text(Format::Conm2, &exported());
    let cards: Vec<&str> = text.lines().filter(|line| !line.starts_with('$')).collect();
    let field = |line: usize, k: usize| cards[line].get(8 + 16 * k..24 + 16 * k).map(str::trim);
    assert!(cards.iter().all(|card| card.len() <= 72), "{text}");
    assert_eq!(cards[0].split_whitespace().next(), Some("GRID*"));
    assert_eq!(cards[2].split_whitespace().next(), Some("CONM2*"));
    let number = |line, k| field(line, k).and_then(|text| text.parse::<f64>().ok());
    assert_eq!(number(2, 3), Some(1.23));
    let offset = [0, 1, 2].map(|k| number(3, k));
    assert_eq!(offset, [0.169, -0.089, 0.020].map(Some));
    // I11, I21, I22, I31, then I32, I33.
    let first = [0, 1, 2, 3].map(|k| number(4, k));
    assert_eq!(first, [0.011134, -0.004253, 0.006762, 0.000956].map(Some));
    assert_eq!([number(5, 0).map(f64::abs), number(5, 1)], [Some(0.002706), Some(0.013942)]);
    assert!(field(5, 0).is_some_and(|text| text.starts_with('-')));
}

/// Checked by hand against the defining equations in the Abaqus Analysis User's Guide, "Rotary inertia":
/// `I11 = ∫ (x₂² + x₃²) dm` and `I12 = −∫ x₁ x₂ dm`, so that all six are the elements of the tensor about the node,
/// which "is assumed to be the center of mass", in the order I11, I22, I33, I12, I13, I23. The guide's defining
/// equation of `I13` gives −0.000956 for a body with ∫ x₁ x₃ dm = +0.000956, as the bar along z at positive x of this
/// frame suggests. The mass stands alone in the data line of `*MASS`; a `*NODE` line is number, x, y, z.
#[test]
fn abaqus_is_as_checked_by_hand() {
    let text = text(Format::Abaqus, &exported());
    let data: String = text
        .lines()
        .filter(|line| !line.starts_with("**"))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(
        data,
        "*NODE, NSET=MASSLINE_COM\n\
         1, 1.6900000000000E-01, -8.9000000000000E-02, 2.0000000000000E-02\n\
         *ELEMENT, TYPE=MASS, ELSET=MASSLINE_MASS\n\
         1, 1\n\
         *MASS, ELSET=MASSLINE_MASS\n\
         1.2300000000000E+00\n\
         *ELEMENT, TYPE=ROTARYI, ELSET=MASSLINE_INERTIA\n\
         2, 1\n\
         *ROTARY INERTIA, ELSET=MASSLINE_INERTIA\n\
         1.1134000000000E-02, 6.7620000000000E-03, 1.3942000000000E-02, 4.2530000000000E-03, \
         -9.5600000000000E-04, 2.7060000000000E-03\n"
    );
}

#[test]
fn titles_cannot_break_out_of_comments_and_names() {
    let mut exported = exported();
    exported.test.title = test_data::one_line("a--><b>\n$ \"x\" & --\u{2028}é\u{0}\r\nMAT1");
    assert_eq!(exported.test.title, "a--><b> $ \"x\" & -- é MAT1");
    for format in [Format::Urdf, Format::Sdf, Format::Mjcf] {
        let text = text(format, &exported);
        let (comment, rest) = text.split_once("-->").unwrap();
        assert!(!comment.split_once("<!--").unwrap().1.contains("--"), "{text}");
        assert!(rest.contains(r#"="a--_b_x_--_é_MAT1""#), "{text}");
    }
    for (format, sign) in [(Format::Conm2, "$ "), (Format::Abaqus, "** ")] {
        let text = text(format, &exported);
        assert!(text.is_ascii() && text.starts_with(sign), "{text}");
        assert!(text.lines().all(|line| !line.starts_with("MAT1")), "{text}");
    }
}

#[test]
fn robots_and_responses_are_si_by_definition() {
    for format in [Format::Urdf, Format::Sdf, Format::Mjcf, Format::Uff] {
        let error = format.check(UnitSystem::TMm, Frame::Body).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("units_not_for_format", 2));
        assert!(error.to_string().contains("--units t-mm"), "{error}");
    }
    assert!(Format::Conm2.check(UnitSystem::TMm, Frame::Principal).is_ok());
    let error = Format::Uff.check(UnitSystem::Si, Frame::Principal).unwrap_err();
    assert_eq!(error.code(), "frame_not_for_format");
}

#[test]
fn a_result_that_no_body_can_have_is_refused_with_the_condition() {
    let theta = |change: &dyn Fn(&mut Vector10)| {
        let mut theta = Vector10::from(THETA);
        change(&mut theta);
        let mut exported = exported();
        exported.body = RigidBody::from_theta(&theta);
        exported
    };
    for (exported, words) in [
        (theta(&|t| t[0] = -0.5), "the mass is -0.5 kg, not positive"),
        (theta(&|t| t[6] = 0.1), "is not below the sum of the other two"),
        (theta(&|t| t[5] = -0.1), "a principal moment is"),
        (
            read(&|value| {
                value["results"][0]["physically_consistent"] = json!(false);
                value["verdict"] = json!("do_not_use");
                value["verdict_reasons"] = json!([{
                    "code": "not_physically_consistent", "verdict": "do_not_use", "message": "m", "clause": null,
                }]);
            }),
            "the result says that it is not physically consistent",
        ),
    ] {
        let error = exported.check(false).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("unphysical_result", 3));
        let message = error.to_string();
        assert!(message.contains(words) && message.contains("--despite-verdict"), "{message}");
        exported.check(true).unwrap();
        assert!(text(Format::Urdf, &exported).contains("NOT A PHYSICAL BODY"));
        assert!(text(Format::Yaml, &exported).contains("physically_consistent: false"));
    }
    exported().check(false).unwrap();
}

#[test]
fn numbers_that_overflow_in_other_units_are_refused_even_despite_the_verdict() {
    let mut huge = exported();
    huge.body.inertia *= 1e308;
    let error = huge.in_units(UnitSystem::GMm).check(true).unwrap_err();
    assert_eq!((error.code(), error.exit_code()), ("not_finite", 3));
}

#[test]
fn a_universal_file_reads_back_and_without_responses_it_is_refused() {
    let exported = exported();
    let file = massline_files::uff::UffFile::parse(&Format::Uff.write(&exported).unwrap()).unwrap();
    let frfs = &exported.test.responses.as_ref().unwrap().frfs;
    assert_eq!(file.functions[0].accelerance(None).unwrap(), frfs[0]);
    let error = universal_file(&TestData { responses: None, ..exported.test }, None).unwrap_err();
    assert_eq!((error.code(), error.exit_code()), ("no_responses", 2));
    assert!(error.to_string().contains("frequency responses"), "{error}");
}

#[test]
fn without_a_covariance_every_format_of_properties_still_writes() {
    let bare = read(&|value| make_bare(&mut value["results"][0]));
    for format in Format::value_variants() {
        assert!(format.write(&bare).is_ok(), "{format:?}");
    }
    assert!(text(Format::Yaml, &bare).contains("covariance: null"));
    assert!(text(Format::Csv, &bare).contains("m,1.23,,,,kg,"));
}

/// The file that `tests/export/run` reads with pyuff. A document has no responses: these are made up.
#[test]
fn the_universal_file_is_as_committed() {
    let now = universal_file(&exported().test.titled("three-bar frame"), None).unwrap();
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/export");
    let path = folder.join("frame.uff");
    if std::env::var_os("MASSLINE_BLESS").is_some() {
        std::fs::write(&path, &now).unwrap();
    }
    assert!(
        now == std::fs::read(&path).unwrap(),
        "the universal file differs from the committed one"
    );
}
