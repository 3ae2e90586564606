//! Score tests (Rao 1948) of small faults in the readings of the suspension modes.
//!
//! A fault of size s changes the sensors and hits of the layout, and the nuisance parameters u of the global fit describe
//! such changes: it is `u = B s` besides the errors of the budget, which are N(0, 1) each. With the parameters û at the
//! minimum and their covariance P the readings say of it
//!
//! ```text
//! ŝ = F⁻¹ Bᵀ û,    cov ŝ = F⁻¹,    F = Bᵀ (I − P) B
//! ```
//! whatever else is fitted, and no further fit is needed.

use massline_shared::layout::{
    GRAVITY_QUANTITIES, HIT_QUANTITIES, HostLayout, SENSOR_QUANTITIES, UncertainQuantity,
};
use nalgebra::{DMatrix, DVector, Vector3};

use super::GlobalAnswer;
use crate::score_tests::{FoundSize, ScoreTest, ScoreTests, SmallFault};

/// Size, m, rad or relative, over which a layout is differentiated. It is nearly linear in all faults.
const DIFFERENCE: f64 = 1e-4;
/// A change that sensors or hits with their errors cannot make but for this part is not one of them.
const LEFT: f64 = 1e-6;
/// Factor on the standard deviation of scores beside gains of single modes, of which P knows nothing.
const BESIDE_GAINS: f64 = 1.2;

impl GlobalAnswer {
    /// The tests of this answer under the layout that it was found with.
    pub(super) fn score_tests(&self, layout: &HostLayout) -> ScoreTests {
        let Some(fitted) = FittedParameters::of(self, layout) else { return ScoreTests::default() };
        let tests = SmallFault::of_suspension(layout).filter_map(|fault| fitted.test(fault));
        ScoreTests::among(tests.collect())
    }
}

/// The parameters of sensors and hits as the fit has left them.
struct FittedParameters<'a> {
    layout: &'a HostLayout,
    describing: Describing,
    pulls: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Changes of the properties, in their standard deviations, with each parameter.
    shifts: DMatrix<f64>,
    mass: f64,
    /// Variance of what a size is off in a layout without faults, over what P says.
    variance: f64,
}

impl<'a> FittedParameters<'a> {
    fn of(answer: &GlobalAnswer, layout: &'a HostLayout) -> Option<Self> {
        let estimate = &answer.solution.estimate;
        let sigma = estimate.sigma()?;
        let describing = Describing::of(layout);
        let (count, whole) = (describing.count, answer.pulls.len());
        let covariance = DMatrix::from_row_slice(whole, whole, &answer.posterior);
        let shifts: Vec<_> =
            answer.nuisances.get(..count)?.iter().map(|own| own.component_div(&sigma)).collect();
        Some(Self {
            layout,
            pulls: DVector::from_column_slice(answer.pulls.get(..count)?),
            covariance: covariance.view((0, 0), (count, count)).into_owned(),
            shifts: DMatrix::from_fn(10, count, |row, k| shifts[k][row]),
            mass: estimate.body.mass,
            variance: if answer.gains.is_some() { BESIDE_GAINS.powi(2) } else { 1.0 },
            describing,
        })
    }

    fn test(&self, fault: SmallFault) -> Option<ScoreTest> {
        let changes = fault.changes_of_layout(self.layout);
        let columns: Option<Vec<DVector<f64>>> =
            changes.iter().map(|change| self.describing.parameters(self.layout, change)).collect();
        let of_parameters = DMatrix::from_columns(&columns.filter(|own| !own.is_empty())?);
        let weighted = &of_parameters / self.variance;
        let all = weighted.tr_mul(&of_parameters);
        let own = &all - weighted.tr_mul(&(&self.covariance * &of_parameters));
        let scores = weighted.tr_mul(&self.pulls);
        let largest = fault.largest(self.layout.characteristic_length(), self.mass);
        let found = FoundSize::of(&own, &all.diagonal(), &scores, largest)?;
        let shifts = &self.shifts * of_parameters;
        ScoreTest::new(fault, found.estimate(&shifts, found.squares()))
    }
}

/// Sensors and hits as the nuisance parameters move them.
struct Describing {
    /// For each sensor and hit: the place of its parameters, and the changes of its coordinates by each of them.
    objects: Vec<(usize, DMatrix<f64>)>,
    /// Number of parameters.
    count: usize,
}

impl Describing {
    fn of(layout: &HostLayout) -> Self {
        let shifted = |quantity: UncertainQuantity| {
            let mut shifted = layout.clone();
            shifted.shift(quantity);
            shifted
        };
        let sensors = (0..layout.sensors.len()).map(|index| {
            let before = sensor_coordinates(layout, index);
            let columns: Vec<_> = (0..SENSOR_QUANTITIES)
                .map(|quantity| UncertainQuantity::Sensor { index, quantity })
                .map(|quantity| sensor_coordinates(&shifted(quantity), index) - &before)
                .collect();
            (SENSOR_QUANTITIES * index, DMatrix::from_columns(&columns))
        });
        let first = SENSOR_QUANTITIES * layout.sensors.len() + GRAVITY_QUANTITIES;
        let hits = (0..layout.hits.len()).map(|index| {
            let before = hit_coordinates(layout, layout, index);
            let columns: Vec<_> = (0..HIT_QUANTITIES)
                .map(|quantity| UncertainQuantity::Hit { index, quantity })
                .map(|quantity| hit_coordinates(&shifted(quantity), layout, index) - &before)
                .collect();
            (first + HIT_QUANTITIES * index, DMatrix::from_columns(&columns))
        });
        let count = first + HIT_QUANTITIES * layout.hits.len();
        Self { objects: sensors.chain(hits).collect(), count }
    }

    /// The nuisance parameters that describe a change of the layout per unit of its size; `None` where something changes
    /// that has no error in the budget.
    fn parameters(
        &self,
        layout: &HostLayout,
        change: &dyn Fn(&mut HostLayout, f64),
    ) -> Option<DVector<f64>> {
        let changed = |size: f64| {
            let mut changed = layout.clone();
            change(&mut changed, size);
            changed
        };
        let (ahead, behind) = (changed(DIFFERENCE), changed(-DIFFERENCE));
        let sensors = layout.sensors.len();
        let mut parameters = DVector::zeros(self.count);
        for (k, (first, columns)) in self.objects.iter().enumerate() {
            let at = |moved: &HostLayout| match k.checked_sub(sensors) {
                None => sensor_coordinates(moved, k),
                Some(hit) => hit_coordinates(moved, layout, hit),
            };
            let wanted = (at(&ahead) - at(&behind)) / (2.0 * DIFFERENCE);
            if wanted.amax() == 0.0 {
                continue;
            }
            let own = columns.clone().pseudo_inverse(f64::EPSILON).ok()? * &wanted;
            if (columns * &own - &wanted).norm() > LEFT * wanted.norm() {
                return None;
            }
            parameters.rows_mut(*first, own.len()).copy_from(&own);
        }
        Some(parameters)
    }
}

/// Position, m, and axes of a sensor.
fn sensor_coordinates(layout: &HostLayout, sensor: usize) -> DVector<f64> {
    let sensor = &layout.sensors[sensor];
    let axes = sensor.axes.iter().flatten();
    DVector::from_iterator(12, sensor.position.iter().chain(axes).copied())
}

/// Position across its direction, m, and direction of a hit: along its direction a force may be displaced.
fn hit_coordinates(layout: &HostLayout, nominal: &HostLayout, hit: usize) -> DVector<f64> {
    let along = Vector3::from(nominal.hits[hit].direction);
    let hit = &layout.hits[hit];
    let position = Vector3::from(hit.position);
    let across = position - along * along.dot(&position);
    DVector::from_iterator(6, across.iter().chain(&hit.direction).copied())
}

#[cfg(test)]
mod tests {
    use massline_physics::Bench;
    use massline_shared::FrequencyResponses;
    use massline_shared::identify::global_fit::GlobalFitSettings;
    use massline_shared::layout::Axis;

    use super::*;
    use crate::suspension::test_wheel::{wheel, wheel_responses};

    /// The tests of the wheel's exact responses, measured with a layout that is changed by so much of a fault along its
    /// first direction.
    fn tested(layout: &HostLayout, fault: Option<(SmallFault, f64)>) -> ScoreTests {
        let mut measured = layout.clone();
        if let Some((fault, size)) = fault {
            fault.changes_of_layout(layout)[0](&mut measured, size);
        }
        let frequencies: Vec<f64> = (0..180).map(|line| 1.0 + 0.05 * f64::from(line)).collect();
        let responses = wheel_responses(&measured, &frequencies, |_| 1.0);
        let readings =
            FrequencyResponses::new(&frequencies, &responses, 9, layout.hits.len()).unwrap();
        let settings = GlobalFitSettings { most_extra_terms: 0, ..Default::default() };
        let start = Bench::named("wheel").unwrap().truth();
        GlobalAnswer::of(layout, &readings, &start, &settings).unwrap().score_tests(layout)
    }

    #[test]
    fn every_fault_is_found_with_its_size() {
        let layout = wheel();
        assert_eq!(tested(&layout, None).shown(), Vec::<&ScoreTest>::new());
        for fault in SmallFault::of_suspension(&layout) {
            let tests = tested(&layout, None).tests;
            let Some(test) = tests.iter().find(|test| test.fault == fault) else { continue };
            // Of half a standard deviation: what is of second order is small beside it.
            let size = 0.5 * test.sizes[0].sigma;
            let tests = tested(&layout, Some((fault, size))).tests;
            let found = tests.iter().find(|test| test.fault == fault).unwrap().sizes[0].value;
            assert!((found / size - 1.0).abs() < 0.1, "{fault:?}: {found} of {size}");
        }
    }

    #[test]
    fn what_has_no_error_in_the_budget_is_not_tested() {
        let mut layout = wheel();
        layout.sensors[0].uncertainty.position = 0.0;
        let tests = tested(&layout, None).tests;
        let node = |node| SmallFault::NodeMisplaced { node, axis: Axis::X };
        assert!(tests.iter().any(|test| test.fault == node(2)));
        assert!(!tests.iter().any(|test| test.fault == node(1)));
        layout.set_exact();
        assert_eq!(tested(&layout, None), ScoreTests::default());
    }
}
