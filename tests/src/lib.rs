//! Code shared by the tests of massline that span several packages; the tests themselves are in `tests/`.

pub mod campaign;
pub mod drawn_wheels;
pub mod faulty_sampler;
pub mod garbage;
pub mod held_scans;
pub mod mistakes;
pub mod person;
pub mod pooled;
pub mod taped_hits;

/// True when `MASSLINE_LONG` asks for the tests with many runs, whose limits apply without allowances for few.
pub fn long() -> bool {
    std::env::var_os("MASSLINE_LONG").is_some()
}
