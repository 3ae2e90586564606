//! Frames mark where a message starts and ends, and show whether it arrived intact.

use core::fmt;

use crate::checksum::crc32;

/// Largest body of a message, bytes.
pub const MAX_BODY: usize = 1200;
const HEADER: usize = 4;
const CHECKSUM: usize = 4;
const MAX_PLAIN: usize = HEADER + MAX_BODY + CHECKSUM;
/// Largest encoded frame, bytes, including its closing zero.
pub const MAX_FRAME: usize = cobs::max_encoding_length(MAX_PLAIN) + 1;

/// A message that arrived intact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Kind of the message.
    pub kind: u16,
    /// Sequence number; an answer has that of its request.
    pub sequence: u16,
    /// The postcard bytes of the message.
    pub body: &'a [u8],
}

/// Why the bytes between two zeros are not a frame, or why a message does not fit into one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`MAX_FRAME`].
    TooLong,
    /// Too short for header and checksum.
    TooShort,
    /// Not valid COBS.
    BadStuffing,
    /// The checksum differs.
    BadChecksum,
    /// The body could not be encoded.
    BadBody,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooLong => "frame too long",
            Self::TooShort => "frame too short",
            Self::BadStuffing => "frame is not COBS",
            Self::BadChecksum => "frame checksum differs",
            Self::BadBody => "message body does not encode",
        })
    }
}

impl core::error::Error for FrameError {}

/// A frame before COBS encoding: 1.1 kB of stack. It does not borrow the message, so the message may lie in
/// the very buffer that receives the frame.
pub struct PlainFrame {
    bytes: [u8; MAX_PLAIN],
    length: usize,
}

impl PlainFrame {
    /// Builds a frame from header, postcard bytes of `message` and checksum.
    ///
    /// # Errors
    /// [`FrameError::BadBody`] when the message takes more than [`MAX_BODY`] bytes.
    pub fn new<T: serde::Serialize + ?Sized>(
        kind: u16,
        sequence: u16,
        message: &T,
    ) -> Result<Self, FrameError> {
        let mut plain = Self { bytes: [0; MAX_PLAIN], length: 0 };
        plain.fill(kind, sequence, message)?;
        Ok(plain)
    }

    fn fill<T: serde::Serialize + ?Sized>(
        &mut self,
        kind: u16,
        sequence: u16,
        message: &T,
    ) -> Result<(), FrameError> {
        let bytes = &mut self.bytes;
        bytes[..2].copy_from_slice(&kind.to_le_bytes());
        bytes[2..HEADER].copy_from_slice(&sequence.to_le_bytes());
        let body = postcard::to_slice(message, &mut bytes[HEADER..HEADER + MAX_BODY])
            .map_err(|_| FrameError::BadBody)?
            .len();
        let end = HEADER + body;
        let checksum = crc32(&bytes[..end]);
        bytes[end..end + CHECKSUM].copy_from_slice(&checksum.to_le_bytes());
        self.length = end + CHECKSUM;
        Ok(())
    }

    /// Writes the encoded frame and its closing zero into `out`; returns the length.
    pub fn stuff(&self, out: &mut [u8; MAX_FRAME]) -> usize {
        let length = cobs::encode(&self.bytes[..self.length], &mut out[..MAX_FRAME - 1]);
        out[length] = 0;
        length + 1
    }
}

/// Encodes `message` with postcard and writes it as a frame into `out`; returns the length.
///
/// # Errors
/// [`FrameError::BadBody`] when the message takes more than [`MAX_BODY`] bytes.
pub fn encode_frame<T: serde::Serialize + ?Sized>(
    kind: u16,
    sequence: u16,
    message: &T,
    out: &mut [u8; MAX_FRAME],
) -> Result<usize, FrameError> {
    // Built in place: a frame passed by value would be on the stack twice.
    let mut plain = PlainFrame { bytes: [0; MAX_PLAIN], length: 0 };
    plain.fill(kind, sequence, message)?;
    Ok(plain.stuff(out))
}

/// Decodes `bytes` (everything between two zeros) in place and checks the frame.
///
/// # Errors
/// [`FrameError`] when the bytes are not an intact frame.
pub fn decode_frame(bytes: &mut [u8]) -> Result<Frame<'_>, FrameError> {
    let length = cobs::decode_in_place(bytes).map_err(|_| FrameError::BadStuffing)?;
    let plain = bytes.get(..length).ok_or(FrameError::BadStuffing)?;
    let end =
        length.checked_sub(CHECKSUM).filter(|&end| end >= HEADER).ok_or(FrameError::TooShort)?;
    let (content, checksum) = plain.split_at(end);
    if crc32(content).to_le_bytes() != checksum {
        return Err(FrameError::BadChecksum);
    }
    Ok(Frame {
        kind: u16::from_le_bytes([content[0], content[1]]),
        sequence: u16::from_le_bytes([content[2], content[3]]),
        body: &content[HEADER..],
    })
}

/// Finds frames in a stream of bytes.
///
/// A zero byte always ends a frame, so after garbage, a broken link or a restart of either side the next zero
/// restores synchronization.
#[derive(Debug)]
pub struct Deframer {
    buffer: [u8; MAX_FRAME],
    length: usize,
    overlong: bool,
    complete: bool,
}

impl Default for Deframer {
    fn default() -> Self {
        Self::new()
    }
}

impl Deframer {
    /// An empty deframer.
    pub const fn new() -> Self {
        Self { buffer: [0; MAX_FRAME], length: 0, overlong: false, complete: false }
    }

    /// Takes bytes up to the end of the next frame. Returns how many it took and, when a frame ended, the
    /// frame or its error. Call it again with the rest. It never takes 0 bytes of a non-empty slice.
    pub fn push(&mut self, bytes: &[u8]) -> (usize, Option<Result<Frame<'_>, FrameError>>) {
        if self.complete {
            self.clear();
        }
        let Some(end) = bytes.iter().position(|&b| b == 0) else {
            self.store(bytes);
            return (bytes.len(), None);
        };
        self.store(&bytes[..end]);
        let taken = end + 1;
        self.complete = true;
        if self.overlong {
            return (taken, Some(Err(FrameError::TooLong)));
        }
        if self.length == 0 {
            // Padding between frames.
            return (taken, None);
        }
        let length = self.length;
        (taken, Some(decode_frame(&mut self.buffer[..length])))
    }

    fn store(&mut self, bytes: &[u8]) {
        match self.buffer.get_mut(self.length..self.length + bytes.len()) {
            Some(room) if !self.overlong => {
                room.copy_from_slice(bytes);
                self.length += bytes.len();
            }
            _ => self.overlong = true,
        }
    }

    fn clear(&mut self) {
        self.length = 0;
        self.overlong = false;
        self.complete = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn frame(kind: u16, sequence: u16, body: &[u8]) -> Vec<u8> {
        let mut out = [0; MAX_FRAME];
        let n = encode_frame(kind, sequence, body, &mut out).unwrap();
        out[..n].to_vec()
    }

    fn frames_in(bytes: &[u8], piece: usize) -> (Vec<(u16, u16)>, usize) {
        let mut deframer = Deframer::new();
        let (mut good, mut bad) = (Vec::new(), 0);
        for piece in bytes.chunks(piece.max(1)) {
            let mut rest = piece;
            while !rest.is_empty() {
                let (taken, frame) = deframer.push(rest);
                match frame {
                    Some(Ok(f)) => good.push((f.kind, f.sequence)),
                    Some(Err(_)) => bad += 1,
                    None => {}
                }
                assert!(taken > 0);
                rest = &rest[taken..];
            }
        }
        (good, bad)
    }

    #[test]
    fn a_frame_cut_after_any_byte_does_not_hide_the_next() {
        let whole = frame(7, 1, &[0, 1, 2, 0, 0, 255]);
        for cut in 0..whole.len() {
            let mut bytes = whole[..cut].to_vec();
            // The zero that starts every transmission after a pause.
            bytes.push(0);
            bytes.extend(frame(8, 2, &[3]));
            let (good, _) = frames_in(&bytes, 3);
            assert_eq!(good.last(), Some(&(8, 2)), "cut after {cut}");
        }
    }

    #[test]
    fn a_frame_too_long_is_named_and_skipped() {
        let mut bytes: Vec<u8> = core::iter::repeat_n(1, MAX_FRAME + 5).collect();
        bytes.push(0);
        bytes.extend(frame(9, 3, &[]));
        assert_eq!(frames_in(&bytes, 64), (std::vec![(9, 3)], 1));
    }

    #[test]
    fn the_longest_body_fits() {
        let body = [0xAB; MAX_BODY - 2];
        assert_eq!(frames_in(&frame(1, 2, &body), 17), (std::vec![(1, 2)], 0));
    }

    proptest! {
        #[test]
        fn whatever_comes_in_pieces_of_any_size_comes_out(
            body in proptest::collection::vec(any::<u8>(), 0..600),
            kind: u16, sequence: u16, piece in 1_usize..700,
        ) {
            prop_assert_eq!(frames_in(&frame(kind, sequence, &body), piece), (std::vec![(kind, sequence)], 0));
        }

        #[test]
        fn garbage_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..4000), piece in 1_usize..99) {
            frames_in(&bytes, piece);
        }

        #[test]
        fn a_flipped_bit_is_never_a_good_frame(
            body in proptest::collection::vec(any::<u8>(), 1..200), at: proptest::sample::Index, bit in 0_u8..8,
        ) {
            let mut bytes = frame(5, 6, &body);
            let i = at.index(bytes.len() - 1);
            bytes[i] ^= 1 << bit;
            let (good, _) = frames_in(&bytes, 50);
            prop_assert!(good.is_empty());
        }
    }
}
