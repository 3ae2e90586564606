//! Records all scans; this program finds and grades the hits in them, as the rig would.

use std::time::{Duration, Instant};

use massline_protocol::event::ScanBlock;
use massline_shared::layout::TestProfile;
use massline_shared::measurement::campaign::Command;
use massline_shared::signal::{HitReport, ringing_s};

use super::Recording;
use super::finder::{HitFinder, ScanOutcome, Settings};
use crate::output::Output;
use crate::support::keyboard::{KeyMeaning, Keyboard};
use crate::{Error, Result};
use massline_client::campaign::is_out_of_reach;
use massline_client::{Client, Event, scans_of};
use massline_files::tape::{Segment, TapeWriter};
use massline_report::words;

/// A rig that streams sends a block at least this often.
const SILENCE: Duration = Duration::from_secs(5);
/// A person is told of a silence of this length.
const TOLD_AFTER: Duration = Duration::from_millis(1500);
/// Without a hit for this long, s, the recording is abandoned because nobody taps.
const NOBODY_TAPS_S: f32 = 300.0;
/// The code of the error of a rig that sends none.
const SILENT: &str = "stream_silent";
/// Polling interval for keyboard and Ctrl-C.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Writes the stream until every DOF has its hits; returns the number of hits.
pub(super) fn record(
    client: &mut Client,
    recording: &Recording<'_>,
    writer: &mut TapeWriter,
    output: &mut Output,
) -> Result<u32> {
    let interrupt = output.interrupt().clone();
    let _guard = interrupt.guard();
    let mut keyboard = output.has_keyboard().then(|| Keyboard::take(output)).transpose()?;
    if recording.identity.board == massline_virtual::BOARD {
        let or_triggered = match recording.profile() {
            TestProfile::MassLine => ", or record with --triggered",
            TestProfile::Suspension => "",
        };
        output.note(format!(
            "a simulated rig taps by itself only in a campaign: press Enter at `massline virtual \
             --manual`{or_triggered}"
        ));
    }
    client.set_stream(true)?;
    let mut tape = Stream::new(recording);
    let recorded = loop {
        if tape.done() {
            break Ok(());
        }
        tape.prompt(output);
        let ended = match keyboard.as_mut().and_then(|keyboard| keyboard.poll(None, |_| false)) {
            Some(KeyMeaning::Command(command)) => tape.steer(command),
            Some(KeyMeaning::QuitOnce) => {
                output.note("q again ends the recording");
                false
            }
            None => false,
        };
        if interrupt.pressed() || ended {
            break Err(Error::interrupted("the recording was interrupted"));
        }
        if let Err(error) = tape.listen(client, writer, output) {
            break Err(error);
        }
    };
    drop(keyboard);
    // An error of the recording takes precedence over one of stopping the stream.
    let stopped = match &recorded {
        Err(error) if is_out_of_reach(error) || error.code() == SILENT => Ok(()),
        _ => client.set_stream(false),
    };
    writer.set_segments(&tape.segments)?;
    recorded?;
    stopped?;
    Ok(tape.segments.len() as u32)
}

/// The state of the recording.
struct Stream<'r> {
    recording: &'r Recording<'r>,
    finder: HitFinder<'r>,
    /// Index of the first scan, and of the next one.
    indices: Option<(u64, u64)>,
    heard: Instant,
    /// The silence since then has been told.
    silent: bool,
    segments: Vec<Segment>,
    dof: usize,
    /// Number of segments before those of the current DOF.
    before: usize,
    prompted: Option<(usize, usize)>,
    /// Index of the scan at which the last hit was complete.
    last_hit: u64,
}

impl<'r> Stream<'r> {
    fn new(recording: &'r Recording<'r>) -> Self {
        let Recording { identity, calibration, layout } = *recording;
        let settings = Settings { adc: &identity.adc, calibration, test: &layout.test };
        Self {
            recording,
            finder: HitFinder::new(settings),
            indices: None,
            heard: Instant::now(),
            silent: false,
            segments: Vec::new(),
            dof: 0,
            before: 0,
            prompted: None,
            last_hit: 0,
        }
    }

    fn done(&self) -> bool {
        self.dof >= self.recording.layout.hits.len()
    }

    fn next_dof(&mut self) {
        self.dof += 1;
        self.before = self.segments.len();
    }

    fn prompt(&mut self, output: &mut Output) {
        let place = (self.dof, self.segments.len());
        if self.prompted != Some(place) {
            self.prompted = Some(place);
            let (taken, wanted) =
                (self.segments.len() - self.before, self.recording.layout.test.hits_per_dof);
            let dof = self.recording.dof(self.dof);
            output.note(match self.recording.profile() {
                TestProfile::MassLine => format!("hit {dof} now ({taken}/{wanted})"),
                TestProfile::Suspension => {
                    format!("when it hangs still, hit {dof} ({taken}/{wanted})")
                }
            });
        }
    }

    /// Applies a command of the operator; true to end the recording.
    fn steer(&mut self, command: Command) -> bool {
        match command {
            Command::Abort => return true,
            Command::Undo => {
                self.segments.truncate(self.before.max(self.segments.len().saturating_sub(1)));
            }
            Command::Redo => self.segments.truncate(self.before),
            Command::Skip | Command::Finish => self.next_dof(),
            _ => {}
        }
        false
    }

    fn listen(
        &mut self,
        client: &mut Client,
        writer: &mut TapeWriter,
        output: &mut Output,
    ) -> Result<()> {
        match client.next_event(LOOK_EVERY)? {
            Some(Event::Scans(block)) => {
                if std::mem::take(&mut self.silent) {
                    output.note("the scans are coming again");
                }
                self.heard = Instant::now();
                self.take(&block, writer, output)
            }
            _ if self.heard.elapsed() > SILENCE => Err(Error::device(
                SILENT,
                format!(
                    "the rig has sent no scans for {} s; `massline device stats` may show why",
                    SILENCE.as_secs()
                ),
            )),
            _ if !self.silent && self.heard.elapsed() > TOLD_AFTER => {
                self.silent = true;
                output.note(format!(
                    "the rig sends no scans; waiting up to {} s for them",
                    SILENCE.as_secs()
                ));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn take(
        &mut self,
        block: &ScanBlock,
        writer: &mut TapeWriter,
        output: &mut Output,
    ) -> Result<()> {
        let (base, next) = self.indices.unwrap_or((block.first, block.first));
        if block.first != next {
            let missing = block.first.wrapping_sub(next);
            return Err(Error::device(
                "scans_lost",
                format!(
                    "{missing} scans after scan {} are missing: the link or this computer was too \
                     slow; record again, with --triggered if it happens again",
                    next - base,
                ),
            ));
        }
        let scans = scans_of(&block.codes);
        writer.push(&scans)?;
        self.indices = Some((base, next + scans.len() as u64));
        for (scan, index) in scans.iter().zip(next - base..) {
            match self.finder.feed(scan, index) {
                ScanOutcome::Nothing => {}
                ScanOutcome::Ringing => {
                    let left = ringing_s(&self.recording.identity.adc);
                    output.note(format!("ringing for {left:.0} s: do not touch it"));
                }
                ScanOutcome::Hit { start, report } => {
                    self.take_hit(start, &report, output);
                    writer.set_segments(&self.segments)?;
                    self.last_hit = index;
                }
            }
        }
        let quiet = (next - base).saturating_sub(self.last_hit) as f32;
        if quiet > NOBODY_TAPS_S * self.recording.identity.adc.rate.0 {
            return Err(Error::device(
                "nobody_taps",
                format!(
                    "no hit for {NOBODY_TAPS_S} s of scans; a simulated rig whose operator taps by \
                     itself does so only in a campaign: record it with --triggered, or tap by hand \
                     with `massline virtual --manual`"
                ),
            ));
        }
        Ok(())
    }

    fn take_hit(&mut self, start: u64, report: &HitReport, output: &mut Output) {
        let Some(hit) = self.recording.layout.hits.get(self.dof) else { return };
        let force = report.peak_force.0;
        if !report.good() {
            let reasons = words::messages(&report.findings);
            output.note(format!("{}  {force:.1} N  rejected: {reasons}", hit.dof));
            // Prompts the operator again.
            self.prompted = None;
            return;
        }
        output.note(format!("{}  {force:.1} N  good", hit.dof));
        self.segments.push(Segment { start, dof: hit.dof });
        if self.segments.len() - self.before >= usize::from(self.recording.layout.test.hits_per_dof)
        {
            self.next_dof();
        }
    }
}
