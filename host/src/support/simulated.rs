//! One campaign on a simulated rig: configures it over its link, taps or plays a tape, and reads the result.

mod report;

use std::path::PathBuf;
use std::time::Duration;

use massline_protocol::event::HitEvent;
use massline_protocol::message::{Identity, Reason, Status};
use massline_protocol::object::MeasurementResult;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{HostLayout, RigLayout, TestProfile};
use massline_shared::measurement::campaign::Command;

use super::collected::CollectedData;
use super::progress::{Progress, Prompts};
use super::rig_layout::judge_layout;
use super::show;
use crate::output::Output;
use crate::rig::{RigKind, SimulatedRig};
use crate::rig_lines::{RigLines, StoredTest};
use crate::support::collected::spectra::CollectingObserver;
use crate::{Error, Result};
use massline_client::Client;
use massline_client::campaign::{
    CampaignOutcome, Observer, StartOptions, begin, follow, restarted,
};
use massline_files::archive::{Archive, ArchivedLayout};

pub use report::{ReportArgs, results_of};

/// A simulated rig without progress for this long is stuck; the slowest step takes a few seconds in a build
/// without optimisation.
const PATIENCE: Duration = Duration::from_secs(120);

/// Options that choose the simulated rig.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct RigArgs {
    /// Simulated rig.
    #[arg(long, value_enum, default_value_t, value_name = "RIG")]
    pub rig: RigKind,
    /// Firmware image for `--rig qemu`; default: built from this checkout.
    #[arg(long, value_name = "ELF")]
    pub firmware: Option<PathBuf>,
}

impl RigArgs {
    /// The firmware image that the rig needs, see [`RigKind::firmware`].
    ///
    /// # Errors
    /// When it does not exist and cannot be built.
    pub fn image(&self) -> Result<Option<PathBuf>> {
        self.rig.firmware(self.firmware.as_deref())
    }
}

/// The layout in the precision and capacity of the rig.
///
/// # Errors
/// When it has more sensors or hits than a rig has room for.
pub fn narrow(layout: &HostLayout) -> Result<RigLayout> {
    layout.cast().ok_or_else(|| {
        Error::input("layout_too_large", "the layout has more sensors or hits than a rig takes")
    })
}

/// Decides on the next command, as [`Observer::steer`].
pub type Policy<'p> =
    dyn FnMut(&mut Client, &Status, &mut Progress) -> Result<Option<Command>> + 'p;

/// What a campaign on a simulated rig has measured.
#[derive(Clone, Debug)]
pub struct SimulatedMeasurement {
    /// The rig's result.
    pub result: MeasurementResult,
    /// The lines that belong to it.
    pub lines: RigLines,
}

impl SimulatedMeasurement {
    /// The same, borrowed.
    pub fn test(&self) -> StoredTest<'_> {
        StoredTest { result: &self.result, lines: &self.lines }
    }
}

/// A campaign on a simulated rig.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedCampaign<'a> {
    /// Name of the campaign, for people.
    pub label: &'a str,
    /// The layout to send.
    pub layout: &'a RigLayout,
    /// The calibration to send.
    pub calibration: &'a CalibrationRecord,
}

impl SimulatedCampaign<'_> {
    /// Runs the campaign to its result.
    ///
    /// # Errors
    /// When the rig refuses, gets stuck or crashes.
    pub fn run(
        &self,
        rig: &mut SimulatedRig,
        output: &mut Output,
        policy: &mut Policy<'_>,
    ) -> Result<SimulatedMeasurement> {
        let measured = self.try_run(rig, output, policy, None);
        measured.map(|(_, measured)| measured).map_err(|e| rig.explain(e))
    }

    /// Runs the campaign to its archive, with the frequency responses and the records of all hits. They are read while
    /// a hit waits for its verdict, which does not change the result.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn archived(
        &self,
        rig: &mut SimulatedRig,
        layout: ArchivedLayout,
        output: &mut Output,
        policy: &mut Policy<'_>,
    ) -> Result<Archive> {
        let mut collected = CollectedData::simulated();
        let measured = self.try_run(rig, output, policy, Some(&mut collected));
        let (identity, SimulatedMeasurement { result, lines }) =
            measured.map_err(|e| rig.explain(e))?;
        let mut archive = Archive::new(&identity, layout, self.calibration, result, None);
        archive.lines = lines.into_dofs();
        Ok(collected.added_to(archive, self.layout, self.has_records(), output))
    }

    /// Records of hits are scans in the mass-line profile only.
    fn has_records(&self) -> bool {
        self.layout.test.profile == TestProfile::MassLine
    }

    fn try_run(
        &self,
        rig: &mut SimulatedRig,
        output: &mut Output,
        policy: &mut Policy<'_>,
        mut collected: Option<&mut CollectedData>,
    ) -> Result<(Identity, SimulatedMeasurement)> {
        let (mut client, identity) = rig.connect()?;
        client.put_calibration(self.calibration)?;
        judge_layout(&client.put_layout(self.layout)?, self.layout, false, output)?;
        let confirm = collected.is_some();
        begin(&mut client, StartOptions { confirm, ..StartOptions::default() })?;
        let interrupt = output.interrupt().clone();
        let progress = Progress::new(output, self.label, self.layout, Prompts::Nothing);
        let mut operator = Operator { progress, rig, policy };
        let mut observe =
            |observer: &mut dyn Observer| follow(&mut client, &interrupt, Some(PATIENCE), observer);
        let ending = match &mut collected {
            Some(collected) => observe(&mut CollectingObserver {
                observer: &mut operator,
                collection: &mut collected.spectra,
                records: self.has_records().then_some((&mut collected.records, self.layout)),
                log: Some(&mut collected.log),
                accepts: true,
            }),
            None => observe(&mut operator),
        }?;
        drop(operator);
        match ending {
            CampaignOutcome::Done(number) => {
                let result = client.result(number)?;
                let lines = RigLines::read(&mut client, identity.adc, &result)?;
                if let Some(collected) = collected {
                    // Those of the last DOF.
                    let status = client.status()?;
                    collected.spectra.collect(&mut client, &status)?;
                }
                Ok((identity, SimulatedMeasurement { result, lines }))
            }
            CampaignOutcome::Stopped(status) => Err(show::stopped(&status)),
            CampaignOutcome::Restarted(status) => Err(restarted(&status)),
            CampaignOutcome::Paused(_) | CampaignOutcome::Aborted => {
                Err(Error::interrupted("interrupted; the simulated rig is gone"))
            }
        }
    }
}

/// Forwards the rig's prompts to the bench or tape, and the progress to the user.
struct Operator<'o, 'p> {
    progress: Progress<'o>,
    rig: &'o SimulatedRig,
    policy: &'o mut Policy<'p>,
}

impl Observer for Operator<'_, '_> {
    fn armed(&mut self, arming: u32, dof: usize) -> Result<()> {
        self.progress.refuse_rejections(dof)?;
        self.rig.armed(arming, dof);
        Ok(())
    }

    fn status(&mut self, status: &Status) {
        self.progress.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.progress.hit(hit);
    }

    fn steer(&mut self, client: &mut Client, status: &Status) -> Result<Option<Command>> {
        let steer = (self.policy)(client, status, &mut self.progress)?;
        self.rig.poke();
        Ok(steer)
    }

    fn at_target(&mut self, _: &mut Client, _: &Status) -> Result<Option<Command>> {
        self.progress.line("target reached; finishing");
        Ok(Some(Command::Conclude))
    }

    fn refused(&mut self, command: Command, reason: Reason) {
        self.progress.refused(command, reason);
    }
}
