//! `s_chain_`: from ADC counts to mass lines and the ten inertial parameters.

use massline_shared::Real;
use massline_shared::capacity::Rig;
use massline_shared::identify::MassLines;
use massline_shared::identify::inertia_restraint::{ReferencePoint, solve};
use massline_shared::layout::TestSettings;
use massline_shared::mass_line::{
    BasisRow, Bin, FitSettings, ResponseFits, Terms, window_correlation,
};
use massline_shared::signal::{
    AdcProperties, CHANNELS, Calibration, ChannelCalibration, HAMMER, HitAnalysis, RealFft,
    Samples, Spectra,
};
use massline_shared::units::{Hertz, Seconds, Volts};
use nalgebra::{Complex, SMatrix};

use crate::layout::{GoldenDofs, RESPONSES};
use crate::{Array, Check, Values};

/// Points of the transform: the next power of two above the 540 scans of a record.
const POINTS: usize = 1024;
/// Bins in use: number 63 reaches 120 Hz.
const BINS: usize = 64;
const HITS: usize = 3;

pub(crate) fn run<R: RealFft + Default>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    // Cutoffs of the hammer and of the sensors: equal low-passes cancel.
    let cutoff = Hertz(input(check, "rc_hz")?);
    let alike = input(check, "hammer_has_same_rc")? != 0.0;
    let cutoffs = [if alike { cutoff } else { Hertz(0.0) }, cutoff];
    let measured = measure(check, input(check, "channel_delay_s")?, cutoffs)?;
    let mut accelerance = SMatrix::<R, RESPONSES, HITS>::zeros();
    for (mut column, fits) in accelerance.column_iter_mut().zip(&measured) {
        column.copy_from_slice(fits.accelerance.as_slice());
    }
    // On a good bench every response has a mass-line plateau.
    if measured.iter().any(|fits| fits.unsteady().next().is_some()) {
        return None;
    }
    let mut dofs = GoldenDofs::new();
    for (index, fits) in measured.iter().enumerate() {
        dofs.push((index, MassLines::without_scatter(fits.accelerance.clone()))).ok()?;
    }
    check.matrix("H_truth", &accelerance);
    check.matrix("H_oracle", &accelerance);
    let estimate = solve(&layout, &dofs, ReferencePoint::Centroid).ok()?;
    check.numbers("theta_truth", estimate.theta().as_slice());
    Some(())
}

/// Mass lines of every force, with channel `k` taken as sampled `k · channel_delay` after the hammer, and
/// with the low-passes of hammer and sensors at these cutoffs.
fn measure<R: RealFft + Default>(
    check: &Check<'_, '_, R>,
    channel_delay: f32,
    cutoffs: [Hertz; 2],
) -> Option<[ResponseFits<R, Rig>; HITS]> {
    let adc = AdcProperties {
        rate: Hertz(input(check, "fs")?),
        channels: CHANNELS as u8,
        bits: input(check, "adc_bits")? as u8,
        reference: Volts(input(check, "vref")?),
        channel_delay: Seconds(channel_delay),
    };
    let accelerometer = ChannelCalibration {
        zero: Volts(input(check, "accel_zero_volt")?),
        sensitivity: input(check, "accel_volt_per_g")? / input(check, "g0")?,
        cutoff: cutoffs[1],
    };
    let mut calibration =
        Calibration { channels: [accelerometer; CHANNELS], ..Calibration::default() };
    let hammer = &mut calibration.channels[HAMMER];
    hammer.sensitivity = input(check, "hammer_volt_per_newton")?;
    hammer.cutoff = cutoffs[0];
    let test = TestSettings {
        exponential_decay: check.input_number("sigma_exp")?,
        band_hz: Some(check.input_array("band")?),
        ..TestSettings::default()
    };
    let pre_trigger = input(check, "pretrigger_s")? * adc.rate.0;
    let analysis =
        HitAnalysis::<R>::new(&adc, &calibration, &test, libm::roundf(pre_trigger) as usize);

    let mut spectra = Spectra::<R, RESPONSES, BINS>::default();
    let none = ResponseFits::zeros(RESPONSES);
    let mut measured = [none.clone(), none.clone(), none];
    for (force, fits) in measured.iter_mut().enumerate() {
        spectra.clear();
        let mut hit = 0;
        while let Some(record) = Record::of(check, force, hit) {
            add(&analysis, &record, &mut spectra)?;
            hit += 1;
        }
        *fits = fit(&analysis, &test, &spectra)?;
    }
    Some(measured)
}

/// Adds the analysis of one hit to the spectra.
fn add<R: RealFft>(
    analysis: &HitAnalysis<R>,
    record: &Record,
    spectra: &mut Spectra<R, RESPONSES, BINS>,
) -> Option<()> {
    let zero = Complex::new(R::zero(), R::zero());
    let mut scratch = [R::zero(); POINTS];
    let (mut force, mut lines) = ([zero; BINS], [zero; BINS]);
    analysis.force(record, &mut scratch, &mut force).ok()?;
    spectra.add_force(&force);
    for response in 0..RESPONSES {
        analysis.response(record, response, &mut scratch, &mut lines).ok()?;
        spectra.add_response(response, &force, &lines);
    }
    Some(())
}

/// The mass lines of the averaged spectra, weighted by G_FF.
fn fit<R: RealFft + Default>(
    analysis: &HitAnalysis<R>,
    test: &TestSettings<R>,
    spectra: &Spectra<R, RESPONSES, BINS>,
) -> Option<ResponseFits<R, Rig>> {
    let resolution = analysis.resolution(POINTS);
    let lines = (0..BINS).map(|line| Bin {
        frequency: R::of(line as f64) * resolution,
        weight: spectra.force_auto(line),
    });
    let mut workspace = [BasisRow::default(); BINS];
    let fitting = FitSettings {
        band: test.expected_band(),
        decay: test.exponential_decay,
        terms: Terms::Abc,
        correlation: window_correlation(test.exponential_decay, R::one() / resolution),
        lag_sigma: R::zero(),
    };
    let h = |response, line| spectra.h1(response, line);
    ResponseFits::new(lines, &fitting, RESPONSES, h, &mut workspace).ok()
}

/// An electrical constant from the inputs.
fn input<R: Real>(check: &Check<'_, '_, R>, name: &str) -> Option<f32> {
    Some(check.input_number(name)?.to_f32())
}

/// The counts of one hit.
struct Record {
    hammer: &'static [u16],
    /// Counts of all responses, one response after another.
    accel: &'static [u16],
}

impl Record {
    fn of<R: Real>(check: &Check<'_, '_, R>, force: usize, hit: usize) -> Option<Self> {
        Some(Self {
            hammer: part(check.case.array("inputs.counts.hammer")?, force, hit)?,
            accel: part(check.case.array("inputs.counts.accel")?, force, hit)?,
        })
    }
}

/// The counts of one force and hit in an array whose first two indices are force and hit.
fn part(array: &Array, force: usize, hit: usize) -> Option<&'static [u16]> {
    let (Values::Whole(counts), [forces, hits, ..]) = (array.values, array.shape) else {
        return None;
    };
    let length = counts.len() / (forces * hits);
    (force < *forces && hit < *hits).then_some(())?;
    counts.chunks_exact(length).nth(force * hits + hit)
}

impl<R: Real> Samples<R> for Record {
    fn scans(&self) -> usize {
        self.hammer.len()
    }

    fn readings(&self, channel: usize, from: usize) -> impl Iterator<Item = R> + '_ {
        let counts = match channel.checked_sub(1) {
            None => self.hammer,
            Some(response) => {
                self.accel.chunks_exact(self.hammer.len()).nth(response).unwrap_or_default()
            }
        };
        counts.get(from..).unwrap_or_default().iter().map(|&count| R::of(f64::from(count)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Case;

    /// Root mean square difference between the mass lines and those of the reference implementation.
    fn distance(delay: f32, cutoffs: [f32; 2]) -> f64 {
        let case = Case::find("s_chain_01_bar_test1").unwrap();
        let mut report = |_: &str, _: &str, _: bool, _: f64| {};
        let check = Check::<f64>::new(case, &mut report);
        let measured = measure(&check, delay, cutoffs.map(Hertz)).unwrap();
        let oracle = case.real("expected.H_oracle").unwrap();
        let mut sum = 0.0;
        for (index, expected) in oracle.iter().enumerate() {
            let got = measured[index % HITS].accelerance[index / HITS];
            sum += (got - expected).powi(2);
        }
        (sum / oracle.len() as f64).sqrt()
    }

    #[test]
    fn the_other_sign_of_the_delay_leads_away_from_the_oracle() {
        let right = distance(1e-5, [497.4; 2]);
        // The reference has other rest values and no force window: a measured difference of 9e-4
        // (m/s²)/N, of 3.2.
        assert!(right < 1.5e-3, "{right}");
        let (none, other) = (distance(0.0, [497.4; 2]), distance(-1e-5, [497.4; 2]));
        assert!(none > 2.0 * right && other > 1.5 * none, "{right} {none} {other}");
    }

    #[test]
    fn the_low_pass_of_the_hammer_must_be_taken_out_with_those_of_the_sensors() {
        // Equal low-passes cancel; with constants in single precision up to 1e-7 of 3.2 (m/s²)/N.
        let [right, none] = [[497.4; 2], [0.0; 2]].map(|cutoffs| distance(1e-5, cutoffs));
        assert!((right - none).abs() < 2e-4, "{right} {none}");
        let half = distance(1e-5, [0.0, 497.4]);
        assert!(half > 2.0 * right, "{right} {half}");
    }
}
