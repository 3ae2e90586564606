//! The other link: the chip's USB, if a socket is wired to PA11 and PA12.

use embassy_stm32::peripherals::{PA11, PA12, USB};
use embassy_stm32::usb::{Driver, InterruptHandler};
use embassy_stm32::{Peri, bind_interrupts};
use embassy_usb::UsbDevice;
use massline_cortex_m::usb::UsbLink;

bind_interrupts!(struct Interrupts {
    USB_LP => InterruptHandler<USB>;
});

/// The serial port.
pub type Link = UsbLink<Driver<'static, USB>>;
/// The USB device, which must be run.
pub type Device = UsbDevice<'static, Driver<'static, USB>>;

/// Creates the device, which the caller must run, and its link.
pub fn open(
    usb: Peri<'static, USB>,
    dp: Peri<'static, PA12>,
    dm: Peri<'static, PA11>,
) -> (Device, Link) {
    let driver = Driver::new(usb, Interrupts, dp, dm);
    massline_cortex_m::usb::open(driver, embassy_stm32::uid::uid_hex())
}
