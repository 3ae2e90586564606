//! Collects the averaged spectra of a whole campaign, DOF by DOF.
//!
//! A rig keeps the spectra of one DOF: those of the hits in hand, and after the last hit of a DOF
//! until the first of the next one is averaged. In a campaign with confirmation that hit waits for a
//! verdict, so there is all the time to read what it would wipe out.

use massline_protocol::event::{HitEvent, ScanBlock};
use massline_protocol::message::{CampaignCommand, Reason, Status};
use massline_shared::measurement::campaign::Phase;

use crate::campaign::{Observer, Steer};
use crate::client::{Client, ClientError, DofSpectra};
use crate::error::Result;

/// Spectra that have been read so far.
#[derive(Clone, Debug, Default)]
pub struct SpectraCollection {
    kept: Vec<DofSpectra>,
    /// DOFs that were asked for; what the rig does not have it will not have later.
    asked: Vec<u8>,
}

impl SpectraCollection {
    /// Reads the spectra of DOFs that are finished by this status, as far as the rig still has them.
    ///
    /// # Errors
    /// When the link is lost or the rig sends nonsense.
    pub fn collect(&mut self, client: &mut Client, status: &Status) -> Result<(), ClientError> {
        let done = Phase::try_from(status.phase).ok() == Some(Phase::Done);
        for (dof, &accepted) in (0_u8..).zip(&status.accepted) {
            let finished = accepted > 0 && (done || dof != status.dof);
            if !finished || self.asked.contains(&dof) {
                continue;
            }
            self.asked.push(dof);
            match client.spectra(dof) {
                Ok(spectra) if spectra.hits == accepted => self.kept.push(spectra),
                Ok(_) => {}
                Err(e) if e.refusal() == Some(Reason::NotFound) => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    /// All that there are, in the order of the campaign.
    pub fn into_spectra(self) -> Vec<DofSpectra> {
        self.kept
    }
}

/// Looks on and steers as another observer does, collects the spectra, and accepts every hit that
/// waits for a verdict and about which the other one says nothing.
pub struct Collecting<'a> {
    /// Looks on as well.
    pub observer: &'a mut dyn Observer,
    /// Takes the spectra.
    pub collection: &'a mut SpectraCollection,
}

impl Observer for Collecting<'_> {
    fn armed(&mut self, arming: u32, dof: usize) -> Result<()> {
        self.observer.armed(arming, dof)
    }

    fn status(&mut self, status: &Status) {
        self.observer.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.observer.hit(hit);
    }

    fn scans(&mut self, block: &ScanBlock) {
        self.observer.scans(block);
    }

    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<Steer>> {
        // Before any command: most of them make the rig forget.
        self.collection.collect(client, status)?;
        let steer = self.observer.steer(client, status)?;
        let waits = Phase::try_from(status.phase).ok() == Some(Phase::Confirming);
        Ok(steer.or(waits.then_some(Steer::Command(CampaignCommand::Accept))))
    }

    fn refused(&mut self, command: CampaignCommand) {
        self.observer.refused(command);
    }
}
