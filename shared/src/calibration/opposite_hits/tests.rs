use super::*;
use crate::capacity::Rig;
use crate::identify::MassLines;
use crate::layout::{CalibratedGains, SensorUncertainty};
use crate::responses::Responses;

const MASS: f64 = 2.0;
/// Channel y of the first sensor.
const FOLLOWER: usize = 2;

fn sensors<R: Real>() -> [Sensor<R>; 3] {
    [[0.0, 0.02, 0.006], [-0.0173, -0.01, 0.006], [0.0173, -0.01, 0.006]].map(|position| Sensor {
        node: 1,
        position: position.map(R::of),
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| axis.map(R::of)),
        senses_gravity: true,
        uncertainty: SensorUncertainty::default(),
        calibrated: CalibratedGains::default(),
    })
}

/// A deterministic number between −1 and 1.
fn odd(k: usize) -> f64 {
    let mixed = (k as u32 + 1).wrapping_mul(2_654_435_761);
    f64::from((mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 8) / f64::from(1 << 23) - 1.0
}

/// Hits from both sides of three axes. They miss their direction by up to 30 mrad and the centre by up to 2 mm; the
/// gains of the sensors are up to 5 % and their axes up to 10 mrad off.
fn hits<R: Real>(memory: f64, asymmetry: f64, noise: f64) -> [BlockHit<R, Rig>; 6] {
    let calibration = Calibration::default();
    let hammer = f64::from(calibration.channels[HAMMER].sensitivity);
    let sensitivity = f64::from(calibration.channels[FOLLOWER].sensitivity);
    core::array::from_fn(|h| {
        let (axis, sign) = (h / 2, if h % 2 == 0 { 1.0 } else { -1.0 });
        let along: Vector3<f64> = Vector3::ith(axis, sign);
        let missed =
            |k: usize, size: f64| Vector3::from_fn(|i, _| size * odd(100 * h + 10 * k + i));
        let force = (along + missed(1, 0.03)).normalize();
        // A plate of 160 × 160 × 10 mm.
        let inertia = Vector3::new(0.00428, 0.00428, 0.00853);
        let angular = missed(2, 0.002).cross(&force).component_div(&inertia);
        let mut accelerance = Responses::<R, Rig>::zeros(3);
        for (s, sensor) in sensors::<f64>().iter().enumerate() {
            let motion = force / MASS + angular.cross(&Vector3::from(sensor.position));
            for a in 0..3 {
                let turned = Vector3::from_fn(|i, _| 0.01 * odd(7 * s + 3 * a + i));
                let mut read =
                    (1.0 + 0.05 * odd(50 + 3 * s + a)) * (motion[a] + turned.dot(&motion));
                // Twice the share `e` is the difference between both sides.
                read += 0.5 * asymmetry * if a == axis { along[axis].abs() / MASS } else { 0.0 };
                if 1 + 3 * s + a == FOLLOWER {
                    read += memory * hammer / sensitivity;
                }
                read += noise * odd(1000 + 9 * h + 3 * s + a);
                accelerance[3 * s + a] = R::of(read);
            }
        }
        let lines = MassLines { hits: 5, ..MassLines::without_scatter(accelerance) };
        BlockHit { direction: along.map(R::of), lines }
    })
}

fn evaluate<R: Real>(
    hits: &[BlockHit<R, Rig>],
    after_hammer: Option<usize>,
) -> Option<OppositeHits<R>> {
    let sensors = sensors();
    let calibration = Calibration::default();
    let setup =
        Setup { sensors: &sensors, mass: R::of(MASS), calibration: &calibration, after_hammer };
    opposite_hits(hits, &setup)
}

fn is_found<R: Real>(tolerance: f64) {
    for memory in [0.0, 0.001, 0.01, -0.005] {
        let result = evaluate(&hits::<R>(memory, 0.006, 0.0), Some(FOLLOWER)).unwrap();
        let error = result.memory.unwrap().value.to_f64() - memory;
        assert!(error.abs() < tolerance, "{memory}: {error:e}");
        assert_eq!(result.asymmetry.len(), 3);
        for (direction, asymmetry) in &result.asymmetry {
            let error = asymmetry.value.to_f64() - 0.006;
            assert!(error.abs() < 8.0 * tolerance, "{memory} {direction}: {error:e}");
        }
    }
}

/// Gains that differ by 5 % and axes that are 10 mrad off turn the misses of the hits, of 30 mrad each and 2 mm on
/// a plate of 65 mm, into what a rigid body does not do: 0.05 · 0.03 of the motion, and κ = 1 reads eight times the
/// motion. Single precision adds 1e-6.
#[test]
fn memory_and_asymmetry_are_found_whatever_gains_axes_and_misses_are() {
    is_found::<f64>(3e-4);
    is_found::<f32>(3e-4);
}

#[test]
fn sigma_covers_the_error() {
    for noise in [0.0, 1e-3, 5e-3] {
        let result = evaluate(&hits::<f64>(0.004, 0.01, noise), Some(FOLLOWER)).unwrap();
        let memory = result.memory.unwrap();
        // Eight degrees of freedom: four standard deviations.
        assert!((memory.value - 0.004).abs() < 4.0 * memory.sigma, "{noise}: {memory:?}");
        for (_, asymmetry) in result.asymmetry {
            assert!((asymmetry.value - 0.01).abs() < 4.0 * asymmetry.sigma, "{asymmetry:?}");
        }
    }
}

#[test]
fn where_another_channel_follows_the_hammer_or_none_does_nothing_is_accused() {
    let hits = hits::<f64>(0.0, 0.0, 1e-4);
    assert_eq!(evaluate(&hits, None).unwrap().memory, None);
    let other = evaluate(&hits, Some(7)).unwrap().memory.unwrap();
    assert!(other.value.abs() < 4.0 * other.sigma, "{other:?}");
    assert_eq!(evaluate(&hits, Some(10)).unwrap().memory, None);
}

#[test]
fn hits_from_one_side_and_two_sensors_show_nothing() {
    let hits = hits::<f64>(0.01, 0.0, 0.0);
    let one_side = [hits[0].clone(), hits[2].clone(), hits[4].clone()];
    assert_eq!(evaluate(&one_side, Some(FOLLOWER)), None);
    let sensors = sensors();
    let calibration = Calibration::default();
    let setup = Setup {
        sensors: &sensors[..2],
        mass: MASS,
        calibration: &calibration,
        after_hammer: Some(FOLLOWER),
    };
    assert_eq!(opposite_hits(&hits, &setup), None);
}
