//! The USB boot loader of STM32 chips: DFU 1.1 with ST's extensions (application note AN3156).
//!
//! A download of block 0 is a command: erase the sector at an address, or set the address pointer. Blocks
//! from 2 on are data at pointer + (block - 2) · transfer size. The operation begins when the status is first
//! read, and is complete when the state is no longer *busy*.

use std::thread;
use std::time::{Duration, Instant};

use dfu_core::functional_descriptor::FunctionalDescriptor;
use dfu_core::{DfuIo, State, Status};

use super::plan::Plan;
use super::{ProgressObserver, Step};
use massline_result::{Error, Result};

const OUT: u8 = 0b0010_0001;
const IN: u8 = 0b1010_0001;
const DOWNLOAD: u8 = 1;
const UPLOAD: u8 = 2;
const GET_STATUS: u8 = 3;
const CLEAR_STATUS: u8 = 4;
const ABORT: u8 = 6;

const SET_ADDRESS: u8 = 0x21;
const ERASE: u8 = 0x41;
/// The number of the first block of data.
const FIRST_BLOCK: u16 = 2;

/// Timeout of a single operation; erasing a sector of 128 KiB takes at most 4 s (data sheet, lowest supply
/// voltage).
const LATE: Duration = Duration::from_secs(20);

/// Erases, writes, reads back, and starts the program.
///
/// # Errors
/// `wrong_chip` when the boot loader describes another flash, `flash_refused` with its status,
/// `flash_differs` when the data read back are different, `usb_failed`, and when `watch` stops it.
pub fn flash<IO>(io: &IO, plan: &Plan, watch: &mut dyn ProgressObserver) -> Result<()>
where
    IO: DfuIo<Read = usize>,
    IO::Error: std::fmt::Display,
{
    let loader = Loader { io, block: usize::from(io.functional_descriptor().transfer_size) };
    same_flash(io, plan)?;
    can_do_both(io.functional_descriptor())?;
    loader.idle()?;
    loader.erase(plan, watch)?;
    loader.write(plan, watch)?;
    loader.verify(plan, watch)?;
    loader.leave(plan.board.flash.origin)
}

/// Checks that the boot loader describes the flash of the plan's chip; any other chip is not written.
fn same_flash<IO: DfuIo>(io: &IO, plan: &Plan) -> Result<()> {
    let board = plan.board;
    let wanted: Vec<u32> =
        board.flash.each_sector().map(|sector| sector.end - sector.start).collect();
    let memory = match io.protocol() {
        dfu_core::DfuProtocol::Dfuse { address, memory_layout } => {
            let sectors = memory_layout.as_ref();
            if *address == board.flash.origin && sectors == wanted {
                return Ok(());
            }
            let bytes: u64 = sectors.iter().map(|&size| u64::from(size)).sum();
            format!("{} KiB in {} sectors at 0x{address:08x}", bytes / 1024, sectors.len())
        }
        dfu_core::DfuProtocol::Dfu => "no addresses: it is not the boot loader of an STM32".into(),
    };
    Err(Error::device(
        "wrong_chip",
        format!(
            "the device in DFU mode has {memory}; a {} has {} KiB in {} sectors at 0x{:08x}",
            board.chip,
            board.flash.bytes() / 1024,
            wanted.len(),
            board.flash.origin,
        ),
    ))
}

fn can_do_both(descriptor: &FunctionalDescriptor) -> Result<()> {
    if descriptor.can_download && descriptor.can_upload && descriptor.transfer_size > 0 {
        return Ok(());
    }
    Err(Error::device("wrong_chip", "the device in DFU mode cannot be both written and read back"))
}

struct Loader<'io, IO> {
    io: &'io IO,
    /// Length of a full block, bytes.
    block: usize,
}

impl<IO> Loader<'_, IO>
where
    IO: DfuIo<Read = usize>,
    IO::Error: std::fmt::Display,
{
    fn erase(&self, plan: &Plan, watch: &mut dyn ProgressObserver) -> Result<()> {
        let mut done = 0;
        watch.at(Step::Erase, done, plan.erased())?;
        for sector in &plan.erase {
            self.command(ERASE, sector.start)
                .map_err(|e| e.within(format!("erasing the sector at 0x{:08x}", sector.start)))?;
            done += u64::from(sector.end - sector.start);
            watch.at(Step::Erase, done, plan.erased())?;
        }
        Ok(())
    }

    fn write(&self, plan: &Plan, watch: &mut dyn ProgressObserver) -> Result<()> {
        let mut done = 0;
        for segment in &plan.image.segments {
            self.command(SET_ADDRESS, segment.address)?;
            for (number, block) in (FIRST_BLOCK..).zip(segment.bytes.chunks(self.block)) {
                self.download(number, block)
                    .map_err(|e| e.within(format!("writing behind 0x{:08x}", segment.address)))?;
                done += block.len() as u64;
                watch.at(Step::Write, done, plan.image.len())?;
            }
        }
        Ok(())
    }

    fn verify(&self, plan: &Plan, watch: &mut dyn ProgressObserver) -> Result<()> {
        let mut done = 0;
        let mut read = vec![0; self.block];
        for segment in &plan.image.segments {
            self.idle()?;
            self.command(SET_ADDRESS, segment.address)?;
            // Leaves the download state; an upload starts from idle.
            self.send(ABORT, 0, &[])?;
            for (number, block) in (FIRST_BLOCK..).zip(segment.bytes.chunks(self.block)) {
                let read = &mut read[..block.len()];
                let got = self.io.read_control(IN, UPLOAD, number, read).map_err(broken)?;
                let same = read.iter().zip(block).take(got).take_while(|(a, b)| a == b).count();
                if same < block.len() {
                    return Err(differs(
                        segment.address + done_in(number, self.block) + same as u32,
                    ));
                }
                done += block.len() as u64;
                watch.at(Step::Verify, done, plan.image.len())?;
            }
        }
        self.idle()
    }

    /// Starts the program whose vector table is at `origin`. The device disconnects, sometimes before it has
    /// answered.
    fn leave(&self, origin: u32) -> Result<()> {
        self.command(SET_ADDRESS, origin)?;
        self.send(DOWNLOAD, 0, &[])?;
        let _ = self.status();
        Ok(())
    }

    fn command(&self, command: u8, address: u32) -> Result<()> {
        let mut bytes = [command; 5];
        bytes[1..].copy_from_slice(&address.to_le_bytes());
        self.download(0, &bytes)
    }

    /// Sends a block and waits until it has been processed.
    fn download(&self, number: u16, bytes: &[u8]) -> Result<()> {
        self.send(DOWNLOAD, number, bytes)?;
        let start = Instant::now();
        loop {
            let (status, state, pause) = self.status()?;
            match state {
                State::DfuDnbusy | State::DfuDnloadSync if start.elapsed() < LATE => {
                    thread::sleep(pause.min(LATE));
                }
                State::DfuDnloadIdle if status == Status::Ok => return Ok(()),
                _ => return Err(refused(status, state)),
            }
        }
    }

    /// Brings the device to the idle state, also from an error that an earlier session left.
    fn idle(&self) -> Result<()> {
        let (_, state, _) = self.status()?;
        match state {
            State::DfuIdle => return Ok(()),
            State::DfuError => self.send(CLEAR_STATUS, 0, &[])?,
            _ => self.send(ABORT, 0, &[])?,
        }
        match self.status()? {
            (_, State::DfuIdle, _) => Ok(()),
            (status, state, _) => Err(refused(status, state)),
        }
    }

    /// Status, state, and the time to wait before the next request.
    fn status(&self) -> Result<(Status, State, Duration)> {
        let mut answer = [0; 6];
        let got = self.io.read_control(IN, GET_STATUS, 0, &mut answer).map_err(broken)?;
        if got < answer.len() {
            return Err(Error::device("usb_failed", "the boot loader's status is cut short"));
        }
        let [status, p0, p1, p2, state, _] = answer;
        let pause = Duration::from_millis(u32::from_le_bytes([p0, p1, p2, 0]).into());
        Ok((Status::from(status), State::from(state), pause))
    }

    fn send(&self, request: u8, value: u16, bytes: &[u8]) -> Result<()> {
        self.io.write_control(OUT, request, value, bytes).map_err(broken)?;
        Ok(())
    }
}

/// Number of bytes before the block with this number.
fn done_in(number: u16, block: usize) -> u32 {
    u32::from(number - FIRST_BLOCK) * block as u32
}

fn broken(error: impl std::fmt::Display) -> Error {
    Error::device("usb_failed", format!("the USB transfer to the boot loader failed: {error}"))
}

fn refused(status: Status, state: State) -> Error {
    let advice = match status {
        Status::ErrVendor => {
            " The chip is protected against reading: its owner can lift that with \
                              ST's STM32CubeProgrammer, which erases all of it, the store too."
        }
        _ => "",
    };
    Error::device(
        "flash_refused",
        format!("the boot loader refuses: {status} (state {}){advice}", u8::from(state)),
    )
}

fn differs(address: u32) -> Error {
    Error::device(
        "flash_differs",
        format!(
            "0x{address:08x} reads back as something else than was written; flash it again, and if that \
             does not help, the chip's flash is worn"
        ),
    )
}

#[cfg(test)]
mod tests;
