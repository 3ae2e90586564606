//! The rig's application: wires measuring, analysing, storing, talking and showing together over the
//! four seams of [`board`]. Nothing here knows a chip.
#![no_std]
#![forbid(unsafe_code)]

pub mod board;
pub mod panel;
pub mod store;
