//! The tables of a bench file about sensors, hammer, converter, taps and operator, with the defaults of
//! the default bench.

use massline_shared::signal::Calibration;
use serde::Deserialize;

/// A key and what is wrong with its value.
pub(super) type Problem = Option<(&'static str, &'static str)>;

/// Corner of the output filter of the ADXL326, 32 kΩ with 10 nF, Hz.
const RC_CORNER_HZ: f64 = 497.359_197;

/// `[sensor]`: the triaxial accelerometers, all alike; a `sigma` is drawn once per test.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSettings {
    /// Error of each coordinate of the position, 1 σ, m.
    pub position_sigma_m: f64,
    /// Rotation about each axis, 1 σ, rad.
    pub rotation_sigma_rad: f64,
    /// Relative gain error that a calibration has left, 1 σ.
    pub gain_sigma: f64,
    /// Sensitivity to each of the two other axes over that to the own one, 1 σ.
    pub cross_axis_sigma: f64,
    /// Output at rest without gravity, V.
    pub zero_v: f64,
    /// Tolerance of it, 1 σ, V.
    pub zero_sigma_v: f64,
    /// V per standard gravity.
    pub sensitivity_v_per_g: f64,
    /// The output clips at plus and minus this, g.
    pub range_g: f64,
    /// One-sided density of the white noise before the filter, g/√Hz.
    pub noise_g_per_sqrt_hz: f64,
    /// Corner of the first-order low-pass, Hz.
    pub rc_corner_hz: f64,
    /// Relative tolerance of the corner, 1 σ.
    pub rc_tolerance: f64,
}

impl Default for SensorSettings {
    fn default() -> Self {
        Self {
            position_sigma_m: 0.001,
            rotation_sigma_rad: 0.010,
            gain_sigma: 0.005,
            cross_axis_sigma: 0.01,
            zero_v: Calibration::ADXL326_ZERO.0,
            zero_sigma_v: 0.05,
            sensitivity_v_per_g: Calibration::ADXL326_VOLT_PER_G,
            range_g: Calibration::ADXL326_RANGE_G,
            noise_g_per_sqrt_hz: 300e-6,
            rc_corner_hz: RC_CORNER_HZ,
            rc_tolerance: 0.02,
        }
    }
}

impl SensorSettings {
    pub(super) fn problem(&self) -> Problem {
        first_problem(&[
            (self.position_sigma_m, "position_sigma_m", Sign::NotNegative),
            (self.rotation_sigma_rad, "rotation_sigma_rad", Sign::NotNegative),
            (self.gain_sigma, "gain_sigma", Sign::NotNegative),
            (self.cross_axis_sigma, "cross_axis_sigma", Sign::NotNegative),
            (self.zero_sigma_v, "zero_sigma_v", Sign::NotNegative),
            (self.sensitivity_v_per_g, "sensitivity_v_per_g", Sign::Positive),
            (self.range_g, "range_g", Sign::Positive),
            (self.noise_g_per_sqrt_hz, "noise_g_per_sqrt_hz", Sign::NotNegative),
            (self.rc_corner_hz, "rc_corner_hz", Sign::Positive),
            (self.rc_tolerance, "rc_tolerance", Sign::NotNegative),
        ])
        .or((self.rc_tolerance > 0.2).then_some(("rc_tolerance", "must not be above 0.2")))
    }
}

/// `[hammer]`: the force transducer with its conditioner.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HammerSettings {
    /// V/N.
    pub sensitivity_v_per_n: f64,
    /// Relative gain error, 1 σ, drawn once per test. None by default: a calibration with a known
    /// mass leaves one error per response, that of its ratio to the hammer.
    pub gain_sigma: f64,
    /// Output at rest, V.
    pub zero_v: f64,
    /// Tolerance of it, 1 σ, V.
    pub zero_sigma_v: f64,
    /// One-sided density of the white noise before the filter, N/√Hz.
    pub noise_n_per_sqrt_hz: f64,
    /// Corner of the first-order low-pass, Hz.
    pub rc_corner_hz: f64,
    /// Relative tolerance of the corner, 1 σ.
    pub rc_tolerance: f64,
}

impl Default for HammerSettings {
    fn default() -> Self {
        Self {
            sensitivity_v_per_n: Calibration::HAMMER_VOLT_PER_NEWTON,
            gain_sigma: 0.0,
            zero_v: Calibration::HAMMER_ZERO.0,
            zero_sigma_v: 0.005,
            noise_n_per_sqrt_hz: 0.0005,
            rc_corner_hz: RC_CORNER_HZ,
            rc_tolerance: 0.02,
        }
    }
}

impl HammerSettings {
    pub(super) fn problem(&self) -> Problem {
        first_problem(&[
            (self.sensitivity_v_per_n, "sensitivity_v_per_n", Sign::Positive),
            (self.gain_sigma, "gain_sigma", Sign::NotNegative),
            (self.zero_sigma_v, "zero_sigma_v", Sign::NotNegative),
            (self.noise_n_per_sqrt_hz, "noise_n_per_sqrt_hz", Sign::NotNegative),
            (self.rc_corner_hz, "rc_corner_hz", Sign::Positive),
            (self.rc_tolerance, "rc_tolerance", Sign::NotNegative),
        ])
        .or((self.rc_tolerance > 0.2).then_some(("rc_tolerance", "must not be above 0.2")))
    }
}

/// `[adc]`: the multiplexed converter.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdcSettings {
    /// Scans per second.
    pub rate_hz: f64,
    /// Resolution.
    pub bits: u8,
    /// Voltage of code `2^bits`.
    pub reference_v: f64,
    /// Channel `k` is sampled `k` times this after the hammer, s.
    pub channel_delay_s: f64,
    /// Steps of the simulation per scan.
    pub oversampling: u16,
}

impl Default for AdcSettings {
    fn default() -> Self {
        Self {
            rate_hz: 4000.0,
            bits: 12,
            reference_v: 3.0,
            channel_delay_s: 10e-6,
            oversampling: 16,
        }
    }
}

impl AdcSettings {
    pub(super) fn problem(&self) -> Problem {
        let last_channel = (massline_shared::signal::CHANNELS - 1) as f64;
        let too_late = self.channel_delay_s * last_channel * self.rate_hz >= 1.0;
        first_problem(&[
            (self.rate_hz, "rate_hz", Sign::Positive),
            (self.reference_v, "reference_v", Sign::Positive),
            (self.channel_delay_s, "channel_delay_s", Sign::NotNegative),
        ])
        .or((!(8..=16).contains(&self.bits)).then_some(("bits", "must lie between 8 and 16")))
        .or(too_late
            .then_some(("channel_delay_s", "the last channel would fall into the next scan")))
        .or((!(1..=256).contains(&self.oversampling))
            .then_some(("oversampling", "must lie between 1 and 256")))
    }
}

/// `[tap]`: what a good tap is like; drawn for each tap.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TapSettings {
    /// Peak force, from and to, N.
    pub force_n: [f64; 2],
    /// Contact time, from and to, s.
    pub duration_s: [f64; 2],
    /// Error of the point of impact along each axis across the direction, 1 σ, m.
    pub point_sigma_m: f64,
    /// Tilt of the hammer about each axis across the direction, 1 σ, rad.
    pub direction_sigma_rad: f64,
}

impl Default for TapSettings {
    fn default() -> Self {
        Self {
            force_n: [18.0, 30.0],
            duration_s: [0.004, 0.006],
            point_sigma_m: 0.002,
            direction_sigma_rad: 0.030,
        }
    }
}

impl TapSettings {
    pub(super) fn problem(&self) -> Problem {
        first_problem(&[
            (self.point_sigma_m, "point_sigma_m", Sign::NotNegative),
            (self.direction_sigma_rad, "direction_sigma_rad", Sign::NotNegative),
        ])
        .or(range_problem(self.force_n, "force_n"))
        .or(range_problem(self.duration_s, "duration_s"))
    }
}

/// `[operator]`: the person with the hammer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OperatorSettings {
    /// Rig time between *armed* and the tap, s.
    pub delay_s: f64,
    /// Rig time after a tap that leads to nothing until the next one, s; after ten such taps the
    /// operator waits for the next arming.
    pub patience_s: f64,
    /// Share of the taps that are too weak.
    pub too_weak_rate: f64,
    /// Peak force of these, from and to, N.
    pub too_weak_n: [f64; 2],
    /// Share of the taps that are too hard.
    pub too_hard_rate: f64,
    /// Peak force of these, from and to, N; more than the hammer channel can show.
    pub too_hard_n: [f64; 2],
    /// Share of the taps that bounce: a second, weaker one follows.
    pub double_rate: f64,
    /// Time between the two, from and to, s.
    pub double_gap_s: [f64; 2],
    /// Share of the taps before which the hammer brushes the object.
    pub grazing_rate: f64,
    /// Share of the taps after which the hammer stays on the object.
    pub leaning_rate: f64,
    /// Share of the taps as with a soft tip: five times as long.
    pub soft_rate: f64,
    /// Share of the taps that land 80 mm beside the mark.
    pub astray_rate: f64,
    /// Tilt of each position of a tumble test about each of two axes, 1 σ, rad.
    pub tilt_sigma_rad: f64,
}

impl Default for OperatorSettings {
    fn default() -> Self {
        Self {
            delay_s: 0.3,
            patience_s: 3.0,
            too_weak_rate: 0.03,
            too_weak_n: [4.5, 6.5],
            too_hard_rate: 0.02,
            too_hard_n: [150.0, 200.0],
            double_rate: 0.0,
            double_gap_s: [0.03, 0.08],
            grazing_rate: 0.0,
            leaning_rate: 0.0,
            soft_rate: 0.0,
            astray_rate: 0.0,
            tilt_sigma_rad: 0.003,
        }
    }
}

impl OperatorSettings {
    /// Shares of the taps that go wrong: too weak, too hard, double, grazing, leaning, soft, astray.
    pub(super) fn rates(&self) -> [f64; 7] {
        [
            self.too_weak_rate,
            self.too_hard_rate,
            self.double_rate,
            self.grazing_rate,
            self.leaning_rate,
            self.soft_rate,
            self.astray_rate,
        ]
    }

    pub(super) fn problem(&self) -> Problem {
        let share: f64 = self.rates().into_iter().sum();
        first_problem(&[
            (self.delay_s, "delay_s", Sign::NotNegative),
            (self.patience_s, "patience_s", Sign::Positive),
            (self.too_weak_rate, "too_weak_rate", Sign::NotNegative),
            (self.too_hard_rate, "too_hard_rate", Sign::NotNegative),
            (self.double_rate, "double_rate", Sign::NotNegative),
            (self.grazing_rate, "grazing_rate", Sign::NotNegative),
            (self.leaning_rate, "leaning_rate", Sign::NotNegative),
            (self.soft_rate, "soft_rate", Sign::NotNegative),
            (self.astray_rate, "astray_rate", Sign::NotNegative),
            (self.tilt_sigma_rad, "tilt_sigma_rad", Sign::NotNegative),
        ])
        .or(range_problem(self.too_weak_n, "too_weak_n"))
        .or(range_problem(self.too_hard_n, "too_hard_n"))
        .or(range_problem(self.double_gap_s, "double_gap_s"))
        .or((share > 1.0).then_some(("too_weak_rate", "the rates add up to more than 1")))
    }
}

enum Sign {
    Positive,
    NotNegative,
}

fn first_problem(values: &[(f64, &'static str, Sign)]) -> Problem {
    values.iter().find_map(|(value, key, sign)| match sign {
        Sign::Positive if *value <= 0.0 => Some((*key, "must be positive")),
        Sign::NotNegative if *value < 0.0 => Some((*key, "must not be negative")),
        _ => None,
    })
}

fn range_problem([low, high]: [f64; 2], key: &'static str) -> Problem {
    (!(low > 0.0 && high >= low)).then_some((key, "must be [from, to] with 0 < from <= to"))
}
