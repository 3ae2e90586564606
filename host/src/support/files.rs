//! Files that several commands read or write.

use std::path::Path;

use massline_shared::calibration::CalibrationRecord;
use massline_shared::diagnosis::Code;
use massline_shared::layout::{RIG_HITS, RIG_SENSORS, RigLayout, TestProfile};

use crate::output::Output;
use crate::support::rig_layout::not_for_a_rig;
use crate::{Error, Result};
use massline_files::calibration_file::CalibrationFile;
use massline_files::file::ExistingFile;
use massline_files::layout_file::LayoutFile;

/// The option to replace an existing file.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct ReplaceArgs {
    /// Replace a file that exists already.
    #[arg(long)]
    force: bool,
}

impl ReplaceArgs {
    /// What happens to a file that exists already.
    pub fn existing(self) -> ExistingFile {
        if self.force { ExistingFile::Replaced } else { ExistingFile::Kept }
    }
}

/// Reads a layout, and warns of what looks like values in another unit.
///
/// # Errors
/// When the file is bad.
pub fn layout(path: &Path, output: &mut Output) -> Result<LayoutFile> {
    layout_in_profile(path, None, output)
}

/// The same in another profile than the file states, where one is given.
///
/// # Errors
/// When the file is bad, or has a setting that does not go with the profile.
pub fn layout_in_profile(
    path: &Path,
    profile: Option<TestProfile>,
    output: &mut Output,
) -> Result<LayoutFile> {
    let file = LayoutFile::read_in_profile(path, profile)?;
    if !file.set_aside.is_empty() {
        let (profile, keys) = (file.layout.test.profile.name(), file.set_aside.join(", "));
        output.note(format!(
            "note: {} states {keys} for another profile; with --profile {profile} the defaults of that profile are \
             used",
            path.display()
        ));
    }
    warn_of_units(&file, path, output);
    Ok(file)
}

/// The same for a layout that may omit `sensors` and `hits`.
///
/// # Errors
/// When the file is bad.
pub fn candidates(path: &Path, output: &mut Output) -> Result<LayoutFile> {
    let file = LayoutFile::read_candidates(path)?;
    warn_of_units(&file, path, output);
    Ok(file)
}

fn warn_of_units(file: &LayoutFile, path: &Path, output: &mut Output) {
    for suspicion in file.suspicions() {
        output.warn(format!("{}: {suspicion}", path.display()));
    }
}

/// The layout of a file in the precision and capacity of the rig.
///
/// # Errors
/// When it has a setting that no rig can measure with, or more sensors or hits than any rig has room for.
pub fn for_rig(file: &LayoutFile, path: &Path) -> Result<RigLayout> {
    if let Some(reason) = not_for_a_rig(file) {
        return Err(Error::input(Code::SettingOutOfRange.name(), reason));
    }
    file.rig_layout().ok_or_else(|| {
        Error::input(
            "layout_too_large",
            format!(
                "{}: {} sensors and {} hits; a rig takes {RIG_SENSORS} and {RIG_HITS}, only \
                 `massline solve` takes more",
                path.display(),
                file.layout.sensors.len(),
                file.layout.hits.len(),
            ),
        )
    })
}

/// The calibration file's calibration for a layout; `None` without a file.
///
/// # Errors
/// When the file is bad or lacks a calibration that the layout names.
pub fn calibration(path: Option<&Path>, layout: &LayoutFile) -> Result<Option<CalibrationRecord>> {
    path.map(|path| CalibrationFile::read(path)?.for_layout(layout)).transpose()
}
