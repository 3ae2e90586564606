//! Writes the sequence into the ADC.

use embassy_stm32::pac::adc::regs::{Smpr1, Smpr2, Sqr1, Sqr2, Sqr3};
use embassy_stm32::pac::adccommon::vals::Adcpre;
use embassy_stm32::pac::{ADC1, ADC1_COMMON};
use massline_blackpill_f411::plan::INPUTS;
use massline_blackpill_f411::sequence::sequence;

/// Clock, sequence and sample times.
pub fn configure() {
    ADC1_COMMON.ccr().modify(|w| {
        w.set_adcpre(Adcpre::DIV4);
        w.set_tsvrefe(true);
        w.set_vbate(false);
    });
    let registers = sequence(&INPUTS);
    ADC1.sqr1().write_value(Sqr1(registers.sqr1));
    ADC1.sqr2().write_value(Sqr2(registers.sqr2));
    ADC1.sqr3().write_value(Sqr3(registers.sqr3));
    ADC1.smpr1().write_value(Smpr1(registers.smpr1));
    ADC1.smpr2().write_value(Smpr2(registers.smpr2));
    ADC1.cr1().write(|w| w.set_scan(true));
}
