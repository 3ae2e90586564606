//! The DFU client against a model of the boot loader in ROM, after AN3156: its states, its commands, NOR
//! flash.

use std::cell::RefCell;

use dfu_core::DfuProtocol;
use dfu_core::memory_layout::MemoryLayout;

use super::super::board::Board;
use super::super::image::{Image, Segment};
use super::*;

const ORIGIN: u32 = 0x0800_0000;
const F411: &str = "@Internal Flash  /0x08000000/04*016Kg,01*064Kg,03*128Kg";

struct Rom {
    protocol: DfuProtocol<MemoryLayout>,
    descriptor: FunctionalDescriptor,
    state: RefCell<RomState>,
}

struct RomState {
    sectors: Vec<u32>,
    flash: Vec<u8>,
    pointer: u32,
    state: State,
    status: Status,
    /// The operation that the next status request starts.
    wanted: Option<(u16, Vec<u8>)>,
    erased: Vec<u32>,
    /// Address of a byte that ignores writes.
    worn: Option<u32>,
    protected: bool,
    started: Option<u32>,
}

#[derive(Debug)]
struct Stall;

impl From<dfu_core::Error> for Stall {
    fn from(_: dfu_core::Error) -> Self {
        Self
    }
}

impl std::fmt::Display for Stall {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("stalled")
    }
}

impl Rom {
    fn new(interface: &str) -> Self {
        let protocol = DfuProtocol::new(interface, (1, 0x1a)).unwrap();
        let DfuProtocol::Dfuse { memory_layout, .. } = &protocol else { panic!() };
        let sectors: Vec<u32> = memory_layout.to_vec();
        // The functional descriptor of the ROM of an STM32F411.
        let bytes = [9, 0x21, 0x0b, 0xff, 0, 0, 8, 0x1a, 1];
        Self {
            descriptor: FunctionalDescriptor::from_bytes(&bytes).unwrap().unwrap(),
            protocol,
            state: RefCell::new(RomState {
                flash: vec![0xA5; sectors.iter().sum::<u32>() as usize],
                sectors,
                pointer: ORIGIN,
                state: State::DfuIdle,
                status: Status::Ok,
                wanted: None,
                erased: Vec::new(),
                worn: None,
                protected: false,
                started: None,
            }),
        }
    }
}

impl RomState {
    fn fail(&mut self, status: Status) {
        (self.state, self.status) = (State::DfuError, status);
    }

    fn read_status(&mut self) -> [u8; 6] {
        let answer = |rom: &Self| [rom.status.into(), 1, 0, 0, rom.state.into(), 0];
        match self.state {
            State::DfuDnloadSync => {
                self.state = State::DfuDnbusy;
                let busy = answer(self);
                let (number, bytes) = self.wanted.take().unwrap();
                if bytes.is_empty() {
                    self.state = State::DfuManifest;
                    self.started = Some(self.pointer);
                    return answer(self);
                }
                self.work(number, &bytes);
                busy
            }
            State::DfuDnbusy => {
                self.state = State::DfuDnloadIdle;
                answer(self)
            }
            _ => answer(self),
        }
    }

    fn work(&mut self, number: u16, bytes: &[u8]) {
        if self.protected {
            return self.fail(Status::ErrVendor);
        }
        let address = |b: &[u8]| u32::from_le_bytes(b[1..5].try_into().unwrap());
        match (number, bytes[0]) {
            (0, 0x21) if bytes.len() == 5 => self.pointer = address(bytes),
            (0, 0x41) if bytes.len() == 5 => self.erase(address(bytes)),
            (2.., _) => self.program(number, bytes),
            _ => self.fail(Status::ErrStalledpkt),
        }
    }

    fn erase(&mut self, address: u32) {
        let mut start = ORIGIN;
        for size in self.sectors.clone() {
            if (start..start + size).contains(&address) {
                let at = (start - ORIGIN) as usize;
                self.flash[at..at + size as usize].fill(0xFF);
                self.erased.push(start);
                return;
            }
            start += size;
        }
        self.fail(Status::ErrTarget);
    }

    fn program(&mut self, number: u16, bytes: &[u8]) {
        let start = self.pointer + (u32::from(number) - 2) * 2048;
        for (address, byte) in (start..).zip(bytes) {
            let Some(cell) = self.flash.get_mut((address - ORIGIN) as usize) else {
                return self.fail(Status::ErrAddress);
            };
            *cell &= if self.worn == Some(address) { 0 } else { *byte };
        }
    }
}

impl DfuIo for Rom {
    type Read = usize;
    type Write = usize;
    type Reset = ();
    type Error = Stall;
    type MemoryLayout = MemoryLayout;

    fn read_control(
        &self,
        _: u8,
        request: u8,
        value: u16,
        buffer: &mut [u8],
    ) -> Result<usize, Stall> {
        let mut rom = self.state.borrow_mut();
        match request {
            3 => buffer.copy_from_slice(&rom.read_status()),
            2 if matches!(rom.state, State::DfuIdle | State::DfuUploadIdle) && value >= 2 => {
                rom.state = State::DfuUploadIdle;
                let at = (rom.pointer - ORIGIN) as usize + (usize::from(value) - 2) * 2048;
                buffer.copy_from_slice(&rom.flash[at..at + buffer.len()]);
            }
            _ => {
                rom.fail(Status::ErrStalledpkt);
                return Err(Stall);
            }
        }
        Ok(buffer.len())
    }

    fn write_control(&self, _: u8, request: u8, value: u16, buffer: &[u8]) -> Result<usize, Stall> {
        let mut rom = self.state.borrow_mut();
        match (request, rom.state) {
            (1, State::DfuIdle | State::DfuDnloadIdle) if buffer.len() <= 2048 => {
                rom.wanted = Some((value, buffer.to_vec()));
                rom.state = State::DfuDnloadSync;
            }
            (4, State::DfuError) | (6, State::DfuDnloadIdle | State::DfuUploadIdle) => {
                (rom.state, rom.status) = (State::DfuIdle, Status::Ok);
            }
            _ => {
                rom.fail(Status::ErrStalledpkt);
                return Err(Stall);
            }
        }
        Ok(buffer.len())
    }

    fn usb_reset(self) -> Result<(), Stall> {
        Ok(())
    }

    fn protocol(&self) -> &DfuProtocol<MemoryLayout> {
        &self.protocol
    }

    fn functional_descriptor(&self) -> &FunctionalDescriptor {
        &self.descriptor
    }
}

#[derive(Default)]
struct Log(Vec<(Step, u64, u64)>);

impl ProgressObserver for Log {
    fn at(&mut self, step: Step, done: u64, total: u64) -> massline_result::Result<()> {
        self.0.push((step, done, total));
        Ok(())
    }
}

/// An image with vectors in sector 0 and code from sector 4 into sector 5.
fn plan() -> Plan {
    let vectors = Segment { address: ORIGIN, bytes: vec![0x11; 408] };
    let code = (0..70_000u32).map(|i| (i * 7) as u8).collect();
    let code = Segment { address: ORIGIN + 0x1_0000, bytes: code };
    let board = Board::named("blackpill-f411").unwrap();
    Plan::new(board, Image { segments: vec![vectors, code] }).unwrap()
}

#[test]
fn the_image_is_written_verified_and_started_and_the_store_stays() {
    let rom = Rom::new(F411);
    let plan = plan();
    let mut log = Log::default();
    flash(&rom, &plan, &mut log).unwrap();
    let state = rom.state.borrow();
    for segment in &plan.image.segments {
        let at = (segment.address - ORIGIN) as usize;
        assert_eq!(state.flash[at..at + segment.bytes.len()], segment.bytes[..]);
    }
    assert!(state.flash[0x4000..0x1_0000].iter().all(|&byte| byte == 0xA5), "the store");
    assert!(state.flash[0x4_0000..].iter().all(|&byte| byte == 0xA5), "sectors without code");
    assert_eq!(state.erased, [ORIGIN, ORIGIN + 0x1_0000, ORIGIN + 0x2_0000]);
    assert_eq!(state.started, Some(ORIGIN));
    for step in [Step::Erase, Step::Write, Step::Verify] {
        let (_, done, total) = log.0.iter().rfind(|at| at.0 == step).unwrap();
        assert_eq!(done, total, "{step:?}");
    }
}

#[test]
fn an_error_that_was_left_behind_is_cleared() {
    let rom = Rom::new(F411);
    rom.state.borrow_mut().fail(Status::ErrFirmware);
    flash(&rom, &plan(), &mut Log::default()).unwrap();
    assert_eq!(rom.state.borrow().started, Some(ORIGIN));
}

#[test]
fn a_byte_that_reads_back_differently_is_named() {
    let rom = Rom::new(F411);
    rom.state.borrow_mut().worn = Some(ORIGIN + 0x1_0000 + 5001);
    let error = flash(&rom, &plan(), &mut Log::default()).unwrap_err();
    assert_eq!(error.code(), "flash_differs");
    assert!(error.to_string().contains("0x08011389"), "{error}");
    assert_eq!(rom.state.borrow().started, None);
}

#[test]
fn a_protected_chip_is_named() {
    let rom = Rom::new(F411);
    rom.state.borrow_mut().protected = true;
    let error = flash(&rom, &plan(), &mut Log::default()).unwrap_err();
    assert_eq!(error.code(), "flash_refused");
    assert!(error.to_string().contains("protected"), "{error}");
}

#[test]
fn the_flash_of_another_chip_is_not_written() {
    // An STM32F411CC: 256 KiB.
    let rom = Rom::new("@Internal Flash  /0x08000000/04*016Kg,01*064Kg,01*128Kg");
    let error = flash(&rom, &plan(), &mut Log::default()).unwrap_err();
    assert_eq!(error.code(), "wrong_chip");
    assert!(error.to_string().contains("256 KiB"), "{error}");
    assert!(rom.state.borrow().flash.iter().all(|&byte| byte == 0xA5));
}

/// The watch stops the flashing while the first sector is erased.
#[test]
fn an_interruption_ends_the_flashing() {
    struct Stop;
    impl ProgressObserver for Stop {
        fn at(&mut self, _: Step, done: u64, _: u64) -> massline_result::Result<()> {
            if done > 0 { Err(Error::interrupted("stopped")) } else { Ok(()) }
        }
    }
    let rom = Rom::new(F411);
    let error = flash(&rom, &plan(), &mut Stop).unwrap_err();
    assert_eq!(error.code(), "interrupted");
    assert_eq!(rom.state.borrow().erased, [ORIGIN]);
}
