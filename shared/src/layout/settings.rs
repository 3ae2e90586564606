//! Checks the `[test]` table against the capabilities of a rig.

use super::TestSettings;
use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Setting, Severity, Subject};

/// Largest number of hits at a DOF.
pub const MAX_HITS_PER_DOF: u8 = 50;

/// How the averaged spectra of a DOF are turned into its frequency responses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum FrfEstimator {
    /// `G_XF/G_FF`: unbiased when the noise is on the responses.
    #[default]
    H1,
    /// `G_XX/G_FX`: unbiased when the noise is on the force.
    H2,
    /// The geometric mean of both.
    Hv,
}

impl FrfEstimator {
    /// Every estimator.
    pub const ALL: [Self; 3] = [Self::H1, Self::H2, Self::Hv];

    /// The name in files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::H1 => "h1",
            Self::H2 => "h2",
            Self::Hv => "hv",
        }
    }
}

/// Highest frequency of a band, Hz, with the arguments of [`check_settings`]: 0.4 times the rate, and at most the last
/// stored bin.
pub fn highest_frequency<R: Real>(rate: R, record: usize, bins: usize) -> R {
    let resolution = rate / R::of(record.max(1) as f64);
    (rate / R::of(2.5)).min(resolution * R::of(bins.saturating_sub(1) as f64))
}

/// Errors for every setting outside its range ([`Setting`]) and for a band with too few bins for
/// the three terms of the mass line.
///
/// `rate` is in scans per second, `record` in scans; `bins` is the number of stored bins, the
/// first at 0 Hz.
///
/// ```
/// # use massline_shared::layout::{TestSettings, check_settings};
/// let good = TestSettings::<f32>::default();
/// assert!(check_settings(&good, 4000.0, 2048, 128).is_empty());
/// // 128 bins of 1.95 Hz end at 248 Hz.
/// let beyond = TestSettings { band_hz: Some([10.0, 300.0]), ..good };
/// assert_eq!(check_settings(&beyond, 4000.0, 2048, 128).len(), 1);
/// ```
pub fn check_settings<R: Real>(
    settings: &TestSettings<R>,
    rate: R,
    record: usize,
    bins: usize,
) -> Diagnostics {
    let mut found = Diagnostics::new();
    let resolution = rate / R::of(record.max(1) as f64);
    // A band found from the data is always suitable.
    let [lower, upper] = settings.band_hz.unwrap_or_else(|| [resolution, resolution + resolution]);
    let highest = highest_frequency(rate, record, bins);
    let duration = R::of(record as f64) / rate;
    let hits = R::of(f64::from(settings.hits_per_dof));
    let [least, most] = settings.impulse_ns;
    let zero = R::zero();
    let ranges = [
        (Setting::HitsPerDof, hits, (1..=MAX_HITS_PER_DOF).contains(&settings.hits_per_dof)),
        (Setting::BandLower, lower, lower > zero && (lower < upper || !upper.finite())),
        (Setting::BandUpper, upper, upper > zero && upper <= highest),
        (Setting::ExponentialDecay, settings.exponential_decay, settings.exponential_decay >= zero),
        (
            Setting::ForceWindow,
            settings.force_window_s,
            settings.force_window_s > zero && settings.force_window_s < duration,
        ),
        (Setting::Trigger, settings.trigger_n, settings.trigger_n > zero),
        (Setting::MinPeakForce, settings.min_peak_force_n, settings.min_peak_force_n >= zero),
        (Setting::ImpulseLower, least, least >= zero && (least < most || !most.finite())),
        (Setting::ImpulseUpper, most, most > zero),
    ];
    for (setting, value, good) in ranges {
        if !(good && value.finite()) {
            let (subject, value) = (Subject::Setting(setting), value.to_f32());
            let out = Diagnostic::about(Code::SettingOutOfRange, Severity::Error, subject, value);
            // There is room for nine settings and one band.
            let _ = found.push(out);
        }
    }
    if found.is_empty() && settings.band_hz.is_some() {
        let inside = (0..bins)
            .map(|bin| resolution * R::of(bin as f64))
            .filter(|&f| lower <= f && f <= upper)
            .count();
        if inside < 4 {
            let narrow = Diagnostic::whole(Code::BandTooNarrow, Severity::Error, inside as f32);
            let _ = found.push(narrow);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn wrong(settings: &TestSettings<f32>) -> Vec<Setting> {
        check_settings(settings, 4000.0, 2048, 128)
            .iter()
            .map(|d| {
                assert_eq!(d.code, Code::SettingOutOfRange);
                let Subject::Setting(setting) = d.subject else { panic!("{d:?}") };
                setting
            })
            .collect()
    }

    #[test]
    fn the_defaults_suit_the_rig() {
        assert!(check_settings(&TestSettings::<f32>::default(), 4000.0, 2048, 128).is_empty());
    }

    #[test]
    fn a_band_from_the_data_is_no_setting_out_of_range() {
        assert!(wrong(&TestSettings { band_hz: None, ..TestSettings::default() }).is_empty());
    }

    #[test]
    fn every_setting_out_of_range_is_named() {
        let good = TestSettings::<f32>::default();
        let bad = f32::NAN;
        assert_eq!(wrong(&TestSettings { hits_per_dof: 0, ..good }), [Setting::HitsPerDof]);
        assert_eq!(wrong(&TestSettings { hits_per_dof: 51, ..good }), [Setting::HitsPerDof]);
        for band in [[0.0, 100.0], [-1.0, 100.0], [100.0, 100.0], [120.0, 10.0], [bad, 100.0]] {
            assert_eq!(wrong(&TestSettings { band_hz: Some(band), ..good }), [Setting::BandLower]);
        }
        // 128 bins of 1.95 Hz end at 248 Hz.
        for band in [[10.0, 260.0], [10.0, f32::INFINITY], [10.0, bad]] {
            assert_eq!(wrong(&TestSettings { band_hz: Some(band), ..good }), [Setting::BandUpper]);
        }
        for decay in [-1.0, bad] {
            let settings = TestSettings { exponential_decay: decay, ..good };
            assert_eq!(wrong(&settings), [Setting::ExponentialDecay]);
        }
        for window in [0.0, 1.0, bad] {
            let settings = TestSettings { force_window_s: window, ..good };
            assert_eq!(wrong(&settings), [Setting::ForceWindow]);
        }
        assert_eq!(wrong(&TestSettings { trigger_n: 0.0, ..good }), [Setting::Trigger]);
        assert_eq!(wrong(&TestSettings { min_peak_force_n: bad, ..good }), [Setting::MinPeakForce]);
        for (impulse_ns, setting) in [
            ([-1.0, 1.0], Setting::ImpulseLower),
            ([1.0, 1.0], Setting::ImpulseLower),
            ([bad, 1.0], Setting::ImpulseLower),
            ([1.0, bad], Setting::ImpulseUpper),
        ] {
            assert_eq!(wrong(&TestSettings { impulse_ns, ..good }), [setting]);
        }
    }

    #[test]
    fn the_band_ends_below_the_rate_over_two_and_a_half() {
        let settings =
            TestSettings::<f32> { band_hz: Some([10.0, 1601.0]), ..TestSettings::default() };
        let found = check_settings(&settings, 4000.0, 2048, 1025);
        assert_eq!(found[0].subject, Subject::Setting(Setting::BandUpper));
        let settings = TestSettings { band_hz: Some([10.0, 1600.0]), ..settings };
        assert!(check_settings(&settings, 4000.0, 2048, 1025).is_empty());
    }

    #[test]
    fn a_band_of_three_lines_is_too_narrow() {
        let settings =
            TestSettings::<f32> { band_hz: Some([10.0, 16.0]), ..TestSettings::default() };
        let found = check_settings(&settings, 4000.0, 2048, 128);
        assert_eq!(found[0].code, Code::BandTooNarrow);
        assert_eq!(found[0].value, 3.0);
    }
}
