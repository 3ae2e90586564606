//! The tables `[test]` and `[target]`.

use std::ops::Range;

use massline_shared::diagnosis::Setting;
use massline_shared::layout::{MAX_HITS_PER_DOF, Target, TestProfile, TestSettings};
use toml::Spanned;

use super::error::{Fault, LayoutFileError, Place};
use super::raw::{RawTarget, RawTest};
use super::source::Source;
use super::values::RawBand;

/// The settings of the test, with the defaults of those that are not given.
pub(super) fn test(
    raw: Option<&RawTest>,
    source: &Source<'_>,
) -> Result<TestSettings<f64>, LayoutFileError> {
    let Some(raw) = raw else { return Ok(TestSettings::default()) };
    let mut test = TestSettings::of_profile(raw.profile.unwrap_or_default());
    if let Some(hits) = &raw.hits_per_dof {
        let allowed = |hits: &u8| (1..=MAX_HITS_PER_DOF).contains(hits);
        test.hits_per_dof =
            u8::try_from(*hits.get_ref()).ok().filter(allowed).ok_or_else(|| {
                let value = *hits.get_ref() as f64;
                let fault = Fault::OutOfRange { value, wanted: "a whole number from 1 to 50" };
                source.fault(hits.span(), "test.hits_per_dof", fault)
            })?;
    }
    if let Some(band) = &raw.band_hz {
        test.band_hz = match *band.get_ref() {
            RawBand::Auto if test.profile == TestProfile::Suspension => {
                return Err(source.fault(band.span(), "test.band_hz", Fault::BandOfSuspension));
            }
            RawBand::Auto => None,
            RawBand::Ends(ends) => Some(band_ends(ends, band.span(), source)?),
        };
    }
    let positive = "a positive number";
    if let Some(v) = &raw.exponential_decay_per_s {
        let wanted = "zero (no window) or a positive number, 1/s";
        let key = "test.exponential_decay_per_s";
        test.exponential_decay = source.within(v, key, |v| v >= 0.0, wanted)?;
    }
    if let Some(v) = &raw.force_window_s {
        test.force_window_s = source.within(v, "test.force_window_s", |v| v > 0.0, positive)?;
    }
    if let Some(v) = &raw.trigger_n {
        test.trigger_n = source.within(v, "test.trigger_n", |v| v > 0.0, positive)?;
    }
    if let Some(v) = &raw.min_peak_force_n {
        test.min_peak_force_n = source.within(v, "test.min_peak_force_n", |v| v > 0.0, positive)?;
    }
    if let Some(impulse) = &raw.impulse_ns {
        test.impulse_ns = impulse_ends(*impulse.get_ref(), impulse.span(), source)?;
    }
    if test.profile == TestProfile::Suspension {
        go_with_modes(raw, source)?;
    }
    test.frf_estimator = raw.frf_estimator.unwrap_or(test.frf_estimator);
    test.terms = raw.terms.unwrap_or(test.terms);
    Ok(test)
}

/// Largest decay of the exponential window in the suspension profile, 1/s: 2 1/s add 11 % of the critical damping to a mode of
/// 3 Hz, beside which the 0.5 to 3 % of its springs can no longer be told.
const FASTEST_DECAY: f64 = 2.0;
/// Smallest half width of the force window in the suspension profile, s: a soft mallet pushes for 15 to 25 ms.
const NARROWEST_WINDOW: f64 = 0.015;

/// Refuses windows in the suspension profile that leave nothing of its modes, such as those of the other profile.
fn go_with_modes(raw: &RawTest, source: &Source<'_>) -> Result<(), LayoutFileError> {
    if let Some(decay) = &raw.exponential_decay_per_s {
        let wanted = "2 1/s at most in the suspension profile, or the window hides the modes; without the line it is 0.1 1/s";
        source.within(decay, "test.exponential_decay_per_s", |v| v <= FASTEST_DECAY, wanted)?;
    }
    if let Some(window) = &raw.force_window_s {
        let wanted = "0.015 s at least in the suspension profile, or the window cuts the push of a soft mallet; without the line \
                      it is 0.05 s";
        source.within(window, "test.force_window_s", |v| v >= NARROWEST_WINDOW, wanted)?;
    }
    Ok(())
}

/// The precision at which a campaign may stop.
pub(super) fn target(
    raw: Option<&RawTarget>,
    source: &Source<'_>,
) -> Result<Target<f64>, LayoutFileError> {
    let Some(raw) = raw else { return Ok(Target::default()) };
    let wanted = "a positive half width: 0.01 is 1 %, or 10 mm for center_m";
    let of = |value: &Option<Spanned<f64>>, key| {
        let check = |v| source.within(v, key, |v| v > 0.0, wanted);
        value.as_ref().map(check).transpose()
    };
    Ok(Target {
        mass: of(&raw.mass, "target.mass")?,
        center: of(&raw.center_m, "target.center_m")?,
        inertia: of(&raw.inertia, "target.inertia")?,
    })
}

fn impulse_ends(
    [least, most]: [f64; 2],
    span: Range<usize>,
    source: &Source<'_>,
) -> Result<[f64; 2], LayoutFileError> {
    source.finite(span.clone(), "test.impulse_ns", &[least, most])?;
    if least < 0.0 || most <= least {
        let value = if least < 0.0 { least } else { most };
        let wanted = "[smallest, largest] impulse in N s, 0 <= smallest < largest";
        return Err(source.fault(span, "test.impulse_ns", Fault::OutOfRange { value, wanted }));
    }
    Ok([least, most])
}

fn band_ends(
    [low, high]: [f64; 2],
    span: Range<usize>,
    source: &Source<'_>,
) -> Result<[f64; 2], LayoutFileError> {
    source.finite(span.clone(), "test.band_hz", &[low, high])?;
    if low <= 0.0 || high <= low {
        let value = if low <= 0.0 { low } else { high };
        let wanted = "[lowest, highest] frequency in Hz, 0 < lowest < highest";
        return Err(source.fault(span, "test.band_hz", Fault::OutOfRange { value, wanted }));
    }
    Ok([low, high])
}

/// Where the settings of the test stand.
pub(super) fn places(test: &RawTest, source: &Source<'_>) -> Vec<(Setting, Place)> {
    let span = |of: &Option<Spanned<f64>>| of.as_ref().map(Spanned::span);
    let band = test.band_hz.as_ref().map(Spanned::span);
    let impulse = test.impulse_ns.as_ref().map(Spanned::span);
    let all = [
        (Setting::HitsPerDof, "test.hits_per_dof", test.hits_per_dof.as_ref().map(Spanned::span)),
        (Setting::BandLower, "test.band_hz", band.clone()),
        (Setting::BandUpper, "test.band_hz", band),
        (
            Setting::ExponentialDecay,
            "test.exponential_decay_per_s",
            span(&test.exponential_decay_per_s),
        ),
        (Setting::ForceWindow, "test.force_window_s", span(&test.force_window_s)),
        (Setting::Trigger, "test.trigger_n", span(&test.trigger_n)),
        (Setting::MinPeakForce, "test.min_peak_force_n", span(&test.min_peak_force_n)),
        (Setting::ImpulseLower, "test.impulse_ns", impulse.clone()),
        (Setting::ImpulseUpper, "test.impulse_ns", impulse),
    ];
    let place = |(setting, key, span)| {
        Some((setting, Place::of(source.file, source.text, Some(span?), key)))
    };
    all.into_iter().filter_map(place).collect()
}
