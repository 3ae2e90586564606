//! The rig that is calibrated: a real one at a port, or a virtual one with a bench.

use std::path::{Path, PathBuf};
use std::time::Duration;

use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource, TumbleHandle, TumbleSource};
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Identity, Status};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::Position;
use massline_shared::layout::HostLayout;
use massline_virtual::flash::FlashBacking;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

use crate::commands::measure::{DisplayedCampaign, ScreenArgs, Watching, watch};
use crate::output::Output;
use crate::rig::PipeTransport;
use crate::support::bench_test::{bench_help, open_bench};
use crate::support::collected::spectra::{CollectingObserver, SpectraCollection};
use crate::support::connect::PortArgs;
use crate::support::progress::{Progress, Prompts};
use crate::{Error, Result};
use massline_analysis::bench_error::bench_error;
use massline_client::Client;
use massline_client::campaign::{CampaignOutcome, Observer, follow};

/// A virtual rig without progress for this long is stuck.
const PATIENCE: Duration = Duration::from_secs(120);

/// Options that choose the rig.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct RigArgs {
    #[command(flatten)]
    port: PortArgs,
    /// Use a simulated rig instead of one at a port.
    #[arg(long, value_enum, value_name = "RIG", conflicts_with = "port")]
    rig: Option<SimulatedKind>,
    /// Seed of all random numbers on the simulated bench: equal seeds give equal sensors.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "rig")]
    seed: u64,
    #[arg(
        long,
        value_name = "NAME|FILE",
        default_value = "block",
        requires = "rig",
        help = bench_help()
    )]
    bench: String,
    /// Store the flash of the simulated rig in this file; default: discarded at the end.
    #[arg(long, value_name = "FILE", requires = "rig")]
    flash: Option<PathBuf>,
    #[command(flatten)]
    pub(super) screen: ScreenArgs,
}

/// A simulated rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SimulatedKind {
    /// The firmware application on a thread of this process.
    Virtual,
}

/// Number of sensors of a virtual rig.
const SENSORS: usize = massline_shared::layout::RIG_SENSORS;

impl RigArgs {
    /// Connects to the rig for a tumble test, in which its sensors are turned by hand.
    ///
    /// # Errors
    /// When there is no rig, or the bench is bad.
    pub fn tumble_rig(&self, output: &Output) -> Result<TumbleRig> {
        let Some(SimulatedKind::Virtual) = self.rig else {
            let (client, identity) = self.port.connect(output)?;
            return Ok(TumbleRig { client, identity, turner: Turner::Person, _rig: None });
        };
        TumbleRig::on_bench(&open_bench(&self.bench)?, SENSORS, self.seed, self.flash.as_deref())
    }

    /// Connects to the rig for a block test, in which its sensors are on the block.
    ///
    /// # Errors
    /// When there is no rig, the bench is bad, or the layout does not fit it.
    pub fn block_rig(&self, layout: &HostLayout, output: &Output) -> Result<BlockRig> {
        let Some(SimulatedKind::Virtual) = self.rig else {
            let (client, identity) = self.port.connect(output)?;
            return Ok(BlockRig { client, identity, rig: None });
        };
        BlockRig::on_bench(&open_bench(&self.bench)?, layout, self.seed, self.flash.as_deref())
    }
}

fn start(
    source: Box<dyn ScanSource>,
    flash: Option<&Path>,
) -> Result<(VirtualRig, Client, Identity)> {
    let mut options = VirtualRigOptions::new(source);
    if let Some(path) = flash {
        options.flash = FlashBacking::File(path.to_owned());
    }
    let rig = VirtualRig::start(options)
        .map_err(|e| Error::input("virtual_rig", format!("the virtual rig does not start: {e}")))?;
    let mut client = Client::new(PipeTransport::new(rig.link()));
    let identity = client.identify()?;
    Ok((rig, client, identity))
}

/// A rig whose sensors are turned from position to position.
#[derive(Debug)]
pub struct TumbleRig {
    /// The rig.
    pub client: Client,
    /// Identity of the rig.
    pub identity: Identity,
    turner: Turner,
    /// Keeps the virtual rig running.
    _rig: Option<VirtualRig>,
}

/// Who turns the sensors.
#[derive(Debug)]
enum Turner {
    /// A person, who says when they lie there.
    Person,
    /// The bench.
    Bench(TumbleHandle),
}

impl TumbleRig {
    /// A virtual rig with the first `sensors` sensors of a bench; `flash` is a file, or `None` for memory.
    ///
    /// # Errors
    /// When the bench has too many sensors or the rig does not start.
    pub fn on_bench(
        bench: &Bench,
        sensors: usize,
        seed: u64,
        flash: Option<&Path>,
    ) -> Result<Self> {
        let source = TumbleSource::new(bench, sensors, seed).map_err(bench_error)?;
        let turner = Turner::Bench(source.handle());
        let (rig, client, identity) = start(Box::new(source), flash)?;
        Ok(Self { client, identity, turner, _rig: Some(rig) })
    }

    /// Turns the sensors to this position, or has `ask` ask a person for it, and returns when they lie there.
    ///
    /// # Errors
    /// Those of `ask`.
    pub fn turn_to(
        &mut self,
        position: Position,
        ask: impl FnOnce(&mut Client, &Identity) -> Result<()>,
    ) -> Result<()> {
        match &self.turner {
            Turner::Bench(handle) => {
                handle.turn_to(position);
                Ok(())
            }
            Turner::Person => ask(&mut self.client, &self.identity),
        }
    }

    /// True when a person can correct a bad reading.
    pub fn can_repeat(&self) -> bool {
        matches!(self.turner, Turner::Person)
    }
}

/// What a person sees of a block test.
#[derive(Clone, Copy, Debug)]
pub struct DisplayedBlockTest<'a> {
    /// Whether it is a full screen.
    pub screen: ScreenArgs,
    /// What is measured.
    pub title: &'a str,
    /// The calibration in force.
    pub calibration: &'a CalibrationRecord,
}

/// A rig whose sensors are glued to a hanging block.
#[derive(Debug)]
pub struct BlockRig {
    /// The rig.
    pub client: Client,
    /// Identity of the rig.
    pub identity: Identity,
    /// The virtual rig, whose bench taps by itself; `None` for a real rig.
    rig: Option<VirtualRig>,
}

impl BlockRig {
    /// A virtual rig with the block of a bench; `flash` is a file, or `None` for memory.
    ///
    /// # Errors
    /// When the layout does not fit the bench or the rig does not start.
    pub fn on_bench(
        bench: &Bench,
        layout: &HostLayout,
        seed: u64,
        flash: Option<&Path>,
    ) -> Result<Self> {
        let source = BenchSource::new(bench, layout, seed).map_err(bench_error)?;
        let (rig, client, identity) = start(Box::new(source), flash)?;
        Ok(Self { client, identity, rig: Some(rig) })
    }

    /// Follows the running campaign, accepts its good hits and collects their spectra.
    ///
    /// # Errors
    /// When the rig cannot be reached or is stuck.
    pub fn follow(
        &mut self,
        layout: &massline_shared::layout::RigLayout,
        collection: &mut SpectraCollection,
        shown: DisplayedBlockTest<'_>,
        output: &mut Output,
    ) -> Result<CampaignOutcome> {
        if self.rig.is_none() {
            let DisplayedBlockTest { screen, title, calibration } = shown;
            let identity = &self.identity;
            let shown = DisplayedCampaign { kind: "block test", title, identity, calibration };
            let shown = screen.wants_screen(output).then_some(shown);
            let watching = Watching { collection: Some(collection), shown, ..Watching::default() };
            return watch(&mut self.client, layout, watching, output);
        }
        let interrupt = output.interrupt().clone();
        let progress = Progress::new(output, "block", layout, Prompts::Nothing);
        let mut looker = Looker(progress);
        let (records, log) = (None, None);
        let mut collecting =
            CollectingObserver { observer: &mut looker, collection, records, log, accepts: true };
        follow(&mut self.client, &interrupt, Some(PATIENCE), &mut collecting)
    }
}

/// Shows the progress of a bench that taps by itself.
struct Looker<'o>(Progress<'o>);

impl Observer for Looker<'_> {
    fn armed(&mut self, _: u32, dof: usize) -> Result<()> {
        self.0.refuse_rejections(dof)
    }

    fn status(&mut self, status: &Status) {
        self.0.status(status);
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.0.hit(hit);
    }
}
