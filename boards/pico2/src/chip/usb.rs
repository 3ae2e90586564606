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
/// The USB device, which must be run.
pub type Device = UsbDevice<'static, Driver<'static, USB>>;

/// Digits of the serial number.
const DIGITS: usize = 16;

/// Creates the device, which the caller must run, and its link. To be called once.
pub fn open(usb: Peri<'static, USB>) -> (Device, Link) {
    static SERIAL: StaticCell<Text> = StaticCell::new();
    let serial = SERIAL.init(Text { bytes: [0; DIGITS], length: 0 });
    // If the chip's number cannot be read, the serial number is 0; there is room for sixteen digits.
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
