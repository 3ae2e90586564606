//! Bytes that are not frames, as a bad cable or another program sends them.

use massline_protocol::message::GetIdentity;
use massline_protocol::{Endpoint, MAX_FRAME, encode_frame};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A framed request that changes nothing on the rig.
pub fn question(sequence: u16) -> Vec<u8> {
    let mut frame = [0; MAX_FRAME];
    let length = encode_frame(GetIdentity::KIND, sequence, &(), &mut frame).unwrap_or(0);
    frame[..length].to_vec()
}

/// Pieces that are not valid frames, each ending in its only zero: noise, a truncated frame, a frame with
/// a wrong bit, and a frame longer than any buffer.
pub fn garbage(random: &mut ChaCha8Rng) -> [Vec<u8>; 4] {
    let mut draw = |range: std::ops::Range<usize>| random.random_range(range);
    let whole = question(draw(0..1 << 16) as u16);
    // At most five bytes: shorter than a header with its checksum, whatever their values.
    let cut = [&whole[..draw(1..6)], &[0]].concat();
    let mut flipped = whole;
    let at = draw(0..flipped.len() - 1);
    // A flip must not make a zero, which would divide the piece in two.
    flipped[at] = if flipped[at] == 0x80 { 0x81 } else { flipped[at] ^ 0x80 };
    let mut noise = |length: usize| {
        let bytes = (0..length).map(|_| draw(1..256) as u8);
        bytes.chain([0]).collect::<Vec<u8>>()
    };
    // The 32-bit CRC of random noise is valid once in four billion pieces.
    let (short, giant) = (noise(300), noise(3 * MAX_FRAME));
    [short, cut, flipped, giant]
}
