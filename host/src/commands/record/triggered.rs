//! Records hit by hit: each record is read before its hit is accepted.

use massline_protocol::event::HitEvent;
use massline_protocol::message::{Reason, Status};
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::Scan;

use super::Recording;
use crate::output::Output;
use crate::support::progress::{Progress, Prompts};
use crate::support::show;
use crate::{Error, Result};
use massline_client::Client;
use massline_client::campaign::{
    CampaignOutcome, Observer, StartOptions, begin, follow, is_out_of_reach, restarted,
};
use massline_files::clock;
use massline_files::tape::{LEAD_IN_SCANS, Segment, TapeWriter};

/// Runs a campaign with the layout on the rig, and writes the record of every good hit; returns the number of hits.
pub(super) fn record(
    client: &mut Client,
    recording: &Recording<'_>,
    writer: &mut TapeWriter,
    output: &mut Output,
) -> Result<u32> {
    let layout = recording.layout;
    let started_unix_s = clock::unix_seconds();
    begin(client, StartOptions { confirm: true, started_unix_s, ..StartOptions::default() })?;
    let interrupt = output.interrupt().clone();
    let progress = Progress::new(output, "hits", layout, Prompts::Hits);
    let mut recorder = Recorder { progress, recording, writer, read: 0, hits: 0 };
    let ending = follow(client, &interrupt, None, &mut recorder);
    let hits = recorder.hits;
    drop(recorder);
    if ending.as_ref().is_err_and(|e| !is_out_of_reach(e)) {
        // A recording cannot be resumed.
        client.command(Command::Abort).ok();
    }
    match ending? {
        CampaignOutcome::Done(number) => {
            output.note(format!("the rig keeps the result as number {number}"));
            Ok(hits)
        }
        CampaignOutcome::Stopped(status) => Err(show::stopped(&status)),
        CampaignOutcome::Restarted(status) => {
            client.command(Command::Abort).ok();
            Err(restarted(&status))
        }
        CampaignOutcome::Paused(_) | CampaignOutcome::Aborted => {
            client.command(Command::Abort).ok();
            Err(Error::interrupted("the recording was interrupted"))
        }
    }
}

struct Recorder<'o, 'r> {
    progress: Progress<'o>,
    recording: &'r Recording<'r>,
    writer: &'r mut TapeWriter,
    /// Number of the hit whose record was read last.
    read: u32,
    hits: u32,
}

impl Recorder<'_, '_> {
    fn keep(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let scans = client.hit_record(status.last_hit)?;
        let dof = self.recording.layout.hits.get(usize::from(status.dof)).map(|hit| hit.dof);
        let Some(dof) = dof else { return Ok(()) };
        let start = self.writer.scans();
        self.writer.push(&lead_in(&scans))?;
        self.writer.push(&scans)?;
        self.writer.segment(Segment { start, dof })
    }
}

/// The scans to play before a record: its quiet beginning once more, so that a trigger that fires a scan
/// earlier still has its pre-trigger scans. The record itself is unchanged.
fn lead_in(record: &[Scan]) -> Vec<Scan> {
    record.iter().take(LEAD_IN_SCANS).copied().collect()
}

impl Observer for Recorder<'_, '_> {
    fn status(&mut self, status: &Status) {
        // The program gives the verdict, so the operator is not prompted for one.
        if Phase::try_from(status.phase).ok() != Some(Phase::Confirming) {
            self.progress.status(status);
        }
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.progress.hit(hit);
    }

    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        if Phase::try_from(status.phase).ok() != Some(Phase::Confirming) {
            return Ok(None);
        }
        if status.last_hit != self.read {
            self.keep(client, status)?;
            self.read = status.last_hit;
            self.hits += 1;
        }
        Ok(Some(Command::Accept))
    }

    /// A recording has every DOF, whatever the target.
    fn at_target(&mut self, _: &mut Client, _: &Status) -> Result<Option<Command>> {
        Ok(Some(Command::Continue))
    }

    fn refused(&mut self, command: Command, reason: Reason) {
        self.progress.refused(command, reason);
    }
}

#[cfg(test)]
mod tests {
    use massline_shared::signal::PRE_TRIGGER_SCANS;

    use super::*;

    #[test]
    fn the_lead_in_is_shorter_than_the_quiet_beginning() {
        let record: Vec<Scan> = (0..2048_u16).map(|i| [i; 10]).collect();
        let lead_in = lead_in(&record);
        assert_eq!(lead_in[..], record[..LEAD_IN_SCANS]);
        const { assert!(LEAD_IN_SCANS < PRE_TRIGGER_SCANS) };
    }
}
