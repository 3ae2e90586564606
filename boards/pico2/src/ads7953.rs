//! The external converter, TI's ADS7953: its commands and its frames.
//!
//! *Frame*: 16 clocks while the chip is selected. A command is sent and a conversion is received: four bits
//! of channel (the *tag*) and twelve of code. The sampling of an input ends at the start of a frame. In the
//! mode *Auto-2* the chip cycles from channel 0 to the last without further commands. SLAS605, "Device
//! functional modes".

use massline_firmware::board::ConverterFault;
use massline_shared::signal::CHANNELS;

use crate::plan::{IN_STEP, OUT_OF_STEP, RANKS, SENTINEL};

/// The last channel of a pass.
const LAST: u16 = CHANNELS as u16 - 1;

/// Command: program Auto-2 with the last channel.
const PROGRAM_AUTO_2: u16 = 0b1001 << 12 | LAST << 6;
/// Command: continue in Auto-2 from channel 0 (bit 10). Bit 11 makes the bits below it valid: the range of
/// the reference, no sleep, tags.
const ENTER_AUTO_2: u16 = 0b0011 << 12 | 1 << 11 | 1 << 10;
/// The first commands; after them, all zeros means "continue".
pub const COMMANDS: [u16; 2] = [PROGRAM_AUTO_2, ENTER_AUTO_2];

/// Frames after the commands within which a whole pass must end: two frames are still of the chip's
/// previous mode, and the pass after them may start at any channel.
pub const FRAMES_TO_START: usize = 4 * CHANNELS;

const CODE_BITS: u32 = 12;
const CODE: u16 = (1 << CODE_BITS) - 1;

/// The channel in a frame's tag.
const fn tag(frame: u16) -> u16 {
    frame >> CODE_BITS
}

/// Frames after the commands that are still of the chip's previous mode.
const PREVIOUS: u16 = COMMANDS.len() as u16 + 2;

/// Finds the end of a pass in the first frames, so that the frame after it is of channel 0.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Number of consecutive frames in order so far.
    in_order: u16,
    /// Number of frames so far.
    frames: u16,
    /// All bits that were set in any frame, and those that were set in all.
    set_in_any: u16,
    set_in_all: u16,
    /// The tag of the frame before.
    last_tag: u16,
    /// True while all tags are the same.
    is_same: bool,
    /// The first tag that does not follow the one before.
    wrong_tag: Option<u16>,
}

impl Default for Start {
    fn default() -> Self {
        Self::new()
    }
}

impl Start {
    /// A search before the first frame.
    pub const fn new() -> Self {
        Self {
            in_order: 0,
            frames: 0,
            set_in_any: 0,
            set_in_all: u16::MAX,
            last_tag: 0,
            is_same: true,
            wrong_tag: None,
        }
    }

    /// Adds a frame; returns true when it was the last of a whole pass.
    pub fn ends_with(&mut self, frame: u16) -> bool {
        self.note(frame);
        self.in_order = match tag(frame) {
            tag if tag == self.in_order => tag + 1,
            0 => 1,
            _ => 0,
        };
        self.in_order > LAST
    }

    fn note(&mut self, frame: u16) {
        let tag = tag(frame);
        self.set_in_any |= frame;
        self.set_in_all &= frame;
        if self.frames > 0 {
            self.is_same &= tag == self.last_tag;
        }
        let due = if self.last_tag >= LAST { 0 } else { self.last_tag + 1 };
        if self.frames > PREVIOUS && tag != due && self.wrong_tag.is_none() {
            self.wrong_tag = Some(tag);
        }
        self.frames += 1;
        self.last_tag = tag;
    }

    /// What was wrong with the frames when no pass has ended, and the first wrong tag.
    pub fn fault(&self) -> (ConverterFault, u8) {
        match self.wrong_tag {
            _ if self.frames == 0 => (ConverterFault::None, 0),
            _ if self.set_in_all == u16::MAX => (ConverterFault::LineHigh, 0),
            _ if self.set_in_any == 0 => (ConverterFault::LineLow, 0),
            _ if self.is_same => (ConverterFault::NoCommands, 0),
            Some(tag) => (ConverterFault::WrongTag, tag as u8),
            None => (ConverterFault::None, 0),
        }
    }
}

/// The codes of a pass, and the sentinel, which shows whether every frame is of the expected channel.
pub fn ranks(frames: [u16; CHANNELS]) -> [u16; RANKS] {
    let in_step = (0..).zip(frames).all(|(channel, frame)| tag(frame) == channel);
    let mut ranks = [0; RANKS];
    for (rank, frame) in ranks.iter_mut().zip(frames) {
        *rank = frame & CODE;
    }
    ranks[SENTINEL] = if in_step { IN_STEP } else { OUT_OF_STEP };
    ranks
}

#[cfg(test)]
mod tests {
    use massline_firmware::board::SampleError;
    use massline_firmware::scan_ring::{Fault, RingSettings, ScanRing};

    use super::*;
    use crate::plan::DECIMATION;

    /// A simulation of the chip by its data sheet: a channel that is selected in one frame is sampled at
    /// the end of the next and sent in the one after. The code identifies the channel.
    struct Chip {
        connected: bool,
        last: u16,
        auto: bool,
        /// Channels selected for the next frame, sampled, and being sent.
        pipeline: [u16; 3],
        frames: u16,
    }

    impl Chip {
        fn new() -> Self {
            Self { connected: true, last: 15, auto: false, pipeline: [0; 3], frames: 0 }
        }

        fn frame(&mut self, command: u16) -> u16 {
            if !self.connected {
                // The pull-up keeps the line high.
                return 0xFFFF;
            }
            let [chosen, sampled, _] = self.pipeline;
            let mut next = chosen;
            if self.auto {
                next = if chosen >= self.last { 0 } else { chosen + 1 };
            }
            match command >> 12 {
                0b1001 => self.last = command >> 6 & 0xF,
                0b0011 => {
                    self.auto = true;
                    if command & 1 << 10 != 0 {
                        next = 0;
                    }
                }
                _ => {}
            }
            self.pipeline = [next, chosen, sampled];
            self.frames += 1;
            sampled << 12 | code(sampled)
        }
    }

    /// The code of a channel, not at either end of the range.
    fn code(channel: u16) -> u16 {
        1000 + 100 * channel
    }

    fn settings() -> RingSettings {
        RingSettings {
            decimation: DECIMATION,
            sentinel: SENTINEL,
            sentinel_codes: IN_STEP..=IN_STEP,
            before_sentinel: None,
            skip: 0,
        }
    }

    /// Starts the chip as the board does: commands, then frames until the end of a pass.
    fn start(chip: &mut Chip) -> bool {
        let mut start = Start::new();
        let frames = COMMANDS.into_iter().chain([0; FRAMES_TO_START]);
        frames.into_iter().any(|command| start.ends_with(chip.frame(command)))
    }

    fn passes(chip: &mut Chip, ring: &mut ScanRing<RANKS, 8>, count: usize) {
        for _ in 0..count {
            let frames = core::array::from_fn(|_| chip.frame(0));
            ring.feed(&ranks(frames), |_, _| {});
        }
    }

    fn expected() -> [u16; CHANNELS] {
        // The mean, in 14 bits, of equal codes of 12 bits.
        core::array::from_fn(|channel| 4 * code(channel as u16))
    }

    #[test]
    fn commands_are_those_that_were_worked_out_by_hand() {
        // 1001 xx 1001 xxxxxx: the last channel is 9. 0011 1 1 xxx 0 0 0 xxxx: Auto-2, reset the counter.
        assert_eq!(COMMANDS, [0x9240, 0x3C00]);
    }

    #[test]
    fn from_any_state_of_the_chip_the_first_pass_is_channel_0_to_9() {
        for before in 0..40 {
            let mut chip = Chip::new();
            chip.auto = before % 2 == 1;
            (0..before).for_each(|_| _ = chip.frame(0));
            assert!(start(&mut chip), "{before}");
            let mut ring = ScanRing::<RANKS, 8>::new();
            ring.start(settings(), 0);
            passes(&mut chip, &mut ring, usize::from(DECIMATION.ratio));
            let mut block = [[0; CHANNELS]; 1];
            assert!(ring.read(&mut block, 0, 1).unwrap().is_some(), "{before}");
            assert_eq!(block, [expected()], "{before}");
        }
    }

    #[test]
    fn a_chip_that_is_not_there_never_starts() {
        let mut chip = Chip::new();
        chip.connected = false;
        assert!(!start(&mut chip));
        // Frames on a line that is stuck at zero always have the tag of channel 0.
        let mut begin = Start::new();
        assert!((0..FRAMES_TO_START).all(|_| !begin.ends_with(0)));
    }

    /// The fault that a start ends with, when the wires turn a frame and the command into others.
    fn fault(
        command: impl Fn(u16) -> u16,
        frame: impl Fn(usize, u16) -> u16,
    ) -> (ConverterFault, u8) {
        let (mut chip, mut start) = (Chip::new(), Start::new());
        let commands = COMMANDS.into_iter().chain([0; FRAMES_TO_START]);
        for (k, sent) in commands.enumerate() {
            let received = chip.frame(command(sent));
            assert!(!start.ends_with(frame(k, received)), "no pass ends");
        }
        start.fault()
    }

    #[test]
    fn a_wiring_fault_is_named_with_the_first_wrong_tag() {
        use ConverterFault::*;
        let sent = |command| command;
        assert_eq!(fault(sent, |_, _| 0xFFFF), (LineHigh, 0), "SDO or CS is not connected");
        assert_eq!(fault(sent, |_, _| 0), (LineLow, 0), "SDO is shorted to ground");
        assert_eq!(fault(|_| 0, |_, frame| frame), (NoCommands, 0), "SDI is not connected");
        // SDI on ground, or the commands one bit late: the converter does not enter the mode.
        assert_eq!(fault(|command| command >> 1, |_, frame| frame), (NoCommands, 0));
        let doubled = |k, frame| if k % 7 == 6 { 5 << 12 | code(5) } else { frame };
        assert_eq!(fault(sent, doubled), (WrongTag, 5));
        assert_eq!(fault(sent, |_, frame| frame << 1).0, WrongTag, "a clock too many");
    }

    #[test]
    fn a_start_that_succeeds_has_no_fault() {
        let (mut chip, mut start) = (Chip::new(), Start::new());
        let mut commands = COMMANDS.into_iter().chain([0; FRAMES_TO_START]);
        assert!(commands.any(|command| start.ends_with(chip.frame(command))));
        assert_eq!(start.fault(), (ConverterFault::None, 0));
    }

    #[test]
    fn a_frame_too_many_or_too_few_or_slipped_bits_are_told_and_a_new_start_mends_them() {
        type Harm = fn(&mut Chip, usize) -> Vec<u16>;
        let harms: [(&str, Harm); 4] = [
            ("a frame is missing", |chip, at| {
                (0..CHANNELS)
                    .map(|k| {
                        if k == at {
                            chip.frame(0);
                            chip.frame(0)
                        } else {
                            chip.frame(0)
                        }
                    })
                    .collect()
            }),
            ("a frame comes twice", |chip, at| {
                let mut frames: Vec<_> = (0..CHANNELS - 1).map(|_| chip.frame(0)).collect();
                frames.insert(at.min(CHANNELS - 2), frames[at.min(CHANNELS - 2)]);
                frames
            }),
            ("a clock too many", |chip, at| {
                let frames: Vec<_> = (0..=CHANNELS).map(|_| chip.frame(0)).collect();
                (0..CHANNELS)
                    .map(|k| if k < at { frames[k] } else { frames[k] << 1 | frames[k + 1] >> 15 })
                    .collect()
            }),
            ("the chip is gone", |_, _| vec![0xFFFF; CHANNELS]),
        ];
        for (name, harm) in harms {
            for at in 0..CHANNELS {
                let mut chip = Chip::new();
                assert!(start(&mut chip));
                let mut ring = ScanRing::<RANKS, 8>::new();
                ring.start(settings(), 0);
                passes(&mut chip, &mut ring, 6);
                let harmed: [u16; CHANNELS] = harm(&mut chip, at).try_into().unwrap();
                ring.feed(&ranks(harmed), |_, _| {});
                assert_eq!(ring.fault(), Some(Fault::Misaligned), "{name} {at}");
                let mut block = [[0; CHANNELS]; 1];
                let lost = ring.read(&mut block, 0, 1);
                assert!(matches!(lost, Err(SampleError::Overrun { .. })), "{name} {at}");
                ring.restart(0);
                assert!(start(&mut chip), "{name} {at}");
                passes(&mut chip, &mut ring, usize::from(DECIMATION.ratio));
                assert!(ring.read(&mut block, 0, 1).unwrap().is_some(), "{name} {at}");
                assert_eq!(block, [expected()], "{name} {at}");
            }
        }
    }
}
