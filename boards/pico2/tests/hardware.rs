//! Tests on the chip: `cargo hardware-test` in the board's folder, with a probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

massline_cortex_m::hardware_tests! { massline_pico2 }
