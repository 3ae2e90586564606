//! The link over USB: a serial port of class CDC-ACM.
//!
//! If no host reads, a packet waits forever, and the session gives the write up after its own timeout. When
//! the host closes the port, `read` returns 0 once, and the session stops sending events.

use core::fmt;

use embassy_futures::select::{Either, select};
use embassy_usb::class::cdc_acm::{CdcAcmClass, ControlChanged, Receiver, Sender, State};
use embassy_usb::driver::Driver;
use embassy_usb::{Builder, Config, UsbDevice};
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use massline_firmware::board::Link;
use static_cell::StaticCell;

/// Vendor of pid.codes, with a product for devices that are not sold.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;
/// Bytes of a full-speed packet.
const PACKET: usize = 64;

/// Creates the device, which the caller must run, and its link. To be called once.
pub fn open<D: Driver<'static>>(
    driver: D,
    serial_number: &'static str,
) -> (UsbDevice<'static, D>, UsbLink<D>) {
    static CONFIGURATION: StaticCell<[u8; 96]> = StaticCell::new();
    static CAPABILITIES: StaticCell<[u8; 16]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State<'static>> = StaticCell::new();
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("massline");
    config.product = Some("massline rig");
    config.serial_number = Some(serial_number);
    // A rig may have a battery; without one it takes its current from the bus.
    config.self_powered = true;
    config.max_power = 100;
    let mut builder = Builder::new(
        driver,
        config,
        CONFIGURATION.init([0; 96]),
        CAPABILITIES.init([0; 16]),
        &mut [],
        CONTROL.init([0; 64]),
    );
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET as u16);
    (builder.build(), UsbLink { class })
}

/// The serial port.
pub struct UsbLink<D: Driver<'static>> {
    class: CdcAcmClass<'static, D>,
}

/// From the host.
pub struct UsbRx<D: Driver<'static>> {
    receiver: Receiver<'static, D>,
    control: ControlChanged<'static>,
    /// The host has configured the device.
    configured: bool,
    /// The host reports that the port is open.
    open: bool,
    packet: [u8; PACKET],
    /// The part of the packet that is still to be read.
    rest: core::ops::Range<usize>,
}

/// To the host.
pub struct UsbTx<D: Driver<'static>> {
    sender: Sender<'static, D>,
    /// The last packet was full, so the host waits for another one.
    full: bool,
}

/// The host has not configured the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotConnectedError;

impl fmt::Display for NotConnectedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no host is connected")
    }
}

impl core::error::Error for NotConnectedError {}

impl embedded_io_async::Error for NotConnectedError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::NotConnected
    }
}

impl<D: Driver<'static>> Link for UsbLink<D> {
    type Rx = UsbRx<D>;
    type Tx = UsbTx<D>;

    /// USB at full speed carries several hundred kilobytes per second.
    const STREAMS: bool = true;

    fn split(self) -> (UsbRx<D>, UsbTx<D>) {
        let (sender, receiver, control) = self.class.split_with_control();
        let rx = UsbRx {
            receiver,
            control,
            configured: false,
            open: false,
            packet: [0; PACKET],
            rest: 0..0,
        };
        (rx, UsbTx { sender, full: false })
    }
}

impl<D: Driver<'static>> ErrorType for UsbRx<D> {
    type Error = NotConnectedError;
}

impl<D: Driver<'static>> Read for UsbRx<D> {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, NotConnectedError> {
        if self.rest.is_empty() {
            self.rest = 0..self.receive().await;
        }
        let count = self.rest.len().min(bytes.len());
        let taken = self.rest.start..self.rest.start + count;
        bytes[..count].copy_from_slice(&self.packet[taken.clone()]);
        self.rest.start = taken.end;
        Ok(count)
    }
}

impl<D: Driver<'static>> UsbRx<D> {
    /// Waits for the next packet that is not empty; returns 0, once, when the host has disconnected.
    async fn receive(&mut self) -> usize {
        loop {
            if !self.configured {
                self.receiver.wait_connection().await;
                self.configured = true;
            }
            let packet = self.receiver.read_packet(&mut self.packet);
            match select(packet, self.control.control_changed()).await {
                Either::First(Ok(0)) => {}
                Either::First(Ok(count)) => return count,
                Either::First(Err(_)) => {
                    self.configured = false;
                    self.open = false;
                    return 0;
                }
                Either::Second(()) => {
                    let was_open = core::mem::replace(&mut self.open, self.control.dtr());
                    if was_open && !self.open {
                        return 0;
                    }
                }
            }
        }
    }
}

impl<D: Driver<'static>> ErrorType for UsbTx<D> {
    type Error = NotConnectedError;
}

impl<D: Driver<'static>> Write for UsbTx<D> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, NotConnectedError> {
        let count = bytes.len().min(PACKET);
        self.sender.write_packet(&bytes[..count]).await.map_err(|_| NotConnectedError)?;
        self.full = count == PACKET;
        Ok(count)
    }

    /// After a full packet the host expects more, so an empty packet ends the transfer.
    async fn flush(&mut self) -> Result<(), NotConnectedError> {
        if self.full {
            self.sender.write_packet(&[]).await.map_err(|_| NotConnectedError)?;
            self.full = false;
        }
        Ok(())
    }
}
