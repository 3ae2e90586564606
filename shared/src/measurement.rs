//! A measurement from scans to a result: a state machine that does no input or output itself.
//!
//! The driver asks for the [`NextAction`], does it, and reports the outcome; commands of the operator may come at any
//! time. The machine waits for nothing and has no access to flash, link, screen or clock; each call does a
//! bounded amount of work.
//!
//! ```text
//!               start, command               next_action ──▶ Wait:    until a command comes
//!                     │                                      Sample:  sampling_started, feed, lost, stopped
//! set_layout ──▶ Measurement ──▶ hits, status, result        Compute: work
//!                     │                                      Store:   store the result; stored, not_stored
//!                 Memory (lent)
//!
//! scans ─▶ capture ─▶ grade ─▶ spectra ─▶ average ─▶ mass lines ─▶ identify ─▶ result
//! ```
//! A rig uses single precision, a Monte Carlo study double precision.
//!
//! | module | subject |
//! | --- | --- |
//! | `setup` | the layout and the calibration in use |
//! | `commands` | commands of the operator |
//! | [`campaign`] | which degree of freedom is hit next |
//! | `capturing` | the capture of a hit under either profile |
//! | `hits` | from scans to an averaged hit |
//! | `averaged_hit` | a hit that is being averaged under either profile |
//! | [`long_hit`] | averages a hit with a long record |
//! | `undo` | takes the last accepted hit out of the averages again |
//! | `listening` | the search for mains hum in a hit |
//! | [`averaging`] | from the hits of one DOF to its mass lines |
//! | `closing` | from averaged hits to mass lines |
//! | [`stored_lines`] | what is kept in memory of a DOF whose lines are stored |
//! | `lines` | closes a DOF whose lines the driver stores |
//! | `identifying` | from mass lines to the estimates, after each DOF and at the end |
//! | `precision` | how precise the answer would be after each DOF, and whether the target is reached |
//! | `view` | the state of the measurement, for display |

mod averaged_hit;
pub mod averaging;
pub mod campaign;
mod capturing;
mod closing;
mod commands;
mod hits;
mod identifying;
mod lines;
mod listening;
pub mod long_hit;
mod memory;
mod precision;
mod result;
mod setup;
pub mod stored_lines;
mod undo;
mod view;

pub use commands::{DofData, RestoredDof, StartError};
pub use memory::Memory;
pub use precision::CampaignPrecision;
pub use result::{BlockResult, MeasuredDof, TestResult};
pub use view::{Counts, GradedHit, RecordContent, StreamProgress};

use heapless::Deque;

use crate::calibration::CalibrationSigma;
use crate::capacity::Rig;
use crate::diagnosis::{Diagnostic, Diagnostics};
use crate::layout::Layout;
use crate::real::Real;
use crate::signal::{AdcProperties, Calibration, RealFft};
use crate::units::ScanIndex;
use campaign::{Campaign, Phase, Step};
use hits::Task;
use undo::LastAcceptedHit;
use view::EVENTS;

/// A layout with the capacity of a rig, in either precision.
pub type TestLayout<R> = Layout<R, Rig>;

/// Number of consecutive losses of scans after which the converter counts as stopped.
pub const LOSSES_TO_STOP: u8 = 3;

/// Next action of the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextAction {
    /// Do nothing until a command comes.
    Wait,
    /// Start the sampler, report [`Measurement::sampling_started`], and feed scans until the next action is
    /// another.
    Sample,
    /// Call [`Measurement::work`].
    Compute,
    /// Store what [`Measurement::result`] says about the DOF that was measured last, with its
    /// [lines](Measurement::line), then report [`Measurement::lines_stored`] or [`Measurement::lines_not_stored`].
    StoreLines {
        /// Index of the DOF in the layout.
        dof: usize,
    },
    /// Store [`Measurement::result`], then report [`Measurement::stored`] or [`Measurement::not_stored`].
    Store,
}

/// Current activity of a rig; there is only one at a time.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time, and no allocator")]
enum Activity<R: Real> {
    /// No activity.
    Idle,
    /// The layout or the calibration is being replaced.
    Changing,
    /// The record is being filled with readings of the channels without a hit.
    Reading,
    /// All scans are passed on, through the record as a ring buffer.
    Streaming(StreamProgress),
    /// A campaign is running.
    Measuring(Campaign, Task<R>),
}

/// A measurement that uses borrowed memory.
pub struct Measurement<'m, R: Real> {
    adc: AdcProperties,
    calibration: Calibration,
    /// What the calibration contributes to the error budget, when it was made.
    gains: Option<CalibrationSigma>,
    layout: Option<TestLayout<R>>,
    activity: Activity<R>,
    /// The campaign that ended last, until another one starts.
    ended: Option<Campaign>,
    recorded: RecordContent,
    /// Index of the DOF whose hits are in the averaged spectra.
    averaged: Option<u8>,
    /// Fingerprint of the last graded record.
    last_record: Option<u32>,
    /// The last graded hit of this campaign.
    last_hit: Option<GradedHit>,
    hits: u32,
    armings: u32,
    campaigns: u32,
    /// Number of consecutive losses of scans.
    losses: u8,
    events: Deque<GradedHit, EVENTS>,
    block: Option<BlockResult>,
    /// The precision after the last closed DOF of this campaign.
    precision: Option<CampaignPrecision<R>>,
    last_accepted: LastAcceptedHit<R>,
    diagnostics: Diagnostics,
    counts: Counts,
    memory: &'m mut Memory<R>,
}

impl<'m, R: RealFft> Measurement<'m, R> {
    /// An idle measurement without a layout, with the calibration of the data sheets.
    pub fn new(adc: AdcProperties, memory: &'m mut Memory<R>) -> Self {
        Self {
            adc,
            calibration: Calibration::default(),
            gains: None,
            layout: None,
            activity: Activity::Idle,
            ended: None,
            recorded: RecordContent::Nothing,
            averaged: None,
            last_record: None,
            last_hit: None,
            hits: 0,
            armings: 0,
            campaigns: 0,
            losses: 0,
            events: Deque::new(),
            block: None,
            precision: None,
            last_accepted: LastAcceptedHit::new(),
            diagnostics: Diagnostics::new(),
            counts: Counts::default(),
            memory,
        }
    }

    /// The next action of the driver.
    pub fn next_action(&self) -> NextAction {
        match &self.activity {
            Activity::Idle | Activity::Changing => NextAction::Wait,
            Activity::Reading | Activity::Streaming(_) => NextAction::Sample,
            Activity::Measuring(campaign, task) => match (campaign.step(), task) {
                (_, Task::Capture { .. }) | (Step::AwaitHit { .. }, Task::None) => {
                    NextAction::Sample
                }
                (_, Task::Grade { .. }) => NextAction::Compute,
                (Step::Rest | Step::AwaitHit { .. }, _) => NextAction::Wait,
                (Step::CloseDof { .. }, Task::StoreLines) if campaign.phase() == Phase::Paused => {
                    NextAction::Wait
                }
                (Step::CloseDof { dof }, Task::StoreLines) => NextAction::StoreLines { dof },
                (Step::Identify, Task::Identified) => NextAction::Store,
                _ => NextAction::Compute,
            },
        }
    }

    /// Does a bounded part of the computation. On a rig at most 1.6 million instructions.
    pub fn work(&mut self) {
        if self.next_action() != NextAction::Compute {
            return;
        }
        let Activity::Measuring(mut campaign, task) = self.take_activity() else { return };
        let task = match (campaign.step(), task) {
            (_, Task::Grade { trigger, extremes }) => {
                self.grade_hit(&mut campaign, trigger, extremes.as_ref())
            }
            (Step::Analyse { dof }, task) => self.average_hit(&mut campaign, dof, task),
            (Step::Undo, task) => {
                let dof = self.last_accepted.dof().unwrap_or_default();
                self.average_hit(&mut campaign, dof, task)
            }
            (Step::CloseDof { dof }, task) if self.is_long() => self.close_lines(dof, task),
            (Step::CloseDof { dof }, _) => {
                self.close_dof(dof);
                campaign.dof_closed();
                Task::None
            }
            (Step::Estimate, task) => self.estimate(&mut campaign, task),
            (Step::Identify, task) => self.identify(&campaign, task),
            (Step::Rest | Step::AwaitHit { .. }, task) => task,
        };
        self.activity = Activity::Measuring(campaign, task);
    }

    fn take_activity(&mut self) -> Activity<R> {
        core::mem::replace(&mut self.activity, Activity::Idle)
    }

    fn push_diagnostic(&mut self, diagnostic: Diagnostic) {
        note(&mut self.diagnostics, diagnostic);
    }
}

/// Adds a diagnostic. If the same code and subject are already in the list, the one of higher severity stays
/// or, at equal severity, the one with the larger value. When the list is full, an error replaces a
/// diagnostic that is not one; anything else is dropped.
pub fn note(list: &mut Diagnostics, diagnostic: Diagnostic) {
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

#[cfg(test)]
mod tests;
