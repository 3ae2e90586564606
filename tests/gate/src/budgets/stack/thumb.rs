//! What an instruction of a Cortex-M does to the stack, and where it jumps to. Encodings: Arm's ARMv7-M
//! manual (DDI 0403), chapter A7.7; a Cortex-M33 has the same.

/// One instruction, as far as it matters to the stack.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Effect {
    Nothing,
    /// The stack grows by these bytes.
    Grows(u32),
    /// The stack grows by what a register holds.
    GrowsUnknown,
    /// A call of what is at this distance from the instruction, bytes.
    Call(i32),
    /// A jump there, under a condition or not.
    Jump(i32),
    /// A register gets the lower half of a constant, and zeros above.
    LoadsLower(u8, u16),
    /// A register gets the upper half.
    LoadsUpper(u8, u16),
}

/// The register that points at the stack.
const SP: u8 = 13;

/// Whether an instruction has a second halfword, from its first (A5.1).
pub const fn is_long(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// The effect of an instruction of one halfword.
pub fn short(halfword: u16) -> Effect {
    match halfword {
        // SUB (SP minus immediate), T1
        _ if halfword & 0xFF80 == 0xB080 => Effect::Grows(4 * u32::from(halfword & 0x7F)),
        // PUSH, T1: eight registers and LR
        _ if halfword & 0xFE00 == 0xB400 => Effect::Grows(4 * (halfword & 0x1FF).count_ones()),
        // ADD (SP plus register), T2, and MOV (register), T1, to SP
        _ if matches!(halfword & 0xFF87, 0x4485 | 0x4685) => Effect::GrowsUnknown,
        // B, T2
        _ if halfword & 0xF800 == 0xE000 => {
            Effect::Jump(signed(u32::from(halfword & 0x7FF) << 1, 12) + 4)
        }
        _ => Effect::Nothing,
    }
}

/// The effect of an instruction of two halfwords.
pub fn long(first: u16, second: u16) -> Effect {
    match first >> 11 {
        0b11101 => stores_and_registers(first, second),
        0b11110 if second & 0x8000 != 0 => branches(first, second),
        0b11110 => immediates(first, second),
        // STRB, STRH, STR with the address kept in SP before the access; the last is PUSH, T3
        _ if matches!(first, 0xF80D | 0xF82D | 0xF84D) && second & 0x0F00 == 0x0D00 => {
            Effect::Grows(u32::from(second & 0xFF))
        }
        _ => Effect::Nothing,
    }
}

/// Stores of several registers, operations of registers, stores of the floating-point unit.
fn stores_and_registers(first: u16, second: u16) -> Effect {
    match first {
        // STMDB with the address kept in SP, which is PUSH, T2
        0xE92D => Effect::Grows(4 * second.count_ones()),
        // STRD and VPUSH, T1 and T2: their immediate counts words
        0xE96D => Effect::Grows(4 * u32::from(second & 0xFF)),
        _ if first & 0xFFBF == 0xED2D && second & 0x0E00 == 0x0A00 => {
            Effect::Grows(4 * u32::from(second & 0xFF))
        }
        // ADD (SP plus register), T3, and SUB (SP minus register), T1
        _ if matches!(first & 0xFFEF, 0xEB0D | 0xEBAD) && second & 0x0F00 == 0x0D00 => {
            Effect::GrowsUnknown
        }
        _ => Effect::Nothing,
    }
}

fn immediates(first: u16, second: u16) -> Effect {
    let register = (second >> 8 & 0xF) as u8;
    let half = || (u32::from(first & 0xF) << 12 | immediate(first, second)) as u16;
    match first & 0xFBFF {
        // SUB (SP minus immediate), T2 and T3; no ADD or SUB to SP is allowed from another register
        0xF1AD | 0xF1BD if register == SP => Effect::Grows(modified_immediate(first, second)),
        0xF2AD if register == SP => Effect::Grows(immediate(first, second)),
        // MOV (immediate), T3, and MOVT
        _ if first & 0xFBF0 == 0xF240 => Effect::LoadsLower(register, half()),
        _ if first & 0xFBF0 == 0xF2C0 => Effect::LoadsUpper(register, half()),
        _ => Effect::Nothing,
    }
}

fn branches(first: u16, second: u16) -> Effect {
    match second >> 12 & 0b101 {
        // BL, T1
        0b101 => Effect::Call(branch_offset(first, second) + 4),
        // B, T4
        0b001 => Effect::Jump(branch_offset(first, second) + 4),
        // B, T3; other instructions are in the place of its last two conditions
        0b000 if first >> 7 & 0b111 != 0b111 => Effect::Jump(conditional_offset(first, second) + 4),
        _ => Effect::Nothing,
    }
}

/// The twelve bits of an immediate, i:imm3:imm8.
fn immediate(first: u16, second: u16) -> u32 {
    let [i, high, low] = [first >> 10 & 1, second >> 12 & 7, second & 0xFF].map(u32::from);
    i << 11 | high << 8 | low
}

/// An immediate of twelve bits that stands for one of 32 (A5.3.2).
fn modified_immediate(first: u16, second: u16) -> u32 {
    let bits = immediate(first, second);
    let byte = bits & 0xFF;
    match bits >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (bits & 0x7F | 0x80).rotate_right(bits >> 7),
    }
}

fn branch_offset(first: u16, second: u16) -> i32 {
    let [sign, high] = [first >> 10 & 1, first & 0x3FF].map(u32::from);
    let [j1, j2, low] = [second >> 13 & 1, second >> 11 & 1, second & 0x7FF].map(u32::from);
    let [i1, i2] = [j1, j2].map(|j| 1 ^ j ^ sign);
    signed(sign << 24 | i1 << 23 | i2 << 22 | high << 12 | low << 1, 25)
}

fn conditional_offset(first: u16, second: u16) -> i32 {
    let [sign, high] = [first >> 10 & 1, first & 0x3F].map(u32::from);
    let [j1, j2, low] = [second >> 13 & 1, second >> 11 & 1, second & 0x7FF].map(u32::from);
    signed(sign << 20 | j2 << 19 | j1 << 18 | high << 12 | low << 1, 21)
}

/// A number of so many bits in two's complement.
fn signed(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)) as i32 >> (32 - bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Assembled by LLVM for thumbv7em-none-eabihf.
    #[test]
    fn what_an_assembler_makes_is_read() {
        for (instruction, halfword, effect) in [
            ("push {r4, r5, r7, lr}", 0xB5B0, Effect::Grows(16)),
            ("push {r0}", 0xB401, Effect::Grows(4)),
            ("sub sp, #508", 0xB0FF, Effect::Grows(508)),
            ("add sp, #508", 0xB07F, Effect::Nothing),
            ("b .-4", 0xE7FC, Effect::Jump(-4)),
            ("b .+100", 0xE030, Effect::Jump(100)),
            ("mov sp, r4", 0x46A5, Effect::GrowsUnknown),
            ("add sp, r4", 0x44A5, Effect::GrowsUnknown),
            ("mov r7, sp", 0x466F, Effect::Nothing),
        ] {
            assert!(!is_long(halfword), "{instruction}");
            assert_eq!(short(halfword), effect, "{instruction}");
        }
        for (instruction, [first, second], effect) in [
            ("push.w {r8, r9, r10, r11}", [0xE92D, 0x0F00], Effect::Grows(16)),
            ("str r11, [sp, #-4]!", [0xF84D, 0xBD04], Effect::Grows(4)),
            ("vpush {d8, d9, d10}", [0xED2D, 0x8B06], Effect::Grows(24)),
            ("vpush {s16}", [0xED2D, 0x8A01], Effect::Grows(4)),
            ("sub.w sp, sp, #16384", [0xF5AD, 0x4D80], Effect::Grows(16_384)),
            ("sub.w sp, sp, #3776", [0xF5AD, 0x6D6C], Effect::Grows(3776)),
            ("sub.w sp, sp, #0x00100010", [0xF1AD, 0x1D10], Effect::Grows(0x0010_0010)),
            ("subw sp, sp, #1234", [0xF2AD, 0x4DD2], Effect::Grows(1234)),
            ("sub.w sp, sp, r4", [0xEBAD, 0x0D04], Effect::GrowsUnknown),
            ("add.w sp, sp, r4", [0xEB0D, 0x0D04], Effect::GrowsUnknown),
            ("add.w sp, sp, #16384", [0xF50D, 0x4D80], Effect::Nothing),
            ("bl .+4096", [0xF000, 0xFFFE], Effect::Call(4096)),
            ("bl .-4096", [0xF7FE, 0xFFFE], Effect::Call(-4096)),
            ("b.w .+300000", [0xF049, 0xB9EE], Effect::Jump(300_000)),
            ("beq.w .+4096", [0xF000, 0x87FE], Effect::Jump(4096)),
            ("strd r0, r1, [sp, #-16]!", [0xE96D, 0x0104], Effect::Grows(16)),
            ("strd r0, r1, [sp, #16]", [0xE9CD, 0x0104], Effect::Nothing),
            ("strb r0, [sp, #-8]!", [0xF80D, 0x0D08], Effect::Grows(8)),
            ("strh r0, [sp, #-8]!", [0xF82D, 0x0D08], Effect::Grows(8)),
            ("ldr r0, [sp], #68", [0xF85D, 0x0B44], Effect::Nothing),
            ("subs.w sp, sp, #16384", [0xF5BD, 0x4D80], Effect::Grows(16_384)),
            ("sub.w r4, sp, #24", [0xF1AD, 0x0418], Effect::Nothing),
            ("movw r3, #0xabcd", [0xF64A, 0x33CD], Effect::LoadsLower(3, 0xABCD)),
            ("movt r11, #0x0801", [0xF6C0, 0x0B01], Effect::LoadsUpper(11, 0x0801)),
            ("pop.w {r8, r9}", [0xE8BD, 0x0300], Effect::Nothing),
            ("msr msp, r1", [0xF381, 0x8808], Effect::Nothing),
            ("dmb sy", [0xF3BF, 0x8F5F], Effect::Nothing),
            ("udf.w #1", [0xF7F0, 0xA001], Effect::Nothing),
        ] {
            assert!(is_long(first), "{instruction}");
            assert_eq!(long(first, second), effect, "{instruction}");
        }
    }
}
