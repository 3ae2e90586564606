//! The object on its cords, the hammer, the sensors, the ADC.
//!
//! A *bench* is everything on the analogue side of the rig: an object on soft cords, three accelerometers
//! glued slightly off their nominal positions, a hammer in the hand of a person who hits slightly beside
//! the mark, filters, noise and a multiplexed converter. A bench file describes it; a seed determines its
//! errors.
//!
//! ```text
//! tap ─▶ modes of the hanging object ─▶ specific force at each sensor ─▶ gain, cross-axis ─▶ clip ─▶ RC ─▶ noise ─▶ ADC
//!  └──────────────────────────────────────────────────▶ hammer gain ────────────────────────────▶ RC ─▶ noise ─▶ ADC
//! ```
//!
//! A draught and creaking cords move the object as well. Motion without a tap is computed a whole scan at a time.
//!
//! | module | subject |
//! | --- | --- |
//! | `bench` | a checked bench: what all other modules read |
//! | [`file`](mod@file) | the bench file |
//! | [`settings`] | its tables: every key with default and allowed values; nodes, elastic modes, mistakes |
//! | [`body`] | composes the object from boxes, cylinders and points |
//! | [`suspension`] | how the object hangs, and its rigid modes |
//! | [`sprung_part`] | a part of the object on springs of its own, such as a tyre |
//! | [`dynamics`] | modal superposition |
//! | `free_response` | motion without a tap, a whole scan at a time |
//! | `environment` | draught and creaking cords |
//! | `loads` | what changes the rigid modes unknown to the layout: boards, cables |
//! | `channels` | values of all channels |
//! | [`chain`] | clipping, compression, low-pass, noise |
//! | `flicker` | 1/f noise of the sensors |
//! | `streams` | streams of random numbers |
//! | `slow` | random processes that change little from scan to scan: wander, draught |
//! | `converter` | from filtered signals to codes: rails, drift, memory of the multiplexer |
//! | `mains` | the hum of the mains |
//! | `supply` | ripple and droops of the supply |
//! | `nonlinearity` | integral and differential nonlinearity of the converter |
//! | [`errors`] | errors that stay constant over a test |
//! | [`error_sizes`] | how large they and those of the hits are |
//! | `faults` | what mistakes do to sensors, hits and cables |
//! | [`taps`] | good and bad taps |
//! | `habit` | what all hits at a DOF have in common: side of the mark, forces of the tip |
//! | [`responses`] | frequency responses by formula, without taps |
//! | [`tumble`] | the sensors held still in the six positions of a tumble test |
//! | [`operator`] | the person, and the bench as a source of scans |
//! | [`source`] | the interface between what makes scans and what consumes them |

#![forbid(unsafe_code)]

mod bench;
pub mod body;
pub mod chain;
mod channels;
mod converter;
pub mod dynamics;
mod environment;
pub mod error_sizes;
pub mod errors;
mod faults;
pub mod file;
mod flicker;
mod free_response;
mod habit;
mod loads;
mod locate;
mod mains;
mod nonlinearity;
pub mod operator;
pub mod responses;
pub mod settings;
mod simulation;
mod slow;
pub mod source;
pub mod sprung_part;
mod streams;
mod supply;
pub mod suspension;
pub mod taps;
pub mod tumble;

#[cfg(test)]
mod tests;

pub use bench::{Bench, BenchError};
pub use error_sizes::ErrorSizes;
pub use file::BundledBench;
pub use locate::BenchFileError;
pub use operator::{BenchSource, TapHandle};
pub use settings::{ErrorsFrom, Fault};
pub use tumble::{TumbleHandle, TumbleSource};
