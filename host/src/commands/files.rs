//! Files that several commands read.

use std::path::Path;

use massline_shared::layout::{RIG_HITS, RIG_SENSORS, RigLayout};
use massline_shared::signal::Calibration;

use crate::calibration_file::CalibrationFile;
use crate::error::{Error, Result};
use crate::layout_file::LayoutFile;

/// A layout as the rig holds it.
///
/// # Errors
/// When the file is bad or has more than any rig has room for.
pub fn rig_layout(path: &Path) -> Result<RigLayout> {
    for_rig(&LayoutFile::read(path)?, path)
}

/// The layout of a file as the rig holds it.
///
/// # Errors
/// When it has more than any rig has room for.
pub fn for_rig(file: &LayoutFile, path: &Path) -> Result<RigLayout> {
    file.rig_layout().ok_or_else(|| {
        Error::input(
            "layout_too_large",
            format!(
                "{}: {} sensors and {} hits; a rig takes {RIG_SENSORS} and {RIG_HITS}, only `massline solve` takes more",
                path.display(),
                file.layout.sensors.len(),
                file.layout.hits.len(),
            ),
        )
    })
}

/// A calibration.
///
/// # Errors
/// When the file is bad.
pub fn calibration(path: &Path) -> Result<Calibration> {
    Ok(CalibrationFile::read(path)?.calibration)
}
