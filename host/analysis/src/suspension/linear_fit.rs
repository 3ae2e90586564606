//! How the answer by maximum likelihood follows small changes of readings and layout, to first order: one product for
//! each of the hundreds of changes, in place of a fit to each. It minimises the same sum of squares as the fit does
//! about its answer (theory, section 4).

use massline_shared::body::{RigidBody, scale};
use massline_shared::capacity::Unbounded;
use massline_shared::identify::DofMassLines;
use massline_shared::layout::{HIT_QUANTITIES, HostLayout, UncertainQuantity};
use nalgebra::{DMatrix, DVector, SVector};

/// Change of a property for its derivative, relative to its scale: the square of it and the rounding over it are about
/// equal.
const STEP: f64 = 1e-5;
/// Least standard deviation of a reading, relative to the largest of its DOF: exact readings have no weight otherwise.
const LEAST_NOISE: f64 = 1e-6;

/// An answer by maximum likelihood with what it owes to each reading.
#[derive(Clone, Debug)]
pub(super) struct LinearFit {
    answer: RigidBody<f64>,
    /// What the answer leaves of readings and priors.
    left: DVector<f64>,
    /// A row for each property, a column for each reading, DOF by DOF, and for each prior.
    gain: DMatrix<f64>,
}

impl LinearFit {
    /// About an answer to these lines under a layout with the error budget that the answer has learned. `None` where
    /// the layout does not determine the ten properties there.
    pub(super) fn about(
        answer: &RigidBody<f64>,
        layout: &HostLayout,
        lines: &[DofMassLines<f64, Unbounded>],
    ) -> Option<Self> {
        let left = left(answer, layout, lines)?;
        let shifted = |shift: UncertainQuantity, layout: &HostLayout| {
            let mut shifted = layout.clone();
            shifted
                .shift(shift)
                .then(|| self::left(answer, &shifted, lines))?
                .map(|now| &left - now)
        };
        let scale = scale(answer.mass, layout.characteristic_length());
        let slope = |property: usize| {
            let step =
                SVector::<f64, 10>::from_fn(
                    |k, _| if k == property { STEP * scale[k] } else { 0.0 },
                );
            let at = |theta| self::left(&RigidBody::from_theta(&theta), layout, lines);
            let [above, below] = [at(answer.theta() + step)?, at(answer.theta() - step)?];
            Some((below - above) / (2.0 * STEP))
        };
        let mut columns: Vec<DVector<f64>> = (0..10).map(slope).collect::<Option<_>>()?;
        let constant = layout.uncertain_quantities().filter(|quantity| is_constant(*quantity));
        columns.extend(constant.filter_map(|quantity| shifted(quantity, layout)));
        let columns = DMatrix::from_columns(&columns);

        let channels = 3 * layout.sensors.len();
        let mut weighted = DMatrix::zeros(columns.ncols(), columns.nrows());
        for (place, (hit, of_dof)) in lines.iter().enumerate() {
            let mut layout = layout.clone();
            layout.test.hits_per_dof = u8::try_from(of_dof.hits).unwrap_or(u8::MAX);
            let of_hit = layout.uncertain_quantities().filter(|change| is_of_hit(*change, *hit));
            let least = LEAST_NOISE * of_dof.accelerance.largest();
            let noise = of_dof.noise.iter().take(channels).map(|sigma| sigma.max(least).powi(2));
            let mut covariance = DMatrix::from_diagonal(&DVector::from_iterator(channels, noise));
            for change in of_hit.filter_map(|quantity| shifted(quantity, &layout)) {
                let change = change.rows(place * channels, channels);
                covariance.ger(1.0, &change, &change, 1.0);
            }
            let rows = columns.rows(place * channels, channels);
            let product = covariance.cholesky()?.solve(&rows).transpose();
            weighted.columns_mut(place * channels, channels).copy_from(&product);
        }
        let first_prior = channels * lines.len();
        for (place, prior) in layout.priors.iter().enumerate() {
            let row = columns.row(first_prior + place) / prior.sigma.powi(2);
            weighted.set_column(first_prior + place, &row.transpose());
        }
        let mut information = &weighted * &columns;
        for nuisance in 10..columns.ncols() {
            information[(nuisance, nuisance)] += 1.0;
        }
        let properties = DMatrix::identity(columns.ncols(), 10);
        let mut gain = information.cholesky()?.solve(&properties).transpose() * weighted;
        gain.row_iter_mut().zip(&scale).for_each(|(mut row, scale)| row *= *scale);
        Some(Self { answer: *answer, left, gain })
    }

    /// The ten properties from other readings, or under another layout.
    pub(super) fn theta(
        &self,
        layout: &HostLayout,
        lines: &[DofMassLines<f64, Unbounded>],
    ) -> Option<SVector<f64, 10>> {
        let change = left(&self.answer, layout, lines)? - &self.left;
        let change = &self.gain * change;
        Some(self.answer.theta() + change.fixed_rows::<10>(0))
    }
}

/// True for an error that stays the same over the test and that mass lines show.
fn is_constant(quantity: UncertainQuantity) -> bool {
    use UncertainQuantity::{Attached, Gravity, Hammer, Hit, Prior, Sensor};
    match quantity {
        Sensor { .. } | Hammer | Attached(_) => true,
        Hit { .. } | Gravity(_) | Prior(_) => false,
    }
}

/// True for an error of place or direction of the hits on a DOF; that of their strength has no weight in the fit.
fn is_of_hit(change: UncertainQuantity, hit: usize) -> bool {
    matches!(change, UncertainQuantity::Hit { index, quantity } if index == hit && quantity < HIT_QUANTITIES - 1)
}

/// What a body leaves of the readings, DOF by DOF, and of the priors.
fn left(
    object: &RigidBody<f64>,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
) -> Option<DVector<f64>> {
    let attached = layout.attached.iter().map(|body| SVector::from(body.phi));
    let whole = RigidBody::from_phi(&(object.phi() + attached.sum::<SVector<f64, 10>>()))?;
    let channels = 3 * layout.sensors.len();
    let mut residuals = Vec::with_capacity(channels * lines.len() + layout.priors.len());
    for (hit, of_dof) in lines {
        let left = &of_dof.accelerance - &layout.accelerance(&whole, *hit)?;
        residuals.extend(left.iter().take(channels));
    }
    let theta = object.theta();
    residuals
        .extend(layout.priors.iter().map(|prior| prior.value - theta[usize::from(prior.property)]));
    Some(DVector::from_vec(residuals))
}

#[cfg(test)]
mod tests {
    use massline_shared::identify::MassLines;
    use massline_shared::identify::maximum_likelihood::{ErrorBudget, Start, solve, workspace};
    use massline_shared::layout::{AttachedBody, Prior};
    use massline_shared::responses::Responses;

    use super::*;
    use massline_files::layout_file::LayoutFile;

    fn layout() -> HostLayout {
        let text = include_str!("../../../examples/three-bar-test-1.toml");
        let mut layout = LayoutFile::parse(text, "three-bar-test-1.toml").unwrap().layout;
        let of_five_grams = [0.005, 0.0005, 0.0, 0.0, 1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0];
        layout.attached.push(AttachedBody { phi: of_five_grams, relative_sigma: 0.1 }).unwrap();
        layout.priors.push(Prior { property: 0, value: 1.23, sigma: 0.01 }).unwrap();
        layout
    }

    fn lines(layout: &HostLayout) -> Vec<DofMassLines<f64, Unbounded>> {
        let theta = [1.23, 0.169, -0.089, 0.02, 0.0111, 0.0068, 0.0139, 0.0042, -0.001, 0.0027];
        let body = RigidBody::from_theta(&SVector::from(theta));
        let of_hit = |hit| {
            let mut lines = MassLines::without_scatter(layout.accelerance(&body, hit).unwrap())
                .with_noise(Responses::repeat(3, 0.002));
            lines.hits = 5;
            (hit, lines)
        };
        (0..layout.hits.len()).map(of_hit).collect()
    }

    fn refitted(
        layout: &HostLayout,
        lines: &[DofMassLines<f64, Unbounded>],
        start: Start<'_, f64>,
    ) -> RigidBody<f64> {
        let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
        solve(layout, lines, start, ErrorBudget::FirstOrder, &mut memory).unwrap().estimate.body
    }

    #[test]
    fn errors_of_the_layout_move_the_answer_as_fits_anew_do() {
        let layout = layout();
        let lines = lines(&layout);
        let answer = refitted(&layout, &lines, Start::InertiaRestraint);
        let fit = LinearFit::about(&answer, &layout, &lines).unwrap();
        let mut variances = [SVector::<f64, 10>::zeros(); 2];
        for quantity in layout.uncertain_quantities() {
            let mut shifted = layout.clone();
            if shifted.shift(quantity) {
                let linear = fit.theta(&shifted, &lines).unwrap();
                let refitted = refitted(&shifted, &lines, Start::At(&answer)).theta();
                for (variance, theta) in variances.iter_mut().zip([linear, refitted]) {
                    *variance += (theta - answer.theta()).map(|change| change * change);
                }
            }
        }
        let [linear, refitted] = variances.map(|variance| variance.map(f64::sqrt));
        let ratio = linear.component_div(&refitted);
        // What is left is of second order, and the largest errors are 5 % of something. The agreement knows a variance
        // from 200 draws, so a standard deviation to 5 %.
        assert!(ratio.iter().all(|ratio| (ratio - 1.0).abs() < 0.05), "{ratio}");
    }

    #[test]
    fn noise_moves_the_answer_as_a_fit_anew_does() {
        let layout = layout();
        let mut lines = lines(&layout);
        let answer = refitted(&layout, &lines, Start::InertiaRestraint);
        let fit = LinearFit::about(&answer, &layout, &lines).unwrap();
        for (place, (_, of_dof)) in lines.iter_mut().enumerate() {
            of_dof.accelerance.iter_mut().enumerate().for_each(|(channel, reading)| {
                *reading += if (place + channel).is_multiple_of(2) { 0.002 } else { -0.002 };
            });
        }
        let refitted = refitted(&layout, &lines, Start::At(&answer)).theta();
        let change = (refitted - answer.theta()).amax();
        let left = (fit.theta(&layout, &lines).unwrap() - refitted).amax();
        // Noise of a thousandth of the readings; what is left is its square.
        assert!(change > 1e-6 && left < 0.01 * change, "{left:e} of {change:e}");
    }

    #[test]
    fn there_is_none_about_an_answer_that_is_no_body() {
        let layout = layout();
        let lines = lines(&layout);
        let none = RigidBody::from_theta(&SVector::zeros());
        assert!(LinearFit::about(&none, &layout, &lines).is_none());
        // The readings of one hit do not determine ten properties.
        let answer = refitted(&layout, &lines, Start::InertiaRestraint);
        assert!(LinearFit::about(&answer, &layout, &lines[..1]).is_none());
    }
}
