//! The seam between whoever makes scans (the bench, a tape) and whoever consumes them (the virtual
//! rig's sampler, the emulated rig's ring, a tape being written).

use massline_shared::signal::{AdcProperties, Scan};

/// Makes scans, as the analogue front end and the person with the hammer do together.
pub trait ScanSource: Send {
    /// Rate, resolution and delay of the scans.
    fn adc(&self) -> AdcProperties;

    /// Sampling starts, and the rig does not wait for a hit unless [`ScanSource::armed`] follows.
    fn started(&mut self) {}

    /// The person reads on the panel that the rig waits for a hit at DOF `dof` of the layout;
    /// `arming` is another number each time.
    fn armed(&mut self, arming: u32, dof: usize);

    /// The next scan, or `None` when nothing happens before the next arming.
    fn next_scan(&mut self) -> Option<Scan>;
}
