//! The `[test]` table: its keys with their defaults, and whether a rig can measure with them.

use super::{HitPolicy, TestProfile};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Setting, Severity, Subject};
use crate::mass_line::Terms;
use crate::real::Real;

/// How the test is run: the `[test]` table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TestSettings<R> {
    /// What is measured.
    pub profile: TestProfile,
    /// Accepted hits wanted at each DOF.
    pub hits_per_dof: u8,
    /// Lower and upper end of the band of the mass line fit or of the suspension modes, Hz, inclusive; `None` to find
    /// that of the mass line from the data.
    pub band_hz: Option<[R; 2]>,
    /// Decay rate σ of the exponential window, 1/s.
    pub exponential_decay: R,
    /// Half width of the force window about the peak of the force, s.
    pub force_window_s: R,
    /// Force at which a record starts, N.
    pub trigger_n: R,
    /// A hit whose peak force is below this is too weak, N. Not used by [`TestProfile::Suspension`].
    pub min_peak_force_n: R,
    /// Smallest and largest impulse of a hit, N s. Used by [`TestProfile::Suspension`] only, whose modes answer to the
    /// impulse and not to the peak.
    pub impulse_ns: [R; 2],
    /// How frequency responses are computed from the averaged spectra.
    pub frf_estimator: FrfEstimator,
    /// Terms of the mass line.
    pub terms: Terms,
    /// Treatment of hits with a fault.
    pub policy: HitPolicy,
}

impl<R: Real> Default for TestSettings<R> {
    /// The measured defaults of theory, section 9.
    fn default() -> Self {
        Self {
            profile: TestProfile::MassLine,
            hits_per_dof: 5,
            band_hz: Some(Self::default_band()),
            exponential_decay: R::of(10.0),
            force_window_s: R::of(0.012),
            trigger_n: R::of(3.0),
            min_peak_force_n: R::of(8.0),
            impulse_ns: [R::of(0.8), R::of(1.3)],
            frf_estimator: FrfEstimator::default(),
            terms: Terms::default(),
            policy: HitPolicy::default(),
        }
    }
}

impl<R: Real> TestSettings<R> {
    /// The defaults of a profile.
    ///
    /// Those of [`TestProfile::Suspension`]: impulses of a soft mallet excite modes up to 12.4 Hz; the exponential
    /// window leaves 2 % of what does not decay by itself at the end of a record of 40 s.
    pub fn of_profile(profile: TestProfile) -> Self {
        match profile {
            TestProfile::MassLine => Self::default(),
            TestProfile::Suspension => Self {
                profile,
                band_hz: Some(Self::suspension_band()),
                exponential_decay: R::of(0.1),
                force_window_s: R::of(0.05),
                ..Self::default()
            },
        }
    }

    /// The same settings under another profile: its own defaults for what [depends on it](Self::depends_on_profile),
    /// band and windows; the rest stays, also the impulse, which means something under one profile alone.
    pub fn under(&self, profile: TestProfile) -> Self {
        if profile == self.profile {
            return *self;
        }
        let Self { band_hz, exponential_decay, force_window_s, .. } = Self::of_profile(profile);
        Self { profile, band_hz, exponential_decay, force_window_s, ..*self }
    }

    /// True for a setting whose default depends on the profile.
    pub fn depends_on_profile(setting: Setting) -> bool {
        let [one, other] = TestProfile::ALL.map(Self::of_profile);
        one.number(setting) != other.number(setting)
    }

    /// The default band of the suspension modes: 0.5 to 12.4 Hz.
    pub fn suspension_band() -> [R; 2] {
        [R::of(0.5), R::of(12.4)]
    }

    /// The default band, used where none is given and the data show none: 10 to 120 Hz.
    pub fn default_band() -> [R; 2] {
        [R::of(10.0), R::of(120.0)]
    }

    /// The band before the data are known: the given one, otherwise the default of the profile.
    pub fn expected_band(&self) -> [R; 2] {
        self.band_hz.unwrap_or_else(|| match self.profile {
            TestProfile::MassLine => Self::default_band(),
            TestProfile::Suspension => Self::suspension_band(),
        })
    }

    /// The number of a setting; an end of the expected band where the band is found from the data.
    pub fn number(&self, setting: Setting) -> R {
        let [lower, upper] = self.expected_band();
        let [least, most] = self.impulse_ns;
        match setting {
            Setting::HitsPerDof => R::of(f64::from(self.hits_per_dof)),
            Setting::BandLower => lower,
            Setting::BandUpper => upper,
            Setting::ExponentialDecay => self.exponential_decay,
            Setting::ForceWindow => self.force_window_s,
            Setting::Trigger => self.trigger_n,
            Setting::MinPeakForce => self.min_peak_force_n,
            Setting::ImpulseLower => least,
            Setting::ImpulseUpper => most,
        }
    }

    /// Changes the number of a setting; a band that is found from the data becomes a given one.
    pub fn set_number(&mut self, setting: Setting, number: R) {
        let band = self.expected_band();
        let to = match setting {
            Setting::HitsPerDof => return self.hits_per_dof = number.to_f64() as u8,
            Setting::BandLower => &mut self.band_hz.get_or_insert(band)[0],
            Setting::BandUpper => &mut self.band_hz.get_or_insert(band)[1],
            Setting::ExponentialDecay => &mut self.exponential_decay,
            Setting::ForceWindow => &mut self.force_window_s,
            Setting::Trigger => &mut self.trigger_n,
            Setting::MinPeakForce => &mut self.min_peak_force_n,
            Setting::ImpulseLower => &mut self.impulse_ns[0],
            Setting::ImpulseUpper => &mut self.impulse_ns[1],
        };
        *to = number;
    }

    /// The word of a choice.
    pub fn word(&self, choice: Choice) -> &'static str {
        match choice {
            Choice::Profile => self.profile.name(),
            Choice::FrfEstimator => self.frf_estimator.name(),
            Choice::Terms => self.terms.name(),
        }
    }

    /// Changes a choice; a word that it does not have changes nothing.
    pub fn set_word(&mut self, choice: Choice, word: &str) {
        match choice {
            Choice::Profile => self.profile = TestProfile::from_name(word).unwrap_or(self.profile),
            Choice::FrfEstimator => {
                self.frf_estimator = FrfEstimator::from_name(word).unwrap_or(self.frf_estimator);
            }
            Choice::Terms => self.terms = Terms::from_name(word).unwrap_or(self.terms),
        }
    }

    /// The same settings in another precision.
    pub fn cast<Q: Real>(&self) -> TestSettings<Q> {
        let to = |v: R| Q::of(v.to_f64());
        TestSettings {
            profile: self.profile,
            hits_per_dof: self.hits_per_dof,
            band_hz: self.band_hz.map(|band| band.map(to)),
            exponential_decay: to(self.exponential_decay),
            force_window_s: to(self.force_window_s),
            trigger_n: to(self.trigger_n),
            min_peak_force_n: to(self.min_peak_force_n),
            impulse_ns: self.impulse_ns.map(to),
            frf_estimator: self.frf_estimator,
            terms: self.terms,
            policy: self.policy,
        }
    }
}

/// A key of `[test]`.
#[derive(Clone, Copy, Debug)]
pub struct TestKey {
    /// As a layout file writes it.
    pub name: &'static str,
    /// What it says, with its unit where the name has none.
    pub meaning: &'static str,
    /// What is written.
    pub form: TestForm,
}

/// What stands behind a key of `[test]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestForm {
    /// A number.
    Number(Setting),
    /// The smaller and the larger end of a range.
    Range([Setting; 2]),
    /// A word.
    Word(Choice),
}

/// A setting that is one of a few words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The profile.
    Profile,
    /// How frequency responses are computed.
    FrfEstimator,
    /// Terms of the mass line.
    Terms,
}

impl Choice {
    /// The words.
    pub fn words(self) -> &'static [&'static str] {
        match self {
            Self::Profile => &TestProfile::NAMES,
            Self::FrfEstimator => &FrfEstimator::NAMES,
            Self::Terms => &Terms::NAMES,
        }
    }
}

/// What a key of `[test]` says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TestValue {
    /// A whole number.
    Count(u8),
    /// A number, in the unit of its setting.
    Number(f64),
    /// Two of them.
    Range([f64; 2]),
    /// A word; `auto` for a band that is found from the data.
    Word(&'static str),
}

impl TestSettings<f64> {
    /// What a key says.
    pub fn value(&self, key: &TestKey) -> TestValue {
        match key.form {
            TestForm::Number(Setting::HitsPerDof) => TestValue::Count(self.hits_per_dof),
            TestForm::Number(setting) => TestValue::Number(self.number(setting)),
            TestForm::Range([Setting::BandLower, _]) if self.band_hz.is_none() => {
                TestValue::Word(AUTOMATIC)
            }
            TestForm::Range(ends) => TestValue::Range(ends.map(|end| self.number(end))),
            TestForm::Word(choice) => TestValue::Word(self.word(choice)),
        }
    }
}

/// The word for a band that is found from the data.
pub const AUTOMATIC: &str = "auto";

/// Every key of `[test]`.
pub const TEST_KEYS: [TestKey; 10] = [
    TestKey {
        name: "profile",
        meaning: "mass lines above the suspension modes, or these modes; band and windows depend on it",
        form: TestForm::Word(Choice::Profile),
    },
    TestKey {
        name: "hits_per_dof",
        meaning: "accepted hits at each DOF",
        form: TestForm::Number(Setting::HitsPerDof),
    },
    TestKey {
        name: "band_hz",
        meaning: "of the fit: from 3 × the highest suspension mode to 0.4 × the first elastic, or \"auto\": found from \
                  the data; in the suspension profile all six suspension modes, up to 12.4 Hz",
        form: TestForm::Range([Setting::BandLower, Setting::BandUpper]),
    },
    TestKey {
        name: "exponential_decay_per_s",
        meaning: "decay rate of the exponential window; zero for no window",
        form: TestForm::Number(Setting::ExponentialDecay),
    },
    TestKey {
        name: "force_window_s",
        meaning: "half width of the force window about the peak",
        form: TestForm::Number(Setting::ForceWindow),
    },
    TestKey {
        name: "trigger_n",
        meaning: "force that starts a record",
        form: TestForm::Number(Setting::Trigger),
    },
    TestKey {
        name: "min_peak_force_n",
        meaning: "a hit with a smaller peak is too weak",
        form: TestForm::Number(Setting::MinPeakForce),
    },
    TestKey {
        name: "impulse_ns",
        meaning: "smallest and largest impulse of a hit in the suspension profile",
        form: TestForm::Range([Setting::ImpulseLower, Setting::ImpulseUpper]),
    },
    TestKey {
        name: "frf_estimator",
        meaning: "estimator of the frequency responses: the noise is on the responses, on the force, or on both",
        form: TestForm::Word(Choice::FrfEstimator),
    },
    TestKey {
        name: "terms",
        meaning: "terms of the mass line: A, suspension B/s², elastic residual C s²",
        form: TestForm::Word(Choice::Terms),
    },
];

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

    /// Their names in files and reports.
    pub const NAMES: [&'static str; 3] = [Self::H1.name(), Self::H2.name(), Self::Hv.name()];

    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::H1 => "h1",
            Self::H2 => "h2",
            Self::Hv => "hv",
        }
    }

    /// The estimator of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|estimator| estimator.name() == name)
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
    let mut diagnostics = Diagnostics::new();
    let resolution = rate / R::of(record.max(1) as f64);
    let highest = highest_frequency(rate, record, bins);
    let duration = R::of(record as f64) / rate;
    for &setting in Setting::ALL {
        let value = settings.number(setting);
        let within = |upper: Setting| {
            let upper = settings.number(upper);
            value < upper || !upper.finite()
        };
        let measurable = match setting {
            // A band found from the data is always suitable.
            Setting::BandLower | Setting::BandUpper if settings.band_hz.is_none() => true,
            Setting::BandLower => within(Setting::BandUpper),
            Setting::BandUpper => value <= highest,
            Setting::ForceWindow => value < duration,
            Setting::ImpulseLower => within(Setting::ImpulseUpper),
            _ => true,
        };
        if !(measurable && setting.allowed().contains(value)) {
            let (subject, value) = (Subject::Setting(setting), value.to_f32());
            let out = Diagnostic::about(Code::SettingOutOfRange, Severity::Error, subject, value);
            // There is room for nine settings and one band.
            let _ = diagnostics.push(out);
        }
    }
    let [lower, upper] = settings.expected_band();
    if diagnostics.is_empty() && settings.band_hz.is_some() {
        let inside = (0..bins)
            .map(|bin| resolution * R::of(bin as f64))
            .filter(|&f| lower <= f && f <= upper)
            .count();
        if inside < 4 {
            let narrow = Diagnostic::whole(Code::BandTooNarrow, Severity::Error, inside as f32);
            let _ = diagnostics.push(narrow);
        }
    }
    diagnostics
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
    fn every_setting_is_behind_the_key_that_its_name_begins_with() {
        for &setting in Setting::ALL {
            let is_of = |key: &&TestKey| match key.form {
                TestForm::Number(own) => own == setting && key.name == setting.name(),
                TestForm::Range(ends) => ends.iter().zip(0..).any(|(&end, k)| {
                    end == setting && std::format!("{}[{k}]", key.name) == setting.name()
                }),
                TestForm::Word(_) => false,
            };
            assert_eq!(TEST_KEYS.iter().filter(is_of).count(), 1, "{setting:?}");
            assert!(setting.words().len() <= 14, "{setting:?}");
        }
    }

    #[test]
    fn under_another_profile_what_depends_on_it_changes_and_the_rest_stays() {
        let mut own = TestSettings::<f64>::default();
        for &setting in Setting::ALL {
            own.set_number(setting, 7.0 + own.number(setting));
        }
        let other = own.under(TestProfile::Suspension);
        let defaults = TestSettings::<f64>::of_profile(TestProfile::Suspension);
        for &setting in Setting::ALL {
            let from =
                if TestSettings::<f64>::depends_on_profile(setting) { &defaults } else { &own };
            assert_eq!(other.number(setting), from.number(setting), "{setting:?}");
        }
        assert_eq!(own.under(TestProfile::MassLine), own);
    }

    #[test]
    fn a_number_of_hits_is_whole_and_not_more_than_fifty() {
        let allowed = Setting::HitsPerDof.allowed();
        assert!([1.0, 5.0, 50.0].iter().all(|&count| allowed.contains(count)));
        for count in [0.0, -1.0, 0.5, 5.5, 51.0, 257.0, 1e300, f64::NAN, f64::INFINITY] {
            assert!(!allowed.contains(count), "{count}");
        }
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
        let diagnostics = check_settings(&settings, 4000.0, 2048, 1025);
        assert_eq!(diagnostics[0].subject, Subject::Setting(Setting::BandUpper));
        let settings = TestSettings { band_hz: Some([10.0, 1600.0]), ..settings };
        assert!(check_settings(&settings, 4000.0, 2048, 1025).is_empty());
    }

    #[test]
    fn a_band_of_three_lines_is_too_narrow() {
        let settings =
            TestSettings::<f32> { band_hz: Some([10.0, 16.0]), ..TestSettings::default() };
        let diagnostics = check_settings(&settings, 4000.0, 2048, 128);
        assert_eq!(diagnostics[0].code, Code::BandTooNarrow);
        assert_eq!(diagnostics[0].value, 3.0);
    }
}
