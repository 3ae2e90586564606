//! Streams of random numbers that do not overlap, so that what is drawn from one changes nothing in the others.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A stream of a seed.
pub(super) fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

/// What is drawn from a branch of a stream.
#[derive(Clone, Copy, Debug)]
pub(super) enum Branch {
    /// 1/f noise.
    Flicker = 1,
    /// Wander of the sensors' outputs.
    Wander = 2,
    /// Draught and creaks.
    Environment = 3,
    /// Ripple and droops of the supply.
    Supply = 4,
}

/// Bits of a stream's number that tell its branches apart; no stream of its own uses them.
const BRANCH: u32 = 24;

/// The beginning of another stream that belongs to this one.
pub(super) fn branch(rng: &ChaCha8Rng, branch: Branch) -> ChaCha8Rng {
    let mut other = ChaCha8Rng::from_seed(rng.get_seed());
    other.set_stream(rng.get_stream() ^ (branch as u64) << BRANCH);
    other
}
