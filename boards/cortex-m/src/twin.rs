//! Two links, of which the host uses one: the link over which it has last sent something.

use core::fmt;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_futures::select::{Either, select};
use embedded_io_async::{Error, ErrorKind, ErrorType, Read, Write};
use massline_firmware::board::Link;

/// Ends an unfinished frame from the other link.
const DELIMITER: u8 = 0;

/// Both links. The first is used until the host sends something over the second.
pub struct TwinLink<A, B> {
    first: A,
    second: B,
    used: &'static ActiveLink,
}

/// The link that is in use.
#[derive(Debug, Default)]
pub struct ActiveLink {
    second: AtomicBool,
}

impl ActiveLink {
    /// The first link is in use.
    pub const fn new() -> Self {
        Self { second: AtomicBool::new(false) }
    }

    fn is(&self, side: Side) -> bool {
        self.second.load(Ordering::Relaxed) == (side == Side::Second)
    }

    /// Puts this link into use; returns true when the other one was used before.
    fn switch(&self, side: Side) -> bool {
        let second = side == Side::Second;
        self.second.swap(second, Ordering::Relaxed) != second
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    First,
    Second,
}

impl<A, B> TwinLink<A, B> {
    /// A link that combines two links.
    pub const fn new(first: A, second: B, used: &'static ActiveLink) -> Self {
        Self { first, second, used }
    }
}

impl<A: Link, B: Link> Link for TwinLink<A, B> {
    type Rx = TwinRx<A::Rx, B::Rx>;
    type Tx = TwinTx<A::Tx, B::Tx>;

    const STREAMS: bool = A::STREAMS && B::STREAMS;

    fn split(self) -> (Self::Rx, Self::Tx) {
        let Self { first, second, used } = self;
        let ((first_rx, first_tx), (second_rx, second_tx)) = (first.split(), second.split());
        let rx = TwinRx { first: first_rx, second: second_rx, used };
        (rx, TwinTx { first: first_tx, second: second_tx, used })
    }
}

/// From the host.
pub struct TwinRx<A, B> {
    first: A,
    second: B,
    used: &'static ActiveLink,
}

/// To the host.
pub struct TwinTx<A, B> {
    first: A,
    second: B,
    used: &'static ActiveLink,
}

/// Error of the link in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TwinError(ErrorKind);

impl fmt::Display for TwinError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the link has failed: {:?}", self.0)
    }
}

impl core::error::Error for TwinError {}

impl Error for TwinError {
    fn kind(&self) -> ErrorKind {
        self.0
    }
}

fn error(error: impl Error) -> TwinError {
    TwinError(error.kind())
}

impl<A, B> ErrorType for TwinRx<A, B> {
    type Error = TwinError;
}

impl<A: Read, B: Read> Read for TwinRx<A, B> {
    /// Reads bytes from either link. Reports a disconnection only of the link in use. Needs room for four
    /// bytes.
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, TwinError> {
        let middle = bytes.len() / 2;
        loop {
            // One byte before each part is for a delimiter.
            let (left, right) = bytes.split_at_mut(middle);
            let (left, right) = (&mut left[1..], &mut right[1..]);
            let (side, read, start) =
                match select(self.first.read(left), self.second.read(right)).await {
                    Either::First(read) => (Side::First, read.map_err(error), 0),
                    Either::Second(read) => (Side::Second, read.map_err(error), middle),
                };
            match read {
                Ok(0) | Err(_) if !self.used.is(side) => {}
                Ok(0) | Err(_) => return read,
                Ok(count) if self.used.switch(side) => {
                    bytes[start] = DELIMITER;
                    bytes.copy_within(start..=start + count, 0);
                    return Ok(count + 1);
                }
                Ok(count) => {
                    bytes.copy_within(start + 1..=start + count, 0);
                    return Ok(count);
                }
            }
        }
    }
}

impl<A, B> ErrorType for TwinTx<A, B> {
    type Error = TwinError;
}

impl<A: Write, B: Write> Write for TwinTx<A, B> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, TwinError> {
        if self.used.is(Side::First) {
            self.first.write(bytes).await.map_err(error)
        } else {
            self.second.write(bytes).await.map_err(error)
        }
    }

    async fn flush(&mut self) -> Result<(), TwinError> {
        if self.used.is(Side::First) {
            self.first.flush().await.map_err(error)
        } else {
            self.second.flush().await.map_err(error)
        }
    }
}

#[cfg(test)]
mod tests {
    use core::task::Poll;
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::rc::Rc;

    use embassy_futures::{block_on, poll_once};

    use super::*;

    /// What a host sends, piece by piece; an empty piece stands for a disconnection.
    #[derive(Clone, Default)]
    struct Wire {
        to_rig: Rc<RefCell<VecDeque<Vec<u8>>>>,
        to_host: Rc<RefCell<Vec<u8>>>,
    }

    impl Wire {
        fn send(&self, bytes: &[u8]) {
            self.to_rig.borrow_mut().push_back(bytes.to_vec());
        }
    }

    impl ErrorType for Wire {
        type Error = ErrorKind;
    }

    impl Read for Wire {
        async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, ErrorKind> {
            core::future::poll_fn(|_| {
                let mut pieces = self.to_rig.borrow_mut();
                let Some(mut piece) = pieces.pop_front() else { return Poll::Pending };
                let count = piece.len().min(bytes.len());
                bytes[..count].copy_from_slice(&piece[..count]);
                if count < piece.len() {
                    pieces.push_front(piece.split_off(count));
                }
                Poll::Ready(Ok(count))
            })
            .await
        }
    }

    impl Write for Wire {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
            self.to_host.borrow_mut().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        async fn flush(&mut self) -> Result<(), ErrorKind> {
            Ok(())
        }
    }

    impl Link for Wire {
        type Rx = Self;
        type Tx = Self;

        const STREAMS: bool = true;

        fn split(self) -> (Self, Self) {
            (self.clone(), self)
        }
    }

    struct Bench {
        first: Wire,
        second: Wire,
        rx: TwinRx<Wire, Wire>,
        tx: TwinTx<Wire, Wire>,
    }

    impl Bench {
        fn new() -> Self {
            let (first, second) = (Wire::default(), Wire::default());
            let used = Box::leak(Box::new(ActiveLink::new()));
            let (rx, tx) = TwinLink::new(first.clone(), second.clone(), used).split();
            Self { first, second, rx, tx }
        }

        /// The next piece, or `None` when there is nothing.
        fn read(&mut self) -> Option<Vec<u8>> {
            let mut bytes = [0xEE; 8];
            match poll_once(self.rx.read(&mut bytes)) {
                Poll::Ready(read) => Some(bytes[..read.unwrap()].to_vec()),
                Poll::Pending => None,
            }
        }
    }

    #[test]
    fn the_answer_goes_where_the_question_came_from() {
        let mut bench = Bench::new();
        for (text, second) in [("a", false), ("b", true), ("c", true), ("d", false)] {
            let wire = if second { &bench.second } else { &bench.first };
            wire.send(text.as_bytes());
            assert!(bench.read().unwrap().ends_with(text.as_bytes()));
            block_on(bench.tx.write_all(text.as_bytes())).unwrap();
        }
        assert_eq!(*bench.first.to_host.borrow(), b"ad");
        assert_eq!(*bench.second.to_host.borrow(), b"bc");
    }

    #[test]
    fn nothing_is_lost_and_a_change_of_the_link_ends_the_frame() {
        let mut bench = Bench::new();
        bench.first.send(b"half a fr");
        bench.second.send(b"whole\0");
        let mut received = Vec::new();
        while let Some(bytes) = bench.read() {
            received.extend(bytes);
        }
        assert_eq!(received, b"half a fr\0whole\0");
    }

    #[test]
    fn only_the_link_that_is_used_is_missed() {
        let mut bench = Bench::new();
        bench.second.send(b"");
        assert_eq!(bench.read(), None);
        bench.first.send(b"");
        assert_eq!(bench.read(), Some(vec![]));
        bench.second.send(b"x");
        assert_eq!(bench.read(), Some(b"\0x".to_vec()));
        bench.first.send(b"");
        assert_eq!(bench.read(), None);
        bench.second.send(b"");
        assert_eq!(bench.read(), Some(vec![]));
    }
}
