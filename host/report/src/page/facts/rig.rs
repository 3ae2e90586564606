//! The rig, or what has stood in for one.

use massline_shared::layout::TestProfile;
use massline_shared::signal::{AdcProperties, PRE_TRIGGER_SCANS, RECORD_SCANS};

use super::{Fact, Group, fact};
use crate::result_file::ResultFile;
use massline_files::archive::{Archive, ArchivedSampler};

/// The boards of simulated rigs: in this program, and in QEMU.
const SIMULATED: [&str; 2] = ["virtual", "mps2-an386"];

/// The board that has measured; empty where it is not known.
pub(in super::super) fn board(source: &ResultFile) -> String {
    match source.archive() {
        Some(archive) => archive.rig.board.clone(),
        None if is_of_simulated_rig(source) => "simulated".into(),
        None => String::new(),
    }
}

/// What was simulated, in a sentence; empty for a test of a real object.
pub(in super::super) fn simulated(source: &ResultFile) -> String {
    let board = source.archive().map(|archive| archive.rig.board.as_str());
    match board.filter(|board| SIMULATED.contains(board)) {
        Some(board) => {
            format!("Simulated: a simulated rig ({board}) has measured a simulated object.")
        }
        None if is_of_simulated_rig(source) => {
            "Simulated: a simulated rig has measured a simulated object.".into()
        }
        None if source.result().truth.is_some() => {
            "Simulated: these are the responses of a simulated object.".into()
        }
        None => String::new(),
    }
}

/// Whether a simulated rig has measured it.
fn is_of_simulated_rig(source: &ResultFile) -> bool {
    source.result().truth.is_some() && source.result().firmware.is_some()
}

/// Board, firmware and sampling.
pub(super) fn group(source: &ResultFile) -> Group {
    let rows = match source.archive() {
        Some(archive) => of_archive(archive),
        None => of_document(source),
    };
    Group::new("Rig", rows)
}

fn of_archive(archive: &Archive) -> Vec<Fact> {
    let rig = &archive.rig;
    let changed = if rig.git_dirty { ", with changes" } else { "" };
    let ArchivedSampler { adc, pre_trigger_scans } = &rig.sampler;
    let rate = f64::from(adc.rate.0);
    let record = match archive.result.profile() {
        TestProfile::MassLine => {
            let before = 1e3 * f64::from(*pre_trigger_scans) / rate;
            let seconds = RECORD_SCANS as f64 / rate;
            format!("{seconds:.3} s, {before:.0} ms of it before the hit")
        }
        TestProfile::Suspension => long_record(adc),
    };
    vec![
        fact("board", &rig.board),
        fact("firmware", format!("{} (commit {}{changed})", rig.firmware, rig.git_hash)),
        fact("sampling", format!("{rate:.0} scans per second, {} bits", adc.bits)),
        fact("record of a hit", record),
    ]
}

/// The record of a hit in the suspension profile: the force in every scan about the hit, the responses filtered and
/// decimated.
fn long_record(adc: &AdcProperties) -> String {
    let rate = f64::from(adc.of_rows().rate.0);
    let [duration, before] = [RECORD_SCANS, PRE_TRIGGER_SCANS].map(|rows| rows as f64 / rate);
    format!(
        "{duration:.1} s, {before:.1} s of it before the hit; responses at {rate:.0} per second"
    )
}

/// What a document says, which has no more than this.
fn of_document(source: &ResultFile) -> Vec<Fact> {
    let result = source.result();
    let mut rows = Vec::new();
    if let Some(firmware) = &result.firmware {
        let board = board(source);
        rows.extend((!board.is_empty()).then(|| fact("board", board)));
        rows.push(fact("firmware", firmware));
    }
    if let (Some(seed), Some(_)) = (result.seed, result.truth) {
        rows.push(fact("seed of the simulation", seed.to_string()));
    }
    rows
}
