//! Decodes the flash's report of an uncorrectable error: RM0440, FLASH_ECCR.

use core::ops::Range;

/// Address within the bank, bits 18:0.
const ADDRESS: u32 = 0x0007_FFFF;
/// The error is in bank 2.
const BANK_2: u32 = 1 << 21;
/// The error is in system memory.
const SYSTEM: u32 = 1 << 22;
/// Corrected errors in the lower and in the upper word of a pair.
const CORRECTED: u32 = 1 << 28 | 1 << 30;
/// Uncorrectable errors in the lower and in the upper word of a pair.
const DETECTED: u32 = 1 << 29 | 1 << 31;

/// Bits that are cleared by writing ones: while one is set, the address is that of the first error.
pub const FLAGS: u32 = CORRECTED | DETECTED;

/// Cause of a non-maskable interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmiSource {
    /// A torn word of the store; it is reported to the reader.
    Store,
    /// A damaged word outside the store, at this offset from the start of its bank.
    Elsewhere {
        /// Number of the bank, 1 or 2; 0 is system memory.
        bank: u8,
        /// Offset in the bank, bytes.
        offset: u32,
    },
    /// The flash is not the cause.
    Other,
}

/// The cause by the register's value; `store` is a part of bank 2, and `reading` is true while it is read. Then
/// the cause is the store whatever the register holds: ES0430 lists that the flash may corrupt it.
pub fn nmi_source(register: u32, reading: bool, store: &Range<u32>) -> NmiSource {
    if reading {
        return NmiSource::Store;
    }
    if register & DETECTED == 0 {
        return NmiSource::Other;
    }
    let offset = register & ADDRESS;
    let bank = match register & (BANK_2 | SYSTEM) {
        0 => 1,
        BANK_2 => 2,
        _ => 0,
    };
    if bank == 2 && store.contains(&offset) {
        NmiSource::Store
    } else {
        NmiSource::Elsewhere { bank, offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::STORE_IN_BANK_2 as STORE;

    const ECCD: u32 = 1 << 31;
    const BK_ECC: u32 = 1 << 21;

    #[test]
    fn a_torn_word_of_the_store_is_the_stores() {
        for offset in [STORE.start, STORE.start + 8, STORE.end - 8] {
            assert_eq!(nmi_source(ECCD | BK_ECC | offset, false, &STORE), NmiSource::Store);
        }
    }

    #[test]
    fn a_word_beside_the_store_is_a_fault() {
        for (register, bank, offset) in [
            (ECCD | BK_ECC | (STORE.start - 8), 2, STORE.start - 8),
            (ECCD | BK_ECC | STORE.end, 2, STORE.end),
            // The same offset in bank 1, which holds the code.
            (ECCD | STORE.start, 1, STORE.start),
            (ECCD | BK_ECC | 1 << 22 | STORE.start, 0, STORE.start),
        ] {
            assert_eq!(nmi_source(register, false, &STORE), NmiSource::Elsewhere { bank, offset });
        }
    }

    #[test]
    fn while_the_store_reads_every_address_is_the_stores() {
        for register in [ECCD | STORE.start, ECCD | BK_ECC | STORE.end, ECCD | BK_ECC | 1 << 22, 0]
        {
            assert_eq!(nmi_source(register, true, &STORE), NmiSource::Store);
            assert_ne!(nmi_source(register, false, &STORE), NmiSource::Store);
        }
    }

    #[test]
    fn without_an_error_that_was_detected_it_is_not_the_flash() {
        for register in [0, BK_ECC | STORE.start, 1 << 30 | BK_ECC | STORE.start, 1 << 28, 1 << 24]
        {
            assert_eq!(nmi_source(register, false, &STORE), NmiSource::Other);
        }
    }

    #[test]
    fn either_word_of_a_pair_may_be_torn_and_a_correction_beside_it_changes_nothing() {
        let at = BK_ECC | STORE.start;
        assert_eq!(nmi_source(1 << 29 | at, false, &STORE), NmiSource::Store);
        assert_eq!(nmi_source(FLAGS | at, false, &STORE), NmiSource::Store);
    }
}
