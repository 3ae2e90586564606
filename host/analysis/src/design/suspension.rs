//! The criterion of the suspension profile: the Cramér-Rao bound of the ten properties from six modes.
//!
//! A mode r with the mass-normalised shape φ shows in a response j under a hit k by its residue `y = (gⱼ φ)(φᵀ fₖ)`,
//! with gⱼ the row of the response at the mode's frequency, gravity included. The six shapes are `Φ = L⁻ᵀ Q`, with
//! `M = L Lᵀ` the mass matrix of the ten properties and Q orthogonal: fifteen angles say how the suspension mixes the
//! motions, and nothing is assumed about it. Frequencies and damping, which all responses share, count as known. The
//! unknowns are the ten properties, the fifteen angles and every uncertain quantity of the layout with its standard
//! deviation as prior.
//!
//! A mode that no hit moves is not found, and what is not found tells nothing, not even that it does not move: its
//! residues are left out. Without two modes or more, the angle between them is open and nothing is determined.
//!
//! The noise of a residue is that of least squares on the windowed record: with white noise, whose line has the
//! variance σ_H² under a window `e^(−σt)` of the length T,
//!
//! ```text
//! var y = 4 σ_H² (ζω + σ)² / (E (ζω + 2σ) ω² n),   E = (1 − e^(−2σT)) / 2σ
//! ```
//! for n hits.

use massline_physics::suspension::RigidMode;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Capacity;
use massline_shared::design::{Criterion, Predict};
use massline_shared::layout::{HostLayout, Layout, UncertainQuantity};
use nalgebra::{Complex, DMatrix, Matrix6, SVector, Vector3, Vector6};

use super::noise::window_energy;

/// Number of angles that mix six motions.
const ANGLES: usize = 15;
/// Number of unknowns without those of the layout.
const UNKNOWNS: usize = 10 + ANGLES;
/// Steps to an orthogonal matrix: each halves singular values above one, and near one the digits double.
const ORTHOGONAL_STEPS: usize = 12;
/// Root of the sum of a mode's squared residues, in standard deviations of one, from which it is found.
const SHOWN: f64 = 5.0;
/// Step of the numerical derivatives, relative to the scales: half the digits of an f64.
const STEP: f64 = 1e-7;

/// The bound for one body on one suspension.
#[derive(Clone, Debug, PartialEq)]
pub struct SuspensionCriterion {
    plain: Criterion<f64>,
    /// Angular frequency, rad/s, and standard deviation of a residue of one hit over that of a line.
    modes: [(f64, f64); 6],
    /// Q.
    mixing: Matrix6<f64>,
}

impl SuspensionCriterion {
    /// The bound for the body of `plain`, with its noise and scale, that has these modes with what the layout attaches
    /// to it, in tests with the settings of the layout and records of `record_s`. Q is the orthogonal matrix nearest to
    /// the shapes: those that were measured are not quite orthogonal.
    pub fn new(
        plain: Criterion<f64>,
        modes: &[RigidMode; 6],
        layout: &HostLayout,
        record_s: f64,
    ) -> Self {
        let decay = layout.test.exponential_decay;
        let energy = window_energy(decay, record_s);
        let of_mode = |mode: &RigidMode| {
            let own = mode.damping_ratio * mode.omega;
            let variance =
                4.0 * (own + decay).powi(2) / (energy * (own + 2.0 * decay) * mode.omega.powi(2));
            (mode.omega, variance.sqrt())
        };
        let shapes = Matrix6::from_columns(&modes.map(|mode| mode.shape));
        let mixing = moving_mass(&plain.body, layout)
            .and_then(|mass| orthogonal(factor(&mass)?.transpose() * shapes))
            .unwrap_or_else(Matrix6::identity);
        Self { plain, modes: modes.each_ref().map(of_mode), mixing }
    }

    /// Body, noise and scale.
    pub fn plain(&self) -> &Criterion<f64> {
        &self.plain
    }

    /// The residues over the standard deviation of their noise: mode by mode, response by response, hit by hit. `None`
    /// for a body without inertia.
    fn residues<C: Capacity>(
        &self,
        layout: &Layout<f64, C>,
        theta: &SVector<f64, 10>,
        mixing: &Matrix6<f64>,
    ) -> Option<Vec<f64>> {
        let mass = moving_mass(&RigidBody::from_theta(theta), layout)?;
        let shapes = factor(&mass)?.transpose().solve_upper_triangular(mixing)?;
        let forces: Vec<Vector6<f64>> =
            layout.hits.iter().map(|hit| hit.unit_force(&Vector3::zeros())).collect();
        let hits = f64::from(layout.test.hits_per_dof.max(1)).sqrt();
        let mut residues = Vec::with_capacity(18 * layout.sensors.len() * forces.len());
        for ((omega, noise), shape) in self.modes.iter().zip(shapes.column_iter()) {
            let scale = hits / (noise * self.plain.noise);
            let excited: Vec<f64> = forces.iter().map(|force| shape.dot(force) * scale).collect();
            for channel in 0..3 * layout.sensors.len() {
                let row = layout.response_row_at(channel, Complex::new(0.0, *omega));
                let seen: f64 =
                    row.iter().zip(shape.iter()).map(|(row, shape)| row.re * shape).sum();
                residues.extend(excited.iter().map(|excited| seen * excited));
            }
        }
        Some(residues)
    }

    /// How the residues of the modes that show change, a column for each unknown: the ten properties over their scales,
    /// the angles, and the uncertain quantities that the layout has, over their standard deviations.
    fn slopes<C: Capacity>(&self, layout: &Layout<f64, C>) -> Option<Vec<Vec<f64>>> {
        let theta = self.plain.body.theta();
        let nominal = self.residues(layout, &theta, &self.mixing)?;
        let of_mode = (nominal.len() / self.modes.len()).max(1);
        let shows = |mode: &[f64]| mode.iter().map(|y| y * y).sum::<f64>() > SHOWN * SHOWN;
        let shown: Vec<bool> = nominal.chunks(of_mode).map(shows).collect();
        let slope = |changed: Vec<f64>, step: f64| {
            let rows = changed.iter().zip(&nominal).enumerate();
            let seen = rows.filter(|(row, _)| shown[row / of_mode]);
            seen.map(|(_, (new, old))| (new - old) / step).collect()
        };
        let mut slopes = Vec::new();
        for property in 0..10 {
            let mut changed = theta;
            changed[property] += STEP * self.plain.scale[property];
            slopes.push(slope(self.residues(layout, &changed, &self.mixing)?, STEP));
        }
        for second in 1..6 {
            for first in 0..second {
                let mut turned = self.mixing;
                turned.column_mut(first).axpy(STEP, &self.mixing.column(second), 1.0);
                turned.column_mut(second).axpy(-STEP, &self.mixing.column(first), 1.0);
                slopes.push(slope(self.residues(layout, &theta, &turned)?, STEP));
            }
        }
        for quantity in layout.uncertain_quantities() {
            let mut shifted = layout.clone();
            if !matches!(quantity, UncertainQuantity::Prior(_)) && shifted.shift(quantity) {
                slopes.push(slope(self.residues(&shifted, &theta, &self.mixing)?, 1.0));
            }
        }
        Some(slopes)
    }
}

impl Predict<f64> for SuspensionCriterion {
    fn scale(&self) -> &SVector<f64, 10> {
        &self.plain.scale
    }

    /// Needs no workspace.
    fn variances<C: Capacity>(
        &self,
        layout: &Layout<f64, C>,
        _workspace: &mut [f64],
    ) -> Option<SVector<f64, 10>> {
        let slopes = self.slopes(layout)?;
        let count = slopes.len();
        let readings = slopes.first()?.len();
        let slopes = DMatrix::from_fn(readings, count, |row, column| slopes[column][row]);
        let mut information = slopes.tr_mul(&slopes);
        for quantity in UNKNOWNS..count {
            information[(quantity, quantity)] += 1.0;
        }
        for prior in &layout.priors {
            let property = usize::from(prior.property);
            information[(property, property)] += (self.plain.scale[property] / prior.sigma).powi(2);
        }
        let covariance = information.cholesky()?.inverse();
        let scale = &self.plain.scale;
        Some(SVector::from_fn(|k, _| covariance[(k, k)] * scale[k] * scale[k]))
    }

    fn with_noise(&self, factor: f64) -> Self {
        Self { plain: self.plain.with_noise(factor), ..self.clone() }
    }
}

/// Mass matrix of a body with what the layout attaches to it; `None` when an attached one has no mass.
fn moving_mass<C: Capacity>(
    body: &RigidBody<f64>,
    layout: &Layout<f64, C>,
) -> Option<Matrix6<f64>> {
    let mut mass = body.mass_matrix();
    for attached in &layout.attached {
        mass += RigidBody::from_phi(&attached.phi.into())?.mass_matrix();
    }
    Some(mass)
}

/// The nearest orthogonal matrix, by Newton's iteration; `None` where the shapes depend on each other.
fn orthogonal(shapes: Matrix6<f64>) -> Option<Matrix6<f64>> {
    let mut nearest = shapes;
    for _ in 0..ORTHOGONAL_STEPS {
        nearest = (nearest + nearest.try_inverse()?.transpose()) * 0.5;
    }
    let left = nearest.tr_mul(&nearest) - Matrix6::identity();
    // What is no number is not below the limit either.
    (left.amax() < STEP).then_some(nearest)
}

/// L of `M = L Lᵀ`.
fn factor(mass: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    Some(mass.cholesky()?.l())
}

#[cfg(test)]
mod tests {
    use massline_physics::Bench;
    use massline_shared::design::total;
    use massline_shared::identify::Method;
    use massline_shared::layout::uncertainty_keys;

    use super::*;
    use crate::design::{Assumptions, LayoutCriterion, PredictedUncertainty, forecast};
    use massline_files::layout_file::LayoutFile;

    const WHEEL: &str = include_str!("../../../examples/wheel.toml");

    fn wheel(text: &str) -> (LayoutFile, Assumptions) {
        let file = LayoutFile::parse(text, "wheel.toml").unwrap();
        let bench = Bench::named("wheel").unwrap();
        let assumed = Assumptions::of(&file, Some(&bench)).unwrap();
        (file, assumed)
    }

    fn criterion(file: &LayoutFile, assumed: &Assumptions) -> LayoutCriterion {
        let layout = &file.layout;
        assumed.criterion(layout, layout.characteristic_length(), assumed.usual_noise(layout))
    }

    #[test]
    fn the_global_fit_is_as_uncertain_as_the_bound_of_six_modes_says() {
        let (file, assumed) = wheel(WHEEL);
        let criterion = criterion(&file, &assumed);
        let bound = criterion.variances(&file.layout, &mut []).unwrap().map(f64::sqrt);
        let hanging = assumed.hanging.as_ref().unwrap();
        let prediction = forecast(&file.layout, hanging, &criterion, |_, _| ()).unwrap();
        let (_, global) =
            prediction.answers.iter().find(|answer| answer.0 == Method::GlobalFit).unwrap();
        for (fit, bound) in global.sigma.iter().zip(bound.iter()) {
            let ratio = fit / bound;
            // The fit also uses the lines between the modes, which say a little more: 0.89 to 1.00. Its noise is
            // estimated from 9000 numbers.
            assert!((0.85..1.03).contains(&ratio), "{ratio}: {:?} {bound}", global.sigma);
        }
        assert_eq!(prediction.modes.len(), 6);
    }

    #[test]
    fn noise_alone_goes_with_the_root_of_the_hits_and_with_the_noise() {
        let exact: String = uncertainty_keys().map(|key| format!("{} = 0\n", key.name)).collect();
        let text = WHEEL.replace("[test]", &format!("[uncertainty]\n{exact}[test]"));
        let (mut file, assumed) = wheel(&text);
        let criterion = criterion(&file, &assumed);
        let sigma = |file: &LayoutFile, criterion: &LayoutCriterion| {
            criterion.variances(&file.layout, &mut []).unwrap()[0].sqrt()
        };
        let usual = sigma(&file, &criterion);
        // Derivatives by steps of 1e-7 are good to 1e-7; the condition multiplies that by a few tens.
        assert!((sigma(&file, &criterion.with_noise(3.0)) / usual - 3.0).abs() < 1e-4);
        file.layout.test.hits_per_dof *= 4;
        assert!((usual / sigma(&file, &criterion) - 2.0).abs() < 1e-4);
    }

    #[test]
    fn one_hit_is_enough_only_if_it_moves_every_mode() {
        let (mut file, coupled) = wheel(WHEEL);
        file.layout.hits.truncate(1);
        // On its three mounts every mode moves under 101:+X.
        let cost = criterion(&file, &coupled).cost(&file.layout, &mut []);
        assert!(cost.is_some_and(|cost| total(cost) < 0.5), "{cost:?}");
        // With a mode along each axis, a push along x does not move those along y and z.
        let apart = Assumptions::of(&file, None).unwrap();
        let cost = criterion(&file, &apart).cost(&file.layout, &mut []);
        assert!(cost.is_none_or(|cost| total(cost) > 1.0), "{cost:?}");
    }

    /// With a hammer whose gain is hardly known the bound of the mass is finite, but its interval contains zero.
    #[test]
    fn what_every_method_would_refuse_is_not_predicted() {
        let (mut file, assumed) = wheel(WHEEL);
        let criterion = criterion(&file, &assumed);
        assert!(PredictedUncertainty::of(&criterion, &file.layout).is_some());
        file.layout.apparatus.hammer_gain = 0.7;
        assert!(criterion.cost(&file.layout, &mut []).is_some());
        assert!(PredictedUncertainty::of(&criterion, &file.layout).is_none());
    }

    /// Of 400 times the noise, the modes that the hits move least do not rise above it.
    #[test]
    fn modes_that_drown_in_noise_leave_the_properties_open() {
        let (file, assumed) = wheel(WHEEL);
        let usual = criterion(&file, &assumed);
        assert!(usual.with_noise(100.0).cost(&file.layout, &mut []).is_some());
        assert!(usual.with_noise(400.0).cost(&file.layout, &mut []).is_none());
    }

    #[test]
    fn a_mass_that_is_known_makes_the_others_more_certain() {
        let (mut file, assumed) = wheel(WHEEL);
        let criterion = criterion(&file, &assumed);
        let before = criterion.variances(&file.layout, &mut []).unwrap();
        let prior = massline_shared::layout::Prior { property: 0, value: 17.295, sigma: 0.01 };
        file.layout.priors.push(prior).unwrap();
        let after = criterion.variances(&file.layout, &mut []).unwrap();
        assert!(after[0].sqrt() < 0.01);
        // The hammer's gain is most of the uncertainty of the moments, and the mass shows it.
        assert!((4..7).all(|k| after[k] < 0.5 * before[k]), "{before} {after}");
    }
}
