//! The low-pass of each sensor axis against that of the hammer, from the spectra of a block test.
//!
//! The rig has already removed the low-passes of the calibration in force from its spectra. What remains of
//! `H = X/F` is the difference D of the errors of both: `D = (τ_F − τ_F0) − (τ − τ_0)` with τ of the sensor
//! axis, τ_F of the hammer and the index 0 for the calibration in force. The error of the hammer is the same
//! in all axes and cannot be separated from theirs, so its low-pass is left unchanged, and `τ = τ_0 − D` is
//! what a measurement needs: with it response and force are filtered alike.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use massline_protocol::object::{DofResult, MeasurementResult};
use massline_shared::EstimatedValue;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::time_constant::{SpectraSettings, difference, mean};
use massline_shared::layout::RigLayout;
use massline_shared::mass_line::Bin;
use massline_shared::signal::{Calibration, HAMMER};
use massline_shared::units::Hertz;
use nalgebra::Vector3;

use massline_files::dof_spectra::DofSpectra;

/// Least cosine between the hit direction and an axis whose time constant is determined. For three orthogonal
/// axes and three orthogonal hit directions every axis has a cosine of at least 1/√3.
const LEAST_COSINE: f64 = 0.5;
/// Part of the error that may not average out, s. With fifty hits per direction the error on the bench is
/// 0.22 µs rms and still falls with their number; smaller errors were never tested.
const FLOOR_S: f64 = 0.2e-6;
/// A difference of more standard deviations than this from the cutoff in force is significant.
const SIGNIFICANT: f64 = 3.0;
/// Largest difference from the expected time constant, times ω at the last bin; beyond it the channel is not
/// the one that is assumed.
const MAX_PHASE_ERROR: f64 = 0.5;
/// How often the fit is repeated with its own result. Each repetition leaves of the error only the relative
/// error of the model, a few hundredths at most.
const REPEATS: usize = 2;
/// Time constants far above that of the rig's own filter which are looked for, s: cutoffs of 300 down to 10 Hz.
const SLOW_S: RangeInclusive<f64> = 0.53e-3..=16e-3;
/// Where that search starts, s: 100 nF behind the output of an ADXL326. From there it finds 40 to 300 Hz, on
/// the bench; 100 + 10 nF make 45 Hz.
const SLOW_START_S: f64 = Calibration::ADXL326_OUTPUT_OHM * 100e-9;
/// How often the fit of that search is repeated with its own result, which starts farther away.
const SLOW_REPEATS: usize = 20;
/// Largest change of its last repetition, relative.
const SETTLED: f64 = 1e-3;

/// The low-pass of one axis of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RcCutoff {
    /// Sensor, 0-based.
    pub sensor: usize,
    /// Axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Cutoff in force, Hz; zero where none is known.
    pub before_hz: f64,
    /// The result of the block test.
    pub found: Result<FoundCutoff, CutoffError>,
}

impl RcCutoff {
    /// What happens to the cutoff in force.
    pub fn verdict(&self) -> &'static str {
        match self.found {
            Ok(FoundCutoff { changed: true, .. }) => "changed",
            Ok(_) => "kept",
            Err(_) => "undetermined",
        }
    }
}

/// A cutoff under the assumption that the hammer's cutoff in force is correct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundCutoff {
    /// Cutoff, Hz.
    pub cutoff_hz: f64,
    /// Its standard deviation, Hz.
    pub sigma_hz: f64,
    /// True when the difference from the cutoff in force is significant.
    pub changed: bool,
}

/// Why a block test does not determine the cutoff of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutoffError {
    /// The calibration has no cutoff for the hammer.
    HammerUnknown,
    /// No hit acts along this axis.
    NotPushed,
    /// The rig no longer has the spectra.
    SpectraGone,
    /// The bins determine no difference.
    Undetermined,
    /// The difference cannot come from a low-pass.
    NoLowPass,
}

impl CutoffError {
    /// The stable identifier.
    pub fn name(self) -> &'static str {
        match self {
            Self::HammerUnknown => "hammer_unknown",
            Self::NotPushed => "not_pushed",
            Self::SpectraGone => "spectra_gone",
            Self::Undetermined => "undetermined",
            Self::NoLowPass => "no_low_pass",
        }
    }
}

/// The cutoffs of every axis of every sensor of the layout, from the spectra that are available.
pub fn cutoffs(
    spectra: &[DofSpectra],
    result: &MeasurementResult,
    layout: &RigLayout,
    record: &CalibrationRecord,
) -> Vec<RcCutoff> {
    let test = Test { spectra, result, layout, calibration: &record.calibration };
    let axes = (0..layout.sensors.len()).flat_map(|sensor| (0..3).map(move |axis| (sensor, axis)));
    axes.map(|(sensor, axis)| test.cutoff(sensor, axis)).collect()
}

/// Writes the cutoffs that have changed to a calibration.
pub fn write(cutoffs: &[RcCutoff], calibration: &mut Calibration) {
    for RcCutoff { sensor, axis, found: result, .. } in cutoffs {
        if let Ok(cutoff) = result
            && cutoff.changed
            && let Some(channel) = calibration.channels.get_mut(channel(*sensor, *axis))
        {
            channel.cutoff = Hertz(cutoff.cutoff_hz as f32);
        }
    }
}

/// The channel of an axis.
fn channel(sensor: usize, axis: usize) -> usize {
    1 + response(sensor, axis)
}

fn response(sensor: usize, axis: usize) -> usize {
    3 * sensor + axis
}

/// Time constant of a cutoff; zero where none is known.
fn time_constant(cutoff: Hertz<f32>) -> f64 {
    if cutoff.0 > 0.0 { (TAU * f64::from(cutoff.0)).recip() } else { 0.0 }
}

/// The data of a block test.
struct Test<'a> {
    spectra: &'a [DofSpectra],
    result: &'a MeasurementResult,
    layout: &'a RigLayout,
    calibration: &'a Calibration,
}

impl Test<'_> {
    fn cutoff(&self, sensor: usize, axis: usize) -> RcCutoff {
        let before = self.calibration.channels[channel(sensor, axis)].cutoff;
        let result = self.determine(sensor, axis);
        RcCutoff { sensor, axis, before_hz: f64::from(before.0), found: result }
    }

    fn determine(&self, sensor: usize, axis: usize) -> Result<FoundCutoff, CutoffError> {
        let channels = &self.calibration.channels;
        let hammer = time_constant(channels[HAMMER].cutoff);
        if hammer == 0.0 {
            return Err(CutoffError::HammerUnknown);
        }
        let before = time_constant(channels[channel(sensor, axis)].cutoff);
        let expected = if before > 0.0 { before } else { hammer };
        let pushed: Vec<_> =
            self.result.dofs.iter().filter(|dof| self.pushes(dof, sensor, axis)).collect();
        if pushed.is_empty() {
            return Err(CutoffError::NotPushed);
        }
        let kept: Vec<_> = pushed.iter().filter_map(|dof| Some((*dof, self.of(dof)?))).collect();
        if kept.is_empty() {
            return Err(CutoffError::SpectraGone);
        }
        let response = response(sensor, axis);
        let top_hz = kept.iter().map(|(_, spectra)| last_line(spectra)).fold(0.0, f64::max);
        let with = |lag: f64| {
            let parts = kept.iter().filter_map(|(dof, spectra)| part(dof, spectra, response, lag));
            mean(&parts.collect::<Vec<_>>()).ok_or(CutoffError::Undetermined)
        };
        // The model is exact when its time constant is the true one.
        let repeated = |start: f64, repeats: usize| {
            let (mut lag, mut difference) = (start, with(start)?);
            for _ in 0..repeats {
                lag = (before - difference.value).max(0.0);
                difference = with(lag)?;
            }
            Ok::<_, CutoffError>((
                difference,
                (before - difference.value - lag).abs() < SETTLED * lag,
            ))
        };
        let reach = MAX_PHASE_ERROR / (TAU * top_hz);
        let (difference, _) = repeated(expected, REPEATS)?;
        match judge(difference, before, expected - reach..=expected + reach) {
            Err(CutoffError::NoLowPass) => match repeated(SLOW_START_S, SLOW_REPEATS) {
                Ok((difference, true)) => judge(difference, before, SLOW_S),
                _ => Err(CutoffError::NoLowPass),
            },
            judged => judged,
        }
    }

    /// True when the hit direction of a DOF excites an axis.
    fn pushes(&self, dof: &DofResult, sensor: usize, axis: usize) -> bool {
        let (Some(hit), Some(sensor)) =
            (self.layout.hits.get(usize::from(dof.index)), self.layout.sensors.get(sensor))
        else {
            return false;
        };
        let cosine = Vector3::from(hit.direction).dot(&Vector3::from(sensor.axes[axis]));
        f64::from(cosine.abs()) >= LEAST_COSINE
    }

    /// The spectra of a DOF, if they are from the hits of the result.
    fn of(&self, dof: &DofResult) -> Option<&DofSpectra> {
        self.spectra.iter().find(|kept| (kept.dof, kept.hits) == (dof.index, dof.hits))
    }
}

/// Frequency of the last bin, Hz.
fn last_line(spectra: &DofSpectra) -> f64 {
    spectra.frequency(spectra.force_auto().len().saturating_sub(1))
}

/// The difference in the spectra of one DOF, from the lower end of its band to the last bin: a low-pass shows
/// better the higher the frequency, and a block is rigid far beyond the band of an object.
fn part(
    dof: &DofResult,
    spectra: &DofSpectra,
    response: usize,
    lag: f64,
) -> Option<EstimatedValue<f64>> {
    let h1 = spectra.h1(response)?;
    let lines = h1
        .into_iter()
        .zip(spectra.force_auto())
        .enumerate()
        .map(|(line, (h, &weight))| (Bin { frequency: spectra.frequency(line), weight }, h));
    let how = SpectraSettings {
        band: [f64::from(dof.band_hz[0]), last_line(spectra)],
        lag,
        decay: spectra.decay,
        record: spectra.resolution.recip(),
    };
    difference(lines.collect::<Vec<_>>(), how).ok()
}

/// Converts a difference to a cutoff, starting from the time constant `before` in force; the time constant must
/// lie within `expected`.
fn judge(
    difference: EstimatedValue<f64>,
    before: f64,
    expected: RangeInclusive<f64>,
) -> Result<FoundCutoff, CutoffError> {
    let lag = before - difference.value;
    let sigma = difference.sigma.hypot(FLOOR_S);
    if lag <= SIGNIFICANT * sigma || !expected.contains(&lag) {
        return Err(CutoffError::NoLowPass);
    }
    let cutoff_hz = (TAU * lag).recip();
    let changed = difference.value.abs() > SIGNIFICANT * sigma;
    Ok(FoundCutoff { cutoff_hz, sigma_hz: cutoff_hz * sigma / lag, changed })
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_files::layout_file::LayoutFile;
    use massline_protocol::LayoutHash;
    use massline_protocol::object::{ResultHead, StoredTrend};
    use massline_shared::layout::FrfEstimator;
    use massline_shared::mass_line::Terms;

    const LAYOUT: &str = include_str!("../../../examples/block.toml");
    const NOMINAL: f64 = 320e-6;
    const REACH: f64 = 320e-6;

    fn judged(value: f64, sigma: f64) -> Result<FoundCutoff, CutoffError> {
        judge(EstimatedValue { value, sigma }, NOMINAL, NOMINAL - REACH..=NOMINAL + REACH)
    }

    #[test]
    fn a_sensor_that_is_slower_than_the_hammer_has_a_lower_cutoff() {
        // Hammer minus sensor is −10 µs, so the sensor's time constant is 330 µs.
        let cutoff = judged(-10e-6, 1e-6).unwrap();
        assert!((cutoff.cutoff_hz - (TAU * 330e-6).recip()).abs() < 1e-9, "{cutoff:?}");
        // 1 µs and the floor of 0.2 µs, relative to 330 µs.
        let relative = cutoff.sigma_hz / cutoff.cutoff_hz;
        assert!((relative - 1.0_f64.hypot(0.2) / 330.0).abs() < 1e-9, "{cutoff:?}");
        assert!(cutoff.changed);
    }

    #[test]
    fn what_may_be_chance_changes_nothing() {
        assert!(!judged(2.9e-6, 1e-6).unwrap().changed);
        assert!(judged(3.2e-6, 1e-6).unwrap().changed);
        // Without scatter only the floor remains.
        assert!(!judged(0.5e-6, 0.0).unwrap().changed);
    }

    #[test]
    fn no_time_at_all_or_far_too_much_is_no_low_pass() {
        for value in [321e-6, 500e-6, 318e-6, -330e-6] {
            assert_eq!(judged(value, 1e-6), Err(CutoffError::NoLowPass), "{value:e}");
        }
    }

    /// A result with the DOFs of these indices, without measured values.
    fn result(dofs: &[u8], layout: &RigLayout) -> MeasurementResult {
        let dof = |&index: &u8| DofResult {
            dof: layout.hits[usize::from(index)].dof,
            index,
            hits: 5,
            band_hz: [10.0, 120.0],
            accelerance: [0.0; 9],
            noise: [0.0; 9],
            scatter: Default::default(),
            coherence: None,
            trend: StoredTrend::default(),
            band_shift: [0.0; 9],
        };
        MeasurementResult {
            head: ResultHead {
                title: Default::default(),
                started_unix_s: 0,
                number: 1,
                layout_hash: layout.hash(),
                calibration: 0,
                gains: None,
                firmware: Default::default(),
                frf_estimator: FrfEstimator::H1,
                terms: Terms::A,
                band_automatic: false,
            },
            dofs: dofs.iter().map(dof).collect(),
            lines: Default::default(),
            estimates: Default::default(),
            diagnostics: Default::default(),
        }
    }

    #[test]
    fn an_axis_without_a_push_or_spectra_is_named() {
        let layout = LayoutFile::parse(LAYOUT, "block.toml").unwrap().rig_layout().unwrap();
        let mut record = CalibrationRecord::default();
        // Hits along x and y only.
        let results = cutoffs(&[], &result(&[0, 2], &layout), &layout, &record);
        assert_eq!(results.len(), 9);
        for cutoff in &results {
            let pushed = cutoff.axis != 2;
            let reason = if pushed { CutoffError::SpectraGone } else { CutoffError::NotPushed };
            assert_eq!(cutoff.found, Err(reason), "{cutoff:?}");
            assert!((cutoff.before_hz - 497.36).abs() < 0.01, "{cutoff:?}");
        }
        let before = record.calibration;
        write(&results, &mut record.calibration);
        assert_eq!(record.calibration, before);
    }
}
