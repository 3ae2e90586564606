//! The exchange with a rig: a request and its answer, events, and a link that is lost and comes back.

use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::time::{Duration, Instant};

use massline_protocol::event::{HIT, HitEvent, SCANS, STATUS_CHANGED, ScanBlock};
use massline_protocol::message::{ANSWER, REFUSED, Status};
use massline_protocol::{Deframer, Endpoint, Frame, MAX_FRAME, Refusal, encode_frame};

use super::error::seconds;
use super::peer::Peer;
use super::purpose::purpose;
use crate::error::ClientError;
use crate::interrupt::Interrupt;
use crate::transport::Transport;

/// Capacity of the event queue; when it is full the oldest event is dropped.
const EVENT_QUEUE: usize = 8192;

/// Time between two looks at the interrupt.
const LOOK: Duration = Duration::from_millis(50);

/// Timeouts and attempts of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Timeout for the answer to one transmission of a request.
    pub answer: Duration,
    /// How often a request is sent before the client gives up.
    pub attempts: u32,
    /// Timeout for a lost link to come back.
    pub reconnect: Duration,
    /// Pause between two attempts to reopen a lost link.
    pub pause: Duration,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            answer: Duration::from_millis(1500),
            attempts: 5,
            reconnect: Duration::from_secs(10),
            pause: Duration::from_millis(100),
        }
    }
}

/// An event that the rig sends unasked.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The status has changed.
    Status(Status),
    /// A hit was graded.
    Hit(HitEvent),
    /// A block of streamed scans.
    Scans(Box<ScanBlock>),
}

/// A rig behind a [`Transport`].
pub struct Client {
    transport: Box<dyn Transport>,
    deframer: Box<Deframer>,
    /// Bytes that were received but not yet parsed.
    unread: VecDeque<u8>,
    sequence: u16,
    /// Whether the other side is a rig.
    peer: Peer,
    events: VecDeque<Event>,
    timing: Timing,
    broken_frames: u64,
    reconnects: u64,
    /// Told what the client waits for.
    listener: Box<dyn FnMut(&str) + Send>,
    /// Ends a wait.
    interrupt: Interrupt,
}

impl std::fmt::Debug for Client {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Client").field("port", &self.transport.name()).finish_non_exhaustive()
    }
}

impl Client {
    /// A client that has not sent anything yet.
    pub fn new(transport: impl Transport + 'static) -> Self {
        Self::with_timing(transport, Timing::default())
    }

    /// A client with other timeouts.
    pub fn with_timing(transport: impl Transport + 'static, timing: Timing) -> Self {
        Self {
            transport: Box::new(transport),
            deframer: Box::default(),
            unread: VecDeque::new(),
            // A random start keeps a rig from mistaking the first request of this client for a repetition of
            // another client's last request.
            sequence: RandomState::new().hash_one(0) as u16,
            peer: Peer::default(),
            events: VecDeque::new(),
            timing,
            broken_frames: 0,
            reconnects: 0,
            listener: Box::new(|_| ()),
            interrupt: Interrupt::new(),
        }
    }

    /// Timeouts and attempts of this client.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Tells `listener` from now on, in sentences for people, while the rig does not answer or the link is lost.
    pub fn telling(mut self, listener: impl FnMut(&str) + Send + 'static) -> Self {
        self.listener = Box::new(listener);
        self
    }

    /// Once `interrupt` has been pressed, a silent rig is asked only once, and a lost link is not waited for.
    pub fn interrupted_by(mut self, interrupt: Interrupt) -> Self {
        self.interrupt = interrupt;
        self
    }

    /// Name of the port.
    pub fn port(&self) -> &str {
        self.transport.name()
    }

    /// Number of frames received corrupt.
    pub fn broken_frames(&self) -> u64 {
        self.broken_frames
    }

    /// How often the link was reopened.
    pub fn reconnects(&self) -> u64 {
        self.reconnects
    }

    /// Sends a request and waits for its answer; repeats the request while no answer comes.
    ///
    /// # Errors
    /// When the rig refuses, does not answer, the link is lost for good, or the wait for either is interrupted.
    pub fn ask<E: Endpoint>(&mut self, request: &E::Request) -> Result<E::Response, ClientError> {
        let name = purpose(E::KIND);
        self.sequence = self.sequence.wrapping_add(1);
        let sequence = self.sequence;
        let mut frame = [0; MAX_FRAME];
        let length = encode_frame(E::KIND, sequence, request, &mut frame)
            .map_err(|_| ClientError::TooLong { request: name })?;
        // The leading zero ends a partial frame that a lost link may have left on the other side.
        let mut bytes = vec![0];
        bytes.extend_from_slice(&frame[..length]);

        let started = Instant::now();
        let attempts = self.timing.attempts.max(1);
        for attempt in 1..=attempts {
            // An interrupted command still has something to ask, such as for a pause.
            let is_overdue = attempt > 1;
            if is_overdue {
                self.unless_interrupted(|| "did not answer".into())?;
                let (port, waited) = (self.transport.name(), seconds(started.elapsed()));
                let missing =
                    if self.peer.is_strange() { "no answer of a rig" } else { "no answer" };
                let notice = format!(
                    "{missing} from {port} for {waited}; asking again ({attempt} of {attempts})"
                );
                (self.listener)(&notice);
            }
            self.send(&bytes)?;
            let deadline = Instant::now() + self.timing.answer;
            while let Some(message) = self.next_message(deadline, is_overdue)? {
                let Message::Answer { kind, sequence: to, body } = message else { continue };
                if to != sequence {
                    continue;
                }
                if kind == E::KIND | ANSWER {
                    if let Ok(answer) = postcard::from_bytes(&body) {
                        return Ok(answer);
                    }
                    self.broken_frames += 1;
                } else if kind == REFUSED
                    && let Ok(Refusal { reason, results_to_delete }) = postcard::from_bytes(&body)
                {
                    return Err(ClientError::Refused { request: name, reason, results_to_delete });
                }
            }
        }
        let (port, waited) = (self.port(), started.elapsed());
        let stranger = self.peer.stranger(port, &frame[..length], attempts, waited);
        Err(stranger.unwrap_or_else(|| ClientError::NoAnswer {
            port: port.into(),
            request: name,
            attempts,
            waited,
        }))
    }

    /// The next event, waiting up to `timeout` for it.
    ///
    /// # Errors
    /// When the link is lost for good.
    pub fn next_event(&mut self, timeout: Duration) -> Result<Option<Event>, ClientError> {
        let deadline = Instant::now() + timeout;
        while self.events.is_empty() {
            // An answer that no request waits for any more is dropped here.
            if self.next_message(deadline, false)?.is_none() {
                break;
            }
        }
        Ok(self.events.pop_front())
    }

    /// Drops the statuses in the queue, because the caller has just received a newer one.
    pub fn discard_statuses(&mut self) {
        self.events.retain(|event| !matches!(event, Event::Status(_)));
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), ClientError> {
        match self.transport.write_all(bytes) {
            Ok(()) => Ok(()),
            Err(lost) => {
                self.reopen(&lost)?;
                // If the link is lost again at once, no answer comes and the request is repeated.
                let _ = self.transport.write_all(bytes);
                Ok(())
            }
        }
    }

    /// The next message that is complete before `deadline`; an event goes to the queue. The wait for an answer that
    /// `is_overdue` can be interrupted.
    fn next_message(
        &mut self,
        deadline: Instant,
        is_overdue: bool,
    ) -> Result<Option<Message>, ClientError> {
        loop {
            if is_overdue {
                self.unless_interrupted(|| "did not answer".into())?;
            }
            while !self.unread.is_empty() {
                let (bytes, _) = self.unread.as_slices();
                let (taken, frame) = self.deframer.push(bytes);
                let message = match frame {
                    Some(Ok(frame)) => Message::read(frame),
                    Some(Err(_)) => Some(Message::Broken),
                    None => None,
                };
                self.unread.drain(..taken);
                if matches!(message, Some(Message::Event(_) | Message::Answer { .. })) {
                    self.peer.is_met();
                }
                match message {
                    Some(Message::Event(event)) => {
                        if self.events.len() == EVENT_QUEUE {
                            self.events.pop_front();
                        }
                        self.events.push_back(*event);
                        return Ok(Some(Message::Queued));
                    }
                    Some(Message::Broken) => self.broken_frames += 1,
                    Some(message) => return Ok(Some(message)),
                    None => {}
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            let mut buffer = [0; 4096];
            match self.transport.read(&mut buffer, left.min(LOOK)) {
                Ok(0) if Instant::now() >= deadline => return Ok(None),
                Ok(n) => {
                    self.peer.sent(&buffer[..n]);
                    self.unread.extend(&buffer[..n]);
                }
                Err(lost) => {
                    self.reopen(&lost)?;
                    // A request sent on the old link gets no answer on the new one.
                    return Ok(None);
                }
            }
        }
    }

    fn reopen(&mut self, lost: &io::Error) -> Result<(), ClientError> {
        let started = Instant::now();
        self.peer.left();
        self.unread.clear();
        *self.deframer = Deframer::new();
        let (port, reconnect) = (self.port().to_owned(), self.timing.reconnect);
        let mut is_reported = false;
        loop {
            match self.transport.reconnect() {
                Ok(()) => {
                    self.reconnects += 1;
                    if is_reported {
                        (self.listener)(&format!("{port} is back"));
                    }
                    return Ok(());
                }
                Err(e)
                    if e.kind() != io::ErrorKind::Unsupported
                        && started.elapsed() < self.timing.reconnect =>
                {
                    if !is_reported {
                        let problem = match e.kind() {
                            io::ErrorKind::ResourceBusy => "is in use by another program".into(),
                            _ => format!("is gone ({lost}): connect the rig again"),
                        };
                        (self.listener)(&format!(
                            "{port} {problem}; waiting up to {} for it",
                            seconds(reconnect)
                        ));
                        is_reported = true;
                    }
                    self.unless_interrupted(|| format!("was gone ({lost})"))?;
                    std::thread::sleep(self.timing.pause);
                }
                Err(e) if e.kind() == io::ErrorKind::ResourceBusy => {
                    return Err(ClientError::PortBusy { port, reason: e.to_string() });
                }
                Err(_) => {
                    let waited = started.elapsed();
                    let stranger = self.peer.stranger(&port, &[], u32::MAX, waited);
                    let reason = lost.to_string();
                    return Err(stranger.unwrap_or(ClientError::Lost { port, reason, waited }));
                }
            }
        }
    }

    /// An error once a wait for a rig in this state is interrupted.
    fn unless_interrupted(&self, state: impl FnOnce() -> String) -> Result<(), ClientError> {
        match self.interrupt.pressed() {
            true => Err(ClientError::Interrupted { port: self.port().into(), state: state() }),
            false => Ok(()),
        }
    }
}

/// The content of one frame.
enum Message {
    Answer {
        kind: u16,
        sequence: u16,
        body: Vec<u8>,
    },
    Event(Box<Event>),
    /// An event that was put in the queue.
    Queued,
    Broken,
}

impl Message {
    fn read(frame: Frame<'_>) -> Option<Self> {
        let event = match frame.kind {
            STATUS_CHANGED => postcard::from_bytes(frame.body).map(Event::Status),
            HIT => postcard::from_bytes(frame.body).map(Event::Hit),
            SCANS => postcard::from_bytes(frame.body).map(|block| Event::Scans(Box::new(block))),
            kind if kind & ANSWER != 0 => {
                return Some(Self::Answer {
                    kind,
                    sequence: frame.sequence,
                    body: frame.body.to_vec(),
                });
            }
            // An event of a newer rig, which this program does not need.
            _ => return None,
        };
        Some(event.map_or(Self::Broken, |event| Self::Event(Box::new(event))))
    }
}
