//! The suspension modes with their uncertainty.

use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::motion_at;
use massline_shared::modes::modal_assurance;
use nalgebra::Vector6;

use super::{HostFit, Survey};

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
    /// Gravity as the readings have it, m/s², where it was taken instead of the layout's.
    pub fitted_gravity: Option<[f64; 3]>,
    /// Warnings about modes.
    pub diagnostics: Vec<Diagnostic>,
}

impl SuspensionModes {
    pub(super) fn new(fit: &HostFit<'_>, survey: &Survey, diagnostics: Vec<Diagnostic>) -> Self {
        let (layout, reference) = (fit.layout(), fit.reference());
        let length = layout.characteristic_length();
        let forces: Vec<_> = layout.hits.iter().map(|hit| hit.unit_force(&reference)).collect();
        let modes = &fit.modes().modes;
        let row = |(place, mode): (usize, &massline_shared::modes::Mode<f64>)| {
            let sigma = survey.deviations.sigma(place);
            let shape = motion_at(&mode.shape, &-reference);
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
            fitted_gravity: None,
            diagnostics,
        }
    }
}

/// The poles of every order.
fn orders(fit: &HostFit<'_>) -> Vec<OrderRow> {
    let fits = fit.orders().fits();
    let used = fit.orders().sufficient().map_or(0, |order| order.poles.len());
    let order_row = |(place, order): (usize, &massline_shared::modes::Order<f64>)| {
        let poles = order.poles.iter().enumerate().map(|(k, pole)| PoleRow {
            frequency_hz: pole.norm() / std::f64::consts::TAU,
            damping_ratio: -pole.re / pole.norm(),
            stable: place > 0 && order.is_stable(k, &fits[place - 1]),
        });
        OrderRow { used: order.poles.len() == used, poles: poles.collect() }
    };
    fits.iter().enumerate().map(order_row).collect()
}
