//! Tests on the chip: `cargo image test nucleo-g474re --test hardware`, with a probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

massline_cortex_m::hardware_tests! {
    massline_nucleo_g474re

    #[test]
    fn the_reference_reading_of_the_factory_is_plausible(_board: Parts) {
        checks::the_reference_reading_of_the_factory_is_plausible(chip::adc::noted_code());
    }
}
