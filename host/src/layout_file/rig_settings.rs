//! Whether a rig can measure with the settings of a layout file.

use massline_shared::diagnosis::{Setting, Subject};
use massline_shared::layout::check_settings;
use massline_shared::signal::{SPECTRUM_BINS, transform_of};

use super::LayoutFile;
use super::error::Place;
use crate::report::message;

/// Scans per second of a rig.
const RATE: f32 = 4000.0;

impl LayoutFile {
    /// The first setting that no rig can measure with: its place in the file, and why.
    pub fn not_for_a_rig(&self) -> Option<String> {
        let test = &self.layout.test;
        let (rate, points) = transform_of(RATE, test.profile);
        let found = check_settings(test, rate.into(), points, SPECTRUM_BINS);
        let first = found.first()?;
        let place = match first.subject {
            Subject::Setting(setting) => self.place_of(setting),
            _ => self.place_of(Setting::BandLower),
        };
        let said = message(first);
        Some(place.map_or(said.clone(), |place| format!("{place}: {said}")))
    }

    fn place_of(&self, setting: Setting) -> Option<&Place> {
        self.places.iter().find(|(of, _)| *of == setting).map(|(_, place)| place)
    }
}
