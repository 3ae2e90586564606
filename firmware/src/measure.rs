//! The measuring loop: does what the campaign says next, from arming to the stored result.
//!
//! Measuring never waits for link or panel, and for flash only between two hits, while the sampler is
//! stopped. The sampler runs only while the rig waits for a hit, takes a record, or streams.

use core::cell::RefCell;
use core::pin::pin;
use massline_shared::campaign::Phase;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::event::HitEvent;
use massline_shared::averaging::DofSpectra;
use massline_shared::campaign::Step;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use massline_shared::layout::TestSettings;
use massline_shared::signal::{
    CHANNELS, Capture, CaptureState, HitReport, RECORD_SCANS, Record, Scan, Standing, Trigger,
    grade,
};
use massline_shared::units::{Newtons, ScanIndex};

use crate::analysis::{Analysis, AnalysisMemory};
use crate::apart::apart;
use crate::board::{SampleError, Sampler};
use crate::deadline::Deadline;
use crate::levels::Levels;
use crate::panel::HitVerdict;
use crate::progress::Kept;
use crate::rig::{Reading, Rig, Streamed, note};
use crate::scan_ring::FAULTS_TO_STOP;
use crate::store::Store;

/// Scans fetched at a time: 5 ms at 4 kS/s.
const BLOCK: usize = 20;

/// The level bars of the panel show the last this long.
const LEVEL_WINDOW_S: f32 = 0.1;

/// The measuring loop and what it works on.
pub(crate) struct Measuring<'a, S: Sampler, F: NorFlash> {
    pub sampler: S,
    pub rig: &'a Rig,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub record: &'a RefCell<Record>,
    pub spectra: &'a RefCell<DofSpectra<f32>>,
    pub memory: &'a mut AnalysisMemory,
    pub kept: Kept,
    /// Losses of scans in a row, without one block read between them.
    pub losses: u8,
}

impl<S: Sampler, F: NorFlash> Measuring<'_, S, F> {
    /// Measures for ever.
    pub async fn run(mut self) -> ! {
        loop {
            apart(pin!(self.kept.update(self.rig, self.store, self.memory))).await;
            self.rig.steer.reset();
            let step = self.rig.campaign.borrow().step();
            match step {
                Step::Rest if self.rig.stream.get() => self.stream().await,
                Step::Rest if self.rig.reading.get() == Reading::Wanted => {
                    self.take_reading().await;
                }
                Step::Rest => self.rig.steer.wait().await,
                Step::AwaitHit { dof } => self.await_hit(dof).await,
                Step::Analyse { dof } => self.average_hit(dof).await,
                Step::CloseDof { dof } => {
                    self.analysis().close_dof(dof);
                    self.rig.campaign.borrow_mut().dof_closed();
                }
                Step::Identify => self.identify().await,
            }
            self.rig.changed();
        }
    }

    fn analysis(&mut self) -> Analysis<'_> {
        Analysis { rig: self.rig, record: self.record, spectra: self.spectra, memory: self.memory }
    }

    /// Samples until a hit has been recorded and graded, or a command comes.
    async fn await_hit(&mut self, dof: usize) {
        let rig = self.rig;
        let taken = select(self.take_record(), rig.steer.wait()).await;
        self.sampler.stop();
        match taken {
            Either::First(Ok(trigger)) => self.grade_hit(dof, trigger),
            Either::First(Err(SampleError::Overrun { lost })) => self.lose_record(dof, lost),
            Either::First(Err(SampleError::Stopped)) => self.give_up(),
            Either::Second(()) => {}
        }
    }

    /// Fills the record; gives the scan of the trigger.
    ///
    /// Deadline: [`crate::deadline::DEADLINE`] between two reads.
    async fn take_record(&mut self) -> Result<ScanIndex, SampleError> {
        let rig = self.rig;
        rig.record_of.set(None);
        rig.reading.set(Reading::None);
        let mut capture = {
            let layout = rig.layout.borrow();
            let level = Newtons(layout.as_ref().map_or(0.0, |layout| layout.test.trigger_n));
            self.record.borrow_mut().clear();
            Capture::new(Trigger::new(&rig.adc, &rig.calibration.borrow(), level))
        };
        self.sampler.start().await?;
        rig.campaign.borrow_mut().armed();
        rig.changed();
        let mut levels = Levels::new((rig.adc.rate.0 * LEVEL_WINDOW_S) as u16);
        let mut block = [[0; CHANNELS]; BLOCK];
        loop {
            let first = self.sampler.read(&mut block).await?;
            self.losses = 0;
            let _deadline = Deadline::begin(rig);
            rig.stats.borrow_mut().scans += BLOCK as u64;
            let mut record = self.record.borrow_mut();
            for (scan, index) in block.iter().zip(first.0..) {
                if let Some(levels) = levels.feed(scan) {
                    rig.levels.set(levels);
                    rig.show.signal(());
                }
                let before = capture.state();
                match capture.feed(&mut record, scan, ScanIndex(index)) {
                    CaptureState::Complete { trigger_scan } => return Ok(trigger_scan),
                    CaptureState::Broken => return Err(SampleError::Overrun { lost: 1 }),
                    CaptureState::Filling if before == CaptureState::Waiting => {
                        rig.stats.borrow_mut().triggers += 1;
                        rig.triggered_at.set(index);
                        rig.campaign.borrow_mut().triggered();
                        rig.changed();
                    }
                    CaptureState::Waiting | CaptureState::Filling => {}
                }
            }
        }
    }

    #[inline(never)]
    fn grade_hit(&mut self, dof: usize, trigger: ScanIndex) {
        let rig = self.rig;
        let report = {
            let _deadline = Deadline::begin(rig);
            let layout = rig.layout.borrow();
            let test = layout.as_ref().map_or_else(TestSettings::default, |layout| layout.test);
            let calibration = rig.calibration.borrow();
            let (record, last) = (self.record.borrow(), rig.last_record.get());
            grade(&record, &rig.adc_in_use(), &calibration, &test, last)
        };
        rig.last_record.set(Some(report.fingerprint));
        let number = self.tell_hit(dof, trigger.0, &report);
        rig.record_of.set(Some(number));
        rig.campaign.borrow_mut().graded(report.good());
    }

    /// Averages the record in hand, or asks for another hit when it does not agree with its siblings.
    async fn average_hit(&mut self, dof: usize) {
        let standing = self.analysis().average_hit(dof).await;
        let mut campaign = self.rig.campaign.borrow_mut();
        let (code, distance) = match standing {
            Standing::Agrees => return campaign.analysed(),
            Standing::Astray(distance) => {
                campaign.withdrawn();
                (Code::HitInconsistent, distance)
            }
            Standing::Contradicts(distance) => {
                campaign.contradicted();
                self.rig.spectra_of.set(None);
                (Code::HitsDisagree, distance)
            }
        };
        drop(campaign);
        self.withdraw_hit(Diagnostic::about(code, Severity::Error, Subject::hit(dof), distance));
    }

    /// Tells about the hit in hand, which was good by itself, once more: now it is rejected.
    fn withdraw_hit(&self, why: Diagnostic) {
        let rig = self.rig;
        if let Some(verdict) = rig.verdict.get() {
            rig.verdict.set(Some(HitVerdict { reason: Some(why), ..verdict }));
        }
        let Some(mut hit) = rig.last_hit.take() else { return };
        hit.good = false;
        note(&mut hit.findings, why);
        rig.tell_hit(hit);
    }

    /// The converter does not deliver: the campaign is interrupted.
    fn give_up(&mut self) {
        // The user may mend the converter and go on.
        self.losses = 0;
        self.rig.say(Diagnostic::whole(Code::SamplerStopped, Severity::Error, 0.0));
        self.rig.campaign.borrow_mut().interrupted();
    }

    /// Counts a loss of scans; true when there was nothing but losses for too long.
    fn lost_too_often(&mut self, lost: u32) -> bool {
        self.rig.overran(lost);
        self.losses = self.losses.saturating_add(1);
        self.losses >= FAULTS_TO_STOP
    }

    /// Scans are missing. Before the hammer has touched that costs nothing but another arming.
    fn lose_record(&mut self, dof: usize, lost: u32) {
        if self.lost_too_often(lost) {
            return self.give_up();
        }
        if self.rig.campaign.borrow().phase() == Phase::Armed {
            return;
        }
        self.rig.stats.borrow_mut().hits_aborted += 1;
        let mut findings = Diagnostics::new();
        note(&mut findings, Diagnostic::whole(Code::ScansLost, Severity::Error, lost as f32));
        let report = HitReport { findings, ..HitReport::default() };
        self.tell_hit(dof, self.rig.triggered_at.get(), &report);
        self.rig.campaign.borrow_mut().record_lost();
    }

    /// Tells host and panel about a hit; gives its number.
    fn tell_hit(&self, dof: usize, scan: u64, report: &HitReport) -> u32 {
        let number = self.rig.hits_seen.get().wrapping_add(1);
        self.rig.hits_seen.set(number);
        let decisive = report.findings.iter().find(|found| found.is_error());
        let verdict = HitVerdict { peak_force: report.peak_force.0, reason: decisive.copied() };
        self.rig.verdict.set(Some(verdict));
        let hit = HitEvent {
            number,
            dof: dof as u8,
            good: report.good(),
            scan,
            peak_force: report.peak_force.0,
            peak_acceleration: report.peak_acceleration.0,
            findings: report.findings.clone(),
        };
        self.rig.last_hit.replace(Some(hit.clone()));
        self.rig.tell_hit(hit);
        number
    }

    /// Computes the ten properties and stores the result; without room the campaign pauses.
    async fn identify(&mut self) {
        let rig = self.rig;
        // Only this loop adds results, so the number stays free while the session has the store.
        let number = self.store.lock().await.next_number();
        self.analysis().identify(number).await;
        let (encoded, mass) = self.memory.encode_result();
        let mut store = self.store.lock().await;
        let put = pin!(store.put_result(encoded, rig.layout_hash.get(), mass));
        match apart(put).await {
            Ok(number) => {
                rig.last_mass.set(mass);
                rig.campaign.borrow_mut().identified(number);
            }
            Err(_) => {
                rig.say(Diagnostic::whole(Code::ResultNotStored, Severity::Error, 0.0));
                rig.campaign.borrow_mut().not_stored();
            }
        }
    }

    /// Fills the record with what the channels read now; a command breaks it off. After lost scans it
    /// begins anew, as long as it is wanted.
    async fn take_reading(&mut self) {
        let rig = self.rig;
        rig.record_of.set(None);
        self.record.borrow_mut().clear();
        let taken = select(self.fill_record(), rig.steer.wait()).await;
        self.sampler.stop();
        rig.reading.set(match taken {
            Either::First(Ok(())) => Reading::Held,
            Either::First(Err(SampleError::Overrun { lost })) if self.lost_too_often(lost) => {
                self.losses = 0;
                Reading::Failed
            }
            Either::First(Err(SampleError::Overrun { .. })) => Reading::Wanted,
            Either::First(Err(SampleError::Stopped)) => Reading::Failed,
            Either::Second(()) => Reading::None,
        });
    }

    async fn fill_record(&mut self) -> Result<(), SampleError> {
        self.sampler.start().await?;
        let mut block: [Scan; BLOCK] = [[0; CHANNELS]; BLOCK];
        for _ in 0..RECORD_SCANS.div_ceil(BLOCK) {
            self.sampler.read(&mut block).await?;
            self.losses = 0;
            self.rig.stats.borrow_mut().scans += BLOCK as u64;
            let mut record = self.record.borrow_mut();
            block.iter().for_each(|scan| record.push(scan));
        }
        Ok(())
    }

    /// Puts every scan into the record, as into a ring, until a command comes.
    async fn stream(&mut self) {
        self.rig.record_of.set(None);
        self.rig.reading.set(Reading::None);
        self.record.borrow_mut().clear();
        self.rig.streamed.set(Streamed::default());
        let rig = self.rig;
        let done = select(self.fill_ring(), rig.steer.wait()).await;
        self.sampler.stop();
        if let Either::First(Err(SampleError::Stopped)) = done {
            self.rig.stream.set(false);
            self.rig.say(Diagnostic::whole(Code::SamplerStopped, Severity::Error, 0.0));
        }
    }

    /// Deadline: [`crate::deadline::DEADLINE`] between two reads.
    async fn fill_ring(&mut self) -> Result<(), SampleError> {
        self.sampler.start().await?;
        let mut block: [Scan; BLOCK] = [[0; CHANNELS]; BLOCK];
        loop {
            let first = match self.sampler.read(&mut block).await {
                Ok(first) => first,
                Err(SampleError::Overrun { lost }) => {
                    self.rig.overran(lost);
                    self.rig.streamed.set(Streamed::default());
                    continue;
                }
                Err(stopped) => return Err(stopped),
            };
            let _deadline = Deadline::begin(self.rig);
            self.rig.stats.borrow_mut().scans += BLOCK as u64;
            let mut record = self.record.borrow_mut();
            for scan in &block {
                record.push(scan);
            }
            let held = self.rig.streamed.get().held + BLOCK as u64;
            self.rig.streamed.set(Streamed { end: first.0 + BLOCK as u64, held });
            self.rig.news.signal(());
        }
    }
}
