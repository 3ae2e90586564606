//! What the parts of the application share: layout, calibration, campaign, counters, news.
//!
//! All parts run in one executor, so cells suffice. Nobody holds a borrow across an await.

use core::cell::{Cell, RefCell};
use massline_protocol::LayoutHash;
use massline_shared::campaign::Phase;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use heapless::{Deque, String, Vec};
use massline_protocol::event::HitEvent;
use massline_protocol::message::{
    CampaignCommand, CommandRequest, Identity, Measured, Reason, Stats, Status,
};
use massline_protocol::{PROTOCOL_MAJOR, PROTOCOL_MINOR};
use massline_shared::calibration::block::{BlockError, ForceRatio};
use massline_shared::campaign::{self, Campaign, Outcome, Step};
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::Applicability;
use massline_shared::layout::{RIG_HITS, RIG_SENSORS, RigLayout, assumed_body, check_settings};
use massline_shared::signal::{
    AdcProperties, CHANNELS, Calibration, PRE_TRIGGER_SCANS, RECORD_SCANS, SPECTRUM_LINES,
};

use crate::board::BoardInfo;
use crate::deadline::Deadline;
use crate::identification::METHODS;
use crate::panel::{HitVerdict, PanelModel};

/// Hits that wait to be told to the host.
const HIT_QUEUE: usize = 4;

/// The state that the parts share.
pub(crate) struct Rig {
    pub info: BoardInfo,
    pub adc: AdcProperties,
    pub streams: bool,
    pub layout: RefCell<Option<RigLayout>>,
    pub layout_hash: Cell<u32>,
    pub calibration: RefCell<Calibration>,
    pub campaign: RefCell<Campaign>,
    /// What is to be said about the campaign.
    pub diagnostics: RefCell<Diagnostics>,
    pub stats: RefCell<Stats>,
    pub hits: RefCell<Deque<HitEvent, HIT_QUEUE>>,
    pub hits_seen: Cell<u32>,
    /// What was told of the last hit.
    pub last_hit: RefCell<Option<HitEvent>>,
    /// Scan of the last trigger.
    pub triggered_at: Cell<u64>,
    /// Number of the hit whose record is whole and readable.
    pub record_of: Cell<Option<u32>>,
    /// Fingerprint of the record graded last.
    pub last_record: Cell<Option<u32>>,
    /// Index of the DOF whose hits are averaged in the spectra.
    pub spectra_of: Cell<Option<u8>>,
    /// What was found of the last hit of this campaign.
    pub verdict: Cell<Option<HitVerdict>>,
    /// How much each channel has moved lately, as [`crate::levels::Levels`] counts it.
    pub levels: Cell<[u8; CHANNELS]>,
    pub last_mass: Cell<Option<Measured>>,
    /// True when the object of the campaign is a block of known mass.
    pub block: Cell<bool>,
    /// How many are changing layout or calibration just now.
    pub changes: Cell<u8>,
    /// Its mass, when the person has typed it in here, kg.
    pub block_mass: Cell<Option<f32>>,
    /// What such a campaign says of the hammer.
    pub block_ratio: Cell<Option<Result<ForceRatio<f32>, BlockError>>>,
    pub reading: Cell<Reading>,
    /// True while the host wants every scan.
    pub stream: Cell<bool>,
    /// Scans taken since the stream was started, and the index of the first.
    pub streamed: Cell<Streamed>,
    /// Wakes the measuring loop: a command came.
    pub steer: Signal<NoopRawMutex, ()>,
    /// Wakes the session: there is something to tell.
    pub news: Signal<NoopRawMutex, ()>,
    /// Wakes the panel: there is something to show.
    pub show: Signal<NoopRawMutex, ()>,
}

/// How far the stream of scans has come.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Streamed {
    /// Index of the scan after the last one taken.
    pub end: u64,
    /// How many of the scans before it are in the record.
    pub held: u64,
}

/// A record of what the channels read without a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    /// The record is something else.
    None,
    /// It is to be taken.
    Wanted,
    /// It is the record.
    Held,
    /// It could not be taken: the converter has stopped.
    Failed,
}

impl Rig {
    pub fn new(info: BoardInfo, adc: AdcProperties, streams: bool) -> Self {
        Self {
            info,
            adc,
            streams,
            layout: RefCell::new(None),
            layout_hash: Cell::new(0),
            calibration: RefCell::new(Calibration::default()),
            campaign: RefCell::new(Campaign::new()),
            diagnostics: RefCell::new(Diagnostics::new()),
            stats: RefCell::new(Stats::default()),
            hits: RefCell::new(Deque::new()),
            hits_seen: Cell::new(0),
            last_hit: RefCell::new(None),
            triggered_at: Cell::new(0),
            record_of: Cell::new(None),
            last_record: Cell::new(None),
            spectra_of: Cell::new(None),
            verdict: Cell::new(None),
            levels: Cell::new([0; CHANNELS]),
            last_mass: Cell::new(None),
            block: Cell::new(false),
            changes: Cell::new(0),
            block_mass: Cell::new(None),
            block_ratio: Cell::new(None),
            reading: Cell::new(Reading::None),
            stream: Cell::new(false),
            streamed: Cell::new(Streamed::default()),
            steer: Signal::new(),
            news: Signal::new(),
            show: Signal::new(),
        }
    }

    /// Tells session and panel that something has changed.
    pub fn changed(&self) {
        self.news.signal(());
        self.show.signal(());
    }

    /// Takes a layout into use; what was said of an earlier one is forgotten.
    pub fn set_layout(&self, layout: RigLayout) {
        self.campaign.borrow_mut().forget();
        self.diagnostics.borrow_mut().clear();
        self.spectra_of.set(None);
        self.verdict.set(None);
        self.layout_hash.set(layout.hash());
        *self.layout.borrow_mut() = Some(layout);
    }

    /// DOFs of the layout in use.
    pub fn dofs(&self) -> usize {
        self.layout.borrow().as_ref().map_or(0, |layout| layout.hits.len())
    }

    /// Keeps a campaign from being started while layout or calibration are written to the flash.
    pub async fn changing<T>(&self, write: impl AsyncFnOnce() -> T) -> T {
        self.changes.set(self.changes.get() + 1);
        let done = write().await;
        self.changes.set(self.changes.get() - 1);
        done
    }

    /// What is to be said about a layout: errors when no method of the rig could give an answer.
    /// Deadline: [`crate::deadline::DEADLINE`].
    pub fn check(&self, layout: &RigLayout) -> Diagnostics {
        let _deadline = Deadline::begin(self);
        let mut diagnostics = judge(layout);
        for found in check_settings(&layout.test, self.adc.rate.0, RECORD_SCANS, SPECTRUM_LINES) {
            note(&mut diagnostics, found);
        }
        if layout.sensors.len() * 3 > self.adc.responses() {
            let channels = self.adc.responses() as f32;
            let missing = Diagnostic::whole(Code::SettingOutOfRange, Severity::Error, channels);
            note(&mut diagnostics, missing);
        }
        diagnostics
    }

    /// Executes a command of the host or of the buttons.
    pub fn command(&self, request: CommandRequest, store_full: bool) -> Result<(), Reason> {
        let command = CampaignCommand::from_raw(request.command).ok_or(Reason::Malformed)?;
        match command.steering() {
            None => self.start(request, store_full)?,
            Some(command) => {
                self.campaign.borrow_mut().command(command)?;
                match command {
                    campaign::Command::Redo => self.spectra_of.set(None),
                    // What had interrupted the campaign is tried again.
                    campaign::Command::Resume => {
                        self.diagnostics.borrow_mut().retain(|d| !d.interrupts());
                    }
                    _ => {}
                }
            }
        }
        self.steer.signal(());
        self.changed();
        Ok(())
    }

    fn start(&self, request: CommandRequest, store_full: bool) -> Result<(), Reason> {
        if self.changes.get() > 0 {
            return Err(Reason::Busy);
        }
        let layout = self.layout.borrow();
        let layout = layout.as_ref().ok_or(Reason::NoLayout)?;
        let mut findings = self.check(layout);
        if request.block {
            // Hits through the centre of mass determine no ten properties, and need not.
            findings.retain(|d| !can_be_forced(d));
            note(&mut findings, Diagnostic::whole(Code::BlockTest, Severity::Note, 0.0));
        }
        let refuses = |d: &Diagnostic| d.is_error() && !(request.force && can_be_forced(d));
        if findings.iter().any(refuses) {
            return Err(Reason::LayoutRefused);
        }
        if store_full {
            return Err(Reason::StoreFull);
        }
        if self.stream.get() {
            return Err(Reason::WrongPhase);
        }
        let mut campaign = self.campaign.borrow_mut();
        campaign.start(layout.hits.len(), layout.test.hits_per_dof, request.confirm)?;
        *self.diagnostics.borrow_mut() = findings;
        self.block.set(request.block);
        self.block_mass.set(None);
        self.block_ratio.set(None);
        self.verdict.set(None);
        Ok(())
    }

    /// What the rig is doing.
    pub fn status(&self) -> Status {
        let campaign = self.campaign.borrow();
        let mut accepted = Vec::<u8, RIG_HITS>::new();
        accepted.extend(campaign.dofs().iter().map(|dof| dof.accepted));
        Status {
            phase: campaign.phase() as u8,
            dof: campaign.dof() as u8,
            armings: campaign.armings(),
            accepted,
            hits_per_dof: campaign.wanted(),
            rejected: campaign.rejected(),
            last_hit: self.hits_seen.get(),
            layout_hash: self.layout_hash.get(),
            result: campaign.result(),
            diagnostics: self.diagnostics.borrow().clone(),
        }
    }

    /// Who the rig is.
    pub fn identity(&self) -> Identity {
        Identity {
            protocol_major: PROTOCOL_MAJOR,
            protocol_minor: PROTOCOL_MINOR,
            firmware: cut(self.info.firmware),
            git_hash: cut(self.info.git_hash),
            git_dirty: self.info.git_dirty,
            board: cut(self.info.name),
            adc: self.adc,
            record_scans: RECORD_SCANS as u16,
            pre_trigger_scans: PRE_TRIGGER_SCANS as u16,
            max_sensors: RIG_SENSORS as u8,
            max_hits: RIG_HITS as u8,
            streams: self.streams,
            boot_reason: self.info.boot_reason,
            last_panic: cut(self.info.last_panic),
        }
    }

    /// What has been counted.
    pub fn stats(&self) -> Stats {
        let stack = (self.info.stack)();
        Stats {
            uptime_ms: Instant::now().as_millis(),
            stack_high_water: stack.high_water,
            stack_size: stack.size,
            ..*self.stats.borrow()
        }
    }

    /// What the panel shows of the campaign.
    pub fn panel(&self) -> PanelModel {
        let idle = self.is_idle();
        let campaign = self.campaign.borrow();
        let layout = self.layout.borrow();
        let diagnostics = self.diagnostics.borrow();
        let dof = layout.as_ref().and_then(|layout| layout.hits.get(campaign.dof()));
        let wanted = u16::from(campaign.wanted());
        let done = campaign.dofs().iter().map(|dof| match dof.outcome {
            Outcome::Open => u16::from(dof.accepted).min(wanted),
            Outcome::Complete | Outcome::Early | Outcome::Skipped => wanted,
        });
        PanelModel {
            phase: campaign.phase(),
            dof: dof.map(|hit| (campaign.dof() as u8, hit.dof)),
            armings: campaign.armings(),
            accepted: campaign.accepted(),
            wanted: campaign.wanted(),
            dofs: self.dofs() as u8,
            averaged: campaign.dofs().iter().map(|dof| u16::from(dof.accepted)).sum(),
            hits_done: done.sum(),
            hits: campaign.dofs().len() as u16 * wanted,
            rejected: campaign.rejected(),
            verdict: self.verdict.get(),
            levels: self.levels.get(),
            block: self.block.get(),
            result: campaign.result(),
            mass: self.last_mass.get(),
            interrupted: diagnostics.iter().any(|d| d.interrupts()),
            idle,
            findings: diagnostics.len() as u8,
            // The rest is the panel's own.
            ..PanelModel::START
        }
    }

    /// True when layout, calibration and results may be changed: nothing is measured.
    pub fn is_idle(&self) -> bool {
        let phase = self.campaign.borrow().phase();
        matches!(phase, Phase::Idle | Phase::Done)
            && !self.stream.get()
            && self.reading.get() != Reading::Wanted
    }

    /// True when nothing is sampled or computed: idle or paused.
    pub fn rests(&self) -> bool {
        let campaign = self.campaign.borrow();
        let paused = campaign.phase() == Phase::Paused && campaign.step() == Step::Rest;
        paused || self.is_idle()
    }

    /// The converter with only those channels that the layout has sensors for.
    pub fn adc_in_use(&self) -> AdcProperties {
        let layout = self.layout.borrow();
        let sensors = layout.as_ref().map_or(0, |layout| layout.sensors.len());
        let responses = self.adc.responses().min(3 * sensors);
        AdcProperties { channels: responses as u8 + 1, ..self.adc }
    }

    /// The sampler has lost so many scans at once.
    pub fn overran(&self, lost: u32) {
        let mut stats = self.stats.borrow_mut();
        stats.scans_lost += u64::from(lost);
        stats.overruns += 1;
    }

    /// Adds to what is to be said about the campaign.
    pub fn say(&self, diagnostic: Diagnostic) {
        note(&mut self.diagnostics.borrow_mut(), diagnostic);
    }

    /// Queues a hit for the host; the oldest goes when nobody reads.
    pub fn tell_hit(&self, hit: HitEvent) {
        let mut hits = self.hits.borrow_mut();
        if hits.is_full() {
            hits.pop_front();
            self.stats.borrow_mut().events_dropped += 1;
        }
        // There is room: one was taken out above.
        let _ = hits.push_back(hit);
    }
}

/// What keeps the rig's methods from an answer under a layout. The object is not known yet: any body
/// about the sensors and hits tells what can be told.
#[inline(never)]
fn judge(layout: &RigLayout) -> Diagnostics {
    let sensors = layout.sensors.iter().map(|sensor| sensor.position);
    let places = sensors.chain(layout.hits.iter().map(|hit| hit.position));
    let body = assumed_body(None, places);
    Applicability::new(layout, &body, &METHODS).diagnostics
}

/// True for a fact of the layout that only takes the answer away; a setting that the rig cannot
/// work with is never forced.
fn can_be_forced(diagnostic: &Diagnostic) -> bool {
    let never = [Code::SettingOutOfRange, Code::LayoutNotFinite, Code::AxesNotOrthonormal];
    !never.contains(&diagnostic.code)
}

/// Adds a diagnostic; of one that is there already the graver stays, of two as grave the one with the
/// larger number. In a full list an error takes the place of something lesser; anything else is left
/// out.
pub(crate) fn note(list: &mut Diagnostics, diagnostic: Diagnostic) {
    let same = |d: &&mut Diagnostic| d.code == diagnostic.code && d.subject == diagnostic.subject;
    if let Some(known) = list.iter_mut().find(same) {
        let rank = |d: &Diagnostic| (d.severity, d.value.abs());
        if rank(&diagnostic) > rank(known) {
            *known = diagnostic;
        }
        return;
    }
    if list.push(diagnostic).is_ok() || !diagnostic.is_error() {
        return;
    }
    if let Some(lesser) = list.iter_mut().rev().find(|d| !d.is_error()) {
        *lesser = diagnostic;
    }
}

/// As much of a text as fits.
pub(crate) fn cut<const N: usize>(text: &str) -> String<N> {
    let mut out = String::new();
    for c in text.chars() {
        if out.push(c).is_err() {
            break;
        }
    }
    out
}
