//! The rig on a Raspberry Pi Pico 2.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
massline_cortex_m::last_words!(massline_pico2::chip::restart);

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    massline_pico2::chip::main()
}

#[cfg(not(target_os = "none"))]
fn main() {
    use massline_pico2::facts::NAME;
    eprintln!(
        "This is firmware. Build it with\n    cargo image build {NAME}\nand flash it as the board's README says."
    );
    std::process::exit(2);
}
