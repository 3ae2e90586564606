//! The faults of a bad cable on a stream of bytes, random but seeded.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Direction, Filter, HostEnd};

/// Probability of each fault, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultRates {
    /// A byte is lost.
    pub lose_byte: f64,
    /// A byte arrives twice.
    pub double_byte: f64,
    /// A bit of a byte is flipped.
    pub flip_bit: f64,
    /// A whole write is lost.
    pub lose_write: f64,
    /// A whole write arrives twice.
    pub double_write: f64,
    /// A write is split after a byte: the reader gets the rest with another read. This is not a fault and
    /// not counted: any link does it.
    pub cut: f64,
}

impl FaultRates {
    /// No faults.
    pub const NONE: Self = Self {
        lose_byte: 0.0,
        double_byte: 0.0,
        flip_bit: 0.0,
        lose_write: 0.0,
        double_write: 0.0,
        cut: 0.0,
    };

    /// About one fault in `bytes` bytes and in `writes` writes, each kind equally frequent; every tenth
    /// byte ends a piece.
    pub fn one_in(bytes: f64, writes: f64) -> Self {
        Self {
            lose_byte: 1.0 / (3.0 * bytes),
            double_byte: 1.0 / (3.0 * bytes),
            flip_bit: 1.0 / (3.0 * bytes),
            lose_write: 1.0 / (2.0 * writes),
            double_write: 1.0 / (2.0 * writes),
            cut: 0.1,
        }
    }
}

/// Makes a pipe faulty and counts the faults on it. Clones share the count.
#[derive(Clone, Default)]
pub struct FaultyPipe {
    faults: Arc<AtomicU64>,
}

impl fmt::Debug for FaultyPipe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FaultyPipe").field("faults", &self.faults()).finish()
    }
}

impl FaultyPipe {
    /// From now on both directions of the pipe behind `host` have faults.
    pub fn on(host: &HostEnd, seed: u64, rates: FaultRates) -> Self {
        let pipe = Self::default();
        host.set_filter(Direction::ToRig, Some(pipe.filter(seed, rates)));
        host.set_filter(Direction::ToHost, Some(pipe.filter(!seed, rates)));
        pipe
    }

    /// Removes the faults from the pipe behind `host`.
    pub fn repair(host: &HostEnd) {
        host.set_filter(Direction::ToRig, None);
        host.set_filter(Direction::ToHost, None);
    }

    /// Faults so far in both directions.
    pub fn faults(&self) -> u64 {
        self.faults.load(Ordering::Relaxed)
    }

    /// A filter for one direction whose faults are counted here.
    pub fn filter(&self, seed: u64, rates: FaultRates) -> Filter {
        let faults = self.faults.clone();
        let mut dice = Dice { rng: ChaCha8Rng::seed_from_u64(seed), faults };
        Box::new(move |bytes| dice.pieces(bytes, &rates))
    }
}

struct Dice {
    rng: ChaCha8Rng,
    faults: Arc<AtomicU64>,
}

impl Dice {
    fn pieces(&mut self, bytes: &[u8], rates: &FaultRates) -> Vec<Vec<u8>> {
        if self.fault(rates.lose_write) {
            return Vec::new();
        }
        let copies = if self.fault(rates.double_write) { 2 } else { 1 };
        let mut pieces = vec![Vec::new()];
        for &byte in std::iter::repeat_n(bytes, copies).flatten() {
            let last = pieces.len() - 1;
            self.byte(byte, rates, &mut pieces[last]);
            if self.rng.random_bool(rates.cut) {
                pieces.push(Vec::new());
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }

    fn byte(&mut self, byte: u8, rates: &FaultRates, out: &mut Vec<u8>) {
        if self.fault(rates.lose_byte) {
            return;
        }
        let flip = if self.fault(rates.flip_bit) { 1 << self.rng.random_range(0..8) } else { 0 };
        out.push(byte ^ flip);
        if self.fault(rates.double_byte) {
            out.push(byte ^ flip);
        }
    }

    fn fault(&mut self, chance: f64) -> bool {
        let happens = chance > 0.0 && self.rng.random_bool(chance);
        self.faults.fetch_add(u64::from(happens), Ordering::Relaxed);
        happens
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(rates: FaultRates, bytes: &[u8]) -> (Vec<Vec<u8>>, u64) {
        let pipe = FaultyPipe::default();
        let pieces = pipe.filter(1, rates)(bytes);
        (pieces, pipe.faults())
    }

    #[test]
    fn a_cut_at_every_byte_is_no_fault() {
        let (pieces, faults) = through(FaultRates { cut: 1.0, ..FaultRates::NONE }, b"abc");
        assert_eq!(pieces, [b"a", b"b", b"c"]);
        assert_eq!(faults, 0);
    }

    #[test]
    fn each_fault_does_what_its_name_says_and_is_counted() {
        let none = FaultRates::NONE;
        assert_eq!(through(none, b"ab"), (vec![b"ab".to_vec()], 0));
        assert_eq!(through(FaultRates { lose_byte: 1.0, ..none }, b"ab"), (vec![], 2));
        let doubled = through(FaultRates { double_byte: 1.0, ..none }, b"ab");
        assert_eq!(doubled, (vec![b"aabb".to_vec()], 2));
        assert_eq!(through(FaultRates { lose_write: 1.0, ..none }, b"ab"), (vec![], 1));
        let doubled = through(FaultRates { double_write: 1.0, ..none }, b"ab");
        assert_eq!(doubled, (vec![b"abab".to_vec()], 1));
        let (pieces, faults) = through(FaultRates { flip_bit: 1.0, ..none }, b"ab");
        assert_eq!(faults, 2);
        for (sent, received) in b"ab".iter().zip(&pieces[0]) {
            assert_eq!((sent ^ received).count_ones(), 1);
        }
    }

    #[test]
    fn the_same_seed_makes_the_same_faults() {
        let rates = FaultRates::one_in(10.0, 5.0);
        let bytes: Vec<u8> = (0..=255).collect();
        assert_eq!(through(rates, &bytes), through(rates, &bytes));
        assert!(through(rates, &bytes).1 > 0);
    }
}
