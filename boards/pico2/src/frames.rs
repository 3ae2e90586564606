//! The program of the PIO's state machine: it makes frames continuously, with the timing of the plan.

use pio::{Program, RP2040_MAX_PROGRAM_SIZE, pio_asm};

/// The program. It sends the converter the upper half of a word from the FIFO, or zeros, and returns the
/// received frame as the lower half of a word.
pub fn program() -> Program<RP2040_MAX_PROGRAM_SIZE> {
    // A gap of 8 + 8 + 8 + 2 + 1 cycles, then sixteen clocks of 3 cycles low and 3 high, and 2 cycles low before CS
    // rises, so that the converter sees the sixteenth falling edge. A bit is sampled at the rising edge of its clock;
    // the machine sees it as it was two core cycles before. While `push` waits for room the converter is not selected.
    pio_asm!(
        ".side_set 2", // The clock, and above it CS, which selects when it is low.
        "    set x, 0        side 0b10",
        ".wrap_target",
        "    pull noblock    side 0b10 [7]", // A command, or X: continue.
        "    set y, 15       side 0b10 [7]",
        "    nop             side 0b10 [7]",
        "    nop             side 0b10 [1]",
        "bit:",
        "    out pins, 1     side 0b00 [2]",
        "    in pins, 1      side 0b01 [1]",
        "    jmp y-- bit     side 0b01",
        "    nop             side 0b00 [1]",
        "    push block      side 0b10",
        ".wrap",
    )
    .program
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use pio::{
        InSource, Instruction, InstructionOperands, JmpCondition, MovDestination, OutDestination,
        SetDestination,
    };

    use super::*;
    use crate::plan::{CORE_HZ, DIVIDER, FRAME_BITS, GAP, HIGH, HOLD, LOW, RATE_HZ, RATIO};

    /// State of the pins in one cycle.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    struct Pins {
        clock: bool,
        select: bool,
        data: bool,
    }

    /// A simulation of the state machine, as far as this program needs, with a data line from the converter.
    #[derive(Default)]
    struct Machine {
        at: u8,
        x: u32,
        y: u32,
        out: u32,
        taken: u32,
        data: bool,
        to_send: VecDeque<u32>,
        received: Vec<u32>,
        cycles: Vec<Pins>,
    }

    impl Machine {
        /// Executes one instruction; `line` returns the level of the data line in a cycle.
        fn step(&mut self, line: impl Fn(usize) -> bool) {
            let program = program();
            let word = program.code[usize::from(self.at)];
            let Instruction { operands, delay, side_set } =
                Instruction::decode(word, program.side_set).unwrap();
            let mut next =
                if self.at == program.wrap.source { program.wrap.target } else { self.at + 1 };
            use InstructionOperands as Op;
            match operands {
                Op::SET { destination: SetDestination::X, data } => self.x = data.into(),
                Op::SET { destination: SetDestination::Y, data } => self.y = data.into(),
                Op::PULL { if_empty: false, block: false } => {
                    self.out = self.to_send.pop_front().unwrap_or(self.x);
                }
                // A `nop` is encoded as a move of Y to itself.
                Op::MOV { destination: MovDestination::Y, .. } => {}
                Op::OUT { destination: OutDestination::PINS, bit_count: 1 } => {
                    self.data = self.out >> 31 == 1;
                    self.out <<= 1;
                }
                Op::IN { source: InSource::PINS, bit_count: 1 } => {
                    self.taken = self.taken << 1 | u32::from(line(self.cycles.len()));
                }
                Op::JMP { condition: JmpCondition::YDecNonZero, address } => {
                    if self.y != 0 {
                        next = address;
                    }
                    self.y = self.y.wrapping_sub(1);
                }
                Op::PUSH { if_full: false, block: true } => {
                    self.received.push(core::mem::take(&mut self.taken));
                }
                other => panic!("{other:?}"),
            }
            let side = side_set.unwrap();
            let pins = Pins { clock: side & 1 == 1, select: side & 2 == 0, data: self.data };
            self.cycles.extend(core::iter::repeat_n(pins, usize::from(delay) + 1));
            self.at = next;
        }
    }

    fn run(commands: &[u16], frames: usize, line: impl Fn(usize) -> bool) -> Machine {
        let to_send = commands.iter().map(|&command| u32::from(command) << 16).collect();
        let mut machine = Machine { to_send, ..Machine::default() };
        while machine.received.len() < frames {
            machine.step(&line);
        }
        machine
    }

    #[test]
    fn clocks_and_gaps_are_those_of_the_plan_and_the_rate_is_exact() {
        let machine = run(&[], 3, |_| false);
        // `set x` runs in one cycle per frame.
        let frame = (GAP + FRAME_BITS * (LOW + HIGH) + HOLD) as usize;
        let cycles = &machine.cycles[1..];
        assert_eq!(cycles.len(), 3 * frame);
        let per_second = u64::from(RATE_HZ * RATIO) * 10 * frame as u64 * u64::from(DIVIDER);
        assert_eq!(per_second, u64::from(CORE_HZ));
        for frame in cycles.chunks(frame) {
            // `push`, the last instruction, belongs to the gap before the next frame.
            let (gap, rest) = frame.split_at(GAP as usize - 1);
            let (clocks, push) = rest.split_at(rest.len() - 1);
            let (clocks, hold) = clocks.split_at(clocks.len() - HOLD as usize);
            assert!(hold.iter().all(|pins| pins.select && !pins.clock), "a falling edge, then CS");
            assert!(gap.iter().chain(push).all(|pins| !pins.select && !pins.clock));
            for clock in clocks.chunks((LOW + HIGH) as usize) {
                let (low, high) = clock.split_at(LOW as usize);
                assert!(low.iter().all(|pins| pins.select && !pins.clock));
                assert!(high.iter().all(|pins| pins.select && pins.clock));
            }
        }
    }

    #[test]
    fn the_converter_is_not_selected_while_the_machine_waits_for_room() {
        let program = program();
        let waits = program.code.iter().map(|word| Instruction::decode(*word, program.side_set));
        let waits = waits.map(Option::unwrap).filter(|instruction| {
            matches!(
                instruction.operands,
                InstructionOperands::PUSH { block: true, .. }
                    | InstructionOperands::PULL { block: true, .. }
                    | InstructionOperands::WAIT { .. }
            )
        });
        let sides: Vec<_> = waits.map(|instruction| instruction.side_set).collect();
        assert_eq!(sides, [Some(0b10)], "one instruction waits, with CS high");
    }

    #[test]
    fn commands_go_out_highest_bit_first_and_zeros_after_them() {
        let machine = run(&[0x9240, 0x3C01], 3, |_| false);
        let mut sent = Vec::new();
        for pair in machine.cycles.windows(2) {
            if !pair[0].clock && pair[1].clock {
                // The converter samples a bit at the rising edge of the clock.
                sent.push(u64::from(pair[1].data));
                assert_eq!(pair[0].data, pair[1].data, "it holds over the edge");
            }
        }
        let bits = sent.iter().fold(0, |bits, bit| bits << 1 | bit);
        assert_eq!(bits, 0x9240_3C01_0000);
    }

    #[test]
    fn the_answer_is_taken_highest_bit_first_where_the_clock_rises() {
        const ANSWER: u16 = 0x7A35;
        // The data line of a converter that changes it at the falling edge of the clock.
        let quiet = run(&[], 1, |_| false);
        let rises: Vec<_> = (1..quiet.cycles.len())
            .filter(|&k| quiet.cycles[k].clock && !quiet.cycles[k - 1].clock)
            .collect();
        let bit = |cycle| {
            let falls = rises.iter().filter(|&&rise| rise + HIGH as usize <= cycle).count();
            ANSWER.checked_shl(falls as u32).unwrap_or(0) >> 15 == 1
        };
        assert_eq!(run(&[], 1, bit).received, [u32::from(ANSWER)]);
    }
}
