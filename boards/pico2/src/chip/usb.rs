//! The link: the board's own USB socket.

use core::fmt::Write;

use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::{Peri, bind_interrupts, otp};
use embassy_usb::UsbDevice;
use massline_cortex_m::usb::UsbLink;
use static_cell::StaticCell;

bind_interrupts!(struct Interrupts {
    USBCTRL_IRQ => InterruptHandler<USB>;
});

/// The serial port.
pub type Link = UsbLink<Driver<'static, USB>>;
/// What answers the host's bus.
pub type Device = UsbDevice<'static, Driver<'static, USB>>;

/// Digits of the chip's number.
const DIGITS: usize = 16;

/// The device, which is to be run, and its link. To be called once.
pub fn open(usb: Peri<'static, USB>) -> (Device, Link) {
    static SERIAL: StaticCell<Text> = StaticCell::new();
    let serial = SERIAL.init(Text { bytes: [0; DIGITS], length: 0 });
    // A chip whose number cannot be read is number 0; sixteen digits have room.
    let _ = write!(serial, "{:016X}", otp::get_chipid().unwrap_or_default());
    let text = core::str::from_utf8(&serial.bytes[..serial.length]).unwrap_or_default();
    massline_cortex_m::usb::open(Driver::new(usb, Interrupts), text)
}

struct Text {
    bytes: [u8; DIGITS],
    length: usize,
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        let end = self.length + text.len();
        let room = self.bytes.get_mut(self.length..end).ok_or(core::fmt::Error)?;
        room.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}
