//! Tests of what crosses the packages of massline. They live in `tests/`; here is what they share.

pub mod campaign;
pub mod faulty_sampler;
pub mod garbage;
