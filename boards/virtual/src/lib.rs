//! The rig as a host process: the application of the real rig over a simulated bench.
//!
//! | module | subject |
//! | --- | --- |
//! | [`bench`] | the object on its cords, the hammer, the sensors, the ADC |
//! | [`source`] | the seam between whoever makes scans and whoever consumes them |

pub mod bench;
pub mod source;
