//! The stack that the firmware has used after a whole campaign of each profile in QEMU.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use massline::qemu::{EmulatedRig, Feeder};
use massline_client::campaign::{CampaignOutcome, Observer, StartOptions, begin, follow};
use massline_client::interrupt::Interrupt;
use massline_client::{Client, SerialTransport};
use massline_files::layout_file::LayoutFile;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_protocol::lines::LinesId;
use massline_protocol::object::MeasurementResult;
use massline_tests::campaign::with_every_dof;

/// A limit that is reached only when something hangs.
const LATE: Duration = Duration::from_secs(120);

/// The high-water marks, bytes.
#[derive(Debug)]
pub struct HighWater {
    pub mass_line: u64,
    pub suspension: u64,
}

impl HighWater {
    /// The larger one.
    pub fn most(&self) -> u64 {
        self.mass_line.max(self.suspension)
    }
}

/// Measures a campaign of each profile.
pub fn measure(elf: &Path, checkout: &Path) -> anyhow::Result<HighWater> {
    let examples = checkout.join("host/examples");
    Ok(HighWater { mass_line: mass_line(elf, &examples)?, suspension: suspension(elf, &examples)? })
}

/// Measures the first test of the three-bar frame with two more DOFs and a target that is missed, so that the rig
/// searches for the hits that help.
fn mass_line(elf: &Path, examples: &Path) -> anyhow::Result<u64> {
    let mut file = LayoutFile::read(&examples.join("three-bar-test-1.toml"))?;
    let mut longer = with_every_dof(file.layout.cast().context("the layout does not fit the rig")?);
    longer.hits.truncate(5);
    longer.target.center = Some(1e-6);
    file.layout = longer.cast().context("the layout does not fit the host")?;
    high_water(elf, &file, "default", |client, _| {
        ensure!(client.mass_lines(0)?.is_some(), "the rig has forgotten the mass lines");
        Ok(())
    })
}

/// Measures the wheel with two hits at each of its first three DOFs: the rig averages, and stores the lines.
fn suspension(elf: &Path, examples: &Path) -> anyhow::Result<u64> {
    let mut file = LayoutFile::read(&examples.join("wheel.toml"))?;
    file.layout.hits.truncate(3);
    file.layout.test.hits_per_dof = 2;
    high_water(elf, &file, "wheel", |client, result| {
        let id = LinesId { result: result.head.number, dof: 0 };
        ensure!(client.lines(id)?.is_some(), "the rig has forgotten the lines");
        Ok(())
    })
}

/// Measures a layout on a bench, and requests every object and message; returns the high-water mark in bytes.
fn high_water(
    elf: &Path,
    file: &LayoutFile,
    bench: &str,
    request: impl FnOnce(&mut Client, &MeasurementResult) -> anyhow::Result<()>,
) -> anyhow::Result<u64> {
    let layout = file.rig_layout().context("the layout does not fit the rig")?;
    let source = BenchSource::new(&Bench::named(bench)?, &file.layout, 1)?;
    let rig = EmulatedRig::start(elf, &source.adc())?;
    let mut client = Client::new(SerialTransport::open(rig.port_path())?);
    client.identify()?;
    client.put_layout(&layout)?;
    let calibration = client.calibration()?;
    client.put_calibration(&calibration)?;
    begin(&mut client, StartOptions::default())?;
    let mut operator = Operator(rig.feed(Box::new(source)));
    let CampaignOutcome::Done(number) =
        follow(&mut client, &Interrupt::new(), Some(LATE), &mut operator)?
    else {
        bail!("the campaign ended without a result");
    };
    let result = client.result(number)?;
    request(&mut client, &result)?;
    ensure!(client.results()?.len() == 1, "the rig lists another number of results");
    let stats = client.stats()?;
    ensure!(stats.stack_high_water > 0, "the rig does not measure its stack");
    Ok(u64::from(stats.stack_high_water))
}

struct Operator(Feeder);

impl Observer for Operator {
    fn armed(&mut self, arming: u32, dof: usize) -> massline::Result<()> {
        self.0.armed(arming, dof);
        Ok(())
    }
}
