//! Plays a tape to a rig: one segment of the requested DOF per arming.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use massline_physics::source::ScanSource;
use massline_protocol::LayoutHash;
use massline_shared::layout::{Dof, RigLayout};
use massline_shared::signal::{AdcProperties, CHANNELS, RECORD_SCANS, Scan};

use crate::{Error, Result};
use massline_files::tape::{Scans, Segment, Tape};

/// Shortest length of a played segment, scans: a record, and a quarter more for a late trigger.
const SHORTEST_PLAY: u64 = (RECORD_SCANS + RECORD_SCANS / 4) as u64;
/// Stands for no DOF.
const NONE: usize = usize::MAX;

/// Plays a tape as a source of scans.
///
/// When the rig is armed at a DOF, the next unused segment of that DOF is played from its start to the start of the
/// next segment, but always for more than the length of a record; past the end of the tape its last scan is repeated
/// for the length of a record, so that a record that has begun ends. Then no scans follow until the next arming.
/// [`TapeProgress`] reports the state to the host.
#[derive(Debug)]
pub struct TapeSource {
    adc: AdcProperties,
    scans: Scans,
    segments: Vec<PlayedSegment>,
    dofs: Vec<Dof>,
    armed: Option<(u32, usize)>,
    /// Index of the next scan, and of the scan after the last of the current segment.
    at: u64,
    end: u64,
    progress: TapeProgress,
}

#[derive(Debug)]
struct PlayedSegment {
    segment: Segment,
    used: bool,
}

/// The state of a tape during a replay, for the host. Clones share the state.
#[derive(Clone, Debug)]
pub struct TapeProgress(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    exhausted: AtomicUsize,
    played_out: AtomicBool,
    play_next: AtomicBool,
    failed: OnceLock<String>,
}

impl TapeProgress {
    /// The index of the DOF that the rig is armed at when it has no unused segment left; the host must then
    /// finish this DOF.
    pub fn exhausted(&self) -> Option<usize> {
        Some(self.0.exhausted.load(Ordering::Acquire)).filter(|&dof| dof != NONE)
    }

    /// True when the segment of the current arming has been played to its end. A rig that is still armed then
    /// has found no hit in it.
    pub fn played_out(&self) -> bool {
        self.0.played_out.load(Ordering::Acquire)
    }

    /// Requests the next segment of the same DOF without a new arming, because the rig found no hit in the
    /// last one. The source reacts when its next scan is requested.
    pub fn play_next(&self) {
        self.0.play_next.store(true, Ordering::Release);
    }

    /// Why the tape cannot be read any more.
    pub fn failed(&self) -> Option<&str> {
        self.0.failed.get().map(String::as_str)
    }
}

impl TapeSource {
    /// Prepares `tape` for a rig with `layout`; returns a warning with it when the tape was recorded with
    /// another layout that has the same DOFs.
    ///
    /// # Errors
    /// Exit 2 when the layout has more sensors than the tape, or the tape was recorded with another layout
    /// whose DOFs differ.
    pub fn new(tape: Tape, layout: &RigLayout) -> Result<(Self, Option<String>)> {
        let Tape { sidecar, scans, .. } = tape;
        let dofs: Vec<Dof> = layout.hits.iter().map(|hit| hit.dof).collect();
        let sensor_count = sensors(&sidecar.adc);
        if layout.sensors.len() > sensor_count {
            let message = format!(
                "the layout has {} sensors and the tape {sensor_count}; use the layout of the tape",
                layout.sensors.len()
            );
            return Err(Error::input("tape_wrong_layout", message));
        }
        let other = sidecar.layout_hash != layout.hash();
        let missing = dofs.iter().find(|d| sidecar.segments.iter().all(|s| s.dof != **d));
        let unknown = sidecar.segments.iter().map(|s| s.dof).find(|d| !dofs.contains(d));
        let warning = match (other, unknown, missing) {
            (false, None, _) => None,
            (true, None, None) => Some(format!(
                "the tape was taken with another layout ({:08x}, this is {:08x}) of the same DOFs",
                sidecar.layout_hash,
                layout.hash()
            )),
            (_, Some(dof), _) => {
                let message = format!(
                    "the tape has hits at {dof} and the layout has not; use the layout of the tape"
                );
                return Err(Error::input("tape_wrong_layout", message));
            }
            (true, None, Some(dof)) => {
                let message = format!(
                    "the layout has hits at {dof} and the tape has none; use the layout of the tape"
                );
                return Err(Error::input("tape_wrong_layout", message));
            }
        };
        let segments: Vec<PlayedSegment> = sidecar
            .segments
            .into_iter()
            .map(|segment| PlayedSegment { segment, used: false })
            .collect();
        let progress = TapeProgress(Arc::new(Shared {
            exhausted: AtomicUsize::new(NONE),
            played_out: AtomicBool::new(false),
            play_next: AtomicBool::new(false),
            failed: OnceLock::new(),
        }));
        let adc = sidecar.adc;
        let source = Self { adc, scans, segments, dofs, armed: None, at: 0, end: 0, progress };
        Ok((source, warning))
    }

    /// The state of the replay, for the host.
    pub fn progress(&self) -> TapeProgress {
        self.progress.clone()
    }

    /// Moves to the next unused segment of a DOF.
    fn wind(&mut self, dof: usize) {
        let shared = &self.progress.0;
        shared.play_next.store(false, Ordering::Release);
        let name = self.dofs.get(dof);
        let next = self.segments.iter_mut().find(|s| !s.used && Some(&s.segment.dof) == name);
        let Some(next) = next else {
            (self.at, self.end) = (0, 0);
            shared.played_out.store(true, Ordering::Release);
            shared.exhausted.store(dof, Ordering::Release);
            return;
        };
        next.used = true;
        let start = next.segment.start;
        let following = self.segments.iter().map(|s| s.segment.start).filter(|&s| s > start).min();
        let following = following.unwrap_or(self.scans.count() + RECORD_SCANS as u64);
        self.at = start;
        self.end = following.max(self.at.saturating_add(SHORTEST_PLAY));
        shared.played_out.store(false, Ordering::Release);
        shared.exhausted.store(NONE, Ordering::Release);
    }
}

impl ScanSource for TapeSource {
    fn adc(&self) -> AdcProperties {
        self.adc
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        if self.armed.is_none_or(|(last, _)| last != arming) {
            self.armed = Some((arming, dof));
            self.wind(dof);
        }
    }

    fn next_scan(&mut self) -> Option<Scan> {
        if self.at >= self.end {
            self.progress.0.played_out.store(true, Ordering::Release);
            if self.progress.0.play_next.swap(false, Ordering::AcqRel)
                && let Some((_, dof)) = self.armed
            {
                self.wind(dof);
            }
        }
        if self.at >= self.end {
            return None;
        }
        let last = self.scans.count().checked_sub(1)?;
        let scan = match self.scans.get(self.at.min(last)) {
            Ok(scan) => scan?,
            Err(error) => {
                let _ = self.progress.0.failed.set(error.to_string());
                return None;
            }
        };
        let bits = self.adc.bits;
        if let Some(channel) = scan.iter().position(|code| u32::from(*code) >> bits > 0) {
            let _ = self.progress.0.failed.set(format!(
                "scan {} has the code {} in channel {channel}, more than {bits} bits; correct adc_bits in its sidecar",
                self.at, scan[channel]
            ));
            return None;
        }
        self.at += 1;
        Some(scan)
    }
}

/// Number of sensors whose three channels are all in use.
fn sensors(adc: &AdcProperties) -> usize {
    usize::from(adc.channels).min(CHANNELS).saturating_sub(1) / 3
}

#[cfg(test)]
mod tests;
