//! `[environment]`.

use super::CORRELATION;

settings! {
    /// `[environment]`: what moves the object besides the hammer, before a tap as well as after it.
    ///
    /// A draught is a random force at the centre of mass and a random moment about it, whose components along the
    /// body axes are independent and normal. A creak of a cord is a short push at the point where a cord holds the
    /// object: along the cord, or in any direction where a mount holds it.
    EnvironmentSettings, "a table [environment]" {
        /// Force of the draught along each body axis, rms, N.
        draught_n: f64 = 0.0, 0.0..=1e3;
        /// Moment of the draught about each body axis, rms, N m.
        draught_n_m: f64 = 0.0, 0.0..=1e3;
        /// Time over which the draught forgets its value: its correlation falls to 1/e, s.
        draught_s: f64 = 1.0, CORRELATION;
        /// Mean number of creaks in a second.
        creak_rate_per_s: f64 = 0.0, 0.0..=100.0;
        /// Impulse of a creak, which is normally distributed about zero, rms, N s.
        creak_n_s: f64 = 0.0, 0.0..=100.0;
    }
}
