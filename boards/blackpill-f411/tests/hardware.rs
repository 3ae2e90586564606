//! Tests on the chip: `cargo hardware-test` in the board's folder, with a probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

massline_cortex_m::hardware_tests! {
    massline_blackpill_f411

    #[test]
    fn the_maker_has_noted_the_reference(_board: Parts) {
        checks::the_maker_has_noted_the_reference(chip::adc::noted_code());
    }
}
