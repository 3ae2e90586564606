//! The link of the virtual rig: a duplex pipe of bytes in memory, asynchronous at the rig's end and
//! blocking at the host's.
//!
//! ```text
//! rig ── RigTx ─▶ filter ─▶ bytes ─▶ HostEnd::read      HostEnd::write ─▶ filter ─▶ bytes ─▶ RigRx ── rig
//! ```
//! Each direction holds a bounded number of bytes; a writer waits for room. The host can pull the plug:
//! bytes in transit are lost, the rig gets one error, then nothing until the plug is back. A [`Filter`]
//! in each direction may drop, double, change and cut bytes ([`faults`] has one that does so at random).
//! so at random).

pub mod faults;
mod host_end;
mod rig_end;

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

pub use host_end::HostEnd;
pub use rig_end::{Backlog, PipeLink, RigRx, RigTx, UnpluggedError};

/// Default capacity of each direction of the pipe, bytes: that of a serial driver.
pub const DEFAULT_CAPACITY: usize = 64 * 1024;

/// What happens to the bytes of one write: returns the pieces that arrive. A read never crosses the
/// boundary between two pieces.
pub type Filter = Box<dyn FnMut(&[u8]) -> Vec<Vec<u8>> + Send>;

/// A direction of the pipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the host to the rig.
    ToRig,
    /// From the rig to the host.
    ToHost,
}

/// A pipe whose directions hold `capacity` bytes each: the rig's end and the host's end, plugged in.
pub fn pipe(capacity: usize) -> (PipeLink, HostEnd) {
    let shared = Arc::new(SharedPipe {
        state: Mutex::new(State {
            to_rig: Lane::new(capacity),
            to_host: Lane::new(capacity),
            plugged: true,
            pulled: false,
            writing: false,
            cut_off: false,
            rig_ended: false,
            rig_reader: None,
            rig_writer: None,
            rig_pacer: None,
        }),
        changed: Condvar::new(),
    });
    (PipeLink::new(shared.clone()), HostEnd::new(shared))
}

struct SharedPipe {
    state: Mutex<State>,
    /// Notified of every change that a host may be waiting for.
    changed: Condvar,
}

struct State {
    to_rig: Lane,
    to_host: Lane,
    plugged: bool,
    /// The plug was pulled and the rig's reader has not yet got the error.
    pulled: bool,
    /// The rig is in the middle of a write, or has abandoned one.
    writing: bool,
    /// The plug was pulled in the middle of that write.
    cut_off: bool,
    /// The rig has dropped its end.
    rig_ended: bool,
    rig_reader: Option<Waker>,
    rig_writer: Option<Waker>,
    /// The rig's task that waits for the host to read.
    rig_pacer: Option<Waker>,
}

impl SharedPipe {
    /// A panic elsewhere leaves the state consistent: every change is complete before anything can fail.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn lane(&mut self, direction: Direction) -> &mut Lane {
        match direction {
            Direction::ToRig => &mut self.to_rig,
            Direction::ToHost => &mut self.to_host,
        }
    }

    fn wake_rig(&mut self) {
        let wakers = [&mut self.rig_reader, &mut self.rig_writer, &mut self.rig_pacer];
        for waker in wakers.into_iter().filter_map(Option::take) {
            waker.wake();
        }
    }
}

/// Stores the waker and returns pending.
fn wait<T>(waker: &mut Option<Waker>, cx: &Context<'_>) -> Poll<T> {
    *waker = Some(cx.waker().clone());
    Poll::Pending
}

/// The bytes in transit in one direction.
struct Lane {
    capacity: usize,
    bytes: VecDeque<u8>,
    /// Ends of the pieces, as counts of bytes queued since the start.
    ends: VecDeque<u64>,
    /// Bytes taken since the start.
    taken: u64,
    filter: Option<Filter>,
}

impl Lane {
    fn new(capacity: usize) -> Self {
        Self {
            capacity: capacity.max(1),
            bytes: VecDeque::new(),
            ends: VecDeque::new(),
            taken: 0,
            filter: None,
        }
    }

    /// Queues as many of `bytes` as there is room for and returns how many.
    fn put(&mut self, bytes: &[u8]) -> usize {
        let room = self.capacity.saturating_sub(self.bytes.len());
        let accepted = &bytes[..bytes.len().min(room)];
        match &mut self.filter {
            _ if accepted.is_empty() => {}
            None => self.bytes.extend(accepted),
            Some(filter) => {
                for piece in filter(accepted) {
                    self.bytes.extend(piece);
                    self.ends.push_back(self.taken + self.bytes.len() as u64);
                }
            }
        }
        accepted.len()
    }

    /// Moves bytes into `out`, up to the end of a piece, and returns how many.
    fn take(&mut self, out: &mut [u8]) -> usize {
        while self.ends.front().is_some_and(|&end| end <= self.taken) {
            self.ends.pop_front();
        }
        let piece = self.ends.front().map_or(usize::MAX, |end| (end - self.taken) as usize);
        let count = out.len().min(self.bytes.len()).min(piece);
        for (place, byte) in out.iter_mut().zip(self.bytes.drain(..count)) {
            *place = byte;
        }
        self.taken += count as u64;
        count
    }

    fn clear(&mut self) {
        self.taken += self.bytes.len() as u64;
        self.bytes.clear();
        self.ends.clear();
    }
}
