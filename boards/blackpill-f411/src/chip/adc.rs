//! The ADC: TIM3 starts a raw scan, and stream 0 of DMA2 writes it into a circular buffer.
//!
//! The HAL writes every rank to SQR3, which has room for only six, and does not check for overruns, so the
//! registers are accessed here.

use embassy_stm32::interrupt::typelevel::{self, Handler};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::adc::vals::{Dds, Exten};
use embassy_stm32::pac::dma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::pac::timer::vals::Mms;
use embassy_stm32::pac::{ADC1, DMA2, GPIOA, GPIOB, RCC, TIM3};
use embassy_stm32::peripherals::{
    self, DMA2_CH0, PA0, PA1, PA2, PA3, PA4, PA5, PA6, PA7, PB0, PB1,
};
use embassy_stm32::{Peri, bind_interrupts};
use massline_cortex_m::sampler::{
    Converter, Plan, RawBuffer, RingSampler, Sentinel, SharedPipeline, Transfer,
};
use massline_cortex_m::supply::{self, FactoryReading};
use massline_firmware::scan_ring::HalfFlags;

use super::registers;
use crate::plan::{
    DECIMATION, HALF_SCANS, RANKS, RAW_LENGTH, RING_SCANS, SENTINEL, TIMER_CYCLES, properties,
};

bind_interrupts!(struct Interrupts {
    DMA2_STREAM0 => HalfInterrupt;
});

/// The sampler of this board.
pub type AdcSampler = RingSampler<TimedAdc, RANKS, RING_SCANS>;

static SHARED: SharedPipeline<RANKS, RING_SCANS> = SharedPipeline::new();
static RAW: RawBuffer<RAW_LENGTH> = RawBuffer::new();

/// Address of the manufacturer's reading of this chip's reference, 12 bits.
const VREFINT_CAL: *const u16 = 0x1FFF_7A2A as *const u16;
/// Trigger on TIM3's update: RM0383, EXTSEL.
const TIM3_TRGO: u8 = 0b1000;
/// The DMA stream, and the ADC's channel of it.
const STREAM: usize = 0;
const CHANNEL: u8 = 0;

/// Peripherals for the exclusive use of the sampler, which accesses their registers directly.
#[allow(dead_code, reason = "owned, not used through the HAL")]
pub struct Parts {
    /// The converter.
    pub adc: Peri<'static, peripherals::ADC1>,
    /// The transfer.
    pub dma: Peri<'static, DMA2_CH0>,
    /// The timer that starts a raw scan.
    pub timer: Peri<'static, peripherals::TIM3>,
    /// The inputs.
    pub channels: Channels,
}

/// Hammer, sensor 1 x, y, z, sensor 2 x, …
pub type Channels = (
    Peri<'static, PA0>,
    Peri<'static, PA1>,
    Peri<'static, PA2>,
    Peri<'static, PA3>,
    Peri<'static, PA4>,
    Peri<'static, PA5>,
    Peri<'static, PA6>,
    Peri<'static, PA7>,
    Peri<'static, PB0>,
    Peri<'static, PB1>,
);

/// The manufacturer's reading of the reference at 3.3 V.
pub fn noted_code() -> u16 {
    // SAFETY: the address is a word of system memory that is always readable.
    unsafe { VREFINT_CAL.read_volatile() }
}

/// Creates the sampler, halted.
pub fn sampler(parts: Parts) -> AdcSampler {
    let noted = FactoryReading::new(noted_code());
    let reference = Sentinel::Reference { noted, before: SENTINEL - 1 };
    let plan = Plan {
        adc: properties(supply::REFERENCE),
        decimation: DECIMATION,
        sentinel: (reference, SENTINEL),
    };
    RingSampler::new(TimedAdc::new(parts), &SHARED, plan)
}

/// ADC, timer and transfer.
pub struct TimedAdc {
    _parts: Parts,
}

impl TimedAdc {
    fn new(parts: Parts) -> Self {
        RCC.apb2enr().modify(|w| w.set_adc1en(true));
        RCC.apb1enr().modify(|w| w.set_tim3en(true));
        GPIOA.moder().modify(|w| (0..8).for_each(|pin| w.set_moder(pin, Moder::ANALOG)));
        GPIOB.moder().modify(|w| (0..2).for_each(|pin| w.set_moder(pin, Moder::ANALOG)));
        registers::configure();
        TIM3.cr2().modify(|w| w.set_mms(Mms::UPDATE));
        TIM3.psc().write_value(0);
        TIM3.arr().write(|w| w.set_arr(TIMER_CYCLES as u16 - 1));
        let _ = Interrupts;
        interrupt::DMA2_STREAM0.set_priority(Priority::P0);
        interrupt::DMA2_STREAM0.unpend();
        // SAFETY: the interrupt handler accesses statics only.
        unsafe { interrupt::DMA2_STREAM0.enable() };
        Self { _parts: parts }
    }
}

impl Converter for TimedAdc {
    fn start(&mut self) {
        ADC1.sr().write(|_| {});
        let stream = DMA2.st(STREAM);
        clear(HalfFlags { first: true, second: true });
        stream.par().write_value(ADC1.dr().as_ptr() as u32);
        stream.m0ar().write_value(RAW.address());
        stream.ndtr().write(|w| w.set_ndt(RAW_LENGTH as u16));
        stream.cr().write(|w| {
            w.set_chsel(CHANNEL);
            w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
            w.set_psize(Size::BITS16);
            w.set_msize(Size::BITS16);
            w.set_minc(true);
            w.set_circ(true);
            w.set_pl(Pl::VERY_HIGH);
            w.set_htie(true);
            w.set_tcie(true);
            w.set_en(true);
        });
        // The converter is ready after 3 µs; the first trigger occurs after 42 µs.
        ADC1.cr2().write(|w| {
            w.set_adon(true);
            w.set_dma(true);
            w.set_dds(Dds::CONTINUOUS);
            w.set_extsel(TIM3_TRGO);
            w.set_exten(Exten::RISING_EDGE);
        });
        TIM3.cnt().write(|w| w.set_cnt(0));
        TIM3.cr1().modify(|w| w.set_cen(true));
    }

    fn stop(&mut self) {
        TIM3.cr1().modify(|w| w.set_cen(false));
        // Switching the converter off resets its position in the sequence.
        ADC1.cr2().write(|_| {});
        let stream = DMA2.st(STREAM);
        stream.cr().modify(|w| w.set_en(false));
        while stream.cr().read().en() {}
        clear(HalfFlags { first: true, second: true });
    }

    fn overrun(&self) -> bool {
        ADC1.sr().read().ovr()
    }
}

fn clear(flags: HalfFlags) {
    DMA2.ifcr(STREAM / 4).write(|w| {
        w.set_htif(STREAM % 4, flags.first);
        w.set_tcif(STREAM % 4, flags.second);
    });
}

/// Interrupt handler of the stream.
struct HalfInterrupt;

impl Handler<typelevel::DMA2_STREAM0> for HalfInterrupt {
    unsafe fn on_interrupt() {
        SHARED.on_interrupt(&Stream, |half, index| RAW.raw_scan(half, index));
    }
}

struct Stream;

impl Transfer for Stream {
    const LENGTH: usize = RAW_LENGTH;
    const HALF_SCANS: usize = HALF_SCANS;

    fn flags(&self) -> HalfFlags {
        let flags = DMA2.isr(STREAM / 4).read();
        HalfFlags { first: flags.htif(STREAM % 4), second: flags.tcif(STREAM % 4) }
    }

    fn clear(&self, flags: HalfFlags) {
        clear(flags);
    }

    fn remaining(&self) -> u16 {
        DMA2.st(STREAM).ndtr().read().ndt()
    }
}
