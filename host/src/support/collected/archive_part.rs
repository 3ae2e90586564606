//! What an interrupted campaign has read from the rig for its archive.
//!
//! A rig does not store frequency responses and records of hits, so they would be lost when the program ends before the
//! campaign does. They go to a file beside the archive, `FILE.massline.part`, from which the next
//! `massline measure --output FILE.massline` takes them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use massline_shared::layout::{Dof, HOST_HITS};
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::support::collected::hit_log;
use massline_client::followed::FollowedCampaign;
use massline_files::archive::{
    ArchivedSpectra, HitRecord, MAX_BYTES, MOST_LOGGED_HITS, MOST_RECORDS, SCHEMA_VERSION,
};
use massline_files::file::{self, ExistingFile};
use massline_files::limited::at_most;
use massline_result::{Json, LoggedHit};

const FORMAT: &str = "massline-archive-part";

/// What has been read so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    format: String,
    schema_version: u32,
    /// The campaign.
    campaign: CampaignId,
    /// Spectra of the finished DOFs.
    #[serde(deserialize_with = "at_most::<HOST_HITS, _, _>")]
    pub spectra: Vec<ArchivedSpectra>,
    /// Records of the accepted hits.
    #[serde(deserialize_with = "at_most::<MOST_RECORDS, _, _>")]
    pub hit_records: Vec<HitRecord>,
    /// Every hit that was graded.
    #[serde(deserialize_with = "at_most::<MOST_LOGGED_HITS, _, _>")]
    pub hit_log: Vec<LoggedHit>,
    /// How far the campaign was followed.
    pub followed: FollowedCampaign,
}

/// What distinguishes a campaign from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CampaignId {
    /// Hash of its layout.
    pub layout_hash: u32,
    /// When it was started, seconds since 1970-01-01 00:00 UTC.
    pub started_unix_s: u32,
}

impl Part {
    /// What was read in this campaign.
    pub fn new(
        campaign: CampaignId,
        spectra: Vec<ArchivedSpectra>,
        hit_records: Vec<HitRecord>,
        hit_log: Vec<LoggedHit>,
        followed: FollowedCampaign,
    ) -> Self {
        Self {
            format: FORMAT.into(),
            schema_version: SCHEMA_VERSION,
            campaign,
            spectra,
            hit_records,
            hit_log,
            followed,
        }
    }

    /// Leaves out what was read of a DOF whose hits are others on the rig now.
    pub fn forget(&mut self, dof: Dof) {
        let name = dof.to_string();
        self.spectra.retain(|spectra| spectra.dof != name);
        self.hit_records.retain(|record| record.dof != name);
        hit_log::forget(&mut self.hit_log, &name);
    }

    /// The file beside an archive.
    pub fn path(archive: &Path) -> PathBuf {
        let mut name = OsString::from(archive);
        name.push(".part");
        name.into()
    }

    /// The part beside an archive; `None` when there is none of this campaign.
    pub fn read(archive: &Path, campaign: CampaignId) -> Option<Self> {
        let bytes = file::read(&Self::path(archive), MAX_BYTES).ok()?;
        let part: Self = Json::parse(&bytes).ok()?.read().ok()?;
        let is_known = part.format == FORMAT && part.schema_version == SCHEMA_VERSION;
        (is_known && part.campaign == campaign).then_some(part)
    }

    /// Writes the part beside an archive.
    ///
    /// # Errors
    /// Exit 2 when it cannot be written.
    pub fn write(&self, archive: &Path) -> Result<()> {
        let path = Self::path(archive);
        let bytes = serde_json::to_vec(self).map_err(|e| file::cannot(&path, e))?;
        file::write(&path, &bytes, ExistingFile::Replaced)
    }

    /// Deletes the part beside an archive, if there is one.
    pub fn delete(archive: &Path) {
        // A part that stays is ignored by every other campaign.
        let _ = std::fs::remove_file(Self::path(archive));
    }
}

#[cfg(test)]
mod tests {
    use massline_result::HitVerdict;

    use super::*;

    #[test]
    fn what_was_read_before_an_interruption_is_for_its_campaign_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.massline");
        let campaign = CampaignId { layout_hash: 7, started_unix_s: 1_795_000_000 };
        let record = HitRecord { hit: 1, dof: "1:+Y".into(), codes: Vec::new() };
        let hit = LoggedHit {
            dof: "1:+Y".into(),
            hit: 1,
            verdict: HitVerdict::Accepted,
            findings: Vec::new(),
            peak_force_n: Some(21.5),
            peak_acceleration_m_per_s2: None,
            impulse_n_s: None,
            rest: None,
            remainder: None,
            graded: None,
        };
        let followed = FollowedCampaign::default();
        let part = Part::new(campaign, Vec::new(), vec![record], vec![hit], followed);
        part.write(&path).unwrap();
        assert!(Part::path(&path).ends_with("a.massline.part"));
        assert_eq!(Part::read(&path, campaign), Some(part));
        let later = CampaignId { started_unix_s: 1_795_000_001, ..campaign };
        assert_eq!(Part::read(&path, later), None);
        std::fs::write(Part::path(&path), "{\"format\":").unwrap();
        assert_eq!(Part::read(&path, campaign), None);
        Part::delete(&path);
        assert!(!Part::path(&path).exists());
    }
}
