//! A measurement from scans to a result: a state machine without inputs and outputs of its own.
//!
//! Whoever drives it asks for a [`Wish`], does it, and reports what came of it. The operator's commands come in
//! between at any time. The machine waits for nothing and knows no flash, link, screen or clock; each call does
//! a bounded piece of work.
//!
//! ```text
//!               start, command                     wish ──▶ Rest:  until a command comes
//!                     │                                     Scans: sampling_started, feed, lost, stopped
//! set_layout ──▶ Measurement ──▶ hits, status, result       Work:  work
//!                     │                                     Keep:  keep the result; stored, not_stored
//!                 Memory (lent)
//!
//! scans ─▶ capture ─▶ grade ─▶ spectra ─▶ average ─▶ mass lines ─▶ identify ─▶ result
//! ```
//! A rig drives it in single precision, a Monte Carlo study in double precision.
//!
//! | module | subject |
//! | --- | --- |
//! | `setup` | the layout and the calibration in use |
//! | `commands` | what the operator wants |
//! | [`campaign`] | which degree of freedom is hit next, and what a verdict leads to |
//! | `hits` | from scans to an averaged hit |
//! | [`averaging`] | one hit DOF from its hits to its mass lines |
//! | `closing` | from averaged hits to mass lines, and from these to the answers |
//! | `view` | what there is to see |

pub mod averaging;
pub mod campaign;
mod closing;
mod commands;
mod hits;
mod memory;
mod result;
mod setup;
mod view;

pub use commands::StartError;
pub use memory::Memory;
pub use result::{BlockResult, MeasuredDof, TestResult};
pub use view::{Counts, GradedHit, Recorded, Streamed};

use heapless::Deque;

use crate::diagnosis::{Diagnostic, Diagnostics};
use crate::layout::{Layout, RIG_HITS, RIG_SENSORS};
use crate::signal::{AdcProperties, Calibration, RealFft};
use crate::units::ScanIndex;
use campaign::{Campaign, Step};
use hits::Task;
use view::EVENTS;

/// A layout of a rig in a precision.
pub type TestLayout<R> = Layout<R, RIG_SENSORS, RIG_HITS>;

/// Losses of scans in a row, without a block between them, that a converter is given up after.
pub const LOSSES_TO_STOP: u8 = 3;

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Nothing until a command comes.
    Rest,
    /// Sample: start the sampler, say so with [`Measurement::sampling_started`], and feed it with scans until the
    /// wish is another one.
    Scans,
    /// Time to compute: [`Measurement::work`].
    Work,
    /// Keep [`Measurement::result`], then report [`Measurement::stored`] or [`Measurement::not_stored`].
    Keep,
}

/// What a rig is doing: one thing at a time.
#[derive(Clone, Debug)]
enum Activity<R> {
    /// Nothing.
    Idle,
    /// Its layout or calibration is being replaced.
    Changing,
    /// It fills the record with what the channels read without a hit.
    Reading,
    /// It passes all scans on, through the record as a ring.
    Streaming(Streamed),
    /// It carries out a campaign.
    Measuring(Campaign, Task<R>),
}

/// A measurement over memory that is lent to it.
pub struct Measurement<'m, R> {
    adc: AdcProperties,
    calibration: Calibration,
    layout: Option<TestLayout<R>>,
    activity: Activity<R>,
    /// The campaign that ended last, while nothing has taken its place.
    ended: Option<Campaign>,
    recorded: Recorded,
    /// Index of the DOF whose hits are averaged in the spectra.
    averaged: Option<u8>,
    /// Fingerprint of the record graded last.
    last_record: Option<u32>,
    /// The hit graded last in this campaign.
    last_hit: Option<GradedHit>,
    hits: u32,
    armings: u32,
    campaigns: u32,
    /// Losses of scans in a row.
    losses: u8,
    events: Deque<GradedHit, EVENTS>,
    block: Option<BlockResult>,
    diagnostics: Diagnostics,
    counts: Counts,
    memory: &'m mut Memory<R>,
}

impl<'m, R: RealFft> Measurement<'m, R> {
    /// Nothing is measured yet; without a layout, and with the calibration of the data sheets.
    pub fn new(adc: AdcProperties, memory: &'m mut Memory<R>) -> Self {
        Self {
            adc,
            calibration: Calibration::default(),
            layout: None,
            activity: Activity::Idle,
            ended: None,
            recorded: Recorded::Nothing,
            averaged: None,
            last_record: None,
            last_hit: None,
            hits: 0,
            armings: 0,
            campaigns: 0,
            losses: 0,
            events: Deque::new(),
            block: None,
            diagnostics: Diagnostics::new(),
            counts: Counts::default(),
            memory,
        }
    }

    /// What is to be done next.
    pub fn wish(&self) -> Wish {
        match &self.activity {
            Activity::Idle | Activity::Changing => Wish::Rest,
            Activity::Reading | Activity::Streaming(_) => Wish::Scans,
            Activity::Measuring(campaign, task) => match (campaign.step(), task) {
                (_, Task::Capture { .. }) | (Step::AwaitHit { .. }, Task::None) => Wish::Scans,
                (_, Task::Grade { .. }) => Wish::Work,
                (Step::Rest | Step::AwaitHit { .. }, _) => Wish::Rest,
                (Step::Identify, Task::Identified) => Wish::Keep,
                _ => Wish::Work,
            },
        }
    }

    /// Does a bounded piece of the computing that is wanted. On a rig at most a million instructions.
    pub fn work(&mut self) {
        if self.wish() != Wish::Work {
            return;
        }
        let Activity::Measuring(mut campaign, task) = self.take_activity() else { return };
        let task = match (campaign.step(), task) {
            (_, Task::Grade { trigger }) => self.grade_hit(&mut campaign, trigger),
            (Step::Analyse { dof }, task) => self.average_hit(&mut campaign, dof, task),
            (Step::CloseDof { dof }, _) => {
                self.close_dof(dof);
                campaign.dof_closed();
                Task::None
            }
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

/// Adds a diagnostic; of one that is there already the graver stays, of two as grave the one with the larger
/// number. In a full list an error takes the place of something lesser; anything else is left out.
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
