//! Code shared by the tests of massline that span several packages; the tests themselves are in `tests/`.

pub mod campaign;
pub mod faulty_sampler;
pub mod garbage;
pub mod held_scans;
