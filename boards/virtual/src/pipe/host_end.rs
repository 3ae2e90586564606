//! The blocking end of the pipe.

use std::fmt;
use std::io::{self, Read, Write};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use super::{Direction, Filter, SharedPipe, State};

/// The host's end: reads and writes like a serial port. Clones are the same end.
///
/// Errors of `read` and `write`: `TimedOut` when nothing could be transferred in time, `NotConnected`
/// while unplugged, `BrokenPipe` when the rig has ended and everything that it sent has been read.
#[derive(Clone)]
pub struct HostEnd {
    shared: Arc<SharedPipe>,
    timeout: Duration,
}

impl fmt::Debug for HostEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HostEnd").field("timeout", &self.timeout).finish_non_exhaustive()
    }
}

impl HostEnd {
    pub(super) fn new(shared: Arc<SharedPipe>) -> Self {
        Self { shared, timeout: Duration::from_secs(1) }
    }

    /// Sets how long `read` and `write` of this clone wait; initially 1 s.
    pub fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }

    /// Pulls the plug: bytes in transit in both directions are lost.
    pub fn unplug(&self) {
        let mut state = self.shared.lock();
        if state.plugged {
            state.plugged = false;
            state.pulled = true;
            state.cut_off = state.writing;
            state.to_rig.clear();
            state.to_host.clear();
            state.wake_rig();
            self.shared.changed.notify_all();
        }
    }

    /// Puts the plug back.
    pub fn plug(&self) {
        self.shared.lock().plugged = true;
    }

    /// False after [`unplug`](Self::unplug).
    pub fn is_plugged(&self) -> bool {
        self.shared.lock().plugged
    }

    /// Passes whatever is written in this direction from now on through `filter`.
    pub fn set_filter(&self, direction: Direction, filter: Option<Filter>) {
        self.shared.lock().lane(direction).filter = filter;
    }

    /// Waits until the rig has read everything that was written to it; false when it has not within the
    /// timeout of this clone.
    pub fn drained(&self) -> bool {
        let state = self.shared.lock();
        let full = |state: &mut State| !state.to_rig.bytes.is_empty();
        let waited = self.shared.changed.wait_timeout_while(state, self.timeout, full);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Repeats `attempt` until it transfers at least one byte or the timeout expires.
    fn until_done(&self, mut attempt: impl FnMut(&mut State) -> usize) -> io::Result<usize> {
        let deadline = Instant::now() + self.timeout;
        let mut state = self.shared.lock();
        loop {
            if !state.plugged {
                return Err(failure(io::ErrorKind::NotConnected, "the rig is unplugged"));
            }
            match attempt(&mut state) {
                0 if state.rig_ended => {
                    return Err(failure(io::ErrorKind::BrokenPipe, "the rig has stopped"));
                }
                0 => {}
                count => {
                    state.wake_rig();
                    return Ok(count);
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(failure(io::ErrorKind::TimedOut, "the rig did not answer in time"));
            }
            state = self
                .shared
                .changed
                .wait_timeout(state, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }
}

fn failure(kind: io::ErrorKind, text: &'static str) -> io::Error {
    io::Error::new(kind, text)
}

impl Read for HostEnd {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        if buf.is_empty() {
            return Ok(0);
        }
        self.until_done(|state| state.to_host.take(buf))
    }
}

impl Write for HostEnd {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        if buf.is_empty() {
            return Ok(0);
        }
        self.until_done(|state| if state.rig_ended { 0 } else { state.to_rig.put(buf) })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;
    use super::*;
    use embassy_futures::block_on;
    use embassy_futures::poll_once;
    use embedded_io_async::{Read as _, Write as _};
    use massline_firmware::board::Link;
    use std::thread;

    const SOON: Duration = Duration::from_millis(1);
    /// Never reached unless something hangs.
    const LATE: Duration = Duration::from_secs(60);

    fn open(capacity: usize) -> (RigRx, RigTx, HostEnd) {
        let (link, mut host) = pipe(capacity);
        host.set_timeout(LATE);
        let (rx, tx) = link.split();
        (rx, tx, host)
    }

    fn read_host(host: &mut HostEnd) -> Vec<u8> {
        let mut buffer = [0; 64];
        let count = io::Read::read(host, &mut buffer).unwrap();
        buffer[..count].to_vec()
    }

    fn read_rig(rx: &mut RigRx) -> Vec<u8> {
        let mut buffer = [0; 64];
        let count = block_on(rx.read(&mut buffer)).unwrap();
        buffer[..count].to_vec()
    }

    #[test]
    fn bytes_go_both_ways() {
        let (mut rx, mut tx, mut host) = open(64);
        host.write_all(b"ping").unwrap();
        assert_eq!(read_rig(&mut rx), b"ping");
        block_on(tx.write_all(b"pong")).unwrap();
        assert_eq!(read_host(&mut host), b"pong");
    }

    #[test]
    fn many_bytes_pass_a_pipe_of_seven() {
        let (mut rx, mut tx, host) = open(7);
        let echo = thread::spawn(move || {
            block_on(async {
                let (mut buffer, mut left) = ([0; 100], 1 << 16);
                while left > 0 {
                    let count = rx.read(&mut buffer).await.unwrap();
                    tx.write_all(&buffer[..count]).await.unwrap();
                    left -= count;
                }
            });
        });
        let sent: Vec<u8> = (0..1 << 16_u32).map(|i| (i * 7 / 3) as u8).collect();
        let (mut writer, bytes) = (host.clone(), sent.clone());
        let write = thread::spawn(move || writer.write_all(&bytes).unwrap());
        let mut received = vec![0; sent.len()];
        (&mut host.clone() as &mut dyn io::Read).read_exact(&mut received).unwrap();
        assert!(received == sent);
        write.join().unwrap();
        echo.join().unwrap();
    }

    #[test]
    fn a_full_pipe_makes_the_rig_wait_and_the_host_time_out() {
        let (_rx, mut tx, mut host) = open(4);
        assert_eq!(block_on(tx.write(b"abcdef")).unwrap(), 4);
        assert!(poll_once(tx.write(b"ef")).is_pending());
        assert_eq!(read_host(&mut host), b"abcd");
        assert!(poll_once(tx.write(b"ef")).is_ready());
        host.set_timeout(SOON);
        assert_eq!(io::Write::write(&mut host, b"123456").unwrap(), 4);
        let error = io::Write::write(&mut host, b"56").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    }

    #[test]
    fn a_read_of_nothing_times_out() {
        let (_rx, _tx, mut host) = open(4);
        host.set_timeout(SOON);
        let error = io::Read::read(&mut host, &mut [0; 4]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    }

    #[test]
    fn what_the_rig_has_taken_is_drained() {
        let (mut rx, _tx, mut host) = open(64);
        assert!(host.drained());
        host.write_all(b"ping").unwrap();
        host.set_timeout(SOON);
        assert!(!host.drained());
        read_rig(&mut rx);
        assert!(host.drained());
    }

    #[test]
    fn a_pulled_plug_loses_the_bytes_on_the_way_and_is_reported_once() {
        let (mut rx, mut tx, mut host) = open(64);
        host.write_all(b"lost").unwrap();
        block_on(tx.write_all(b"lost")).unwrap();
        host.unplug();
        assert_eq!(
            io::Write::write(&mut host, b"x").unwrap_err().kind(),
            io::ErrorKind::NotConnected
        );
        assert_eq!(block_on(tx.write(b"x")), Err(UnpluggedError));
        assert_eq!(block_on(rx.read(&mut [0; 8])), Err(UnpluggedError));
        assert!(poll_once(rx.read(&mut [0; 8])).is_pending());
        host.plug();
        host.write_all(b"here").unwrap();
        assert_eq!(read_rig(&mut rx), b"here");
        block_on(tx.write_all(b"there")).unwrap();
        assert_eq!(read_host(&mut host), b"there");
    }

    #[test]
    fn a_write_that_waits_when_the_plug_is_pulled_fails_although_it_is_back_at_once() {
        let (_rx, mut tx, mut host) = open(4);
        assert_eq!(block_on(tx.write(b"abcd")).unwrap(), 4);
        {
            let mut waits = std::pin::pin!(tx.write(b"ef"));
            assert!(poll_once(&mut waits).is_pending());
            host.unplug();
            host.plug();
            assert_eq!(block_on(waits), Err(UnpluggedError));
        }
        block_on(tx.write_all(b"gh")).unwrap();
        assert_eq!(read_host(&mut host), b"gh");
    }

    #[test]
    fn a_plug_that_is_back_at_once_is_still_seen() {
        let (mut rx, _tx, mut host) = open(64);
        host.unplug();
        host.plug();
        host.write_all(b"new").unwrap();
        assert_eq!(block_on(rx.read(&mut [0; 8])), Err(UnpluggedError));
        assert_eq!(read_rig(&mut rx), b"new");
    }

    #[test]
    fn a_rig_that_ends_is_seen_after_its_last_words() {
        let (rx, mut tx, mut host) = open(64);
        block_on(tx.write_all(b"bye")).unwrap();
        drop((rx, tx));
        assert_eq!(read_host(&mut host), b"bye");
        let error = io::Read::read(&mut host, &mut [0; 8]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
        let error = io::Write::write(&mut host, b"x").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
    }

    #[test]
    fn a_filter_changes_drops_doubles_and_cuts() {
        let (mut rx, _tx, mut host) = open(64);
        host.set_filter(
            Direction::ToRig,
            Some(Box::new(|bytes| match bytes {
                b"drop" => vec![],
                b"double" => vec![bytes.to_vec(), bytes.to_vec()],
                _ => bytes.iter().map(|b| vec![b.to_ascii_uppercase()]).collect(),
            })),
        );
        for text in [&b"drop"[..], b"double", b"ab"] {
            host.write_all(text).unwrap();
        }
        let read: Vec<Vec<u8>> = (0..4).map(|_| read_rig(&mut rx)).collect();
        assert_eq!(read, [&b"double"[..], b"double", b"A", b"B"]);
        host.set_filter(Direction::ToRig, None);
        host.write_all(b"drop").unwrap();
        assert_eq!(read_rig(&mut rx), b"drop");
    }
}
