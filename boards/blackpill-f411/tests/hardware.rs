//! Tests on the chip: `cargo image test blackpill-f411 --test hardware`, with a probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

massline_cortex_m::hardware_tests! {
    massline_blackpill_f411

    #[test]
    fn the_reference_reading_of_the_factory_is_plausible(_board: Parts) {
        checks::the_reference_reading_of_the_factory_is_plausible(chip::adc::noted_code());
    }

    #[test]
    fn the_voltage_is_that_for_96_megahertz(_board: Parts) {
        use embassy_stm32::pac::PWR;
        use embassy_stm32::pac::pwr::vals::Vos;
        assert_eq!(PWR.cr1().read().vos(), Vos::SCALE1);
        assert!(PWR.csr1().read().vosrdy());
    }
}
