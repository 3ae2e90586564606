//! The tables `[test]` and `[target]`.

use std::ops::Range;
use std::sync::LazyLock;

use massline_shared::diagnosis::{AllowedValues, Setting};
use massline_shared::layout::{
    Choice, TARGET_KEYS, TEST_KEYS, Target, TestForm, TestKey, TestProfile, TestSettings,
};
use serde::de::MapAccess;
use toml::Spanned;

use super::error::{Fault, LayoutFileError, Place};
use super::keyed::{KeyedTable, OneOf, TableKeys};
use super::source::Source;
use super::values::RawBand;

/// The keys of `[test]`.
pub(super) struct TestKeys;

/// A value of `[test]`.
#[derive(Debug)]
pub(super) enum TestEntry {
    /// A number.
    Number(Spanned<f64>),
    /// The ends of a range.
    Range(Spanned<[f64; 2]>),
    /// The ends of the band, or `auto`.
    Band(Spanned<RawBand>),
    /// A word.
    Word(&'static str),
}

impl TestEntry {
    /// Where it stands in the file.
    pub(super) fn span(&self) -> Option<Range<usize>> {
        match self {
            Self::Number(number) => Some(number.span()),
            Self::Range(range) => Some(range.span()),
            Self::Band(band) => Some(band.span()),
            Self::Word(_) => None,
        }
    }
}

impl KeyedTable<TestKeys> {
    /// What is stated for a key of this form.
    fn entry(&self, form: TestForm) -> Option<&TestEntry> {
        TEST_KEYS.iter().find(|key| key.form == form).and_then(|key| self.get(key.name))
    }

    /// The number that is stated for a setting.
    fn number(&self, setting: Setting) -> Option<&Spanned<f64>> {
        match self.entry(TestForm::Number(setting)) {
            Some(TestEntry::Number(number)) => Some(number),
            _ => None,
        }
    }

    /// The profile that is stated.
    pub(super) fn profile(&self) -> Option<TestProfile> {
        match self.entry(TestForm::Word(Choice::Profile)) {
            Some(TestEntry::Word(word)) => TestProfile::from_name(word),
            _ => None,
        }
    }

    /// Puts these settings under another profile: those that were meant for the former have its own defaults. Returns
    /// their keys.
    pub(super) fn change_profile(&mut self, profile: TestProfile) -> Vec<&'static str> {
        if self.profile().unwrap_or_default() == profile {
            return Vec::new();
        }
        let depends = |key: &&TestKey| match key.form {
            TestForm::Number(setting) | TestForm::Range([setting, _]) => {
                TestSettings::<f64>::depends_on_profile(setting)
            }
            TestForm::Word(choice) => choice == Choice::Profile,
        };
        let mut set_aside = Vec::new();
        for key in TEST_KEYS.iter().filter(depends) {
            let was_stated = self.take(key.name).is_some();
            if key.form == TestForm::Word(Choice::Profile) {
                self.insert(key.name, TestEntry::Word(profile.name()));
            } else if was_stated {
                set_aside.push(key.name);
            }
        }
        set_aside
    }
}

impl TableKeys for TestKeys {
    type Value = TestEntry;
    const WRITTEN: &'static str = "a table [test]";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| TEST_KEYS.map(|key| key.name).to_vec());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        name: &'static str,
        map: &mut A,
    ) -> Result<TestEntry, A::Error> {
        match TEST_KEYS.iter().find(|key| key.name == name).map(|key| key.form) {
            Some(TestForm::Word(choice)) => {
                map.next_value_seed(OneOf(choice.words())).map(TestEntry::Word)
            }
            Some(TestForm::Range([Setting::BandLower, _])) => map.next_value().map(TestEntry::Band),
            Some(TestForm::Range(_)) => map.next_value().map(TestEntry::Range),
            Some(TestForm::Number(Setting::HitsPerDof)) => {
                let count: Spanned<i64> = map.next_value()?;
                Ok(TestEntry::Number(Spanned::new(count.span(), *count.get_ref() as f64)))
            }
            Some(TestForm::Number(_)) | None => map.next_value().map(TestEntry::Number),
        }
    }
}

/// The keys of `[target]`.
pub(super) struct TargetKeys;

impl TableKeys for TargetKeys {
    type Value = Spanned<f64>;
    const WRITTEN: &'static str = "a table [target]";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| TARGET_KEYS.map(|key| key.name).to_vec());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<Spanned<f64>, A::Error> {
        map.next_value()
    }
}

/// The settings of the test, with the defaults of those that are not given.
pub(super) fn test(
    raw: &KeyedTable<TestKeys>,
    source: &Source<'_>,
) -> Result<TestSettings<f64>, LayoutFileError> {
    let mut test = TestSettings::of_profile(raw.profile().unwrap_or_default());
    for key in TEST_KEYS {
        let name = format!("test.{}", key.name);
        match (raw.get(key.name), key.form) {
            (Some(TestEntry::Number(number)), TestForm::Number(setting)) => {
                let allowed = setting.allowed();
                let wanted = match allowed {
                    AllowedValues::HitCount => "a whole number from 1 to 50",
                    AllowedValues::NotNegative => "zero or a positive number",
                    AllowedValues::Positive => "a positive number",
                };
                let number = source.within(number, &name, |v| allowed.contains(v), wanted)?;
                test.set_number(setting, number);
            }
            (Some(TestEntry::Range(range)), TestForm::Range(ends)) => {
                set_range(&mut test, ends, *range.get_ref(), range.span(), &name, source)?;
            }
            (Some(TestEntry::Band(band)), TestForm::Range(ends)) => match *band.get_ref() {
                RawBand::Auto if test.profile == TestProfile::Suspension => {
                    return Err(source.fault(band.span(), &name, Fault::BandOfSuspension));
                }
                RawBand::Auto => test.band_hz = None,
                RawBand::Ends(range) => {
                    set_range(&mut test, ends, range, band.span(), &name, source)?;
                }
            },
            (Some(TestEntry::Word(word)), TestForm::Word(choice)) => test.set_word(choice, word),
            // A value has the form of its key.
            (None | Some(_), _) => {}
        }
    }
    if test.profile == TestProfile::Suspension {
        go_with_modes(raw, source)?;
    }
    Ok(test)
}

fn set_range(
    test: &mut TestSettings<f64>,
    settings: [Setting; 2],
    ends: [f64; 2],
    span: Range<usize>,
    key: &str,
    source: &Source<'_>,
) -> Result<(), LayoutFileError> {
    source.finite(span.clone(), key, &ends)?;
    let [low, high] = ends;
    let [lower, upper] = settings;
    if !lower.allowed().contains(low) || high <= low {
        let value = if lower.allowed().contains(low) { high } else { low };
        let wanted = match lower.allowed() {
            AllowedValues::Positive | AllowedValues::HitCount => {
                "[lowest, highest], 0 < lowest < highest"
            }
            AllowedValues::NotNegative => "[smallest, largest], 0 <= smallest < largest",
        };
        return Err(source.fault(span, key, Fault::OutOfRange { value, wanted }));
    }
    test.set_number(lower, low);
    test.set_number(upper, high);
    Ok(())
}

/// Largest decay of the exponential window in the suspension profile, 1/s: 2 1/s add 11 % of the critical damping to a
/// mode of 3 Hz, beside which the 0.5 to 3 % of its springs can no longer be told.
const FASTEST_DECAY: f64 = 2.0;
/// Smallest half width of the force window in the suspension profile, s: a soft mallet pushes for 15 to 25 ms.
const NARROWEST_WINDOW: f64 = 0.015;

/// Refuses windows in the suspension profile that leave nothing of its modes, such as those of the other profile.
fn go_with_modes(raw: &KeyedTable<TestKeys>, source: &Source<'_>) -> Result<(), LayoutFileError> {
    if let Some(decay) = raw.number(Setting::ExponentialDecay) {
        let wanted = "2 1/s at most in the suspension profile, or the window hides the modes; without the line it is \
             0.1 1/s";
        source.within(decay, "test.exponential_decay_per_s", |v| v <= FASTEST_DECAY, wanted)?;
    }
    if let Some(window) = raw.number(Setting::ForceWindow) {
        let wanted = "0.015 s at least in the suspension profile, or the window cuts the push of a soft mallet; \
                      without the line it is 0.05 s";
        source.within(window, "test.force_window_s", |v| v >= NARROWEST_WINDOW, wanted)?;
    }
    Ok(())
}

/// The precision at which a campaign may stop.
pub(super) fn target(
    raw: &KeyedTable<TargetKeys>,
    source: &Source<'_>,
) -> Result<Target<f64>, LayoutFileError> {
    let wanted = "a positive half width: 0.01 is 1 %, or 10 mm for center_m";
    let mut widths = Target::default().values();
    for (width, key) in widths.iter_mut().zip(TARGET_KEYS) {
        let Some(stated) = raw.get(key.name) else { continue };
        let key = format!("target.{}", key.name);
        *width = Some(source.within(stated, &key, |v| v > 0.0, wanted)?);
    }
    Ok(widths.into())
}

/// Where the settings of the test stand.
pub(super) fn places(raw: &KeyedTable<TestKeys>, source: &Source<'_>) -> Vec<(Setting, Place)> {
    let mut places = Vec::new();
    for key in TEST_KEYS {
        let Some(span) = raw.get(key.name).and_then(TestEntry::span) else { continue };
        let place = Place::of(source.file, source.text, Some(span), &format!("test.{}", key.name));
        match key.form {
            TestForm::Number(setting) => places.push((setting, place)),
            TestForm::Range(ends) => places.extend(ends.map(|end| (end, place.clone()))),
            TestForm::Word(_) => {}
        }
    }
    places
}
