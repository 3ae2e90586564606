use heapless::Vec as FixedVec;
use massline_protocol::object::{DofResult, ResultHead, StoredTrend};
use massline_shared::layout::{FrfEstimator, HOST_SENSORS};
use massline_shared::mass_line::Terms;
use massline_shared::signal::RESPONSES;
use massline_shared::units::{Hertz, Seconds, Volts};
use serde_json::{Value, json};

use super::*;
use massline_result::HitVerdict;

/// A layout file, and a result with one DOF whose numbers need all their digits.
fn archive() -> Archive {
    let text = include_str!("../../../examples/three-bar-test-1.toml");
    let file = LayoutFile::parse(text, "frame.toml").unwrap();
    let dof = DofResult {
        dof: file.layout.hits[0].dof,
        index: 0,
        hits: 5,
        band_hz: [10.0, 120.0],
        accelerance: [0.1_f32; RESPONSES].map(|a| a / 3.0),
        noise: [1e-7; RESPONSES],
        scatter: FixedVec::new(),
        coherence: None,
        trend: StoredTrend::default(),
        band_shift: [-1e-9; RESPONSES],
    };
    let result = MeasurementResult {
        head: ResultHead {
            number: 3,
            layout_hash: file.hash().unwrap(),
            title: "frame".try_into().unwrap(),
            started_unix_s: 1_795_000_000,
            calibration: 9,
            gains: None,
            firmware: "0.1.0".try_into().unwrap(),
            frf_estimator: FrfEstimator::H1,
            terms: Terms::Abc,
            band_automatic: false,
        },
        dofs: [dof].into_iter().collect(),
        lines: Default::default(),
        estimates: FixedVec::new(),
        diagnostics: FixedVec::new(),
    };
    let mut archive = Archive {
        format: FORMAT.into(),
        schema_version: SCHEMA_VERSION,
        measured: clock::moment(result.head.started_unix_s),
        written: clock::now(),
        program: "0.1.0".into(),
        rig: ArchivedRig {
            board: "virtual".into(),
            firmware: "0.1.0".into(),
            git_hash: "0".into(),
            git_dirty: false,
            sampler: ArchivedSampler {
                adc: AdcProperties {
                    rate: Hertz(4000.0),
                    channels: 10,
                    bits: 12,
                    reference: Volts(3.3),
                    channel_delay: Seconds(1e-5),
                },
                pre_trigger_scans: 80,
            },
        },
        layout: ArchivedLayout::of_file(&file),
        calibration: Some(CalibrationTable::of_record(&CalibrationRecord::default())),
        result,
        spectra: Vec::new(),
        lines: Vec::new(),
        hit_records: Vec::new(),
        hit_log: Vec::new(),
        answers: Some(TestResult::default()),
    };
    archive.hit_records =
        vec![HitRecord { hit: 1, dof: "1:+Y".into(), codes: vec![[7; RESPONSES + 1]; 3] }];
    archive.hit_log = vec![LoggedHit {
        dof: "1:+Y".into(),
        hit: 1,
        verdict: HitVerdict::Accepted,
        findings: Vec::new(),
        peak_force_n: Some(0.1),
        peak_acceleration_m_per_s2: None,
        impulse_n_s: None,
        rest: None,
        remainder: None,
        graded: Some("2026-11-24T08:30:00Z".into()),
    }];
    archive
}

#[test]
fn what_is_written_reads_back_to_the_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.massline");
    let archive = archive();
    archive.write(&path, ExistingFile::Kept).unwrap();
    assert_eq!(Archive::read(&path).unwrap(), archive);
    assert_eq!(archive.write(&path, ExistingFile::Kept).unwrap_err().code(), "file_exists");
}

/// Nobody has followed the campaign.
#[test]
fn an_archive_without_a_log_of_hits_reads() {
    let mut unfollowed = archive();
    unfollowed.hit_log.clear();
    let bytes = serde_json::to_vec(&unfollowed).unwrap();
    assert!(!String::from_utf8_lossy(&bytes).contains("hit_log"));
    assert_eq!(Archive::parse(&bytes, "a.massline").unwrap(), unfollowed);
}

#[test]
fn a_cut_archive_a_newer_one_and_other_files_are_named() {
    let bytes = serde_json::to_vec(&archive()).unwrap();
    let code = |bytes: &[u8]| Archive::parse(bytes, "a.massline").unwrap_err().code().to_owned();
    for length in [1, 100, bytes.len() / 2, bytes.len() - 1] {
        assert_eq!(code(&bytes[..length]), "archive_cut_short", "{length} bytes");
    }
    let changed = |key: &str, value: Value| {
        let mut document: Value = serde_json::from_slice(&bytes).unwrap();
        document[key] = value;
        serde_json::to_vec(&document).unwrap()
    };
    assert_eq!(code(&changed("schema_version", json!(2))), "archive_too_new");
    assert_eq!(code(&changed("schema_version", json!(0))), "archive_malformed");
    assert_eq!(code(&changed("result", json!({}))), "archive_malformed");
    assert_eq!(code(&changed("format", json!("other"))), "not_an_archive");
    assert_eq!(code(b"title = \"a layout\""), "not_an_archive");
    assert_eq!(code(b"{}"), "not_an_archive");
}

#[test]
fn a_number_that_json_cannot_hold_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.massline");
    let mut archive = archive();
    archive.result.dofs[0].noise[0] = f32::NAN;
    let error = archive.write(&path, ExistingFile::Kept).unwrap_err();
    assert_eq!(error.code(), "archive_not_faithful");
    assert!(!path.exists());
}

#[test]
fn contents_that_no_test_gives_are_named() {
    let text = String::from_utf8(serde_json::to_vec(&archive()).unwrap()).unwrap();
    let message = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} is in {text}");
        let changed = text.replacen(from, to, 1);
        let error = Archive::parse(changed.as_bytes(), "a.massline").unwrap_err();
        assert_eq!(error.code(), "archive_malformed", "{error}");
        error.to_string()
    };
    // In single precision this is infinite.
    let infinite = message("\"noise\":[1e-7", "\"noise\":[1e39");
    assert!(infinite.contains("number out of range"), "{infinite}");
    let nan = message("\"noise\":[1e-7", "\"noise\":[null");
    assert!(nan.contains("invalid type: null, expected a number"), "{nan}");
    let other_hit = message("\"index\":0", "\"index\":1");
    assert!(other_hit.contains("result.dofs[0] (1:+Y): the layout has another hit"), "{other_hit}");
    let negative = message("\"gain\":0.0", "\"gain\":-0.0");
    assert!(negative.contains("layout.resolved: a standard deviation"), "{negative}");
    let no_hits = message("\"hits\":5", "\"hits\":0");
    assert!(no_hits.contains("result.dofs[0] (1:+Y): it has no hits"), "{no_hits}");
    let uneven = message(
        "\"spectra\":[",
        "\"spectra\":[{\"dof\":\"1:+Y\",\"hits\":1,\"resolution_hz\":2.0,\"decay_per_s\":0.0,\"force_auto\":[1.0],\
         \"cross\":[],\"response_auto\":[]}",
    );
    assert!(uneven.contains("spectra[0]: its lists have different lengths"), "{uneven}");
    let bits = message("\"bits\":12", "\"bits\":40");
    assert!(bits.contains("rig.sampler.adc"), "{bits}");
    let zero = message("\"sensitivity_v_per_n\":", "\"sensitivity_v_per_n\":0.0,\"was\":");
    assert!(zero.contains("was"), "{zero}");
}

#[test]
fn the_place_of_a_wrong_answer_is_named() {
    let text = String::from_utf8(serde_json::to_vec(&archive()).unwrap()).unwrap();
    let changed = text.replace("\"verdict\":null", "\"verdict\":\"fine\"");
    assert_ne!(changed, text);
    let message = Archive::parse(changed.as_bytes(), "a.massline").unwrap_err().to_string();
    assert!(message.contains("answers.verdict: unknown variant `fine`"), "{message}");
    // Brackets of any depth are refused, not followed.
    let deep = format!("\"results\":{}{}", "[".repeat(100_000), "]".repeat(100_000));
    let changed = text.replace("\"results\":[]", &deep);
    assert_ne!(changed, text);
    assert!(Archive::parse(changed.as_bytes(), "a.massline").is_err());
}

#[test]
fn points_that_contradict_each_other_are_named() {
    let archive = serde_json::to_value(archive()).unwrap();
    let message = |change: &dyn Fn(&mut Value)| {
        let mut changed = archive.clone();
        change(&mut changed["layout"]);
        let bytes = serde_json::to_vec(&changed).unwrap();
        let error = Archive::parse(&bytes, "a.massline").unwrap_err();
        assert_eq!(error.code(), "archive_malformed", "{error}");
        error.to_string()
    };
    let node = message(&|layout| layout["nodes"][0]["position_m"][1] = json!(0.25));
    assert!(node.contains("layout.resolved.sensors[0].position is"), "{node}");
    assert!(node.contains("layout.nodes (node 1) says [0.0, 0.25, 0.0]"), "{node}");
    let sensor = message(&|layout| layout["resolved"]["sensors"][1]["position"][0] = json!(0.3));
    assert!(sensor.contains("layout.resolved.sensors[1].position is [0.3, "), "{sensor}");
    let hit = message(&|layout| layout["resolved"]["hits"][0]["position"][2] = json!(0.001));
    assert!(hit.contains("layout.resolved.hits[0].position is [0.0, 0.0, 0.001]"), "{hit}");
    let lost = message(&|layout| drop(layout["nodes"].as_array_mut().unwrap().remove(0)));
    assert!(lost.contains("is at node 1, which layout.nodes does not have"), "{lost}");
    let direction =
        message(&|layout| layout["resolved"]["hits"][0]["direction"] = json!([0.0, -1.0, 0.0]));
    assert!(direction.contains("layout.resolved.hits[0].direction is"), "{direction}");
    let axes = message(&|layout| {
        layout["resolved"]["sensors"][0]["axes"] =
            json!([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    });
    assert!(axes.contains("layout.resolved.sensors[0].axes is"), "{axes}");
    let text = message(&|layout| {
        let toml = layout["toml"].as_str().unwrap();
        assert!(toml.contains("0.20785"), "{toml}");
        layout["toml"] = json!(toml.replace("0.20785", "0.21785"));
    });
    assert!(text.contains("layout.toml says [0.21785"), "{text}");
    let many = message(&|layout| {
        let sensors = layout["resolved"]["sensors"].as_array_mut().unwrap();
        *sensors = vec![sensors[0].clone(); HOST_SENSORS + 1];
    });
    assert!(many.contains("9 sensors and 3 hits; at most 8 and 24 are possible"), "{many}");
}

#[test]
fn a_dof_that_is_there_twice_is_named() {
    let mut archive = serde_json::to_value(archive()).unwrap();
    let dofs = archive["result"]["dofs"].as_array_mut().unwrap();
    dofs.push(dofs[0].clone());
    let bytes = serde_json::to_vec(&archive).unwrap();
    let message = Archive::parse(&bytes, "a.massline").unwrap_err().to_string();
    assert!(message.contains("result.dofs[1] (1:+Y): it is there twice"), "{message}");
}

#[test]
fn an_edited_archive_is_read_only_without_its_checksum() {
    let bytes = archive().to_bytes("a.massline").unwrap();
    assert_eq!(Archive::parse(&bytes, "a.massline").unwrap(), archive());
    let text = String::from_utf8(bytes).unwrap();
    let changes = [
        ("\"hits\":5", "\"hits\":6"),
        ("[1e-7", "[2e-7"),
        ("\"peak_force_n\":0.1", "\"peak_force_n\":0.2"),
    ];
    for (from, to) in changes {
        assert!(text.contains(from), "{from}: {text}");
        let changed = text.replacen(from, to, 1);
        let error = Archive::parse(changed.as_bytes(), "a.massline").unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("archive_edited", 2), "{error}");
        assert!(error.to_string().contains("delete its key \"checksum\""), "{error}");
        let (before, _) = changed.rsplit_once(",\"checksum\"").unwrap();
        Archive::parse(format!("{before}}}").as_bytes(), "a.massline").unwrap();
    }
}
