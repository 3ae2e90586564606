//! The suspension modes with their uncertainty.

use massline_shared::diagnosis::Diagnostic;
use massline_shared::modes::{MOST_PAIRS, Modes, modal_assurance};
use nalgebra::{Vector3, Vector6};

use super::{HostFit, Survey};

/// Numbers of a mode: frequency, damping ratio, shape.
const FIGURES: usize = 8;

/// A suspension mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeRow {
    /// Natural frequency, Hz, and its standard deviation; NaN where that is not known, as below.
    pub frequency_hz: [f64; 2],
    /// Damping ratio and its standard deviation.
    pub damping_ratio: [f64; 2],
    /// Mass-normalised shape at the origin of the body frame, `[x; θ]`, 1/√kg and 1/(m √kg).
    pub shape: Vector6<f64>,
    /// Standard deviations of the shape.
    pub shape_sigma: Vector6<f64>,
    /// Imaginary over real part of the residues.
    pub complexity: f64,
    /// Norm Indicator of every hit of the layout.
    pub norm_indicators: Vec<f64>,
}

/// The fit of one order.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderRow {
    /// True for the order that the modes come from.
    pub used: bool,
    /// The poles.
    pub poles: Vec<PoleRow>,
}

/// A pole of the fit of one order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleRow {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// True when the next smaller order has this pole as well.
    pub stable: bool,
}

/// All suspension modes of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct SuspensionModes {
    /// The modes, in the order of their frequencies.
    pub rows: Vec<ModeRow>,
    /// Modal assurance criterion of every mode with every other.
    pub assurance: Vec<Vec<f64>>,
    /// Fits of every order, from one pair of poles on.
    pub orders: Vec<OrderRow>,
    /// Standard deviation of the noise of a reading, (m/s²)/N, of a complex number.
    pub noise: f64,
    /// Warnings about modes.
    pub diagnostics: Vec<Diagnostic>,
}

impl SuspensionModes {
    pub(crate) fn new(fit: &HostFit<'_>, survey: &Survey, diagnostics: Vec<Diagnostic>) -> Self {
        let (layout, reference) = (fit.layout(), fit.reference());
        let length = layout.characteristic_length();
        let forces: Vec<_> = layout.hits.iter().map(|hit| hit.unit_force(&reference)).collect();
        let modes = &fit.modes().modes;
        let row = |(place, mode): (usize, &massline_shared::modes::Mode<f64>)| {
            let sigma = survey.modes.sigma(place);
            let shape = at_origin(&mode.shape, &reference);
            ModeRow {
                frequency_hz: [mode.frequency_hz, sigma[0]],
                damping_ratio: [mode.damping_ratio, sigma[1]],
                shape,
                shape_sigma: Vector6::from_fn(|i, _| sigma[2 + i]),
                complexity: mode.complexity,
                norm_indicators: forces.iter().map(|f| mode.indicator(f, length)).collect(),
            }
        };
        let assurance = modes
            .iter()
            .map(|a| modes.iter().map(|b| modal_assurance(&a.shape, &b.shape, length)).collect());
        Self {
            rows: modes.iter().enumerate().map(row).collect(),
            assurance: assurance.collect(),
            orders: orders(fit),
            noise: fit.noise(),
            diagnostics,
        }
    }
}

/// The poles of every order.
fn orders(fit: &HostFit<'_>) -> Vec<OrderRow> {
    let fits = fit.orders().fits();
    let used = fit.orders().sufficient().map_or(0, |order| order.poles.len());
    let of = |(place, order): (usize, &massline_shared::modes::Order<f64>)| {
        let poles = order.poles.iter().enumerate().map(|(k, pole)| PoleRow {
            frequency_hz: pole.norm() / std::f64::consts::TAU,
            damping_ratio: -pole.re / pole.norm(),
            stable: place > 0 && order.is_stable(k, &fits[place - 1]),
        });
        OrderRow { used: order.poles.len() == used, poles: poles.collect() }
    };
    fits.iter().enumerate().map(of).collect()
}

/// A shape of the reference point as one of the origin.
fn at_origin(shape: &Vector6<f64>, reference: &Vector3<f64>) -> Vector6<f64> {
    let rotation = shape.fixed_rows::<3>(3).into_owned();
    let translation = shape.fixed_rows::<3>(0) - rotation.cross(reference);
    Vector6::from_fn(|i, _| if i < 3 { translation[i] } else { rotation[i - 3] })
}

/// What small changes do to the modes.
#[derive(Clone, Debug)]
pub(super) struct Deviations {
    unchanged: Option<Modes<f64>>,
    /// Sums of squares under noise and under errors of the layout.
    noise: [[f64; FIGURES]; MOST_PAIRS],
    layout: [[f64; FIGURES]; MOST_PAIRS],
    draws: u32,
}

impl Deviations {
    pub(super) fn new() -> Self {
        let zero = [[0.0; FIGURES]; MOST_PAIRS];
        Self { unchanged: None, noise: zero, layout: zero, draws: 0 }
    }

    /// Adds changed modes; the first ones are the unchanged ones. `noise` tells a draw of noise from an error of the layout.
    pub(super) fn add(&mut self, changed: &Modes<f64>, noise: bool) {
        let Some(unchanged) = &self.unchanged else {
            self.unchanged = Some(changed.clone());
            return;
        };
        self.draws += u32::from(noise);
        let sums = if noise { &mut self.noise } else { &mut self.layout };
        for (sums, (new, old)) in sums.iter_mut().zip(changed.modes.iter().zip(&unchanged.modes)) {
            // A shape has no sign.
            let sign = if new.shape.dot(&old.shape) < 0.0 { -1.0 } else { 1.0 };
            sums[0] += (new.frequency_hz - old.frequency_hz).powi(2);
            sums[1] += (new.damping_ratio - old.damping_ratio).powi(2);
            for i in 0..6 {
                sums[2 + i] += (sign * new.shape[i] - old.shape[i]).powi(2);
            }
        }
    }

    /// Standard deviations; NaN when nothing was perturbed.
    fn sigma(&self, place: usize) -> [f64; FIGURES] {
        let draws = f64::from(self.draws);
        std::array::from_fn(|k| (self.noise[place][k] / draws + self.layout[place][k]).sqrt())
    }
}
