//! The ADCs: TIM6 starts a raw scan of ADC1 and ADC2 at the same time, and channel 1 of DMA1 writes the
//! pairs of codes into a circular buffer.

use embassy_stm32::interrupt::typelevel::{self, Handler};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::adc::Adc;
use embassy_stm32::pac::adc::regs::{Smpr, Smpr2, Sqr1, Sqr2};
use embassy_stm32::pac::adc::vals::{Adcaldif, Adstp, Exten, Trovs};
use embassy_stm32::pac::adccommon::vals::{Ckmode, Dmacfg, Dual, Mdma};
use embassy_stm32::pac::bdma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::pac::timer::vals::Mms;
use embassy_stm32::pac::{ADC1, ADC2, ADC12_COMMON, DMA1, DMAMUX1, GPIOA, GPIOB, GPIOC, RCC, TIM6};
use embassy_stm32::peripherals::{
    self, DMA1_CH1, PA0, PA1, PA4, PA6, PA7, PB0, PB14, PC0, PC1, PC2, PC3,
};
use embassy_stm32::{Peri, bind_interrupts};
use massline_cortex_m::sampler::{
    Converter, Plan, RawBuffer, RingSampler, Sentinel, SharedPipeline, Transfer,
};
use massline_cortex_m::sequence::{Input, sequence};
use massline_cortex_m::supply::{self, FactoryReading};
use massline_firmware::scan_ring::HalfFlags;

use crate::plan::{
    self, ADDED_UP, CORE_HZ, DECIMATION, HALF_SCANS, PAIR, PAIRS, RANKS, RAW_LENGTH, RING_SCANS,
    SENTINEL, TIMER_CYCLES, properties,
};
use crate::sequence::LAYOUT;

bind_interrupts!(struct Interrupts {
    DMA1_CHANNEL1 => HalfInterrupt;
});

/// The sampler of this board.
pub type AdcSampler = RingSampler<PairedAdcs, RANKS, RING_SCANS>;

static SHARED: SharedPipeline<RANKS, RING_SCANS> = SharedPipeline::new();
static RAW: RawBuffer<RAW_LENGTH> = RawBuffer::new();

/// Address of the manufacturer's reading of this chip's reference at 3.0 V, 12 bits.
const VREFINT_CAL: *const u16 = 0x1FFF_75AA as *const u16;
/// Trigger on TIM6's update: RM0440, external triggers of ADC1 and ADC2.
const TIM6_TRGO: u8 = 13;
/// DMA request of ADC1: RM0440, DMAMUX inputs.
const ADC1_REQUEST: u8 = 5;
/// Channel 1 of DMA1 is the first of both.
const STREAM: usize = 0;
/// Start-up time of an ADC's regulator.
const REGULATOR_CYCLES: u32 = CORE_HZ / 1_000_000 * 20;

/// Peripherals for the exclusive use of the sampler, which accesses their registers directly.
#[allow(dead_code, reason = "owned, not used through the HAL")]
pub struct Parts {
    /// The converters.
    pub adcs: (Peri<'static, peripherals::ADC1>, Peri<'static, peripherals::ADC2>),
    /// The transfer.
    pub dma: Peri<'static, DMA1_CH1>,
    /// The timer that starts a raw scan.
    pub timer: Peri<'static, peripherals::TIM6>,
    /// The inputs.
    pub channels: Channels,
    /// The input that is converted beside the reference, at ground.
    pub spare: Peri<'static, PA7>,
}

/// Hammer, sensor 1 x, y, z, sensor 2 x, …
pub type Channels = (
    Peri<'static, PA0>,
    Peri<'static, PA1>,
    Peri<'static, PC0>,
    Peri<'static, PC1>,
    Peri<'static, PC2>,
    Peri<'static, PC3>,
    Peri<'static, PB0>,
    Peri<'static, PA4>,
    Peri<'static, PB14>,
    Peri<'static, PA6>,
);

/// The reference's reading at 3.3 V, converted from the manufacturer's at 3.0 V.
pub fn noted_code() -> u16 {
    // SAFETY: the address is a word of system memory that is always readable.
    FactoryReading::code_at_three_volts(unsafe { VREFINT_CAL.read_volatile() })
}

/// Creates the sampler, halted.
pub fn sampler(parts: Parts) -> AdcSampler {
    let noted = FactoryReading::new(noted_code());
    let reference = Sentinel::Reference { noted, before: SENTINEL - PAIR };
    let plan = Plan {
        adc: properties(supply::REFERENCE),
        decimation: DECIMATION,
        sentinel: (reference, SENTINEL),
    };
    RingSampler::new(PairedAdcs::new(parts), &SHARED, plan)
}

/// ADCs, timer and transfer.
pub struct PairedAdcs {
    _parts: Parts,
}

impl PairedAdcs {
    fn new(parts: Parts) -> Self {
        RCC.ahb2enr().modify(|w| w.set_adc12en(true));
        RCC.apb1enr1().modify(|w| w.set_tim6en(true));
        analog(GPIOA, &[0, 1, 4, 6, 7]);
        analog(GPIOB, &[0, 14]);
        analog(GPIOC, &[0, 1, 2, 3]);
        ADC12_COMMON.ccr().write(|w| {
            w.set_ckmode(Ckmode::SYNC_DIV4);
            w.set_vrefen(true);
            w.set_dual(Dual::DUAL_R);
            w.set_mdma(Mdma::ENABLED12B10B);
            w.set_dmacfg(Dmacfg::CIRCULAR);
        });
        switch_on(ADC1, &plan::ADC1);
        switch_on(ADC2, &plan::ADC2);
        // ADC2 follows ADC1.
        ADC1.cfgr().modify(|w| {
            w.set_extsel(TIM6_TRGO);
            w.set_exten(Exten::RISING_EDGE);
        });
        TIM6.cr2().modify(|w| w.set_mms(Mms::UPDATE));
        TIM6.psc().write_value(0);
        TIM6.arr().write(|w| w.set_arr(TIMER_CYCLES as u16 - 1));
        DMAMUX1.ccr(STREAM).write(|w| w.set_dmareq_id(ADC1_REQUEST));
        let _ = Interrupts;
        interrupt::DMA1_CHANNEL1.set_priority(Priority::P0);
        interrupt::DMA1_CHANNEL1.unpend();
        // SAFETY: the interrupt handler accesses statics only.
        unsafe { interrupt::DMA1_CHANNEL1.enable() };
        Self { _parts: parts }
    }
}

fn analog(port: Gpio, pins: &[usize]) {
    port.moder().modify(|w| pins.iter().for_each(|&pin| w.set_moder(pin, Moder::ANALOG)));
}

/// Sets up the regulator, calibration, sequence and oversampling; then the ADC is ready.
fn switch_on(adc: Adc, inputs: &[Input; PAIRS]) {
    adc.cr().modify(|w| {
        w.set_deeppwd(false);
        w.set_advregen(true);
    });
    cortex_m::asm::delay(REGULATOR_CYCLES);
    adc.cr().modify(|w| w.set_adcaldif(Adcaldif::SINGLE_ENDED));
    adc.cr().modify(|w| w.set_adcal(true));
    while adc.cr().read().adcal() {}
    // Four ADC cycles must pass before the ADC may be enabled.
    cortex_m::asm::delay(64);
    let registers = sequence(inputs, &LAYOUT);
    adc.sqr1().write_value(Sqr1(registers.ranks[0]));
    adc.sqr2().write_value(Sqr2(registers.ranks[1]));
    adc.smpr().write_value(Smpr(registers.times[0]));
    adc.smpr2().write_value(Smpr2(registers.times[1]));
    adc.cfgr2().write(|w| {
        w.set_rovse(true);
        w.set_ovsr(ADDED_UP.ilog2() as u8 - 1);
        w.set_ovss(0);
        w.set_trovs(Trovs::AUTOMATIC);
    });
    adc.isr().write(|w| w.set_adrdy(true));
    adc.cr().modify(|w| w.set_aden(true));
    while !adc.isr().read().adrdy() {}
}

impl Converter for PairedAdcs {
    fn start(&mut self) {
        ADC1.isr().write(|w| w.set_ovr(true));
        ADC2.isr().write(|w| w.set_ovr(true));
        clear(HalfFlags { first: true, second: true });
        let channel = DMA1.ch(STREAM);
        channel.par().write_value(ADC12_COMMON.cdr().as_ptr() as u32);
        channel.mar().write_value(RAW.address());
        channel.ndtr().write(|w| w.set_ndt((RAW_LENGTH / PAIR) as u16));
        channel.cr().write(|w| {
            w.set_dir(Dir::FROM_PERIPHERAL);
            w.set_psize(Size::BITS32);
            w.set_msize(Size::BITS32);
            w.set_minc(true);
            w.set_circ(true);
            w.set_pl(Pl::VERY_HIGH);
            w.set_htie(true);
            w.set_tcie(true);
            w.set_en(true);
        });
        ADC1.cr().modify(|w| w.set_adstart(true));
        TIM6.cnt().write(|w| w.set_cnt(0));
        TIM6.cr1().modify(|w| w.set_cen(true));
    }

    fn stop(&mut self) {
        TIM6.cr1().modify(|w| w.set_cen(false));
        if ADC1.cr().read().adstart() {
            ADC1.cr().modify(|w| w.set_adstp(Adstp::STOP));
            while ADC1.cr().read().adstart() {}
        }
        DMA1.ch(STREAM).cr().modify(|w| w.set_en(false));
        clear(HalfFlags { first: true, second: true });
    }

    fn overrun(&self) -> bool {
        ADC1.isr().read().ovr() || ADC2.isr().read().ovr()
    }
}

fn clear(flags: HalfFlags) {
    DMA1.ifcr().write(|w| {
        w.set_htif(STREAM, flags.first);
        w.set_tcif(STREAM, flags.second);
    });
}

/// Interrupt handler of the transfer.
struct HalfInterrupt;

impl Handler<typelevel::DMA1_CHANNEL1> for HalfInterrupt {
    unsafe fn on_interrupt() {
        SHARED.on_interrupt(&Words, |half, index| RAW.raw_scan(half, index));
    }
}

/// The transfer; it counts words, each of a pair of codes.
struct Words;

impl Transfer for Words {
    const LENGTH: usize = RAW_LENGTH;
    const HALF_SCANS: usize = HALF_SCANS;

    fn flags(&self) -> HalfFlags {
        let flags = DMA1.isr().read();
        HalfFlags { first: flags.htif(STREAM), second: flags.tcif(STREAM) }
    }

    fn clear(&self, flags: HalfFlags) {
        clear(flags);
    }

    fn remaining(&self) -> u16 {
        DMA1.ch(STREAM).ndtr().read().ndt() * PAIR as u16
    }
}
