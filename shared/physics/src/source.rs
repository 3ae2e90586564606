//! The interface between what makes scans (the bench, a tape) and what consumes them (the virtual rig's
//! sampler, the emulated rig's ring, a tape being written).

use massline_shared::signal::{AdcProperties, Scan};

/// Makes scans, in place of the analogue front end and the person with the hammer.
pub trait ScanSource: Send {
    /// Rate, resolution and delay of the scans.
    fn adc(&self) -> AdcProperties;

    /// Sampling starts; the rig does not wait for a hit until [`ScanSource::armed`] is called.
    fn started(&mut self) {}

    /// The rig waits for a hit at DOF `dof` of the layout, as the person reads on the panel; `arming` is
    /// different each time.
    fn armed(&mut self, arming: u32, dof: usize);

    /// The next scan, or `None` when there are none until the next arming.
    fn next_scan(&mut self) -> Option<Scan>;
}
