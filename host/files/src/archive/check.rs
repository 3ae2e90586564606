//! What is checked of a file before it is taken for an archive.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use massline_protocol::object::DofResult;
use massline_shared::diagnosis::Code;
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout, LayoutReport};
use massline_shared::signal::AdcProperties;
use serde_json::value::RawValue;

use super::{Archive, ArchivedLayout, EXTENSION, FORMAT, MAX_BYTES, SCHEMA_VERSION, sources};
use crate::embedded;
use massline_result::{Error, Result};

/// The first bytes of an archive that this program has written.
const FIRST: &str = r#"{"format":"massline-archive""#;

/// The largest coordinate of a point, m.
const FARTHEST: f64 = 1e4;

/// True when the first bytes of a file, or of the result in a report, are those of an archive; a pipe is not read.
pub(super) fn begins_as_archive(path: &Path) -> bool {
    let mut first = [0; FIRST.len()];
    let is_one = path.is_file()
        && File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok()
        && first == *FIRST.as_bytes();
    is_one || embedded::begins_with(path, FIRST, MAX_BYTES)
}

/// Checks the format and its version; returns the checksum, if there is one.
///
/// # Errors
/// Exit 2 when the bytes are not an archive, or one of a version that this program does not know.
pub(super) fn head(bytes: &[u8], file: &str) -> Result<Option<u32>> {
    #[derive(serde::Deserialize)]
    struct Head<'a> {
        #[serde(borrow)]
        format: Option<&'a RawValue>,
        #[serde(borrow)]
        schema_version: Option<&'a RawValue>,
        #[serde(borrow)]
        checksum: Option<&'a RawValue>,
    }
    if bytes.is_empty() {
        return Err(Error::input(
            "not_an_archive",
            format!("{file}: this file is empty; write it again, or give another one"),
        ));
    }
    let head = match serde_json::from_slice::<Head>(bytes) {
        Err(e) if e.is_data() => Head { format: None, schema_version: None, checksum: None },
        head => head.map_err(|e| not_json(&e, file))?,
    };
    if head.format.is_none_or(|format| format.get() != format!("\"{FORMAT}\"")) {
        let message = format!(
            "{file}: this is not an archive: its \"format\" is not \"{FORMAT}\"; `massline results get N -o \
             FILE.{EXTENSION}` and `massline measure -o` write archives"
        );
        return Err(Error::input("not_an_archive", message));
    }
    match head.schema_version.and_then(|version| version.get().parse::<u64>().ok()) {
        Some(version) if version == u64::from(SCHEMA_VERSION) => match head.checksum {
            None => Ok(None),
            Some(checksum) => match checksum.get().parse() {
                Ok(checksum) => Ok(Some(checksum)),
                Err(_) => Err(malformed(file, "\"checksum\" is no checksum".into())),
            },
        },
        Some(newer) if newer > u64::from(SCHEMA_VERSION) => {
            let message = format!(
                "{file}: this archive has version {newer} of its format, and this program (massline {}) reads \
                 version {SCHEMA_VERSION}; update the program",
                env!("CARGO_PKG_VERSION")
            );
            Err(Error::input("archive_too_new", message))
        }
        _ => Err(malformed(file, "\"schema_version\" is not the version of an archive".into())),
    }
}

/// What no test gives, in words.
pub(super) fn contents(archive: &Archive) -> Result<(), String> {
    let Archive { layout, result, spectra, lines, .. } = archive;
    let HostLayout { sensors, hits, .. } = &layout.resolved;
    if sensors.len() > HOST_SENSORS || hits.len() > HOST_HITS {
        return Err(format!(
            "layout.resolved: {} sensors and {} hits; at most {HOST_SENSORS} and {HOST_HITS} are possible",
            sensors.len(),
            hits.len()
        ));
    }
    let diagnostics = LayoutReport::new(&layout.resolved, None).diagnostics;
    let has = |code: Code| diagnostics.iter().any(|diagnostic| diagnostic.code == code);
    if has(Code::LayoutNotFinite) {
        return Err("layout.resolved: a standard deviation, prior or target is negative".into());
    }
    if has(Code::AxesNotOrthonormal) {
        return Err("layout.resolved: a direction or an axis has no unit length".into());
    }
    if !is_of_an_object(layout) {
        return Err(format!("layout: a position is more than {FARTHEST:.0} m away"));
    }
    sources::check(layout)?;
    for (place, dof) in result.dofs.iter().enumerate() {
        belongs(dof, &layout.resolved)
            .map_err(|reason| format!("result.dofs[{place}] ({}): {reason}", dof.dof))?;
        if result.dofs[..place].iter().any(|other| other.index == dof.index) {
            return Err(format!("result.dofs[{place}] ({}): it is there twice", dof.dof));
        }
    }
    for (place, head) in result.lines.iter().enumerate() {
        let hit = layout.resolved.hits.get(usize::from(head.index));
        if hit.is_none_or(|hit| hit.dof != head.dof) {
            let dof = head.dof;
            return Err(format!(
                "result.lines[{place}] ({dof}): the layout has another hit at this index"
            ));
        }
    }
    for (place, dof_lines) in lines.iter().enumerate() {
        dof_lines
            .check(&result.lines, layout.resolved.sensors.len())
            .map_err(|reason| format!("lines[{place}] ({}): {reason}", dof_lines.dof))?;
    }
    if !is_usable(&archive.rig.sampler.adc) {
        return Err("rig.sampler.adc: no converter has these properties".into());
    }
    for (place, dof_spectra) in spectra.iter().enumerate() {
        dof_spectra.check().map_err(|reason| format!("spectra[{place}]: {reason}"))?;
    }
    if let Some(answers) = archive.answers() {
        answers.check().map_err(|reason| format!("answers.{reason}"))?;
    }
    Ok(())
}

/// True for a layout whose points could be those of an object.
fn is_of_an_object(layout: &ArchivedLayout) -> bool {
    let sensors = layout.resolved.sensors.iter().map(|sensor| sensor.position);
    let hits = layout.resolved.hits.iter().map(|hit| hit.position);
    let nodes = layout.nodes.iter().map(|node| node.position_m);
    sensors.chain(hits).chain(nodes).flatten().all(|coordinate| coordinate.abs() <= FARTHEST)
}

/// True for properties that codes can be converted with.
fn is_usable(adc: &AdcProperties) -> bool {
    let is_positive = |value: f32| value.is_finite() && value > 0.0;
    let delay = adc.channel_delay.0;
    (1..=16).contains(&adc.bits)
        && is_positive(adc.rate.0)
        && is_positive(adc.reference.0)
        && delay.is_finite()
        && delay >= 0.0
}

/// Checks that a DOF is one of the layout, with mass lines that can be solved.
fn belongs(dof: &DofResult, layout: &HostLayout) -> Result<(), &'static str> {
    if layout.hits.get(usize::from(dof.index)).is_none_or(|hit| hit.dof != dof.dof) {
        return Err("the layout has another hit at this index");
    }
    if dof.hits == 0 || dof.noise.iter().any(|noise| *noise < 0.0) {
        return Err("it has no hits, or its noise is negative");
    }
    dof.mass_lines().map(|_| ()).ok_or("its numbers contradict each other")
}

/// The error for bytes that are not one JSON value.
fn not_json(error: &serde_json::Error, file: &str) -> Error {
    if error.is_eof() {
        return Error::input(
            "archive_cut_short",
            format!(
                "{file}: this archive is cut short: it ends in the middle of a value; copy it again, or fetch the \
                 result once more with `massline results get`"
            ),
        );
    }
    let message = format!("{file}: this is not an archive: it is not JSON ({error})");
    Error::input("not_an_archive", message)
}

/// The error for an archive that is not as it was written.
pub(super) fn edited(file: &str) -> Error {
    let message = format!(
        "{file}: this archive was edited, or rewritten by another program: its contents do not have its checksum. Use \
         the archive as it was written; to read this one as it is, delete its key \"checksum\""
    );
    Error::input("archive_edited", message)
}

/// The error for an archive with contents that this program cannot have written.
pub(super) fn malformed(file: &str, reason: String) -> Error {
    let message = format!(
        "{file}: this archive is damaged: {reason}; was it edited, or written by a development version? `massline \
         results get` writes it anew while the rig has the result"
    );
    Error::input("archive_malformed", message)
}
