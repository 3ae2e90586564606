//! The gauge of the battery: a MAX17048 on the bus of the screen, which a rig may have or not.
//!
//! Registers by its data sheet (19-6171): the voltage of the cell at 0x02 in 78.125 µV, its charge at 0x04 in 1/256 %,
//! 16 bits each, the upper byte first.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_time::Duration;
use embedded_hal_async::i2c::I2c;
use massline_protocol::message::Battery;

/// Time between two readings.
pub const INTERVAL: Duration = Duration::from_secs(10);
/// Address on the bus.
const ADDRESS: u8 = 0x36;
/// First of the registers that are read.
const VOLTAGE: u8 = 0x02;
/// Voltages that a cell may have, mV: other values are not those of a gauge.
const OF_A_CELL: core::ops::RangeInclusive<u16> = 2000..=5000;

/// What was read last: zero when nothing was, else millivolts and, above them, percent.
static CHARGE: AtomicU32 = AtomicU32::new(0);

/// The charge that was read last.
pub fn battery() -> Option<Battery> {
    let charge = CHARGE.load(Ordering::Relaxed);
    let [low, high, percent, _] = charge.to_le_bytes();
    (charge != 0).then_some(Battery { millivolts: u16::from_le_bytes([low, high]), percent })
}

/// Notes what was read.
pub fn note(battery: Option<Battery>) {
    let charge = battery.map_or(0, |Battery { millivolts, percent }| {
        let [low, high] = millivolts.to_le_bytes();
        u32::from_le_bytes([low, high, percent, 0])
    });
    CHARGE.store(charge, Ordering::Relaxed);
}

/// Reads the gauge; `None` when there is none.
pub async fn read(bus: &mut impl I2c) -> Option<Battery> {
    let mut registers = [0; 4];
    bus.write_read(ADDRESS, &[VOLTAGE], &mut registers).await.ok()?;
    let [high, low, percent, _] = registers;
    // 78.125 µV are 5/64 mV, so the result is at most 5119.
    let millivolts = (u32::from(u16::from_be_bytes([high, low])) * 5 / 64) as u16;
    OF_A_CELL.contains(&millivolts).then_some(Battery { millivolts, percent: percent.min(100) })
}

#[cfg(test)]
mod tests {
    use embassy_futures::block_on;
    use embedded_hal_async::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};

    use super::*;

    /// A gauge with these registers from the voltage on, or none.
    struct Bus(Option<[u8; 4]>);

    impl ErrorType for Bus {
        type Error = ErrorKind;
    }

    impl I2c for Bus {
        async fn transaction(
            &mut self,
            address: u8,
            operations: &mut [Operation<'_>],
        ) -> Result<(), ErrorKind> {
            let absent = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
            let registers = self.0.filter(|_| address == 0x36).ok_or(absent)?;
            let [Operation::Write([0x02]), Operation::Read(bytes)] = operations else {
                return Err(ErrorKind::Other);
            };
            bytes.copy_from_slice(&registers);
            Ok(())
        }
    }

    fn read_of(registers: Option<[u8; 4]>) -> Option<Battery> {
        block_on(read(&mut Bus(registers)))
    }

    #[test]
    fn voltage_and_charge_are_those_of_the_data_sheet() {
        // 0xC000 · 78.125 µV = 3.84 V; 0x4080 / 256 = 64.5 %.
        let charged = Battery { millivolts: 3840, percent: 64 };
        assert_eq!(read_of(Some([0xC0, 0x00, 0x40, 0x80])), Some(charged));
        assert!(!charged.is_low());
        let low = read_of(Some([0xAE, 0xFF, 0x05, 0x00])).unwrap();
        assert_eq!(low, Battery { millivolts: 3499, percent: 5 });
        assert!(low.is_low());
    }

    #[test]
    fn without_a_gauge_there_is_no_charge() {
        assert_eq!(read_of(None), None);
        // A data line that is always high, or always low.
        assert_eq!(read_of(Some([0xFF; 4])), None);
        assert_eq!(read_of(Some([0; 4])), None);
    }

    #[test]
    fn what_was_read_last_is_kept() {
        for last in [Some(Battery { millivolts: 4187, percent: 100 }), None] {
            note(last);
            assert_eq!(battery(), last);
        }
        // A gauge counts a little beyond a full cell.
        assert_eq!(read_of(Some([0xD0, 0x00, 103, 0])).unwrap().percent, 100);
    }
}
