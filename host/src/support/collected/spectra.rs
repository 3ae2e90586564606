//! Collects the averaged spectra of a whole campaign, DOF by DOF.
//!
//! A rig stores the spectra of one DOF only: those of the DOF in progress, and after its last hit until the
//! first hit of the next DOF is averaged. In a campaign with confirmation that hit waits for a verdict, which
//! leaves time to read the spectra before they are overwritten.

use massline_protocol::event::{HitEvent, ScanBlock};
use massline_protocol::message::{Reason, Status};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Phase};

use crate::Result;
use crate::support::collected::hit_log::HitLog;
use crate::support::collected::hit_records::RecordCollection;
use massline_client::campaign::{Observer, open_dof};
use massline_client::followed::FollowedCampaign;
use massline_client::{Client, ClientError};
use massline_files::dof_spectra::DofSpectra;

/// Spectra that have been read so far.
#[derive(Clone, Debug, Default)]
pub struct SpectraCollection {
    kept: Vec<DofSpectra>,
    /// DOFs whose spectra were requested once; spectra that the rig does not have then are lost for good.
    asked: Vec<u8>,
    /// How far the campaign was followed.
    pub followed: FollowedCampaign,
}

impl SpectraCollection {
    /// Goes on with a campaign that was followed so far.
    pub fn after(followed: FollowedCampaign) -> Self {
        Self { followed, ..Self::default() }
    }

    /// Reads the spectra of the DOFs that are finished according to this status, if the rig still has them. Those of a
    /// DOF that is open again, because its last hit was undone, are discarded.
    ///
    /// # Errors
    /// When the link is lost or the rig sends invalid data.
    pub fn collect(&mut self, client: &mut Client, status: &Status) -> Result<(), ClientError> {
        self.followed.status(status);
        if let Some(open) = open_dof(status) {
            self.asked.retain(|&dof| dof != open);
            self.kept.retain(|spectra| spectra.dof != open);
        }
        let done = Phase::try_from(status.phase).ok() == Some(Phase::Done);
        for (dof, &accepted) in (0_u8..).zip(&status.accepted) {
            let finished = accepted > 0 && (done || dof != status.dof);
            if !finished || self.asked.contains(&dof) {
                continue;
            }
            self.asked.push(dof);
            match client.spectra(dof) {
                Ok(spectra) if spectra.hits == accepted => {
                    self.kept.push(spectra);
                    if let Some(lines) = client.mass_lines(dof)? {
                        self.followed.finished(&lines);
                    }
                }
                Ok(_) => {}
                Err(e) if e.refusal() == Some(Reason::NotFound) => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    /// All collected spectra, in the order of the campaign.
    pub fn spectra(&self) -> &[DofSpectra] {
        &self.kept
    }

    /// As [`Self::spectra`].
    pub fn into_spectra(self) -> Vec<DofSpectra> {
        self.kept
    }
}

/// Forwards everything to another observer and collects the spectra, and the records of hits where they are wanted.
pub struct CollectingObserver<'a> {
    /// The other observer.
    pub observer: &'a mut dyn Observer,
    /// Stores the spectra.
    pub collection: &'a mut SpectraCollection,
    /// Stores the records of accepted hits, named by the layout, where they are wanted.
    pub records: Option<(&'a mut RecordCollection, &'a RigLayout)>,
    /// Stores what became of every hit, where that is wanted.
    pub log: Option<&'a mut HitLog>,
    /// Whether hits that the other observer does not decide on are accepted; otherwise they go on waiting.
    pub accepts: bool,
}

impl CollectingObserver<'_> {
    /// Reads the record of a hit that is about to be accepted, and drops those of hits that do not count any more.
    fn keep_records(
        &mut self,
        client: &mut Client,
        status: &Status,
        command: Option<Command>,
    ) -> Result<()> {
        let Some((records, layout)) = &mut self.records else { return Ok(()) };
        let hit = layout.hits.get(usize::from(status.dof));
        if let (Some(open), Some(hit)) = (open_dof(status), hit) {
            records.truncate(hit.dof, status.accepted.get(usize::from(open)).copied().unwrap_or(0));
        }
        match command {
            Some(Command::Accept) => records.collect(client, status, layout),
            Some(Command::Redo) => {
                hit.into_iter().for_each(|hit| records.discard(hit.dof));
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

impl Observer for CollectingObserver<'_> {
    fn armed(&mut self, arming: u32, dof: usize) -> Result<()> {
        self.observer.armed(arming, dof)
    }

    fn status(&mut self, status: &Status) {
        if let Some(log) = &mut self.log {
            log.status(status);
        }
        self.observer.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        if let Some(log) = &mut self.log {
            log.hit(hit);
        }
        self.observer.hit(hit);
    }

    fn scans(&mut self, block: &ScanBlock) {
        self.observer.scans(block);
    }

    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        // Before any command, because most commands make the rig discard the spectra.
        self.collection.collect(client, status)?;
        let steer = self.observer.steer(client, status)?;
        let waits = Phase::try_from(status.phase).ok() == Some(Phase::Confirming);
        let accept = Command::Accept;
        let steer = steer.or((waits && self.accepts).then_some(accept));
        self.keep_records(client, status, steer)?;
        Ok(steer)
    }

    fn at_target(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        self.collection.collect(client, status)?;
        self.observer.at_target(client, status)
    }

    fn refused(&mut self, command: Command, reason: Reason) {
        self.observer.refused(command, reason);
    }
}
