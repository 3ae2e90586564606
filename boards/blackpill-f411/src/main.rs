//! The rig on a Black Pill.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
massline_cortex_m::last_words!(cortex_m::peripheral::SCB::sys_reset);

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    massline_blackpill_f411::chip::main()
}

#[cfg(not(target_os = "none"))]
fn main() {
    use massline_blackpill_f411::facts::NAME;
    eprintln!(
        "This is firmware. Build it with\n    cargo image build {NAME}\nand flash it as the board's README says."
    );
    std::process::exit(2);
}
