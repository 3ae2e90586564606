//! Whether a rig can measure with a layout.

use massline_analysis::design::gravity_to_be_stated;
use massline_files::layout_file::LayoutFile;
use massline_protocol::message::{Identity, LayoutAnswer};
use massline_shared::diagnosis::{Diagnostic, Setting, Subject};
use massline_shared::layout::{RigLayout, TestProfile, check_settings, highest_frequency};
use massline_shared::signal::{SPECTRUM_BINS, transform_of};

use super::show;
use crate::output::Output;
use crate::{Error, Result};
use massline_report::words::{self, message};

/// Scans per second of a rig.
const RATE: f32 = 4000.0;

/// The first setting of a layout file that no rig can measure with: its place in the file, and why.
pub fn not_for_a_rig(file: &LayoutFile) -> Option<String> {
    let test = &file.layout.test;
    let (rate, points) = transform_of(RATE, test.profile);
    let diagnostics = check_settings(test, rate.into(), points, SPECTRUM_BINS);
    let first = diagnostics.first()?;
    let (setting, sentence) = match first.subject {
        Subject::Setting(setting) => {
            let highest = highest_frequency(rate, points, SPECTRUM_BINS);
            (setting, out_of_range(setting, first.value, test.profile, highest))
        }
        _ => (Setting::BandLower, message(first)),
    };
    let place = file.place_of(setting);
    Some(place.map_or(sentence.clone(), |place| format!("{place}: {sentence}")))
}

/// What is wrong with the value of a setting, and what a rig allows.
fn out_of_range(setting: Setting, value: f32, profile: TestProfile, highest: f32) -> String {
    let unit = setting.unit();
    let allowed = match setting {
        Setting::BandLower | Setting::BandUpper => {
            let profile = profile.name();
            format!(
                "; in the profile {profile} a band lies above 0 and ends at {highest:.1} Hz at most; without the line \
                 the default is used"
            )
        }
        _ => String::new(),
    };
    let space = if unit.is_empty() { "" } else { " " };
    format!("{value}{space}{unit} is out of the range of a rig{allowed}")
}

/// Rejects a layout that the rig has no inputs or memory for, before anything is sent.
pub fn fits(layout: &RigLayout, identity: &Identity) -> Result<()> {
    let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
    if sensors <= usize::from(identity.max_sensors) && hits <= usize::from(identity.max_hits) {
        return Ok(());
    }
    Err(Error::input(
        "layout_too_large",
        format!(
            "the layout has {sensors} sensors and {hits} hits; this rig takes {} and {}",
            identity.max_sensors, identity.max_hits,
        ),
    ))
}

/// Reports the rig's diagnostics of the layout; an error among them ends the command unless `force` is set.
pub fn judge_layout(
    answer: &LayoutAnswer,
    layout: &RigLayout,
    force: bool,
    output: &mut Output,
) -> Result<()> {
    let message_of = |d: &Diagnostic| words::message_in(d, layout);
    if let Some(error) = show::first_error(&answer.diagnostics, message_of)
        && !force
    {
        return Err(error);
    }
    show::warn(&answer.diagnostics, message_of, output);
    // What a rig finds after the last hit only.
    show::warn(gravity_to_be_stated(layout).as_slice(), message_of, output);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_that_no_rig_can_measure_with_is_named_with_its_place() {
        let text = include_str!("../../examples/three-bar-test-1.toml");
        let reason_of = |text: &str| not_for_a_rig(&LayoutFile::parse(text, "l.toml").unwrap());
        assert_eq!(reason_of(text), None);
        for (band, word) in [("[10.0, 1e6]", "1000000"), ("[10.0, 12.0]", "bins")] {
            let text = text.replace("band_hz = [10.0, 120.0]", &format!("band_hz = {band}"));
            let reason = reason_of(&text).unwrap();
            assert!(reason.contains(": test.band_hz: ") && reason.contains(word), "{reason}");
        }
    }
}
