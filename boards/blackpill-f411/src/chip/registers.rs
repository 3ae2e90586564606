//! Writes the sequence into the ADC.

use crate::plan::INPUTS;
use crate::sequence::LAYOUT;
use embassy_stm32::pac::adc::regs::{Smpr1, Smpr2, Sqr1, Sqr2, Sqr3};
use embassy_stm32::pac::adccommon::vals::Adcpre;
use embassy_stm32::pac::{ADC1, ADC1_COMMON};
use massline_cortex_m::sequence::sequence;

/// Sets clock, sequence and sample times.
pub fn configure() {
    ADC1_COMMON.ccr().modify(|w| {
        w.set_adcpre(Adcpre::DIV4);
        w.set_tsvrefe(true);
        w.set_vbate(false);
    });
    let registers = sequence(&INPUTS, &LAYOUT);
    let [sqr3, sqr2, sqr1, _] = registers.ranks;
    let [smpr2, smpr1] = registers.times;
    ADC1.sqr1().write_value(Sqr1(sqr1));
    ADC1.sqr2().write_value(Sqr2(sqr2));
    ADC1.sqr3().write_value(Sqr3(sqr3));
    ADC1.smpr1().write_value(Smpr1(smpr1));
    ADC1.smpr2().write_value(Smpr2(smpr2));
    ADC1.cr1().write(|w| w.set_scan(true));
}
