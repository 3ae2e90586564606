//! Size and resolution of the spectra that the rig keeps.

use massline_shared::signal::{RECORD_SCANS, RESPONSES, SPECTRUM_LINES, Spectra};

/// The averaged spectra of one DOF as the rig keeps them.
pub(crate) type RigSpectra = Spectra<f32, RESPONSES, SPECTRUM_LINES>;

/// Distance of the rig's spectral lines at a rate, Hz.
pub(crate) fn resolution(rate: f32) -> f32 {
    rate / RECORD_SCANS as f32
}
