//! The link: USB on PA11 and PA12.

use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_stm32::usb::{Config, Driver, InterruptHandler};
use embassy_stm32::{Peri, bind_interrupts};
use embassy_usb::UsbDevice;
use massline_cortex_m::usb::UsbLink;
use static_cell::StaticCell;

bind_interrupts!(struct Interrupts {
    OTG_FS => InterruptHandler<USB_OTG_FS>;
});

/// The serial port.
pub type Link = UsbLink<Driver<'static, USB_OTG_FS>>;

/// The USB device, which must be run.
pub type Device = UsbDevice<'static, Driver<'static, USB_OTG_FS>>;

/// Buffer for received packets: one control and one data packet, 64 bytes each.
const RECEIVE_BUFFER: usize = 128;

/// Creates the device, which the caller must run, and its link.
pub fn open(
    usb: Peri<'static, USB_OTG_FS>,
    dp: Peri<'static, PA12>,
    dm: Peri<'static, PA11>,
) -> (Device, Link) {
    static RECEIVED: StaticCell<[u8; RECEIVE_BUFFER]> = StaticCell::new();
    let mut config = Config::default();
    // The board has no wire for VBUS detection, and is powered by the host anyway.
    config.vbus_detection = false;
    let received = RECEIVED.init([0; RECEIVE_BUFFER]);
    let driver = Driver::new_fs(usb, Interrupts, dp, dm, received, config);
    massline_cortex_m::usb::open(driver, embassy_stm32::uid::uid_hex())
}
