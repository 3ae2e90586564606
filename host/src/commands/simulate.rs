//! `massline simulate`: simulates a measurement with a layout on the bench.

mod monte_carlo;
pub(super) mod object;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use massline_physics::source::ScanSource;
use massline_protocol::LayoutHash;
use massline_shared::layout::{Dof, RigLayout};
use massline_shared::signal::{AdcProperties, Calibration, PRE_TRIGGER_SCANS, RECORD_SCANS, Scan};

use crate::Result;
use crate::output::Output;
use crate::support::bench_test::{BenchArgs, BenchTest, nominal_calibration};
use crate::support::beside_truth::ShownTest;
use crate::support::files;
use crate::support::files::ReplaceArgs;
use crate::support::show::DetailsArgs;
use crate::support::simulated::{ReportArgs, RigArgs};
use massline_files::file::ExistingFile;
use massline_files::tape::{Segment, Sidecar, TapeWriter};
use monte_carlo::{MonteCarloArgs, StudyObject};
use object::SimulatedObject;

/// Arguments of `massline simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The object is the one that the layout's [reference] states, as a rigid body on a soft suspension, or that
of --bench. The sensors and marks are where the layout says, up to the errors of the bench. The result is
printed beside the truth. A layout with profile = 'suspension' in its [test] has records of 40 s taken.
A single run has a verdict; the exit code is 3 when it is not to use the answer.

With --runs the test is repeated with other errors each time, on all cores, from ADC codes to the
ten properties by every method: bias, rms error, rms error over the Cramér-Rao bound, and how
often the 95 % intervals hold the truth. With --errors layout the bench has errors as large as the
error budget of the layout says: the intervals then have to hold. With a [target] in the layout each
run stops as soon as it is reached: the coverage at the stop and the hits saved are printed. A seed
gives the same numbers on any machine and number of cores.

Examples:
  massline simulate frame.toml
  massline simulate frame.toml --suspension-hz 5
  massline simulate frame.toml --bench ideal --seed 5 --json
  massline simulate frame.toml --bench uncalibrated --calibration rig.toml
  massline simulate frame.toml --report frame.html
  massline simulate wheel.toml --bench wheel
  massline simulate frame.toml --runs 1000
  massline simulate frame.toml --runs 200 --budget bench --json
  massline simulate frame.toml --runs 200 --errors layout
  massline simulate frame.toml --bench box.toml --tape box-tape.npy
  massline replay box-tape.npy --layout frame.toml")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    #[command(flatten)]
    bench: BenchArgs,
    /// Highest suspension mode of the object of [reference], Hz [default: 3; 7.5 in the suspension profile].
    #[arg(long, value_name = "HZ", conflicts_with = "bench", value_parser = suspension_hz)]
    suspension_hz: Option<f64>,
    #[command(flatten)]
    rig: RigArgs,
    /// Calibration file; default: the calibration that the data sheets of the bench state.
    #[arg(long, value_name = "FILE", conflicts_with = "runs")]
    calibration: Option<PathBuf>,
    /// Write the scans to this tape, and its sidecar beside it.
    #[arg(long, value_name = "OUT.npy", conflicts_with = "runs")]
    tape: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    replace: ReplaceArgs,
    #[command(flatten)]
    details: DetailsArgs,
    #[command(flatten)]
    monte_carlo: MonteCarloArgs,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, the rig does not start or gets stuck, or there is no answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = files::layout(&args.layout, output)?;
    let layout = files::for_rig(&file, &args.layout)?;
    let given = files::calibration(args.calibration.as_deref(), &file)?;
    let object = SimulatedObject::of(&args.bench, args.suspension_hz, &file, &args.layout)?;
    output.note(&object.description);
    let SimulatedObject { bench, description } = object;
    if let Some(runs) = args.monte_carlo.runs {
        let study = StudyObject { bench: &bench, seed: args.bench.seed, description };
        return monte_carlo::run(&args.layout, &file, study, &args.monte_carlo, runs, output);
    }
    args.report.check(args.replace.existing())?;
    let calibration = given.unwrap_or_else(|| nominal_calibration(&bench).into());
    let firmware = args.rig.image()?;
    let name: String =
        args.layout.file_stem().map_or("layout".into(), |s| s.to_string_lossy().into());
    let test = BenchTest {
        label: &name,
        layout: &file.layout,
        bench: &bench,
        seed: args.bench.seed,
        rig: args.rig.rig,
        firmware: firmware.as_deref(),
    };
    let existing = args.replace.existing();
    let shown =
        ShownTest { test, file: &file, report: &args.report, existing, description: &description };
    let Some(path) = &args.tape else {
        let measured = shown.measure(&calibration, output, |source| source)?;
        return shown.print(measured, None, args.details.extent(), output);
    };
    TapeWriter::check(path, existing)?;
    let recorder = Recorder::new(path, existing, &layout, &calibration.calibration);
    let measured = shown.measure(&calibration, output, |source| recorder.around(source));
    let taped = recorder.end(measured.is_ok());
    if let Ok(Some(scans)) = taped {
        output.note(format!("{}: {scans} scans", path.display()));
    }
    let tape = taped.is_ok().then(|| path.clone());
    shown.print(measured?, tape, args.details.extent(), output)?;
    // The answer needs no tape.
    taped.map(|_| ())
}

/// Parses the frequency of a suspension.
fn suspension_hz(text: &str) -> std::result::Result<f64, String> {
    let hz = text.parse::<f64>().ok().filter(|hz| (0.1..=100.0).contains(hz));
    hz.ok_or_else(|| "give a frequency from 0.1 to 100 Hz".into())
}

/// Records the scans of a source on a tape, one segment per arming: all that the rig sees from the start of its sampler
/// on, so that a replay gives the same result.
#[derive(Clone, Debug)]
pub struct Recorder {
    path: PathBuf,
    existing: ExistingFile,
    sidecar: Sidecar,
    dofs: Vec<Dof>,
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    writer: Option<TapeWriter>,
    /// Scans since the start of the sampler, before the arming.
    lead: Vec<Scan>,
    /// The segment of the present arming, which is listed when it is complete.
    begun: Option<Segment>,
    /// The first error; later ones are consequences of it.
    failed: Option<crate::Error>,
}

impl Recorder {
    /// A recorder for a test with this layout and calibration.
    pub fn new(
        path: &Path,
        existing: ExistingFile,
        layout: &RigLayout,
        calibration: &Calibration,
    ) -> Self {
        Self {
            path: path.to_owned(),
            existing,
            sidecar: sidecar(
                layout,
                calibration,
                AdcProperties {
                    rate: Default::default(),
                    channels: 0,
                    bits: 0,
                    reference: Default::default(),
                    channel_delay: Default::default(),
                },
            ),
            dofs: layout.hits.iter().map(|hit| hit.dof).collect(),
            state: Arc::default(),
        }
    }

    /// Wraps a source so that its scans are recorded.
    pub fn around(&self, source: Box<dyn ScanSource>) -> Box<dyn ScanSource> {
        let sidecar = Sidecar { adc: source.adc(), ..self.sidecar.clone() };
        self.state().attempt(|state| {
            state.writer = Some(TapeWriter::create(&self.path, sidecar, self.existing)?);
            Ok(())
        });
        Box::new(RecordedSource { source, recorder: self.clone() })
    }

    /// Ends the tape of a test, complete or not; returns its number of scans, if there is a tape. One that could not be
    /// written is removed, because the test can be repeated.
    ///
    /// # Errors
    /// When the tape could not be written.
    pub fn end(&self, complete: bool) -> Result<Option<u64>> {
        let mut state = self.state();
        state.attempt(State::end_segment);
        match (state.writer.take(), state.failed.take()) {
            (writer, Some(error)) => {
                writer.into_iter().for_each(TapeWriter::discard);
                Err(error)
            }
            (None, None) => Ok(None),
            (Some(writer), None) if complete => writer.finish().map(Some),
            (Some(writer), None) => writer.keep(),
        }
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Lists the segment that was begun, if it has scans.
    fn end_segment(&mut self) -> Result<()> {
        match (self.begun.take(), &mut self.writer) {
            (Some(segment), Some(writer)) if segment.start < writer.scans() => {
                writer.segment(segment)
            }
            _ => Ok(()),
        }
    }

    fn attempt(&mut self, action: impl FnOnce(&mut Self) -> Result<()>) {
        if self.failed.is_none() {
            self.failed = action(self).err();
        }
    }
}

/// The sidecar of a tape for this test.
pub fn sidecar(layout: &RigLayout, calibration: &Calibration, adc: AdcProperties) -> Sidecar {
    Sidecar {
        adc,
        calibration: *calibration,
        pre_trigger_scans: PRE_TRIGGER_SCANS as u32,
        layout_hash: layout.hash(),
        segments: Vec::new(),
    }
}

struct RecordedSource {
    source: Box<dyn ScanSource>,
    recorder: Recorder,
}

impl ScanSource for RecordedSource {
    fn adc(&self) -> AdcProperties {
        self.source.adc()
    }

    fn started(&mut self) {
        self.source.started();
        self.recorder.state().attempt(|state| {
            state.lead.clear();
            state.end_segment()
        });
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.source.armed(arming, dof);
        let Some(&dof) = self.recorder.dofs.get(dof) else { return };
        self.recorder.state().attempt(|state| {
            state.end_segment()?;
            let lead = std::mem::take(&mut state.lead);
            let Some(writer) = &mut state.writer else { return Ok(()) };
            state.begun = Some(Segment { start: writer.scans(), dof });
            writer.push(&lead)
        });
    }

    fn next_scan(&mut self) -> Option<Scan> {
        let scan = self.source.next_scan()?;
        self.recorder.state().attempt(|state| match (&state.begun, &mut state.writer) {
            (Some(_), Some(writer)) => writer.push(&[scan]),
            _ => {
                // An arming follows its start by a few scans. What else is sampled belongs to no hit.
                if state.lead.len() < RECORD_SCANS {
                    state.lead.push(scan);
                }
                Ok(())
            }
        });
        Some(scan)
    }
}
