//! Records of single hits, read during a campaign.

use massline_protocol::message::Status;
use massline_shared::layout::{Dof, RigLayout};

use crate::Result;
use massline_client::Client;
use massline_files::archive::HitRecord;

/// The records of the hits of a campaign.
#[derive(Clone, Debug, Default)]
pub struct RecordCollection {
    kept: Vec<HitRecord>,
}

impl RecordCollection {
    /// The records that were read before the campaign was interrupted.
    pub fn of(kept: Vec<HitRecord>) -> Self {
        Self { kept }
    }

    /// Reads the record of the hit that waits for a verdict.
    ///
    /// # Errors
    /// When the link is lost.
    pub fn collect(
        &mut self,
        client: &mut Client,
        status: &Status,
        layout: &RigLayout,
    ) -> Result<()> {
        let Some(dof) = layout.hits.get(usize::from(status.dof)).map(|hit| hit.dof) else {
            return Ok(());
        };
        let codes = client.hit_record(status.last_hit)?;
        self.kept.push(HitRecord { hit: status.last_hit, dof: dof.to_string(), codes });
        Ok(())
    }

    /// Drops the latest records of a DOF of which only `accepted` hits count: the others were withdrawn or undone.
    pub fn truncate(&mut self, dof: Dof, accepted: u8) {
        let (name, mut left) = (dof.to_string(), accepted);
        self.kept.retain(|record| {
            let counts = record.dof != name || left > 0;
            left -= u8::from(record.dof == name && left > 0);
            counts
        });
    }

    /// Drops the records of a DOF that is measured again.
    pub fn discard(&mut self, dof: Dof) {
        let name = dof.to_string();
        self.kept.retain(|record| record.dof != name);
    }

    /// All records, in the order of the campaign.
    pub fn records(&self) -> &[HitRecord] {
        &self.kept
    }
}
