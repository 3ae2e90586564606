use serde_json::json;

use super::*;
use massline_analysis::design::body_for_checks;
use massline_report::words::{Extent, hash_text, result_text};
use massline_shared::body::scale;
use massline_shared::layout::LayoutReport;

/// The layouts and universal files that `tests/data/uff/generate.py` wrote with pyuff from the golden
/// cases; the layouts' `[reference]` is the expected answer about the origin.
macro_rules! data {
    ($name:literal) => {
        include_bytes!(concat!("../../../tests/data/uff/", $name))
    };
}

/// The options of the golden cases of the linear method.
const ORIGIN: Options = Options {
    suspension_band_hz: None,
    mode_choice: ModeChoice::All,
    lines: LinesPerSide::Width,
    reference_point: ReferencePoint::Origin,
    quantity: None,
    selection: Selection::Only(Method::InertiaRestraint),
    decay: 0.0,
};

fn layout(bytes: &[u8]) -> LayoutFile {
    LayoutFile::parse_bytes(bytes, "layout.toml").unwrap()
}

/// The layout with hits and marks stated to turn by nothing: then maximum likelihood expects exact forces.
fn straight(toml: &[u8]) -> Vec<u8> {
    let text = std::str::from_utf8(toml).unwrap();
    format!("{text}\n[uncertainty]\nhit_direction_rad = 0.0\nnode_direction_rad = 0.0\n")
        .into_bytes()
}

/// Largest error of maximum likelihood on the files of 12 digits: its iterations end at 1e-7 of a standard deviation of
/// some 1 % of scale, and the rounding is magnified where the data determine little.
const EXACT: f64 = 1e-6;

fn case(toml: &[u8], uff: &[u8], options: &Options) -> Result<Solution> {
    solve(&layout(toml), &UffFile::parse(uff).unwrap(), options, |_, _| ())
}

/// The largest error, relative to [m, L, L, L, m L² × 6].
fn worst(solution: &Solution) -> f64 {
    let expected = solution.measured.expected().map(Option::unwrap);
    let scale = scale(expected[0], solution.layout.characteristic_length());
    let got = solution.answer().unwrap().theta();
    (0..10).map(|k| (got[k] - expected[k]).abs() / scale[k]).fold(0.0, f64::max)
}

#[test]
fn pyuff_files_give_what_the_golden_cases_expect() {
    // The golden tolerance is 1e-9 of scale; the files have 12 digits, so ten times that.
    for (toml, uff) in [
        (&data!("a_irm_01.toml")[..], &data!("a_irm_01.ascii.uff")[..]),
        (&data!("a_irm_01.toml")[..], &data!("a_irm_01.binary.uff")[..]),
        (data!("a_irm_02.toml"), data!("a_irm_02.ascii.uff")),
        (&data!("a_irm_02.toml")[..], &data!("a_irm_02.binary.uff")[..]),
        (data!("a_irm_03.toml"), data!("a_irm_03.ascii.uff")),
        (&data!("a_irm_03.toml")[..], &data!("a_irm_03.binary.uff")[..]),
    ] {
        let error = worst(&case(toml, uff, &ORIGIN).unwrap());
        assert!(error < 1e-8, "{error:e}");
    }
}

#[test]
fn single_precision_costs_a_hundred_thousandth() {
    let solution = case(data!("a_irm_01.toml"), data!("a_irm_01.single.uff"), &ORIGIN).unwrap();
    // The file has six digits.
    assert!(worst(&solution) < 1e-5, "{:e}", worst(&solution));
}

#[test]
fn noise_makes_the_reference_point_matter_and_exact_data_do_not() {
    let centroid = Options { reference_point: ReferencePoint::Centroid, ..ORIGIN };
    let exact = case(data!("a_irm_01.toml"), data!("a_irm_01.binary.uff"), &centroid).unwrap();
    // The golden tolerance times ten, as above.
    assert!(worst(&exact) < 1e-8);
    let noisy = case(data!("a_irm_02.toml"), data!("a_irm_02.binary.uff"), &centroid).unwrap();
    assert!(worst(&noisy) > 1e-4, "{:e}", worst(&noisy));
}

#[test]
fn the_condition_is_that_of_the_golden_case() {
    let solution = case(data!("a_irm_01.toml"), data!("a_irm_01.binary.uff"), &ORIGIN).unwrap();
    // a_irm_01: cond 20.577235, tolerance 1e-6 relative.
    assert!((solution.answer().unwrap().condition / 20.577_235_148_582_1 - 1.0).abs() < 1e-6);
}

#[test]
fn the_example_layouts_have_the_conditions_of_the_theory() {
    // Theory, section 8, with the digits printed there.
    let files = [
        (include_str!("../../examples/three-bar-test-1.toml"), 21.0, 0.5),
        (include_str!("../../examples/three-bar-test-2.toml"), 18.0, 0.5),
        (include_str!("../../examples/three-bar-test-3.toml"), 8.4, 0.05),
        (include_str!("../../examples/three-bar-test-4.toml"), 7.7, 0.05),
    ];
    for (text, expected, tolerance) in files {
        let file = LayoutFile::parse(text, "l").unwrap();
        let report = LayoutReport::new(&file.layout, Some(&body_for_checks(&file).0));
        assert!(report.diagnostics.is_empty());
        let condition = report.condition_a.unwrap();
        assert!((condition - expected).abs() <= tolerance, "{condition}");
    }
}

#[test]
fn a_hit_of_opposite_sign_uses_the_functions_negated() {
    let text = std::str::from_utf8(data!("a_irm_01.toml")).unwrap().replacen("1:+Y", "1:-Y", 1);
    let solution = case(text.as_bytes(), data!("a_irm_01.binary.uff"), &ORIGIN).unwrap();
    assert!(worst(&solution) < 1e-8);
}

#[test]
fn a_missing_function_is_named() {
    let text = std::str::from_utf8(data!("a_irm_01.toml")).unwrap();
    let text = text.replacen("hits = [", "hits = [\"3:+Z\", ", 1);
    let error = case(text.as_bytes(), data!("a_irm_01.binary.uff"), &ORIGIN).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (2, "frf_missing"));
    let message = error.to_string();
    assert!(message.contains("node 1, axis X, due to the hit 3:+Z"), "{message}");
}

#[test]
fn a_function_that_is_there_twice_is_named() {
    let twice = [&data!("a_irm_01.ascii.uff")[..], data!("a_irm_01.ascii.uff")].concat();
    let error = case(data!("a_irm_01.toml"), &twice, &ORIGIN).unwrap_err();
    assert_eq!(error.code(), "frf_doubled");
    assert!(error.to_string().contains("datasets 1 and 28"), "{error}");
}

#[test]
fn a_number_that_is_none_is_named() {
    let text = String::from_utf8_lossy(data!("a_irm_01.ascii.uff"));
    let nan = text.replacen("   1.07233343736e+00", "                 NaN", 1);
    assert!(nan != text);
    let error = case(data!("a_irm_01.toml"), nan.as_bytes(), &ORIGIN).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (2, "data_not_finite"));
    assert!(error.to_string().contains("node 1, axis X, due to the hit 1:+Y (dataset 1)"));
    assert!(error.to_string().contains("at 10 Hz"), "{error}");
}

#[test]
fn a_wrong_function_type_is_named() {
    let text = String::from_utf8_lossy(data!("a_irm_01.ascii.uff"));
    let first = "    4         0    0         0       NONE         1   1";
    let coherence = text.replacen(first, &first.replacen('4', "6", 1), 1);
    assert!(coherence != text);
    let error = case(data!("a_irm_01.toml"), coherence.as_bytes(), &ORIGIN).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (2, "uff_wrong_function_type"));
    assert!(error.to_string().contains("coherence"), "{error}");
}

#[test]
fn a_band_without_lines_is_named() {
    let text = std::str::from_utf8(data!("a_irm_01.toml")).unwrap();
    let text = text.to_owned() + "\n[test]\nband_hz = [10.0, 25.0]\n";
    let error = case(text.as_bytes(), data!("a_irm_01.binary.uff"), &ORIGIN).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (2, "band_too_narrow"));
    assert!(error.to_string().contains("2 bins within 10 to 25 Hz"), "{error}");
}

/// The error of solving a layout with the nodes of the frame and other sensors, hits and tables.
fn undetermined(sensors: &str, hits: &str, more: &str) -> Error {
    let text = format!(
        "sensors = [{sensors}]\nhits = [{hits}]\n\
         node = [{{ id = 1, position_m = [0, 0, 0] }}, {{ id = 2, position_m = [0.2, 0, 0] }}, \
         {{ id = 3, position_m = [0.4, 0, 0] }}, {{ id = 4, position_m = [0.2, 0.3, 0.1] }}]\n{more}"
    );
    let error = case(text.as_bytes(), data!("a_irm_01.binary.uff"), &ORIGIN).unwrap_err();
    assert_eq!(error.exit_code(), 3, "{error}");
    error
}

#[test]
fn layouts_that_cannot_determine_the_ten_are_named() {
    let good = "\"1:+X\", \"4:+Y\", \"3:+Z\"";
    for (sensors, hits, code) in [
        ("1, 2", good, "fewer_than_three_sensors"),
        ("1, 2, 3", good, "sensors_collinear"),
        ("1, 2, 4", "\"1:+X\", \"4:+Y\"", "fewer_than_three_hits"),
        ("1, 2, 4", "\"1:+Z\", \"2:+Z\", \"4:+Z\"", "hits_all_parallel"),
        ("1, 2, 4", "\"4:+X\", \"4:+Y\", \"4:+Z\"", "hits_concurrent"),
    ] {
        assert_eq!(undetermined(sensors, hits, "").code(), code);
    }
}

#[test]
fn hits_through_one_point_are_refused_whatever_is_expected_of_the_object() {
    // All hits pass through node 4, which is the centre of mass in [reference].
    let hits = "\"4:+X\", \"4:+Y\", \"4:+Z\"";
    let reference = "[reference]\nmass_kg = 2\ncenter_of_mass_m = [0.2, 0.3, 0.1]\n";
    let expected = undetermined("1, 2, 4", hits, reference).to_string();
    let error = undetermined("1, 2, 4", hits, "").to_string();
    assert_eq!(error, expected);
    assert!(!error.contains("pass the centre of mass"), "{error}");
    assert!(error.contains("assumed mass of 1 kg") && error.contains("centroid of the nodes"));
    let error = undetermined("1, 2, 4", hits, "[prior]\nmass_kg = { value = 3, sigma = 1 }\n");
    assert!(error.to_string().contains("the mass of [prior]"), "{error}");
}

#[test]
fn the_json_is_that_of_all_results() {
    let solution = case(data!("a_irm_01.toml"), data!("a_irm_01.binary.uff"), &ORIGIN).unwrap();
    let json = json!(solution.result());
    assert!((json["results"][0]["mass_kg"]["value"].as_f64().unwrap() - 1.23).abs() < 1e-8);
    assert!(json["results"][0]["mass_kg"]["sigma"].is_null());
    assert_eq!(json["reference_point"], "origin");
    assert_eq!(json["band_hz"], json!([10.0, 120.0]));
    assert_eq!(
        json["layout_hash"],
        hash_text(layout(data!("a_irm_01.toml")).hash().unwrap()).unwrap()
    );
    assert!(json["calibration"].is_null() && json["firmware"].is_null());
    assert_eq!(json["mass_lines"][0]["dof"], "1:+Y");
    let text = result_text(&solution.result(), Extent::Details);
    assert!(text.contains("error, %") && text.contains("10.0 to 120.0 Hz"), "{text}");
}

#[test]
fn the_usual_methods_answer_the_best_first() {
    let both = Options { reference_point: ReferencePoint::Origin, ..Options::default() };
    let solution = case(data!("a_irm_01.toml"), data!("a_irm_01.binary.uff"), &both).unwrap();
    let methods = solution.identification.estimates.iter().map(|estimate| estimate.method);
    assert!(methods.eq(Method::of_mass_lines()));
    // Hits that turn by 50 mrad, at marks that turn by 10 mrad, would be 0.26 % weaker along their direction. The data
    // are exact and show no such hits: what is left is the loss of directions that were learned to be a tenth of that
    // or less.
    assert!(worst(&solution) < 2e-5, "{:e}", worst(&solution));
    let exact =
        case(&straight(data!("a_irm_01.toml")), data!("a_irm_01.binary.uff"), &both).unwrap();
    assert!(worst(&exact) < EXACT, "{:e}", worst(&exact));
    let details = solution.identification.details.as_ref().unwrap();
    assert_eq!((details.nuisances.sensors.len(), details.nuisances.hits.len()), (3, 3));
}

#[test]
fn two_sensors_leave_maximum_likelihood_alone() {
    let text = std::str::from_utf8(data!("a_irm_01.toml")).unwrap();
    let text = text.replacen("sensors = [1, 2, 3]", "sensors = [1, 2]", 1);
    let uff = &data!("a_irm_01.binary.uff")[..];
    let solution = case(&straight(text.as_bytes()), uff, &Options::default()).unwrap();
    assert_eq!(solution.answer().unwrap().method, Method::MaximumLikelihood);
    assert!(worst(&solution) < EXACT, "{:e}", worst(&solution));
    let json = json!(solution.result());
    assert_eq!(json["results"].as_array().unwrap().len(), 1);
    assert_eq!(json["not_applicable"][0]["method"], "inertia-restraint");
    assert_eq!(json["not_applicable"][0]["code"], "fewer_than_three_sensors");
    let error = case(text.as_bytes(), uff, &ORIGIN).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "fewer_than_three_sensors"));
}

#[test]
fn the_band_is_found_where_the_layout_leaves_it_to_the_data() {
    let text = std::str::from_utf8(data!("a_irm_01.toml")).unwrap().to_owned();
    let text = text + "\n[test]\nband_hz = \"auto\"\nterms = \"ab\"\n";
    let uff = UffFile::parse(data!("a_irm_01.binary.uff")).unwrap();
    let solved = solve(&layout(text.as_bytes()), &uff, &ORIGIN, |_, _| ());
    // The file has the plain mass lines of 10 to 120 Hz, without modes. From three times the lower end to 0.4
    // of the upper end the bins of 30 and 40 Hz remain.
    let error = solved.unwrap_err();
    assert_eq!(error.code(), "band_too_narrow");
    assert!(error.to_string().contains("2 bins within 30 to 48 Hz"), "{error}");
}

/// Lines that begin above the suspension show no stiffness; the fit ran away from them once.
#[test]
fn a_global_fit_without_a_suspension_to_see_is_refused() {
    for (toml, uff) in [
        (&data!("a_irm_01.toml")[..], &data!("a_irm_01.binary.uff")[..]),
        (&data!("a_irm_02.toml")[..], &data!("a_irm_02.binary.uff")[..]),
        (&data!("a_irm_03.toml")[..], &data!("a_irm_03.binary.uff")[..]),
    ] {
        let selection = Selection::Only(Method::GlobalFit);
        let options = Options { selection, ..Options::default() };
        let error = case(toml, uff, &options).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, "suspension_modes_missing"));
        assert!(error.to_string().contains("rely on mass lines"), "{error}");
    }
}
