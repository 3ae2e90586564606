//! Why the rig has started, and a panic message in memory that survives a reset.

use core::fmt;

use massline_firmware::board::BootReason;

/// Reset flags of the chip. Several may be set, because every reset pulls the pin low.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResetFlags {
    /// The supply was switched on or broke down.
    pub power: bool,
    /// The reset pin was low.
    pub pin: bool,
    /// A watchdog expired.
    pub watchdog: bool,
    /// The firmware requested the reset.
    pub software: bool,
}

/// The boot reason by the most specific flag; `panicked` is true when the previous run has left a panic
/// message.
pub fn reason(flags: ResetFlags, panicked: bool) -> BootReason {
    match flags {
        // Memory was without power, so any message is noise.
        ResetFlags { power: true, .. } => BootReason::PowerOn,
        ResetFlags { watchdog: true, .. } => BootReason::Watchdog,
        ResetFlags { software: true, .. } if panicked => BootReason::Panic,
        ResetFlags { software: true, .. } => BootReason::Unknown,
        ResetFlags { pin: true, .. } => BootReason::ResetPin,
        _ => BootReason::Unknown,
    }
}

/// Failed starts in a row after which a rig runs in safe mode.
pub const FAILURES_TO_SAFE_MODE: u32 = 3;

/// The reason of this start, and the number of runs in a row that a panic or a hang has ended. `before` is that number
/// at the last start, or 0 if that run has lasted for a while: then its end is the first.
pub fn after_failures(reason: BootReason, before: u32) -> (BootReason, u32) {
    match reason {
        BootReason::Panic | BootReason::Watchdog => {
            let failures = before.saturating_add(1);
            let safe = failures >= FAILURES_TO_SAFE_MODE;
            (if safe { BootReason::SafeMode } else { reason }, failures)
        }
        _ => (reason, 0),
    }
}

/// A number as it is kept in memory that is not initialised at the start: beside its complement, with a mark of the
/// firmware that keeps it.
pub fn kept_number(number: u32, mark: u32) -> [u32; 2] {
    [number, !number ^ mark]
}

/// The number kept there; 0 when it did not survive, or other firmware has kept it.
pub fn number_kept([number, complement]: [u32; 2], mark: u32) -> u32 {
    if complement == !number ^ mark { number } else { 0 }
}

/// A panic message, as words of memory that is not initialised at the start: a mark, the length, a checksum, the text.
/// Any words may be read back; only what was written is a message.
#[derive(Clone, Copy, Debug)]
pub struct Words {
    length: usize,
    text: [u8; Self::CAPACITY],
}

impl Words {
    /// Most bytes of a panic message that a rig reports.
    pub const CAPACITY: usize = 96;
    /// Words of memory.
    pub const SIZE: usize = Self::HEAD + Self::CAPACITY / size_of::<u32>();
    const HEAD: usize = 3;
    const MARK: u32 = u32::from_le_bytes(*b"last");

    /// As much of a message as there is room for, cut between two characters.
    pub fn of(message: fmt::Arguments<'_>) -> Self {
        let mut words = Self { length: 0, text: [0; Self::CAPACITY] };
        // On an error the text is full and holds what fitted.
        let _ = fmt::write(&mut words, message);
        words
    }

    /// The words to keep.
    pub fn encode(&self) -> [u32; Self::SIZE] {
        let mut kept = [0; Self::SIZE];
        let (head, text) = kept.split_at_mut(Self::HEAD);
        head.copy_from_slice(&[Self::MARK, self.length as u32, self.checksum()]);
        for (word, bytes) in text.iter_mut().zip(self.text.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        kept
    }

    /// The message in these words; `None` when there is none or it did not survive.
    pub fn read(kept: &[u32; Self::SIZE]) -> Option<heapless::String<{ Self::CAPACITY }>> {
        let &[mark, length, sum, ref text @ ..] = kept;
        let mut words = Self { length: length as usize, text: [0; Self::CAPACITY] };
        for (bytes, word) in words.text.as_chunks_mut().0.iter_mut().zip(text) {
            *bytes = word.to_le_bytes();
        }
        if mark != Self::MARK || sum != words.checksum() {
            return None;
        }
        let text = core::str::from_utf8(words.text.get(..words.length)?).ok()?;
        heapless::String::try_from(text).ok()
    }

    fn checksum(&self) -> u32 {
        (self.length as u32).rotate_left(16) ^ massline_protocol::crc32(&self.text)
    }
}

impl fmt::Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for c in text.chars() {
            let end = self.length + c.len_utf8();
            let room = self.text.get_mut(self.length..end).ok_or(fmt::Error)?;
            c.encode_utf8(room);
            self.length = end;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_telling_flag_is_the_reason() {
        let pin = ResetFlags { pin: true, ..ResetFlags::default() };
        assert_eq!(
            reason(ResetFlags { power: true, software: true, ..pin }, true),
            BootReason::PowerOn
        );
        assert_eq!(reason(pin, false), BootReason::ResetPin);
        // A message that was not read before the reset button was pressed.
        assert_eq!(reason(pin, true), BootReason::ResetPin);
        assert_eq!(reason(ResetFlags { watchdog: true, ..pin }, false), BootReason::Watchdog);
        assert_eq!(reason(ResetFlags { software: true, ..pin }, true), BootReason::Panic);
        assert_eq!(reason(ResetFlags { software: true, ..pin }, false), BootReason::Unknown);
        assert_eq!(reason(ResetFlags::default(), false), BootReason::Unknown);
    }

    #[test]
    fn after_three_failures_in_a_row_a_rig_starts_in_safe_mode_until_it_is_reset_by_hand() {
        use BootReason::*;
        let mut failures = 0;
        let mut start = |reason| {
            let (reason, now) = after_failures(reason, failures);
            failures = now;
            reason
        };
        assert_eq!([PowerOn, Panic, Watchdog].map(&mut start), [PowerOn, Panic, Watchdog]);
        assert_eq!([Panic, Panic].map(&mut start), [SafeMode, SafeMode], "safe mode may fail too");
        assert_eq!([ResetPin, Panic, Panic].map(&mut start), [ResetPin, Panic, Panic]);
        assert_eq!([Unknown, Panic, Panic].map(&mut start), [Unknown, Panic, Panic]);
        assert_eq!(start(Watchdog), SafeMode);
        assert_eq!(after_failures(Panic, u32::MAX), (SafeMode, u32::MAX));
    }

    #[test]
    fn a_number_in_memory_without_power_is_zero() {
        for mark in [0, 7] {
            assert_eq!(number_kept(kept_number(2, mark), mark), 2);
            for noise in [[0, 0], [u32::MAX; 2], [2, 2], [3, !2]] {
                assert_eq!(number_kept(noise, mark), 0);
            }
        }
        assert_eq!(number_kept(kept_number(2, 7), 8), 0, "of other firmware");
    }

    fn read(kept: [u32; Words::SIZE]) -> Option<heapless::String<{ Words::CAPACITY }>> {
        Words::read(&kept)
    }

    #[test]
    fn the_words_of_a_panic_are_read_back() {
        let words = Words::of(format_args!("index {} of {}", 7, 5));
        assert_eq!(read(words.encode()).as_deref(), Some("index 7 of 5"));
        assert_eq!(read(Words::of(format_args!("")).encode()).as_deref(), Some(""));
    }

    #[test]
    fn long_words_are_cut_between_two_characters() {
        let words = Words::of(format_args!("{}µ²", "x".repeat(Words::CAPACITY - 3)));
        let kept = read(words.encode()).unwrap();
        assert_eq!(kept.len(), Words::CAPACITY - 1);
        assert!(kept.ends_with("xµ"));
    }

    #[test]
    fn noise_and_decayed_words_are_no_words() {
        assert_eq!(read([0; Words::SIZE]), None);
        assert_eq!(read([u32::MAX; Words::SIZE]), None);
        let mut noise = [0; Words::SIZE];
        noise[..2].copy_from_slice(&[Words::MARK, u32::MAX]);
        assert_eq!(read(noise), None);
        let spoken = Words::of(format_args!("out of memory")).encode();
        for bit in 0..u32::BITS as usize * Words::SIZE {
            let mut decayed = spoken;
            decayed[bit / 32] ^= 1 << (bit % 32);
            assert_eq!(read(decayed), None, "{bit}");
        }
    }
}
