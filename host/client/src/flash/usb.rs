//! Finds a boot loader on USB and communicates with it, without system libraries.

use std::time::Duration;

use dfu_core::functional_descriptor::FunctionalDescriptor;
use dfu_core::memory_layout::MemoryLayout;
use dfu_core::{DfuIo, DfuProtocol};
use massline_boards::boot_loader::{Dfu, UsbId};
use nusb::transfer::{ControlIn, ControlOut, ControlType, Recipient, TransferError};
use nusb::{DeviceInfo, ErrorKind, Interface, MaybeFuture};

use crate::udev;
use massline_result::{Error, Result};

/// Code of a computer whose USB devices cannot be listed.
pub const UNLISTED: &str = "usb_not_listed";
/// Prefix of the string that describes the alternate setting of the internal flash.
const FLASH: &str = "@Internal Flash";
/// The boot loader may not answer while it erases, so this is long.
const TIMEOUT: Duration = Duration::from_secs(20);

/// The boot loader of a chip, opened for its internal flash.
pub struct DfuDevice {
    interface: Interface,
    descriptor: FunctionalDescriptor,
    protocol: DfuProtocol<MemoryLayout>,
}

impl DfuDevice {
    /// Opens the only chip in DFU mode whose USB identity is that of `loader`.
    ///
    /// # Errors
    /// `no_dfu_device`, `several_dfu_devices`, `usb_denied`, `wrong_chip`, `usb_not_listed`, `usb_failed`.
    pub fn open(loader: &Dfu) -> Result<Self> {
        let device = only(devices()?, loader)?;
        let device = device.open().wait().map_err(|error| opened(&error, loader.usb))?;
        let configuration = device.active_configuration().map_err(failed)?;
        for setting in configuration.interface_alt_settings() {
            let Some(index) = setting.string_index() else { continue };
            // Every STM32 has its strings in US English.
            let text =
                device.get_string_descriptor(index, 0x0409, TIMEOUT).wait().map_err(failed)?;
            // The layout parser slices by bytes, so the text must be ASCII.
            if !text.starts_with(FLASH) || !text.is_ascii() {
                continue;
            }
            let descriptor = configuration
                .interface_alt_settings()
                .flat_map(|s| s.descriptors().collect::<Vec<_>>())
                .find_map(|d| FunctionalDescriptor::from_bytes(d.as_bytes()))
                .ok_or_else(|| failed("it has no DFU descriptor"))?
                .map_err(failed)?;
            let protocol = DfuProtocol::new(&text, descriptor.dfu_version).map_err(failed)?;
            let interface = device
                .claim_interface(setting.interface_number())
                .wait()
                .map_err(|error| opened(&error, loader.usb))?;
            interface.set_alt_setting(setting.alternate_setting()).wait().map_err(failed)?;
            return Ok(Self { interface, descriptor, protocol });
        }
        Err(Error::device("wrong_chip", "the device in DFU mode offers no internal flash"))
    }
}

fn only(devices: impl Iterator<Item = DeviceInfo>, loader: &Dfu) -> Result<DeviceInfo> {
    let UsbId { vendor, product } = loader.usb;
    let mine = |d: &DeviceInfo| (d.vendor_id(), d.product_id()) == (vendor, product);
    let mut candidates: Vec<_> = devices.filter(mine).collect();
    match (candidates.pop(), candidates.len()) {
        (Some(device), 0) => Ok(device),
        (Some(_), others) => Err(Error::device(
            "several_dfu_devices",
            format!("{} chips are in DFU mode; leave one of them connected", others + 1),
        )),
        (None, _) => Err(Error::device(
            "no_dfu_device",
            format!(
                "no chip in DFU mode (USB {vendor:04x}:{product:04x}): {}, and run this again. The cable must \
                 carry data. {}",
                loader.steps, loader.remedy
            ),
        )),
    }
}

fn opened(error: &nusb::Error, usb: UsbId) -> Error {
    match error.kind() {
        ErrorKind::PermissionDenied => Error::device(
            "usb_denied",
            format!(
                "the chip in DFU mode may not be opened ({error}): {}",
                udev::advice("usb", "ATTR", Some((usb.vendor, usb.product)))
            ),
        ),
        ErrorKind::Busy => Error::device(
            "usb_busy",
            "another program has opened the chip in DFU mode; end it and run this again",
        ),
        _ => failed(error),
    }
}

/// True when a chip whose boot loader has this identity is connected and may be opened.
///
/// # Errors
/// `usb_not_listed` when the USB devices cannot be listed; `usb_denied` and `usb_busy` when the chip cannot be opened.
pub fn is_connected(loader: &Dfu) -> Result<bool> {
    let UsbId { vendor, product } = loader.usb;
    let mut devices = devices()?;
    let Some(device) = devices.find(|d| (d.vendor_id(), d.product_id()) == (vendor, product))
    else {
        return Ok(false);
    };
    device.open().wait().map(|_| true).map_err(|error| opened(&error, loader.usb))
}

fn devices() -> Result<impl Iterator<Item = DeviceInfo>> {
    nusb::list_devices().wait().map_err(|error| {
        Error::device(UNLISTED, format!("the USB devices cannot be listed: {error}"))
    })
}

fn failed(error: impl std::fmt::Display) -> Error {
    // Windows gives a device to a program only through a driver, which it does not choose by itself.
    let driver = if cfg!(windows) {
        "; if the WinUSB driver is not installed, install it: boards/BRING-UP.md, \"Windows and the Black Pill\""
    } else {
        ""
    };
    Error::device("usb_failed", format!("the chip in DFU mode cannot be used: {error}{driver}"))
}

/// Why a transfer failed.
#[derive(Debug, thiserror::Error)]
pub enum UsbError {
    /// A bus error, or a request that the device refused.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// Resetting the device failed.
    #[error(transparent)]
    Reset(#[from] nusb::Error),
    /// A protocol error.
    #[error(transparent)]
    Dfu(#[from] dfu_core::Error),
}

impl DfuIo for DfuDevice {
    type Read = usize;
    type Write = usize;
    type Reset = ();
    type Error = UsbError;
    type MemoryLayout = MemoryLayout;

    fn read_control(
        &self,
        _: u8,
        request: u8,
        value: u16,
        buffer: &mut [u8],
    ) -> Result<usize, UsbError> {
        let transfer = ControlIn {
            control_type: ControlType::Class,
            recipient: Recipient::Interface,
            request,
            value,
            index: self.interface.interface_number().into(),
            length: u16::try_from(buffer.len()).unwrap_or(u16::MAX),
        };
        let read = self.interface.control_in(transfer, TIMEOUT).wait()?;
        let got = read.len().min(buffer.len());
        buffer[..got].copy_from_slice(&read[..got]);
        Ok(got)
    }

    fn write_control(
        &self,
        _: u8,
        request: u8,
        value: u16,
        buffer: &[u8],
    ) -> Result<usize, UsbError> {
        let transfer = ControlOut {
            control_type: ControlType::Class,
            recipient: Recipient::Interface,
            request,
            value,
            index: self.interface.interface_number().into(),
            data: buffer,
        };
        self.interface.control_out(transfer, TIMEOUT).wait()?;
        Ok(buffer.len())
    }

    /// Never called: the boot loader starts the program by itself.
    fn usb_reset(self) -> Result<(), UsbError> {
        Ok(())
    }

    fn protocol(&self) -> &DfuProtocol<MemoryLayout> {
        &self.protocol
    }

    fn functional_descriptor(&self) -> &FunctionalDescriptor {
        &self.descriptor
    }
}
