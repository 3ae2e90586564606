//! Tests on the chip: `cargo image test pico2 --test hardware`, with a probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

massline_cortex_m::hardware_tests! { massline_pico2 }
