//! How a person at the terminal sees a campaign: as lines, or on a full screen.

use crossterm::event::KeyCode;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Reason, Status};
use massline_shared::measurement::campaign::Command;

use crate::support::progress::Progress;
use massline_client::Client;
use massline_client::campaign::explain_refusal;
use massline_result::ModesSoFar;

use crate::Result;
use massline_analysis::precision::PrecisionReport;
use massline_report::words::{modes_so_far, precision};

/// Shows a campaign to a person.
pub(super) trait Presenter {
    /// The status has changed.
    fn status(&mut self, status: &Status);

    /// A hit was graded.
    fn hit(&mut self, hit: &HitEvent);

    /// The precision after a further DOF.
    fn precision(&mut self, report: &PrecisionReport<'_>);

    /// Which modes show after a further DOF, in the suspension profile.
    fn modes(&mut self, report: &ModesSoFar);

    /// The hit that closed a DOF was undone: the lines of so many DOFs are left.
    fn reopened(&mut self, measured: usize) {
        let _ = measured;
    }

    /// The object rings for so many seconds yet, or not any more.
    fn ringing(&mut self, left_s: Option<u64>);

    /// A key has given the rig a command, so what was said before is dealt with.
    fn acted(&mut self) {}

    /// A question that a key answers, or that answers itself.
    fn question(&mut self, text: &str);

    /// Something else to be read.
    fn line(&mut self, text: &str);

    /// Called again and again: reads from the rig what is shown besides.
    ///
    /// # Errors
    /// When the link is lost.
    fn look(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let _ = (client, status);
        Ok(())
    }

    /// Takes a key that only changes what is shown; false for any other key.
    fn key(&mut self, key: KeyCode) -> bool {
        let _ = key;
        false
    }

    /// The rig refused a command.
    fn refused(&mut self, command: Command, reason: Reason) {
        self.line(&explain_refusal(command, reason));
    }
}

impl Presenter for Progress<'_> {
    fn status(&mut self, status: &Status) {
        Progress::status(self, status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        Progress::hit(self, hit);
    }

    fn precision(&mut self, report: &PrecisionReport<'_>) {
        Progress::line(self, &precision::text(report));
    }

    fn modes(&mut self, report: &ModesSoFar) {
        Progress::line(self, &modes_so_far::text(report));
    }

    fn ringing(&mut self, left_s: Option<u64>) {
        Progress::ringing(self, left_s);
    }

    fn question(&mut self, text: &str) {
        Progress::line(self, text);
    }

    fn line(&mut self, text: &str) {
        Progress::line(self, text);
    }
}
