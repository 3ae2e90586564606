//! What a campaign reads from the rig for its archive, and a rig does not store.

pub mod archive_part;
pub mod hit_log;
pub(crate) mod hit_records;
pub mod spectra;

use std::path::{Path, PathBuf};

use massline_protocol::message::Status;
use massline_protocol::object::MeasurementResult;
use massline_shared::layout::RigLayout;

use crate::Result;
use crate::output::Output;
use archive_part::{CampaignId, Part};
use hit_log::HitLog;
use hit_records::RecordCollection;
use massline_client::Client;
use massline_files::archive::{Archive, ArchivedSpectra, HitRecord, MOST_LOGGED_HITS};
use massline_files::dof_spectra::DofSpectra;
use massline_result::LoggedHit;
use massline_shared::layout::Dof;
use massline_shared::signal::RESPONSES;
use nalgebra::Complex;
use spectra::SpectraCollection;

/// Frequency responses, records of hits, and what became of every hit.
#[derive(Default)]
pub struct CollectedData {
    /// The archive and the campaign.
    part: Option<(PathBuf, CampaignId)>,
    /// Those read before the campaign was interrupted.
    earlier: Vec<ArchivedSpectra>,
    earlier_hits: Vec<LoggedHit>,
    /// Averaged spectra of each DOF.
    pub spectra: SpectraCollection,
    /// Records of single hits.
    pub records: RecordCollection,
    /// What became of every hit.
    pub log: HitLog,
}

impl CollectedData {
    /// Begins a simulated campaign, whose hits have no time of day.
    pub fn simulated() -> Self {
        Self { log: HitLog::simulated(), ..Self::default() }
    }

    /// Begins with what was read before the campaign on this rig was interrupted; nothing without an archive.
    ///
    /// What belongs to hits that the rig has replaced meanwhile is left out.
    pub fn of_campaign(
        archive: Option<&Path>,
        layout: &RigLayout,
        client: &mut Client,
    ) -> Result<Self> {
        let Some(archive) = archive else { return Ok(Self::default()) };
        let Status { layout_hash, started_unix_s, .. } = client.status()?;
        if started_unix_s == 0 {
            // Started without a computer, a campaign cannot be told from others with its layout.
            return Ok(Self::default());
        }
        let campaign = CampaignId { layout_hash, started_unix_s };
        let part = Some((archive.to_owned(), campaign));
        let Some(mut read) = Part::read(archive, campaign) else {
            return Ok(Self { part, ..Self::default() });
        };
        for changed in read.followed.changed(client)? {
            if let Some(hit) = layout.hits.get(usize::from(changed)) {
                read.forget(hit.dof);
            }
        }
        Ok(Self {
            part,
            earlier: read.spectra,
            earlier_hits: read.hit_log,
            spectra: SpectraCollection::after(read.followed),
            records: RecordCollection::of(read.hit_records),
            log: HitLog::default(),
        })
    }

    /// Discards what was read, because the campaign was aborted.
    pub fn discard(&mut self) {
        if let Some((archive, _)) = self.part.take() {
            Part::delete(&archive);
        }
    }

    /// Keeps what was read, in a file beside the archive, for the command that goes on with the campaign.
    pub fn keep(&self, layout: &RigLayout, output: &mut Output) {
        let Some((archive, campaign)) = &self.part else { return };
        let (spectra, records) = (self.archived_spectra(layout), self.hit_records());
        let hits = self.hit_log(layout);
        if spectra.is_empty() && records.is_empty() && hits.is_empty() {
            return;
        }
        let read =
            format!("frequency responses: {}, records of hits: {}", spectra.len(), records.len());
        let followed = self.spectra.followed.clone();
        match Part::new(*campaign, spectra, records, hits, followed).write(archive) {
            Ok(()) => output.note(format!(
                "read so far ({read}) and kept in {}: the same command adds it to the archive",
                Part::path(archive).display()
            )),
            Err(error) => output.warn(format!(
                "{error}; what was read so far ({read}) is lost, because a rig does not store it"
            )),
        }
    }

    /// The archive with what was read, and a warning of what is missing.
    pub fn added_to(
        &self,
        mut archive: Archive,
        layout: &RigLayout,
        records: bool,
        output: &mut Output,
    ) -> Archive {
        archive.spectra = self.archived_spectra(layout);
        archive
            .spectra
            .retain(|spectra| hits_of(&archive.result, &spectra.dof) == Some(spectra.hits.into()));
        archive.hit_records = self.hit_records();
        archive.hit_log = self.hit_log_of(&archive.result, layout);
        for missing in missing(&archive, records) {
            output.warn(missing);
        }
        archive
    }

    /// The spectra of all DOFs; those read later replace those read before.
    fn archived_spectra(&self, layout: &RigLayout) -> Vec<ArchivedSpectra> {
        let named = self.spectra.spectra().iter().filter_map(|spectra| {
            Some(archived(spectra, layout.hits.get(usize::from(spectra.dof))?.dof))
        });
        let new: Vec<_> = named.collect();
        let earlier =
            self.earlier.iter().filter(|spectra| new.iter().all(|new| new.dof != spectra.dof));
        earlier.cloned().chain(new.iter().cloned()).collect()
    }

    /// Every hit of the campaign that this command has followed, before and after an interruption.
    fn hit_log(&self, layout: &RigLayout) -> Vec<LoggedHit> {
        let mut hits = self.earlier_hits.clone();
        hits.extend(self.log.logged(layout));
        hits.truncate(MOST_LOGGED_HITS);
        hits
    }

    /// The same once there is a result.
    pub fn hit_log_of(&self, result: &MeasurementResult, layout: &RigLayout) -> Vec<LoggedHit> {
        let mut hits = self.hit_log(layout);
        hit_log::settle_with(&mut hits, result);
        hits
    }

    fn hit_records(&self) -> Vec<HitRecord> {
        self.records.records().to_vec()
    }
}

/// The number of hits averaged at a DOF.
fn hits_of(result: &MeasurementResult, name: &str) -> Option<u16> {
    result.measured().find(|(dof, ..)| dof.to_string() == name).map(|(.., hits)| hits)
}

/// What an archive should have and has not, in sentences.
fn missing(archive: &Archive, records: bool) -> Vec<String> {
    let measured = archive.result.measured();
    let dofs: Vec<_> = measured.map(|(dof, _, hits)| (dof.to_string(), hits)).collect();
    let has_lines = |name: &str| archive.lines.iter().any(|lines| lines.dof == name);
    let without: Vec<_> = (dofs.iter().map(|(name, _)| name.as_str()))
        .filter(|name| {
            archive.spectra.iter().all(|spectra| spectra.dof != *name) && !has_lines(name)
        })
        .collect();
    let record_count =
        |name: &str| archive.hit_records.iter().filter(|record| record.dof == name).count();
    let other: Vec<_> = dofs
        .iter()
        .filter(|(name, hits)| records && record_count(name) != usize::from(*hits))
        .map(|(name, hits)| format!("{} for {hits} hits at {name}", record_count(name)))
        .collect();
    let spectra = (!without.is_empty()).then(|| format!(
        "the archive has no frequency responses of {}: they were measured while this command did not follow the \
         campaign, and a rig keeps those of its last DOF only",
        without.join(", ")
    ));
    let records = (!other.is_empty()).then(|| {
        format!("the archive has another number of hit records than hits: {}", other.join(", "))
    });
    spectra.into_iter().chain(records).collect()
}

/// The spectra that a rig has sent for this DOF, as an archive has them.
fn archived(spectra: &DofSpectra, dof: Dof) -> ArchivedSpectra {
    let responses = 0..RESPONSES;
    // A rig sends numbers of single precision.
    let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
    let parts = |values: &[Complex<f64>]| {
        values.iter().map(|value| [value.re, value.im].map(|x| x as f32)).collect()
    };
    ArchivedSpectra {
        dof: dof.to_string(),
        hits: spectra.hits,
        resolution_hz: spectra.resolution,
        decay_per_s: spectra.decay,
        force_auto: single(spectra.force_auto()),
        cross: responses.clone().filter_map(|k| spectra.cross(k)).map(parts).collect(),
        response_auto: responses.filter_map(|k| spectra.response_auto(k)).map(single).collect(),
    }
}
