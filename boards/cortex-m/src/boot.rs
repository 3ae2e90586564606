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

/// Text in memory that is not initialised at the start. Any content is safe to read.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Words {
    magic: u32,
    length: u32,
    sum: u32,
    text: [u8; Self::CAPACITY],
}

impl Words {
    /// Most bytes of a panic message that a rig reports.
    pub const CAPACITY: usize = 96;
    const MAGIC: u32 = u32::from_le_bytes(*b"last");

    /// An empty text.
    pub const fn none() -> Self {
        Self { magic: 0, length: 0, sum: 0, text: [0; Self::CAPACITY] }
    }

    /// Stores as much of `words` as there is room for, cut between two characters.
    pub fn write(&mut self, words: fmt::Arguments<'_>) {
        *self = Self::none();
        // On an error the text is full and holds what fitted.
        let _ = fmt::write(self, words);
        self.sum = self.checksum();
        self.magic = Self::MAGIC;
    }

    /// Returns the text and clears it; `None` when there is none or it did not survive.
    pub fn take(&mut self) -> Option<heapless::String<{ Self::CAPACITY }>> {
        let magic = core::mem::take(&mut self.magic);
        let text = self.text.get(..self.length as usize)?;
        let text = core::str::from_utf8(text).ok()?;
        let whole = magic == Self::MAGIC && self.sum == self.checksum();
        whole.then(|| heapless::String::try_from(text).ok()).flatten()
    }

    fn checksum(&self) -> u32 {
        self.length.rotate_left(16) ^ massline_protocol::crc32(&self.text)
    }
}

impl fmt::Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for c in text.chars() {
            let start = self.length as usize;
            let end = start + c.len_utf8();
            let room = self.text.get_mut(start..end).ok_or(fmt::Error)?;
            c.encode_utf8(room);
            self.length = end as u32;
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
    fn the_words_of_a_panic_can_be_taken_once() {
        let mut words = Words::none();
        assert_eq!(words.take(), None);
        words.write(format_args!("index {} of {}", 7, 5));
        assert_eq!(words.take().as_deref(), Some("index 7 of 5"));
        assert_eq!(words.take(), None);
    }

    #[test]
    fn long_words_are_cut_between_two_characters() {
        let mut words = Words::none();
        words.write(format_args!("{}µ²", "x".repeat(Words::CAPACITY - 3)));
        let kept = words.take().unwrap();
        assert_eq!(kept.len(), Words::CAPACITY - 1);
        assert!(kept.ends_with("xµ"));
    }

    #[test]
    fn noise_and_decayed_words_are_no_words() {
        let noise = Words { magic: Words::MAGIC, length: u32::MAX, ..Words::none() };
        assert_eq!({ noise }.take(), None);
        let mut spoken = Words::none();
        spoken.write(format_args!("out of memory"));
        for bit in 0..8 * 13 {
            let mut decayed = spoken;
            decayed.text[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(decayed.take(), None);
        }
        let mut shorter = spoken;
        shorter.length -= 1;
        assert_eq!(shorter.take(), None);
    }
}
