use super::*;
use std::vec::Vec;

const G: f64 = crate::units::STANDARD_GRAVITY;

/// A sensor with gains off by up to 8 % and 1.5 % of cross-axis sensitivity, V/(m/s²).
fn truth() -> (Vector3<f64>, Matrix3<f64>) {
    #[rustfmt::skip]
    let relative = Matrix3::new(
        1.05, 0.012, -0.008,
        -0.015, 0.92, 0.004,
        0.006, 0.011, 1.08,
    );
    (Vector3::new(1.46, 1.52, 1.57), relative * (0.057 / G))
}

/// Readings of the sensor in the six positions, each tilted by two angles.
fn readings<R: Real>(tilts: [[f64; 2]; 6]) -> Vec<SensorVoltages<R>> {
    let (zero, sensitivity) = truth();
    let tilted = |(position, [first, second]): (Position, [f64; 2])| {
        let mut up = position.up::<f64>();
        up[(position.axis.index() + 1) % 3] = first;
        up[(position.axis.index() + 2) % 3] = second;
        let mean = zero + sensitivity * up.normalize() * G;
        SensorVoltages {
            position,
            mean: mean.map(R::of),
            deviation: Vector3::repeat(R::of(5e-4)),
            sigma: Vector3::repeat(R::of(1e-5)),
        }
    };
    Position::ALL.into_iter().zip(tilts).map(tilted).collect()
}

fn level<R: Real>() -> Vec<SensorVoltages<R>> {
    readings([[0.0; 2]; 6])
}

fn recovered<R: Real>(tolerance: f64) {
    let (zero, sensitivity) = truth();
    let solution = solve(&level::<R>(), &TumbleLimits::default()).unwrap();
    let error = solution.sensitivity.map(Real::to_f64) - sensitivity;
    assert!(error.amax() < tolerance * sensitivity.amax(), "{error}");
    assert!((solution.zero.map(Real::to_f64) - zero).amax() < tolerance);
    assert!(solution.tilt.to_f64() < 10.0 * tolerance);
    assert!(solution.is_level(&TumbleLimits::default()));
}

/// The tolerance covers rounding: differences of voltages whose size is the sensitivity times 2 g, a third of
/// the zero.
#[test]
fn level_positions_give_zero_and_sensitivity_exactly() {
    recovered::<f64>(1e-14);
    recovered::<f32>(1e-5);
}

/// 3 mrad in every position: the gain error is of second order (1e-5), and the cross-axis error is half the
/// difference of two tilts.
#[test]
fn tilts_cost_gains_nothing_and_their_size_is_reported() {
    let t = 0.003;
    let signs = [[t, -t], [t, t], [-t, t], [t, -t], [-t, -t], [t, t]];
    let (_, sensitivity) = truth();
    let solution = solve(&readings::<f64>(signs), &TumbleLimits::default()).unwrap();
    let relative = (solution.sensitivity - sensitivity) * (G / 0.057);
    for k in 0..3 {
        // A tilt t reduces the reading by t², 1e-5, and adds up to 2 % of cross-axis sensitivity times t,
        // 6e-5.
        assert!(relative[(k, k)].abs() < 7e-5, "{relative}");
    }
    for (row, column) in OFF_DIAGONAL {
        assert!(relative[(row, column)].abs() < 1.1 * t, "{relative}");
        let sigma = solution.sensitivity_sigma[(row, column)] * (G / 0.057);
        assert!((0.3 * t..2.0 * t).contains(&sigma), "{sigma}");
    }
    // Six midpoints that are 0 or ±t: their mean square equals that of the tilts within a small factor.
    assert!((0.4 * t..1.6 * t).contains(&solution.tilt), "{}", solution.tilt);
}

#[test]
fn one_tilted_position_is_named_by_its_axis() {
    let mut tilts = [[0.0; 2]; 6];
    tilts[3] = [0.06, 0.0];
    let solution = solve(&readings::<f64>(tilts), &TumbleLimits::default()).unwrap();
    assert_eq!(solution.worst.0, Axis::Y);
    // Half of the tilt appears in the midpoint; gains differ by up to 8 %.
    assert!((solution.worst.1 - 0.03).abs() < 0.003, "{}", solution.worst.1);
    assert!(!solution.is_level(&TumbleLimits::default()));
}

fn problems(readings: &[SensorVoltages<f64>]) -> TumbleProblems<f64> {
    solve(readings, &TumbleLimits::default()).unwrap_err()
}

#[test]
fn missing_and_repeated_positions_are_named() {
    let mut five = level::<f64>();
    let again = five.remove(3);
    assert_eq!(problems(&five)[..], [TumbleProblem::Missing(Position::ALL[3])]);
    five.push(SensorVoltages { position: Position::ALL[0], ..again });
    assert_eq!(
        problems(&five)[..],
        [TumbleProblem::Repeated(Position::ALL[0]), TumbleProblem::Missing(Position::ALL[3])]
    );
    assert_eq!(problems(&[]).len(), 6);
}

#[test]
fn a_sensor_that_was_not_turned_reads_as_the_position_before() {
    let mut six = level::<f64>();
    six[1].mean = six[0].mean;
    let doubled = TumbleProblem::ReadsAs { position: Position::ALL[1], like: Position::ALL[0] };
    assert_eq!(problems(&six)[..], [doubled]);
    // Two swapped channels: four positions read as others.
    let mut six = level::<f64>();
    six.iter_mut().for_each(|r| r.mean.swap_rows(0, 1));
    assert_eq!(problems(&six).len(), 4);
}

#[test]
fn a_reading_that_moves_is_no_number_or_not_one_g_is_named() {
    let mut six = level::<f64>();
    six[2].deviation.y = 0.01;
    let [TumbleProblem::NotAtRest { position, deviation }] = problems(&six)[..] else {
        panic!("{:?}", problems(&six));
    };
    assert_eq!(position, Position::ALL[2]);
    // 10 mV over 5.81 mV/(m/s²).
    assert!((deviation - 1.7205).abs() < 1e-3);
    let mut six = level::<f64>();
    six[4].mean.z = f64::NAN;
    assert_eq!(problems(&six)[..], [TumbleProblem::NotFinite(Position::ALL[4])]);
    // A channel is not connected, so nothing is read along z.
    let mut six = level::<f64>();
    six.iter_mut().for_each(|r| r.mean.z = 0.0);
    let problem_list = problems(&six);
    assert!(
        problem_list.iter().any(|p| !matches!(p, TumbleProblem::Missing(_)))
            && problem_list.len() == 2
    );
}

#[test]
fn a_position_is_read_from_its_name() {
    for position in Position::ALL {
        assert_eq!(position.name().parse(), Ok(position));
    }
    assert_eq!("-z ".parse(), Ok(Position::ALL[5]));
    assert_eq!("Z".parse::<Position>(), Err(PositionError));
}
