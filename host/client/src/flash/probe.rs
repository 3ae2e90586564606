//! Flashing through a debug probe on SWD with the probe-rs library. Requires the feature `probe`.

use probe_rs::flashing::{DownloadOptions, FlashProgress, ProgressEvent, ProgressOperation};
use probe_rs::probe::DebugProbeInfo;
use probe_rs::probe::list::Lister;
use probe_rs::{Permissions, Session};

use super::plan::Plan;
use super::{ProgressObserver, Step};
use massline_result::{Error, Result};

/// Erases, writes, reads back, and starts the program.
///
/// # Errors
/// `no_probe`, `several_probes`, `probe_failed`, and when `watch` stops it before anything is erased.
pub fn flash(plan: &Plan, watch: &mut dyn ProgressObserver) -> Result<()> {
    let mut session = attach(plan)?;
    watch.at(Step::Erase, 0, plan.erased())?;
    let mut loader = session.target().flash_loader();
    for segment in &plan.image.segments {
        loader.add_data(segment.address.into(), &segment.bytes).map_err(failed)?;
    }
    let mut options = DownloadOptions::new();
    // Other contents of the image's sectors are not needed.
    options.keep_unwritten_bytes = false;
    options.verify = true;
    options.progress = progress(plan, watch);
    loader.commit(&mut session, options).map_err(failed)?;
    session.core(0).map_err(failed)?.reset().map_err(failed)
}

/// The only probe that is connected.
///
/// # Errors
/// `no_probe`, `several_probes`.
pub fn find() -> Result<DebugProbeInfo> {
    let mut probes = Lister::new().list_all();
    if probes.len() > 1 {
        let names: Vec<_> = probes.iter().map(ToString::to_string).collect();
        return Err(Error::device(
            "several_probes",
            format!("leave one of these probes connected: {}", names.join(", ")),
        ));
    }
    probes.pop().ok_or_else(|| {
        Error::device(
            "no_probe",
            "no debug probe found: connect its USB plug, and its SWDIO, SWCLK and GND to the board. On \
             Linux a probe needs udev rules: https://probe.rs/docs/getting-started/probe-setup",
        )
    })
}

fn attach(plan: &Plan) -> Result<Session> {
    let probe = find()?.open().map_err(failed)?;
    probe.attach(plan.board.chip.as_str(), Permissions::default()).map_err(failed)
}

fn progress<'w>(plan: &Plan, watch: &'w mut dyn ProgressObserver) -> FlashProgress<'w> {
    let totals = (plan.erased(), plan.image.len());
    let mut done = 0;
    FlashProgress::new(move |event| {
        let (operation, size) = match event {
            ProgressEvent::Started(operation) => {
                done = 0;
                (operation, 0)
            }
            ProgressEvent::Progress { operation, size, .. } => (operation, size),
            _ => return,
        };
        done += size;
        let (step, total) = match operation {
            ProgressOperation::Erase => (Step::Erase, totals.0),
            ProgressOperation::Program => (Step::Write, totals.1),
            ProgressOperation::Verify => (Step::Verify, totals.1),
            _ => return,
        };
        // The library cannot be stopped part-way.
        let _ = watch.at(step, done.min(total), total);
    })
}

fn failed(error: impl std::error::Error) -> Error {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    Error::device("probe_failed", format!("the debug probe: {text}"))
}
