//! Fuzz targets: each accepts arbitrary bytes, must not panic, and checks invariants that hold for all
//! input.
//!
//! `cargo test -p massline-fuzz` replays the corpus and a bounded number of seeded mutations of it.
//! With cargo-fuzz: `RUSTC_BOOTSTRAP=1 cargo fuzz run --fuzz-dir tests/fuzz --features libfuzzer
//! --sanitizer none uff`.

use massline_analysis::hits;
use massline_files::archive::Archive;
use massline_files::layout_file::LayoutFile;
use massline_files::recording::{Recording, StatedUnit, Statements};
use massline_files::tape::{Sidecar, scans_of_npy};
use massline_files::uff::{Encoding, Frf, Quantity, UffFile, write};
use massline_protocol::event::{HitEvent, ScanBlock};
use massline_protocol::frame::{Deframer, FrameError};
use massline_protocol::lines::split_dof;
use massline_protocol::message::{
    Identity, LayoutAnswer, Refusal, ResultPage, StartRequest, Stats, Status,
};
use massline_protocol::object::{Chunk, ChunkRequest, DofResult, MeasurementResult, ObjectInfo};
use massline_report::export::{Format, Frame, UnitSystem, of_document};
use massline_report::recorded_hits::{hits_json, hits_text};
use massline_shared::layout::LayoutReport;
use massline_shared::measurement::campaign::Command;
use massline_shared::signal::expand_response;

/// A target: its name, which is also the name of its corpus, and the function.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 7] = [
    ("deframer", fuzz_deframer),
    ("uff", fuzz_uff),
    ("layout", fuzz_layout),
    ("tape", fuzz_tape),
    ("recording", fuzz_recording),
    ("archive", fuzz_archive),
    ("result", fuzz_result),
];

/// The deframer, and the decoding of a frame's body as every type of message and as a DOF with lines.
///
/// # Panics
/// When the frames found depend on how the bytes are divided into reads, or an accepted line is no number.
pub fn fuzz_deframer(bytes: &[u8]) {
    let whole = frames(bytes, bytes.len().max(1));
    for size in [1, 3, 64] {
        assert!(frames(bytes, size) == whole, "frames depend on pieces of {size} bytes");
    }
    for (_, _, body) in whole.into_iter().flatten() {
        // Decoding may fail but must not panic.
        let _ = postcard::from_bytes::<Identity>(&body).is_ok();
        let _ = postcard::from_bytes::<Status>(&body).is_ok();
        let _ = postcard::from_bytes::<Stats>(&body).is_ok();
        let _ = postcard::from_bytes::<massline_shared::layout::RigLayout>(&body).is_ok();
        let _ = postcard::from_bytes::<LayoutAnswer>(&body).is_ok();
        let _ =
            postcard::from_bytes::<massline_shared::calibration::CalibrationRecord>(&body).is_ok();
        let _ = postcard::from_bytes::<StartRequest>(&body).is_ok();
        let _ = postcard::from_bytes::<Command>(&body).is_ok();
        let _ = postcard::from_bytes::<ObjectInfo>(&body).is_ok();
        let _ = postcard::from_bytes::<ChunkRequest>(&body).is_ok();
        let _ = postcard::from_bytes::<Chunk>(&body).is_ok();
        let _ = postcard::from_bytes::<ResultPage>(&body).is_ok();
        let _ = postcard::from_bytes::<Refusal>(&body).is_ok();
        let _ = postcard::from_bytes::<HitEvent>(&body).is_ok();
        let _ = postcard::from_bytes::<ScanBlock>(&body).is_ok();
        if let Some((dof, responses)) = split_dof::<DofResult>(&body) {
            let _ = dof.mass_lines();
            let lines = responses.iter().filter_map(expand_response::<f32>).flatten();
            lines.for_each(|line| assert!(line.re.is_finite() && line.im.is_finite()));
        }
        if let Ok(result) = postcard::from_bytes::<MeasurementResult>(&body) {
            let of_rig = massline_report::words::result_of_rig(&result);
            let _ = massline_report::words::result_text(
                &of_rig,
                massline_report::words::Extent::Details,
            );
        }
    }
}

/// Kind, sequence and body of a frame, or the error found in it.
type DecodedFrame = Result<(u16, u16, Vec<u8>), FrameError>;

/// The results of a deframer when the bytes arrive in pieces of `size`.
fn frames(bytes: &[u8], size: usize) -> Vec<DecodedFrame> {
    let mut deframer = Deframer::new();
    let mut frames = Vec::new();
    for mut piece in bytes.chunks(size) {
        while !piece.is_empty() {
            let (taken, frame) = deframer.push(piece);
            if let Some(frame) = frame {
                frames.push(frame.map(|f| (f.kind, f.sequence, f.body.to_vec())));
            }
            assert!(taken > 0, "the deframer takes nothing");
            piece = piece.get(taken..).unwrap_or_default();
        }
    }
    frames
}

/// The UFF reader, its conversions and its writer.
///
/// # Panics
/// When abscissa and ordinate differ in length, or the written file does not read back the same.
pub fn fuzz_uff(bytes: &[u8]) {
    let Ok(file) = UffFile::parse(bytes) else { return };
    for function in &file.functions {
        assert_eq!(function.abscissa.len(), function.ordinate.len());
        // At most one value for every two bytes of the file.
        assert!(function.ordinate.len() <= bytes.len());
        let _ = function.accelerance(None).is_ok();
        let Ok(frf) = function.accelerance(Some(Quantity::Displacement)) else { continue };
        let plain = |x: &f64| x.is_finite() && x.abs() < 1e90;
        let fits = |node: i64| (0..=1_000_000_000).contains(&node);
        if !frf.frequency_hz.iter().all(plain)
            || !frf.accelerance.iter().all(|h| plain(&h.re) && plain(&h.im))
            || !fits(frf.response.node)
            || !fits(frf.reference.node)
        {
            continue;
        }
        read_back(&frf);
    }
}

fn read_back(frf: &Frf) {
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let bytes = write(std::slice::from_ref(frf), encoding);
        let again = UffFile::parse(&bytes).unwrap_or_else(|e| panic!("{encoding:?}: {e}"));
        let again = again.functions.first().map(|f| f.accelerance(None));
        match again {
            Some(Ok(again)) => {
                assert_eq!(again.response.node, frf.response.node);
                assert_eq!(again.accelerance.len(), frf.accelerance.len());
                if encoding == Encoding::Binary {
                    assert_eq!(again.accelerance, frf.accelerance);
                }
            }
            other => panic!("{encoding:?}: {other:?}"),
        }
    }
}

/// The reader of archives, and what is printed of those that it accepts.
///
/// # Panics
/// When an accepted archive does not read back as it was, or an error does not name the file.
pub fn fuzz_archive(bytes: &[u8]) {
    let archive = match Archive::parse(bytes, "fuzz.massline") {
        Ok(archive) => archive,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.massline:"), "{error}");
            return;
        }
    };
    let again = archive.to_bytes("fuzz.massline").unwrap();
    assert!(Archive::parse(&again, "fuzz.massline").unwrap() == archive);
    let _ = archive.frfs();
    let of_rig = massline_report::words::result_of_rig(&archive.result);
    let answers = archive.answers().unwrap_or(&of_rig);
    let _ = massline_report::words::Summary::of(answers).document();
    let _ = massline_report::words::result_text(answers, massline_report::words::Extent::Details);
    let _ = massline_analysis::single_fault::NominalTest::of_archive(&archive.layout);
}

/// The layout reader, and the diagnosis of the layouts that it accepts.
///
/// # Panics
/// When accepted axes are not orthonormal, or an error does not name the file.
pub fn fuzz_layout(bytes: &[u8]) {
    let file = match LayoutFile::parse_bytes(bytes, "fuzz.toml") {
        Ok(file) => file,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.toml:"), "{error}");
            return;
        }
    };
    for sensor in &file.layout.sensors {
        for (i, a) in sensor.axes.iter().enumerate() {
            for (j, b) in sensor.axes.iter().enumerate() {
                let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                let wanted = if i == j { 1.0 } else { 0.0 };
                // Rounding of the normalisation.
                assert!((dot - wanted).abs() < 1e-12, "axes {i} and {j}: {dot}");
            }
        }
    }
    let (body, _) = massline_analysis::design::body_for_checks(&file);
    let report = LayoutReport::new(&file.layout, Some(&body));
    for diagnostic in &report.diagnostics {
        let _ = massline_report::words::message_in(diagnostic, &file.layout);
    }
    let _ = file.hash();
}

/// The readers of a tape and its sidecar.
///
/// # Panics
/// When more scans are read than the bytes contain, or a written sidecar does not read back the same.
pub fn fuzz_tape(bytes: &[u8]) {
    if let Ok(scans) = scans_of_npy(bytes.to_vec()) {
        assert!(scans.count() * 20 <= bytes.len() as u64);
    }
    if let Ok(sidecar) = std::str::from_utf8(bytes).map(|text| Sidecar::parse(text, "fuzz.toml"))
        && let Ok(sidecar) = sidecar
    {
        let again = Sidecar::parse(&sidecar.to_toml(), "again.toml");
        assert!(again.as_ref() == Ok(&sidecar), "{again:?}");
    }
}

/// The readers of recordings, and the grading of the recordings that they accept.
///
/// # Panics
/// When more samples are read than the bytes contain, or a hit is graded without a verdict.
pub fn fuzz_recording(bytes: &[u8]) {
    let Ok(recording) = Recording::parse(bytes) else { return };
    let samples: usize = recording.segments.iter().flat_map(|s| &s.0).map(Vec::len).sum();
    assert!(samples <= bytes.len());
    // As the file states its units, and as a user states them.
    let unit = |column: &str, unit: &str| StatedUnit { column: column.into(), unit: unit.into() };
    for units in [vec![], vec![unit("1", "N"), unit("*", "g")]] {
        let statements = Statements { units, ..Statements::default() };
        let options =
            hits::Options { statements, rate_hz: Some(4000.0), ..hits::Options::default() };
        let Ok(graded) = hits::grade(recording.clone(), &options) else { continue };
        assert!(!hits_text(&graded).is_empty());
        assert_eq!(hits_json(&graded).hits.len(), graded.hits.len());
    }
}

/// The reader of a result's JSON document, and the export of the results that it accepts.
///
/// # Panics
/// When an error does not name the document, or a result that passes the check has a number that is none.
pub fn fuzz_result(bytes: &[u8]) {
    let exported = match of_document(bytes, "fuzz.json", None) {
        Ok(exported) => exported,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.json: "), "{error}");
            return;
        }
    };
    for (frame, units) in [
        (Frame::Body, UnitSystem::Si),
        (Frame::Principal, UnitSystem::TMm),
        (Frame::CenterOfMass, UnitSystem::LbIn),
    ] {
        let _ = exported.check(false).is_ok();
        let Ok(exported) = exported.clone().in_frame(frame) else { continue };
        let exported = exported.in_units(units);
        if exported.check(true).is_err() {
            continue;
        }
        assert!(exported.theta().iter().all(|value| value.is_finite()));
        for format in FORMATS_OF_PROPERTIES {
            let written = format.write(&exported);
            // A number may not fit the columns of a card.
            assert!(written.is_ok() || format == Format::Conm2, "{format:?}: {written:?}");
        }
    }
}

/// All formats but the universal file, which holds responses.
const FORMATS_OF_PROPERTIES: [Format; 10] = [
    Format::Urdf,
    Format::Sdf,
    Format::Mjcf,
    Format::Conm2,
    Format::Abaqus,
    Format::Yaml,
    Format::Csv,
    Format::Json,
    Format::Npz,
    Format::Mat,
];
