use super::*;
use crate::capacity::Fixed;
use crate::identify::ScatterAccumulator;
use std::vec::Vec;

/// Room for two sensors.
type Two = Fixed<2, 3>;

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const BLOCK: BlockMass<f64> = BlockMass { mass: 2.0, sigma: 0.0 };

fn lines<R: Real>(hits: &[BlockHit<R, Two>]) -> impl Iterator<Item = &MassLines<R, Two>> + Clone {
    hits.iter().map(|hit| &hit.lines)
}

/// True sensitivity of two sensors relative to the calibration in use: +7 % and −4 %, with cross-axis terms.
fn sensors() -> [Matrix3<f64>; 2] {
    #[rustfmt::skip]
    let first = Matrix3::new(1.07, 0.01, -0.02, 0.015, 1.05, 0.0, 0.01, -0.01, 1.06);
    #[rustfmt::skip]
    let second = Matrix3::new(0.96, 0.02, 0.01, -0.01, 0.97, 0.005, 0.0, 0.012, 0.95);
    [first, second]
}

/// Five hits along each axis with direction errors of ±`direction_error` rad, read through `sensors` and a
/// hammer whose output is `hammer` times the nominal one.
fn hits<R: Real>(
    sensors: &[Matrix3<f64>; 2],
    hammer: f64,
    direction_error: f64,
) -> Vec<BlockHit<R, Two>> {
    let pattern = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.0, 0.0]];
    (0..3)
        .map(|axis| {
            let mut lines = ScatterAccumulator::<f64, Two>::new(2);
            for [a, b] in pattern {
                let mut push = Vector3::ith(axis, 1.0);
                push[(axis + 1) % 3] = a * direction_error;
                push[(axis + 2) % 3] = b * direction_error;
                let acceleration = push.normalize() / BLOCK.mass;
                let mut read = Responses::<f64, Two>::zeros(2);
                for (i, sensor) in sensors.iter().enumerate() {
                    read.set_sensor(i, (sensor * acceleration / hammer).into());
                }
                lines.add(&read, None);
            }
            let lines = lines.mass_lines().cast();
            BlockHit { direction: Vector3::ith(axis, R::one()), lines }
        })
        .collect()
}

fn recovers_the_matrices<R: Real>(tolerance: f64) {
    let truth = sensors();
    let hits = hits::<R>(&truth, 1.02, 0.0);
    let block = BlockMass { mass: R::of(2.0), sigma: R::zero() };
    for (i, expected) in truth.iter().enumerate() {
        let axes = AXES.map(|axis| axis.map(R::of));
        let estimate = sensor_ratios(&hits, i, &axes, block).unwrap();
        let error = estimate.ratio.map(Real::to_f64) - expected / 1.02;
        assert!(error.amax() < tolerance, "{error}");
    }
}

/// The tolerance covers the rounding of a few products.
#[test]
fn straight_hits_give_the_matrix_of_every_sensor_over_the_hammer() {
    recovers_the_matrices::<f64>(1e-14);
    recovers_the_matrices::<f32>(1e-6);
}

#[test]
fn sensors_may_stand_turned_on_the_block() {
    // The sensor's x points along y of the block, its y against x.
    let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let turn = Matrix3::from_fn(|row, column: usize| axes[row][column]);
    let truth = sensors();
    let seen = truth.map(|sensor| sensor * turn);
    let estimate = sensor_ratios(&hits::<f64>(&seen, 1.0, 0.0), 1, &axes, BLOCK).unwrap();
    assert!((estimate.ratio - truth[1]).amax() < 1e-14, "{}", estimate.ratio);
}

fn hammer_is_found<R: Real>(tolerance: f64) {
    let exact = [Matrix3::identity(); 2];
    let block = BlockMass { mass: R::of(2.0), sigma: R::of(0.001) };
    for direction_error in [0.0, 0.03, 0.1] {
        let hits = hits::<R>(&exact, 1.02, direction_error);
        let estimate = force_ratio(lines(&hits), 2, block).unwrap();
        let error = estimate.ratio.to_f64() * 1.02 - 1.0;
        assert!(error.abs() < tolerance, "{direction_error}: {error}");
        assert!(estimate.is_consistent());
        // The mass is known to 0.05 %, the floor is 0.1 %, and the length of the hits is exact but for the
        // curvature of an arc of `direction_error`.
        let sigma = estimate.sigma.to_f64();
        assert!(
            (1.08e-3..1.12e-3 + 0.2 * direction_error * direction_error).contains(&sigma),
            "{sigma}"
        );
    }
}

/// The length of a calibrated reading does not depend on the direction; the tolerance covers rounding.
#[test]
fn with_known_sensors_hits_that_miss_their_direction_still_give_the_hammer_exactly() {
    hammer_is_found::<f64>(1e-13);
    hammer_is_found::<f32>(1e-5);
}

#[test]
fn a_direction_that_contradicts_the_others_is_seen() {
    let mut wrong = [Matrix3::identity(); 2];
    // Both sensors read 3 % too much along y, which is 2 % from the mean of the three directions.
    wrong.iter_mut().for_each(|s| s[(1, 1)] = 1.03);
    let estimate = force_ratio(lines(&hits::<f64>(&wrong, 1.0, 0.03)), 2, BLOCK).unwrap();
    assert!((estimate.departure.0 - 0.02).abs() < 1e-3, "{:?}", estimate.departure);
    assert!(!estimate.is_consistent());
}

/// The standard deviation of a cross-axis ratio is that of the mean direction: four of five hits have a
/// direction error of 30 mrad, two to each side.
#[test]
fn the_scatter_of_the_directions_is_the_sigma_of_the_cross_axis_ratios() {
    let exact = [Matrix3::identity(); 2];
    let estimate = sensor_ratios(&hits::<f64>(&exact, 1.0, 0.03), 0, &AXES, BLOCK).unwrap();
    let expected = 0.03 * (2.0 / 4.0_f64).sqrt() / 5.0_f64.sqrt();
    for (row, column) in super::super::tumble::OFF_DIAGONAL {
        let sigma = estimate.sigma[(row, column)];
        // The hit directions are normalised, which reduces the value by 4.5e-4.
        assert!((sigma / expected - 1.0).abs() < 2e-3, "{sigma} {expected}");
    }
    assert!(estimate.sigma.diagonal().amax() < 2e-4);
}

#[test]
fn what_gives_no_calibration_is_named() {
    let good = hits::<f64>(&sensors(), 1.0, 0.03);
    let ratio = |hits: &[BlockHit<f64, Two>]| sensor_ratios(hits, 0, &AXES, BLOCK).unwrap_err();
    assert_eq!(ratio(&good[..2]), BlockError::DirectionsMissing);
    assert_eq!(ratio(&[]), BlockError::DirectionsMissing);
    let mut once = good.clone();
    once[1].lines.hits = 1;
    assert_eq!(ratio(&once), BlockError::TooFewHits);
    assert_eq!(force_ratio(lines(&once), 2, BLOCK), Err(BlockError::TooFewHits));
    let mut broken = good.clone();
    broken[2].lines.accelerance[4] = f64::NAN;
    assert_eq!(ratio(&broken), BlockError::NotFinite);
    let weightless = BlockMass { mass: 0.0, sigma: 0.0 };
    assert_eq!(force_ratio(lines(&good), 2, weightless), Err(BlockError::NotFinite));
    let mut dead = good.clone();
    for hit in &mut dead {
        hit.lines.accelerance.set_sensor(1, [0.0; 3]);
        hit.lines.scatter = crate::responses::ResponseSquare::zeros(2);
    }
    let silent = BlockError::Dead { sensor: 1 };
    assert_eq!(sensor_ratios(&dead, 1, &AXES, BLOCK), Err(silent));
    assert_eq!(force_ratio(lines(&dead), 2, BLOCK), Err(silent));
    assert_eq!(force_ratio(lines(&good), 3, BLOCK), Err(BlockError::DirectionsMissing));
}
