//! The stack that the firmware has used after a whole campaign in QEMU.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use massline::campaign::{CampaignOutcome, Observer, StartOptions, begin, follow};
use massline::client::{Client, SerialTransport};
use massline::interrupt::Interrupt;
use massline::layout_file::LayoutFile;
use massline::qemu::{EmulatedRig, Feeder};
use massline_tests::campaign::with_every_dof;
use massline_virtual::bench::{Bench, BenchSource};
use massline_virtual::source::ScanSource;

/// A limit that is reached only when something hangs.
const LATE: Duration = Duration::from_secs(60);

/// Measures the first test of the three-bar frame with two more DOFs and a target that is missed, so that the rig
/// searches for the hits that help, and requests every object and message; returns the high-water mark in bytes.
pub fn measure(elf: &Path, checkout: &Path) -> anyhow::Result<u64> {
    let mut file = LayoutFile::read(&checkout.join("host/examples/three-bar-test-1.toml"))?;
    let mut longer = with_every_dof(file.layout.cast().context("the layout does not fit the rig")?);
    longer.hits.truncate(5);
    longer.target.center = Some(1e-6);
    file.layout = longer.cast().context("the layout does not fit the host")?;
    let layout = file.rig_layout().context("the layout does not fit the rig")?;
    let source = BenchSource::new(&Bench::named("default")?, &file.layout, 1)?;
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
    client.result(number)?;
    ensure!(client.mass_lines(0)?.is_some(), "the rig has forgotten the mass lines");
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
