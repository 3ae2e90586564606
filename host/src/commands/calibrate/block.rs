//! `massline calibrate block` and `massline calibrate verify`: tests with a hanging block.

use std::num::NonZeroU8;
use std::path::{Path, PathBuf};

use massline_protocol::object::MeasurementResult;
use massline_shared::calibration::block::BlockMass;
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::RigLayout;
use massline_shared::signal::HAMMER;
use serde_json::json;

use super::rig::{BlockRig, DisplayedBlockTest, RigArgs};
use super::{OriginArgs, Warnings, conversion_order, store};
use crate::commands::measure::{ScreenArgs, make_room, paused};
use crate::output::Output;
use crate::support::collected::spectra::SpectraCollection;
use crate::support::files;
use crate::support::rig_layout::fits;
use crate::support::show;
use crate::{Error, Result};
use massline_analysis::calibration::block::{Block, Conditions};
use massline_analysis::calibration::capacitor::extra_capacitors;
use massline_analysis::calibration::cutoffs::cutoffs;
use massline_analysis::calibration::plausible::{find_implausibility, find_wrong_mass};
use massline_analysis::calibration::verify::{DriftVerdict, drifts};
use massline_client::campaign::{CampaignOutcome, StartOptions, StartOutcome, begin, restarted};
use massline_files::clock;
use massline_files::layout_file::LayoutFile;
use massline_report::calibration::{self as report, capacitor, electronics, plausible};
use massline_report::document::BlockCalibration;
use massline_report::words::message_in;
use massline_result::Verdict;

/// The default layout of the block.
pub const LAYOUT: &str = include_str!("../../../examples/block.toml");

/// Its name in messages.
const DEFAULT_NAME: &str = "block.toml";

/// Blocks that three sensors can be glued to and a hammer can move, kg.
const MASSES_KG: std::ops::RangeInclusive<f64> = 0.02..=500.0;

/// The block of a test.
#[derive(Clone, Debug, clap::Args)]
pub struct BlockArgs {
    #[command(flatten)]
    rig: RigArgs,
    /// Mass of the block with everything glued to it, kg.
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    mass: f64,
    /// Standard deviation of the block's mass, kg.
    #[arg(long, value_name = "KG", default_value_t = 0.001)]
    mass_sigma: f64,
    /// Layout with the block's centre of mass as origin; default: a plate of 160 x 160 x 10 mm with
    /// three sensors around the middle of its top, hit from both sides along each axis.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    /// Discard a campaign that is running or interrupted.
    #[arg(long)]
    restart: bool,
}

/// Arguments of `massline calibrate block`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Hang the block from soft cords like any object, glue the sensors near its centre of mass, and hit it
through the centre of mass, as hard as the channels allow: 2 kg and 60 to 100 N. After a tumble test
this gives the hammer's own sensitivity; without one, the sensors against the hammer. The RC cutoff
of each axis is found against the hammer's, which stays as it is; one below 300 Hz is refused, because
the breakout's own capacitor makes it. Hits from both sides also show what the channel converted after
the hammer keeps of its voltage (memory of the multiplexer) and whether the sensors answer pushes from
both sides alike; mains hum is taken out and named. Good hits are accepted by themselves. The rig
keeps them: after Ctrl-C the same command goes on, but what was hit before gives no cutoffs any more
(--restart hits it again).

Examples:
  massline calibrate block --mass 2.000 --mass-sigma 0.001
  massline calibrate block --mass 1.512 --layout my-block.toml --hits 8
  massline calibrate block --mass 2.000 --rig virtual --seed 7 --flash rig.bin")]
pub struct Args {
    #[command(flatten)]
    block: BlockArgs,
    #[command(flatten)]
    origin: OriginArgs,
    /// Hits per direction; default: the number in the layout.
    #[arg(long, value_name = "N")]
    hits: Option<NonZeroU8>,
    /// The hammer is not the one of the calibration on the rig, so its gain may be anything.
    #[arg(long)]
    new_hammer: bool,
    /// Compute and print, but do not change the calibration on the rig.
    #[arg(long)]
    dry_run: bool,
}

/// Arguments of `massline calibrate verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A block test with few hits, compared with what the rig keeps. Exit 0 when every channel is within
the tolerance, 3 when one has drifted or the hits scatter too much to say.

Examples:
  massline calibrate verify --mass 2.000
  massline calibrate verify --mass 2.000 --tolerance 0.01 --hits 10 --json")]
pub struct VerifyArgs {
    #[command(flatten)]
    block: BlockArgs,
    /// Hits per direction.
    #[arg(long, value_name = "N", default_value = "4")]
    hits: NonZeroU8,
    /// Drift from which on a channel counts as drifted, relative.
    #[arg(long, value_name = "RATIO", default_value_t = 0.02)]
    tolerance: f64,
}

/// Runs `calibrate block`.
///
/// # Errors
/// When the rig cannot be reached or refuses, or the hits do not determine a calibration.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let test = args.block.test(args.hits, output)?;
    let origin = args.origin.origin(test.layout.sensors.len())?;
    let mut rig = args.block.rig.block_rig(&test.file.layout, output)?;
    let before = rig.client.calibration()?;
    let block = test.run(&mut rig, &before, output)?;
    let mut warnings = judge(&block, &before, &test.layout, output)?;
    if let Some(why) = find_implausibility(&block, &before, args.block.mass, args.new_hammer) {
        return Err(plausible::refusal(&why));
    }
    let mut record = before;
    block.write(&mut record);
    origin.write(&mut record);
    if !args.dry_run {
        store(&mut rig.client, &record)?;
    }
    if let Some(hammer) = block.hammer.filter(|hammer| !hammer.is_consistent()) {
        let text = format!(
            "the directions disagree by {:.2} %: a sensor has changed since its tumble test, or some \
             hits missed the centre of mass",
            100.0 * hammer.departure.0,
        );
        warnings.add(text, output);
    }
    let value = BlockCalibration {
        verdict: warnings.verdict(),
        calibration: report::record_json(&record),
        block: report::block_json(&block),
        stored: !args.dry_run,
    };
    output.answer(&value, |output| {
        format!("{}\n{}", warnings.first_line(output), report::block_text(&block, &record))
    })
}

/// Prints and counts what the hits show besides the sensitivities, and refuses a breakout's own capacitor.
///
/// # Errors
/// Exit 3 with the axes whose cutoff has turned out to be too low.
fn judge(
    block: &Block,
    before: &CalibrationRecord,
    layout: &RigLayout,
    output: &mut Output,
) -> Result<Warnings> {
    let low = extra_capacitors(&block.cutoffs);
    if let Some(error) = capacitor::refusal(&low) {
        if !output.json() {
            let hammer = before.calibration.channels[HAMMER].cutoff;
            output.text(report::cutoffs_text(&block.cutoffs, hammer))?;
        }
        output.explain(&json!({ "block": report::block_json(block) }));
        return Err(error);
    }
    show::list(&block.warnings, |d| message_in(d, layout), output);
    let grave = block.warnings.iter().filter(|warning| warning.severity > Severity::Note);
    let mut warnings = Warnings { count: grave.count() };
    capacitor::sentence(&low).into_iter().for_each(|text| warnings.add(text, output));
    electronics::warnings(&block.electronics)
        .into_iter()
        .for_each(|text| warnings.add(text, output));
    Ok(warnings)
}

/// Runs `calibrate verify`.
///
/// # Errors
/// As [`run`]; exit 3 when the calibration has drifted.
pub fn verify(args: &VerifyArgs, output: &mut Output) -> Result<()> {
    if !(args.tolerance > 0.0 && args.tolerance < 1.0) {
        return Err(Error::input("tolerance_out_of_range", "--tolerance must lie between 0 and 1"));
    }
    let test = args.block.test(Some(args.hits), output)?;
    let mut rig = args.block.rig.block_rig(&test.file.layout, output)?;
    let record = rig.client.calibration()?;
    let from_data_sheets = record.method == CalibrationMethod::DataSheet;
    if from_data_sheets {
        output.warn(
            "the rig keeps no calibration yet: its channels are compared with their data sheets; \
             `massline calibrate tumble` and `calibrate block` make one",
        );
    }
    let block = test.run(&mut rig, &record, output)?;
    let warnings = judge(&block, &record, &test.layout, output)?;
    if let Some(why) = find_wrong_mass(&block, &record, args.block.mass, false) {
        return Err(plausible::refusal(&why));
    }
    let drifts = drifts(&block.sensors, args.tolerance);
    let worst = drifts.iter().map(|drift| drift.verdict).max().unwrap_or(DriftVerdict::Good);
    let verdict = worst.on_calibration().max(warnings.verdict());
    let value = report::drifts_json(&drifts, args.tolerance, verdict, &record, &block);
    let text = |output: &Output| {
        let first = match worst {
            DriftVerdict::Good if warnings.verdict() > Verdict::Good => warnings.first_line(output),
            _ => output.verdict_line(verdict, report::check_line(worst, from_data_sheets)),
        };
        format!("{first}\n{}", report::drifts_text(&drifts, args.tolerance))
    };
    let error = match worst {
        DriftVerdict::Good => return output.answer(&value, text),
        DriftVerdict::Drifted => Error::undetermined(
            "calibration_drifted",
            if from_data_sheets {
                "the channels are not what their data sheets say: calibrate"
            } else {
                "the calibration no longer holds: calibrate again"
            },
        ),
        DriftVerdict::Unclear => Error::undetermined(
            "drift_unclear",
            "these hits scatter too much to say whether it holds: use more --hits, or a larger \
             --tolerance",
        ),
    };
    if !output.json() {
        output.text(text(output))?;
    }
    output.explain(&value);
    Err(error)
}

impl BlockArgs {
    fn test(&self, hits: Option<NonZeroU8>, output: &mut Output) -> Result<BlockTest> {
        let sound = MASSES_KG.contains(&self.mass) && self.mass_sigma >= 0.0;
        if !sound || self.mass_sigma >= 0.1 * self.mass {
            let (least, most) = (MASSES_KG.start(), MASSES_KG.end());
            return Err(Error::input(
                "mass_out_of_range",
                format!(
                    "--mass {} and --mass-sigma {}: give a mass from {least} to {most} kg, and less than \
                     a tenth of it as its standard deviation",
                    self.mass, self.mass_sigma,
                ),
            ));
        }
        let mut file = match &self.layout {
            Some(path) => files::layout(path, output)?,
            None => LayoutFile::parse(LAYOUT, DEFAULT_NAME)?,
        };
        if let Some(hits) = hits {
            file.layout.test.hits_per_dof = hits.get();
        }
        let path = self.layout.as_deref().unwrap_or(Path::new(DEFAULT_NAME));
        let layout = files::for_rig(&file, path)?;
        let mass = BlockMass { mass: self.mass, sigma: self.mass_sigma };
        Ok(BlockTest { file, layout, mass, restart: self.restart, screen: self.rig.screen })
    }
}

/// A block test on any rig.
#[derive(Clone, Debug)]
pub struct BlockTest {
    /// The layout in the capacity of the bench.
    pub file: LayoutFile,
    /// The layout in the capacity of the rig.
    pub layout: RigLayout,
    /// The block.
    pub mass: BlockMass<f64>,
    /// Discard a running campaign.
    pub restart: bool,
    /// Whether a person sees a full screen.
    pub screen: ScreenArgs,
}

impl BlockTest {
    /// Runs the campaign and computes its result; `record` is the calibration in force.
    ///
    /// # Errors
    /// When the rig refuses or is stuck, the user interrupts, or the hits do not determine a calibration.
    pub fn run(
        &self,
        rig: &mut BlockRig,
        record: &CalibrationRecord,
        output: &mut Output,
    ) -> Result<Block> {
        fits(&self.layout, &rig.identity)?;
        make_room(&mut rig.client, &self.layout, self.restart)?;
        rig.client.put_layout(&self.layout)?;
        // A hit that waits for a verdict leaves time to read the spectra of the DOF before it.
        let how = StartOptions {
            block_mass: Some(self.mass.mass as f32),
            confirm: true,
            restart: self.restart,
            started_unix_s: clock::unix_seconds(),
            ..StartOptions::default()
        };
        match begin(&mut rig.client, how)? {
            StartOutcome::Started => {}
            StartOutcome::Resumed => output.note("resuming the interrupted block test"),
            StartOutcome::Joined => output.note("joins the block test that is under way"),
        }
        let mut collection = SpectraCollection::default();
        let title = if self.layout.title.is_empty() { "block" } else { &self.layout.title };
        let shown = DisplayedBlockTest { screen: self.screen, title, calibration: record };
        let result = match rig.follow(&self.layout, &mut collection, shown, output)? {
            CampaignOutcome::Done(number) => rig.client.result(number)?,
            CampaignOutcome::Stopped(status) => return Err(show::stopped(&status)),
            CampaignOutcome::Paused(status) => return Err(paused(&status)),
            CampaignOutcome::Restarted(status) => return Err(restarted(&status)),
            CampaignOutcome::Aborted => {
                return Err(Error::interrupted("the block test was aborted; nothing has changed"));
            }
        };
        require_block(&result)?;
        let status = rig.client.status()?;
        collection.collect(&mut rig.client, &status)?;
        let cutoffs = cutoffs(&collection.into_spectra(), &result, &self.layout, record);
        let order = conversion_order(&rig.identity);
        let (layout, mass) = (&self.layout, self.mass);
        Block::of(&result, Conditions { layout, record, mass, order: &order }, cutoffs)
    }
}

/// Returns an error when the campaign that was joined is one on an object.
fn require_block(result: &MeasurementResult) -> Result<()> {
    let is_block = |d: &Diagnostic| d.code == Code::BlockTest;
    if result.diagnostics.iter().any(is_block) {
        return Ok(());
    }
    Err(Error::undetermined(
        "no_block_test",
        format!(
            "result {} was measured on an object, not on a block; begin anew with --restart",
            result.head.number,
        ),
    ))
}
