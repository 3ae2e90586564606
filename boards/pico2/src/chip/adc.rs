//! The converter: a state machine of PIO0 makes its frames, two channels of the DMA write them alternately
//! into the halves of a buffer, and two more reset these channels to the start of their halves.
//!
//! ```text
//!  A, first half ─▶ reset A ─▶ B, second half ─▶ reset B ─▶ A
//! ```

use core::sync::atomic::{AtomicU16, Ordering};

use embassy_rp::interrupt::typelevel::{self, Handler};
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::pac;
use embassy_rp::pac::dma::regs::{ChTransCount, CtrlTrig};
use embassy_rp::pac::dma::vals::{DataSize, TreqSel};
use embassy_rp::peripherals::{
    DMA_CH0, DMA_CH1, DMA_CH2, DMA_CH3, PIN_16, PIN_17, PIN_18, PIN_19, PIO0,
};
use embassy_rp::pio::{
    self, Config, Direction, LoadedProgram, Pio, ShiftConfig, ShiftDirection, StateMachine,
};
use embassy_rp::{Peri, bind_interrupts, gpio};
use massline_cortex_m::sampler::{
    Converter, Plan, RawBuffer, RingSampler, Sentinel, SharedPipeline,
};
use massline_firmware::board::ConverterFault;
use massline_firmware::scan_ring::HalfFlags;
use static_cell::StaticCell;

use crate::ads7953::{COMMANDS, FRAMES_TO_START, Start, ranks};
use crate::frames;
use crate::plan::{
    DECIMATION, DIVIDER, IN_STEP, PROPERTIES, RANKS, RAW_LENGTH, RING_SCANS, SENTINEL,
};
use crate::transfer::{Frames, HALF, LINE, Registers, WRITERS, bits};

bind_interrupts!(struct Interrupts {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    DMA_IRQ_1 => HalfInterrupt;
});

/// The sampler of this board.
pub type AdcSampler = RingSampler<Ads7953, RANKS, RING_SCANS>;

static SHARED: SharedPipeline<RANKS, RING_SCANS> = SharedPipeline::new();
static RAW: RawBuffer<RAW_LENGTH> = RawBuffer::new();
/// What was wrong at the last start: the fault, and above it the tag.
static FAULT: AtomicU16 = AtomicU16::new(0);

/// What is wrong with the converter, and the channel in its first wrong frame.
pub fn fault() -> (ConverterFault, u8) {
    let [fault, tag] = FAULT.load(Ordering::Relaxed).to_le_bytes();
    (fault.into(), tag)
}

/// The channels of the DMA that reset those that write frames.
const SETTERS: [usize; 2] = [1, 3];
const ALL: u16 = 0b1111;
/// Both halves of the buffer.
const BOTH: HalfFlags = HalfFlags { first: true, second: true };
/// The state machine that the sampler uses.
const MACHINE: usize = 0;
/// Number of polls for a frame, which takes 625 cycles, before the converter is given up.
const LOOKS: usize = 10_000;

/// Peripherals for the exclusive use of the sampler.
pub struct Parts {
    /// The PIO, which makes the frames.
    pub pio: Peri<'static, PIO0>,
    /// The transfer; its registers are accessed directly.
    pub dma: Channels,
    /// SDO of the converter.
    pub data_out: Peri<'static, PIN_16>,
    /// SCLK.
    pub clock: Peri<'static, PIN_18>,
    /// CS.
    pub select: Peri<'static, PIN_19>,
    /// SDI.
    pub data_in: Peri<'static, PIN_17>,
}

/// Channels 0 to 3 of the DMA.
pub type Channels = (
    Peri<'static, DMA_CH0>,
    Peri<'static, DMA_CH1>,
    Peri<'static, DMA_CH2>,
    Peri<'static, DMA_CH3>,
);

/// Creates the sampler, halted.
pub fn sampler(parts: Parts) -> AdcSampler {
    let plan = Plan {
        adc: PROPERTIES,
        decimation: DECIMATION,
        sentinel: (Sentinel::Code(IN_STEP), SENTINEL),
    };
    RingSampler::new(Ads7953::new(parts), &SHARED, plan)
}

/// The converter, its state machine and its transfer.
pub struct Ads7953 {
    machine: StateMachine<'static, PIO0, MACHINE>,
    program: LoadedProgram<'static, PIO0>,
    /// Start addresses of the halves, in RAM because the DMA reads them.
    starts: &'static [u32; 2],
    _dma: Channels,
}

impl Ads7953 {
    fn new(parts: Parts) -> Self {
        static STARTS: StaticCell<[u32; 2]> = StaticCell::new();
        let Parts { pio, dma, data_out, clock, select, data_in } = parts;
        let Pio { mut common, sm0: mut machine, .. } = Pio::new(pio, Interrupts);
        let program = common.load_program(&frames::program());
        let [mut data_out, data_in] = [common.make_pio_pin(data_out), common.make_pio_pin(data_in)];
        let [clock, select] = [common.make_pio_pin(clock), common.make_pio_pin(select)];
        // Without a converter the line is high, which is not a channel that the rig uses.
        data_out.set_pull(gpio::Pull::Up);
        let mut config = Config::default();
        config.use_program(&program, &[&clock, &select]);
        config.set_out_pins(&[&data_in]);
        config.set_in_pins(&[&data_out]);
        config.clock_divider = (DIVIDER as u16).into();
        let left = ShiftConfig { direction: ShiftDirection::Left, ..ShiftConfig::default() };
        config.shift_in = left;
        config.shift_out = left;
        machine.set_config(&config);
        machine.set_pins(gpio::Level::High, &[&select]);
        machine.set_pins(gpio::Level::Low, &[&clock, &data_in]);
        machine.set_pin_dirs(Direction::Out, &[&clock, &select, &data_in]);
        let half = HALF * size_of::<u16>() as u32;
        let starts = STARTS.init([RAW.address(), RAW.address() + half]);
        interrupt::DMA_IRQ_1.set_priority(Priority::P0);
        interrupt::DMA_IRQ_1.unpend();
        // SAFETY: the interrupt handler accesses statics only.
        unsafe { interrupt::DMA_IRQ_1.enable() };
        Self { machine, program, starts, _dma: dma }
    }

    /// Reads frames until the end of a pass.
    fn find_start(&mut self) -> bool {
        let mut start = Start::new();
        let mut frames = (0..COMMANDS.len() + FRAMES_TO_START)
            .map_while(|_| (0..LOOKS).find_map(|_| self.machine.rx().try_pull()));
        let is_aligned = frames.any(|frame| start.ends_with(frame as u16));
        let (fault, tag) = if is_aligned { (ConverterFault::None, 0) } else { start.fault() };
        FAULT.store(u16::from_le_bytes([fault.into(), tag]), Ordering::Relaxed);
        is_aligned
    }

    fn start_transfer(&mut self) {
        for half in 0..2 {
            let (writer, setter) = (WRITERS[half], SETTERS[half]);
            let channel = pac::DMA.ch(writer);
            channel.read_addr().write_value(self.machine.rx_fifo_ptr() as u32);
            channel.write_addr().write_value(self.starts[half]);
            channel.trans_count().write_value(ChTransCount(HALF));
            let mut control = CtrlTrig(0);
            control.set_treq_sel(self.machine.rx_treq());
            control.set_data_size(DataSize::SIZE_HALFWORD);
            control.set_incr_write(true);
            control.set_high_priority(true);
            control.set_chain_to(setter as u8);
            control.set_en(true);
            channel.al1_ctrl().write_value(control.0);

            let channel = pac::DMA.ch(setter);
            channel.read_addr().write_value(&raw const self.starts[half] as u32);
            channel.write_addr().write_value(pac::DMA.ch(writer).write_addr().as_ptr() as u32);
            channel.trans_count().write_value(ChTransCount(1));
            let mut control = CtrlTrig(0);
            control.set_treq_sel(TreqSel::PERMANENT);
            control.set_data_size(DataSize::SIZE_WORD);
            control.set_high_priority(true);
            control.set_irq_quiet(true);
            control.set_chain_to(WRITERS[1 - half] as u8);
            control.set_en(true);
            channel.al1_ctrl().write_value(control.0);
        }
        Dma.clear(LINE, bits(BOTH));
        pac::DMA.inte(LINE).write_value(bits(BOTH));
        pac::DMA.multi_chan_trigger().write(|w| w.set_multi_chan_trigger(1 << WRITERS[0]));
    }
}

impl Converter for Ads7953 {
    /// Takes 0.2 ms. If the converter does not answer correctly, the transfer stays halted.
    fn start(&mut self) {
        self.machine.restart();
        self.machine.clear_fifos();
        // SAFETY: the machine is halted, and its program starts at this address.
        unsafe { self.machine.exec_jmp(self.program.origin) };
        for command in COMMANDS {
            self.machine.tx().push(u32::from(command) << u16::BITS);
        }
        self.machine.clkdiv_restart();
        self.machine.set_enable(true);
        if self.find_start() {
            self.start_transfer();
        }
        // Discards frames that arrived before the transfer was started.
        self.machine.rx().stalled();
    }

    fn stop(&mut self) {
        self.machine.set_enable(false);
        pac::DMA.inte(LINE).write_value(0);
        // Another channel must not start a channel while it is being aborted: RP2350-E5.
        for channel in WRITERS.into_iter().chain(SETTERS) {
            pac::DMA.ch(channel).al1_ctrl().write_value(0);
        }
        pac::DMA.chan_abort().write(|w| w.set_chan_abort(ALL));
        while pac::DMA.chan_abort().read().chan_abort() & ALL != 0 {}
        Dma.clear(LINE, bits(BOTH));
    }

    /// True when the machine had to wait for room in its FIFO, so that frames were late.
    fn overrun(&self) -> bool {
        pac::PIO0.fdebug().read().rxstall() & 1 << MACHINE != 0
    }
}

/// Interrupt handler of the transfer.
struct HalfInterrupt;

impl Handler<typelevel::DMA_IRQ_1> for HalfInterrupt {
    unsafe fn on_interrupt() {
        SHARED.on_interrupt(&Frames(Dma), |half, index| ranks(RAW.raw_scan(half, index)));
    }
}

/// The registers of the DMA.
struct Dma;

impl Registers for Dma {
    fn intr(&self, number: usize) -> u32 {
        pac::DMA.intr(number).read()
    }

    fn clear(&self, line: usize, channels: u32) {
        pac::DMA.ints(line).write_value(channels);
    }

    fn remaining(&self, channel: usize) -> Option<u32> {
        let channel = pac::DMA.ch(channel);
        channel.ctrl_trig().read().busy().then(|| channel.trans_count().read().count())
    }
}
