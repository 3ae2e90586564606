//! What the parts of the application share: the measurement, counters, and the signals that wake them.
//!
//! All parts run in one executor, so cells suffice. No part holds a borrow across an await.

use core::cell::{Cell, RefCell};

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use heapless::{String, Vec};
use massline_protocol::message::{EstimatedMass, Identity, Stats, Status};
use massline_protocol::{PROTOCOL_MAJOR, PROTOCOL_MINOR, crc32};
use massline_shared::identify::Estimate;
use massline_shared::layout::{RIG_HITS, RIG_SENSORS, RigLayout, TestProfile};
use massline_shared::measurement::campaign::{Command, CommandError, Start};
use massline_shared::measurement::{Measurement, Memory, StartError};
use massline_shared::signal::{
    AdcProperties, CHANNELS, COMPACT_RESPONSE, PRE_TRIGGER_SCANS, RECORD_SCANS,
};

use crate::deadline::Deadline;
use crate::info::BoardInfo;
use crate::pulse::Pulse;
use crate::store::{CampaignSize, StoreError, decode_layout};

/// The state that the parts share.
pub(crate) struct Rig<'m> {
    pub info: BoardInfo,
    /// True when the link carries all scans.
    pub streams: bool,
    pub measurement: RefCell<Measurement<'m, f32>>,
    /// Hash of the layout in use, 0 without one.
    pub layout_hash: Cell<u32>,
    /// True while a result is deleted: a page of flash may be erased, during which nothing can be sampled.
    deleting: Cell<bool>,
    /// Counters other than those of the measurement and of the store.
    pub stats: RefCell<Stats>,
    /// Level of each channel over the last window: see [`crate::levels::Levels`].
    pub levels: Cell<[u8; CHANNELS]>,
    /// Mass according to the best estimate of the last result.
    pub last_mass: Cell<Option<EstimatedMass>>,
    /// What measuring, session and panel do.
    pub pulse: Pulse,
    /// Wakes the measuring loop when a command has arrived.
    pub wake: Signal<NoopRawMutex, ()>,
    /// Wakes the session when there is something to report to the host.
    pub news: Signal<NoopRawMutex, ()>,
    /// Wakes the panel when there is something to show.
    pub show: Signal<NoopRawMutex, ()>,
}

impl<'m> Rig<'m> {
    pub fn new(
        info: BoardInfo,
        adc: AdcProperties,
        streams: bool,
        memory: &'m mut Memory<f32>,
    ) -> Self {
        Self {
            info,
            streams,
            measurement: RefCell::new(Measurement::new(adc, memory)),
            layout_hash: Cell::new(0),
            deleting: Cell::new(false),
            stats: RefCell::new(Stats::default()),
            levels: Cell::new([0; CHANNELS]),
            last_mass: Cell::new(None),
            pulse: Pulse::new(),
            wake: Signal::new(),
            news: Signal::new(),
            show: Signal::new(),
        }
    }

    /// Signals the session and the panel that something has changed.
    pub fn changed(&self) {
        self.news.signal(());
        self.show.signal(());
    }

    /// Signals the measuring loop, the session and the panel that the measurement was given a command.
    pub fn steered(&self) {
        self.wake.signal(());
        self.changed();
    }

    /// Puts a layout into use, given by its postcard bytes.
    ///
    /// # Errors
    /// [`StoreError::Malformed`] when the bytes are not a layout; nothing changes then.
    pub fn use_layout(&self, encoded: &[u8]) -> Result<(), StoreError> {
        let layout = decode_layout(encoded).ok_or(StoreError::Malformed)?;
        self.use_decoded(layout, crc32(encoded));
        Ok(())
    }

    /// Puts a layout with this hash into use.
    pub fn use_decoded(&self, layout: RigLayout, hash: u32) {
        self.measurement.borrow_mut().set_layout(layout);
        self.layout_hash.set(hash);
        self.changed();
    }

    /// What a campaign with the layout in use will store. A campaign by mass lines stores no other lines.
    pub fn campaign_size(&self) -> CampaignSize {
        let measurement = self.measurement.borrow();
        let Some(layout) = measurement.layout() else { return CampaignSize { dofs: 0, lines: 0 } };
        let lines = match measurement.profile() {
            TestProfile::MassLine => 0,
            TestProfile::Suspension => measurement.adc_in_use().responses() * COMPACT_RESPONSE,
        };
        CampaignSize { dofs: layout.hits.len(), lines }
    }

    /// Starts a campaign; `room` is true when the store has room for it. Deadline:
    /// [`crate::deadline::DEADLINE`].
    pub fn start(&self, start: Start, force: bool, room: bool) -> Result<(), StartError> {
        let _deadline = Deadline::begin(&self.stats);
        if self.deleting.get() {
            return Err(StartError::Busy);
        }
        self.measurement.borrow_mut().start(start, force, room)?;
        self.steered();
        Ok(())
    }

    /// Executes a command from the operator.
    pub fn command(&self, command: Command) -> Result<(), CommandError> {
        self.unless_deleting()?;
        self.measurement.borrow_mut().command(command)?;
        self.steered();
        Ok(())
    }

    /// Requests a reading of the channels without a hit.
    pub fn take_reading(&self) -> Result<(), CommandError> {
        self.unless_deleting()?;
        self.measurement.borrow_mut().take_reading()?;
        self.steered();
        Ok(())
    }

    /// Runs `write`, which stores a layout or a calibration. Until it returns, no measurement can be started.
    ///
    /// # Errors
    /// Those of `write`, and a [`StartError`] when a measurement is running.
    pub async fn changing<T, E: From<StartError>>(
        &self,
        write: impl AsyncFnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.measurement.borrow_mut().begin_change()?;
        let done = write().await;
        self.measurement.borrow_mut().end_change();
        done
    }

    /// Runs `delete`, which deletes a result while the rig is idle or paused. Until it returns, nothing is started or
    /// resumed.
    ///
    /// # Errors
    /// Those of `delete`; [`StartError::WrongPhase`] while the rig measures, [`StartError::Busy`] during another
    /// deletion.
    pub async fn deleting<T, E: From<StartError>>(
        &self,
        delete: impl AsyncFnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        if !self.measurement.borrow().rests() {
            return Err(StartError::WrongPhase.into());
        }
        if self.deleting.replace(true) {
            return Err(StartError::Busy.into());
        }
        let done = delete().await;
        self.deleting.set(false);
        done
    }

    /// # Errors
    /// [`CommandError::WrongPhase`] while a result is deleted.
    pub fn unless_deleting(&self) -> Result<(), CommandError> {
        if self.deleting.get() { Err(CommandError::WrongPhase) } else { Ok(()) }
    }

    /// State of the rig.
    pub fn status(&self) -> Status {
        let measurement = self.measurement.borrow();
        let campaign = measurement.campaign();
        let mut accepted = Vec::<u8, RIG_HITS>::new();
        accepted.extend(campaign.iter().flat_map(|c| c.dofs()).map(|dof| dof.accepted));
        Status {
            phase: measurement.phase().into(),
            dof: campaign.map_or(0, |campaign| campaign.dof() as u8),
            armings: measurement.armings(),
            accepted,
            hits_per_dof: campaign.map_or(0, |campaign| campaign.hits_per_dof()),
            rejected: campaign.map_or(0, |campaign| campaign.rejected()),
            last_hit: measurement.hits(),
            layout_hash: self.layout_hash.get(),
            result: campaign.map_or(0, |campaign| campaign.result()),
            started_unix_s: campaign.map_or(0, |campaign| campaign.started().started_unix_s),
            diagnostics: measurement.diagnostics().clone(),
        }
    }

    /// Identity of the rig.
    pub fn identity(&self) -> Identity {
        identity(&self.info, *self.measurement.borrow().adc(), self.streams)
    }

    /// Counters of the rig without those of the store.
    pub fn stats(&self) -> Stats {
        let (stack, counts) = ((self.info.stack)(), self.measurement.borrow().counts());
        let stats = self.stats.borrow();
        Stats {
            uptime_ms: Instant::now().as_millis(),
            scans: counts.scans,
            scans_lost: counts.scans_lost,
            overruns: counts.overruns,
            triggers: counts.triggers,
            hits_aborted: counts.hits_aborted,
            events_dropped: stats.events_dropped + counts.events_dropped,
            stack_high_water: stack.high_water,
            stack_size: stack.size,
            ..*stats
        }
    }
}

/// Identity of a rig with this converter, whose link carries all scans if `streams` is true.
pub(crate) fn identity(info: &BoardInfo, adc: AdcProperties, streams: bool) -> Identity {
    Identity {
        protocol_major: PROTOCOL_MAJOR,
        protocol_minor: PROTOCOL_MINOR,
        firmware: cut(info.firmware),
        git_hash: cut(info.git_hash),
        git_dirty: info.git_dirty,
        board: cut(info.name),
        adc,
        record_scans: RECORD_SCANS as u16,
        pre_trigger_scans: PRE_TRIGGER_SCANS as u16,
        max_sensors: RIG_SENSORS as u8,
        max_hits: RIG_HITS as u8,
        streams,
        boot_reason: info.boot_reason.into(),
        last_panic: cut(info.last_panic),
    }
}

/// The mass of an estimate.
pub(crate) fn mass_of(estimate: &Estimate<f32>) -> EstimatedMass {
    EstimatedMass { value: estimate.body.mass, sigma: estimate.sigma().map(|sigma| sigma[0]) }
}

/// The beginning of a text, as much as fits.
pub(crate) fn cut<const N: usize>(text: &str) -> String<N> {
    let mut out = String::new();
    for c in text.chars() {
        if out.push(c).is_err() {
            break;
        }
    }
    out
}
