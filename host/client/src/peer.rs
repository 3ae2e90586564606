//! What the other side of a link has shown of itself before it has proved to be a rig.

use std::time::Duration;

use crate::error::ClientError;

/// How much of what it sends is looked at.
const LOOKED_AT: usize = 1024;
/// How much of it is shown.
const SHOWN: usize = 32;

/// The other side of a link.
#[derive(Debug, Default)]
pub(super) struct Peer {
    /// It has sent an answer or an event of the protocol.
    is_rig: bool,
    /// The first bytes that it sent.
    first: Vec<u8>,
    /// How often it has closed the link.
    closed: u32,
}

impl Peer {
    /// It has sent these bytes.
    pub fn sent(&mut self, bytes: &[u8]) {
        if !self.is_rig {
            let room = LOOKED_AT.saturating_sub(self.first.len());
            self.first.extend(bytes.iter().take(room));
        }
    }

    /// It has sent a message that only a rig sends.
    pub fn is_met(&mut self) {
        *self = Self { is_rig: true, ..Self::default() };
    }

    /// True where it has sent something that a rig has not, so far.
    pub fn is_strange(&self) -> bool {
        !self.is_rig && !self.first.is_empty()
    }

    /// It has closed the link, or the link was lost.
    pub fn left(&mut self) {
        self.closed += 1;
    }

    /// Why this is no rig, after it was sent `request`, `attempts` times in all; `None` for a rig, and when it has
    /// shown nothing.
    pub fn stranger(
        &self,
        port: &str,
        request: &[u8],
        attempts: u32,
        waited: Duration,
    ) -> Option<ClientError> {
        let port = port.to_owned();
        let is_echo =
            !request.is_empty() && self.first.windows(request.len()).any(|bytes| bytes == request);
        match () {
            () if self.is_rig => None,
            () if is_echo => Some(ClientError::Echo { port }),
            () if !self.first.is_empty() => {
                Some(ClientError::NoRig { port, first: quote_start(&self.first) })
            }
            () if self.closed >= attempts => Some(ClientError::Closing { port, attempts, waited }),
            () => None,
        }
    }
}

/// The first bytes as text, with an escape for what is no text.
fn quote_start(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(SHOWN)];
    let ellipsis = if bytes.len() > SHOWN { "…" } else { "" };
    format!("\"{}{ellipsis}\"", start.escape_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;

    const REQUEST: &[u8] = b"\x01\x02\x03";

    fn code(peer: &Peer) -> Option<&'static str> {
        peer.stranger("p", REQUEST, 5, Duration::ZERO).map(|error| error.code())
    }

    #[test]
    fn a_rig_is_no_stranger_and_silence_shows_nothing() {
        let mut peer = Peer::default();
        assert_eq!(code(&peer), None);
        peer.sent(b"half a frame of the stream before");
        peer.is_met();
        peer.sent(b"garbage");
        assert_eq!(code(&peer), None);
    }

    #[test]
    fn an_echo_is_found_within_other_bytes() {
        let mut peer = Peer::default();
        peer.sent(b"login: ");
        assert_eq!(code(&peer), Some("not_a_rig"));
        peer.sent(b"\x01\x02");
        peer.sent(b"\x03");
        assert_eq!(code(&peer), Some("echo"));
    }

    #[test]
    fn one_that_closes_every_time_is_told_from_a_link_that_was_lost_once() {
        let mut peer = Peer::default();
        peer.left();
        assert_eq!(code(&peer), None);
        (0..4).for_each(|_| peer.left());
        assert_eq!(code(&peer), Some("connection_closed"));
    }

    #[test]
    fn the_first_bytes_are_shown_with_escapes() {
        assert_eq!(quote_start(b"$GPGGA,1\r\n"), "\"$GPGGA,1\\r\\n\"");
        assert_eq!(quote_start(&[0xFF; 33]), format!("\"{}…\"", "\\xff".repeat(32)));
    }
}
