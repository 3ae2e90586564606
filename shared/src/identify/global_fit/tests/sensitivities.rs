//! Sensitivities, priors and attached bodies, against fits of changed data and layouts.

use super::wheel::*;
use super::*;
use crate::layout::{AttachedBody, Prior};

/// The answer for a layout and data, and its sensitivities.
struct Answer {
    theta: SVector<f64, 10>,
    sigma: SVector<f64, 10>,
    gain: Vec<SVector<Complex<f64>, 10>>,
    nuisances: Vec<SVector<f64, 10>>,
    pulls: Vec<f64>,
    posterior: Vec<f64>,
}

fn answer(layout: &Wheel, data: &[Complex<f64>], elastic: bool) -> Answer {
    weighted_answer(layout, data, elastic, &[])
}

/// The same with this precision of the bins.
fn weighted_answer(
    layout: &Wheel,
    data: &[Complex<f64>],
    elastic: bool,
    precision: &[f64],
) -> Answer {
    let f = bins();
    let responses = FrequencyResponses::new(&f, data, 9, 5).unwrap().weighted(precision);
    let settings = GlobalFitSettings { elastic, most_extra_terms: 1, ..Default::default() };
    let mut gain = vec![SVector::zeros(); gains(f.len(), 3, 5)];
    let mut of_nuisances = vec![SVector::zeros(); nuisances(3, 5, layout.attached.len())];
    let mut left = gain.iter().map(|_| Complex::new(0.0, 0.0)).collect::<Vec<_>>();
    let count = of_nuisances.len();
    let (mut pulls, mut posterior) = (vec![0.0; count], vec![0.0; count * count]);
    let mut to = Sensitivities {
        gain: &mut gain,
        nuisances: &mut of_nuisances,
        left: &mut left,
        pulls: &mut pulls,
        posterior: &mut posterior,
    };
    let start = RigidBody::from_theta(&SVector::from(THETA));
    let mut memory = vec![0.0; workspace(3, 5)];
    let solution =
        solve_with_sensitivities(layout, &responses, &start, &settings, &mut memory, &mut to);
    let estimate = solution.unwrap().estimate;
    let (theta, sigma) = (estimate.theta(), estimate.sigma().unwrap());
    Answer { theta, sigma, gain, nuisances: of_nuisances, pulls, posterior }
}

/// Exact apparatus and the usual noise. Second derivatives times residuals over their variance, which the
/// sensitivities leave out, are of the order of one over the noise, and below a hundredth here.
fn data(layout: &Wheel) -> Vec<Complex<f64>> {
    measure(&without_errors(layout.clone()), &Object::new(0.0), &bins(), NOISE, &mut Random(7))
}

/// Largest difference in standard deviations, relative to the largest change.
fn difference(changed: &Answer, from: &Answer, expected: &SVector<f64, 10>) -> f64 {
    let left = (changed.theta - from.theta - expected).component_div(&from.sigma);
    left.amax() / expected.component_div(&from.sigma).amax()
}

#[test]
fn the_posterior_is_that_of_the_pulls() {
    let layout = layout();
    let exact = data(&layout);
    let nominal = answer(&layout, &exact, false);
    let count = nominal.pulls.len();
    let covariance = |a: usize, b: usize| nominal.posterior[a * count + b];
    for a in 0..count {
        assert!((0.0..1.0 + 1e-6).contains(&covariance(a, a)), "{a}: {}", covariance(a, a));
        for b in 0..a {
            assert!((covariance(a, b) - covariance(b, a)).abs() < 1e-6, "{a} {b}");
        }
    }
    // A hit whose mark is moved by a standard deviation is pulled back as far as the data determine it.
    let mut moved = layout.clone();
    let hit = layout.hits[1];
    let [t, _] = crate::layout::across(&hit.direction.into());
    let (position, _) = hit.uncertainty.of_mean(u16::from(layout.test.hits_per_dof));
    moved.hits[1].position = (Vector3::from(hit.position) + t * position).into();
    let place = 45 + crate::layout::GRAVITY_QUANTITIES + crate::layout::HIT_QUANTITIES;
    let change = answer(&moved, &exact, false).pulls[place] - nominal.pulls[place];
    let determined = 1.0 - covariance(place, place);
    // Second derivatives take a few per cent of a standard deviation.
    assert!(determined > 0.3 && (change + determined).abs() < 0.1, "{change} {determined}");
}

#[test]
fn the_gain_is_the_change_of_the_answer_with_the_data() {
    let layout = layout();
    let exact = data(&layout);
    let uneven: Vec<f64> = bins().iter().map(|f| 1.0 + 0.5 * f.sin()).collect();
    for (elastic, precision) in [(false, &[][..]), (true, &[]), (false, &uneven)] {
        let answer = |data: &[_]| weighted_answer(&layout, data, elastic, precision);
        let from = answer(&exact);
        let mut random = Random(99);
        let mut changed = exact.clone();
        let mut expected = SVector::zeros();
        for (h, gain) in changed.iter_mut().zip(&from.gain) {
            let change = Complex::new(random.normal(), random.normal()) * (NOISE / 10.0);
            *h += change;
            expected += gain.map(|g| g.re * change.re + g.im * change.im);
        }
        let left = difference(&answer(&changed), &from, &expected);
        // Second derivatives, and the weight of the priors changes with the noise.
        assert!(left < 0.05, "{left}");
    }
}

#[test]
fn bins_of_little_precision_hardly_count() {
    let layout = layout();
    let exact = data(&layout);
    let f = bins();
    let bad = |bin: usize| bin.is_multiple_of(3);
    let mut random = Random(5);
    let mut spoilt = exact.clone();
    for (bin, of_bin) in spoilt.chunks_exact_mut(45).enumerate() {
        for h in of_bin.iter_mut().filter(|_| bad(bin)) {
            *h += Complex::new(random.normal(), random.normal()) * (20.0 * NOISE);
        }
    }
    let precision: Vec<f64> = (0..f.len()).map(|bin| if bad(bin) { 0.05 } else { 1.0 }).collect();
    let from = answer(&layout, &exact, false);
    let off = |changed_answer: &Answer| {
        (changed_answer.theta - from.theta).component_div(&from.sigma).amax()
    };
    let (plain, weighted) = (
        off(&answer(&layout, &spoilt, false)),
        off(&weighted_answer(&layout, &spoilt, false, &precision)),
    );
    // Two thirds of the bins say what all say within the square root of a half of their standard deviation, in three of
    // those; without weights the noise is more than ten times as large.
    assert!(weighted < 3.0 * 0.5_f64.sqrt() && plain > 2.0 * weighted, "{weighted} {plain}");
}

#[test]
fn the_answer_follows_the_nominal_layout() {
    let layout = layout();
    let exact = data(&layout);
    let from = answer(&layout, &exact, false);
    // A tenth of a standard deviation of each kind, in sensor 1, gravity, hit 2 and the hammer.
    let part = 0.1;
    let sensor = layout.sensors[1].uncertainty;
    let (hit, of_hit) = (&layout.hits[2], layout.hits[2].uncertainty.of_mean(5));
    let [first, second] = crate::layout::across(&hit.direction.into());
    let check = |place: usize, layout: &Wheel, data: &[Complex<f64>], quantity: &str| {
        let left = difference(&answer(layout, data, false), &from, &(from.nuisances[place] * part));
        // What second derivatives make of it is below a hundredth of a standard deviation for each; a mean direction
        // has most, as it is shorter than one.
        let limit = if quantity == "direction of a hit" { 0.3 } else { 0.1 };
        assert!(left < limit, "{quantity}: {left}");
    };
    // A nominal sensitivity that is larger by this makes the accelerances smaller.
    let mixed = |to: usize, from: usize, by: f64| {
        let mut data = exact.clone();
        for of_bin in data.chunks_exact_mut(45) {
            for hit in 0..5 {
                let change = of_bin[(3 + from) * 5 + hit] * by;
                of_bin[(3 + to) * 5 + hit] -= change;
            }
        }
        data
    };
    check(15 + 4, &layout, &mixed(1, 1, sensor.gain * part), "gain");
    check(15 + 5, &layout, &mixed(1, 2, sensor.cross_axis * part), "cross axis");
    let mut shifted = layout.clone();
    let turn = nalgebra::Rotation3::new(Vector3::new(0.0, 0.0, sensor.rotation * part));
    let axes = turn.matrix().transpose() * layout.sensors[1].axes_matrix();
    shifted.sensors[1].axes = core::array::from_fn(|i| axes.row(i).transpose().into());
    check(15 + 11, &shifted, &exact, "rotation");
    let mut shifted = layout.clone();
    shifted.sensors[1].position[0] += sensor.position * part;
    check(15 + 12, &shifted, &exact, "position");
    let mut shifted = layout.clone();
    let stated = Vector3::from(layout.gravity.unwrap());
    let [_, across] = crate::layout::across(&stated.normalize());
    let gravity = stated + across * (stated.norm() * layout.apparatus.gravity_direction * part);
    shifted.gravity = Some(gravity.into());
    check(45 + 1, &shifted, &exact, "direction of gravity");
    let mut shifted = layout.clone();
    let place: Vector3<f64> = Vector3::from(hit.position) + first * (of_hit.0 * part);
    shifted.hits[2].position = place.into();
    check(47 + 10, &shifted, &exact, "position of a hit");
    let mut shifted = layout.clone();
    let direction: Vector3<f64> = Vector3::from(hit.direction) + second * (of_hit.1 * part);
    shifted.hits[2].direction = direction.into();
    check(47 + 10 + 3, &shifted, &exact, "direction of a hit");
    let mut shifted = layout.clone();
    let length = layout.hits[2].uncertainty.second_order(5).0.hypot(layout.apparatus.hit_gain);
    shifted.hits[2].direction = hit.direction.map(|v| v * (1.0 + length * part));
    check(47 + 10 + 4, &shifted, &exact, "length of a hit");
    let by = 1.0 / (1.0 - layout.apparatus.hammer_gain * part);
    let louder: Vec<_> = exact.iter().map(|h| h * by).collect();
    check(47 + 25, &layout, &louder, "hammer");
}

#[test]
fn attached_bodies_are_subtracted_and_priors_hold() {
    let mut layout = layout();
    layout.attached.push(AttachedBody::point(0.5, 0.1, [0.1, 0.05, -0.02])).unwrap();
    let exact = data(&layout);
    let from = answer(&layout, &exact, false);
    let without = {
        let mut bare = layout.clone();
        bare.attached.clear();
        answer(&bare, &exact, false)
    };
    // Nothing but rounding tells an attached body from the object.
    assert!((without.theta[0] - from.theta[0] - 0.5).abs() < 1e-6 * without.theta[0]);
    let heavier = {
        let mut layout = layout.clone();
        layout.attached[0] = AttachedBody::point(0.55, 0.1, [0.1, 0.05, -0.02]);
        answer(&layout, &exact, false)
    };
    let left = difference(&heavier, &from, &from.nuisances[47 + 26]);
    // The moments are of second order in the mass.
    assert!(left < 0.05, "{left}");
    layout.priors.push(Prior { property: 0, value: 17.0, sigma: 1e-4 }).unwrap();
    let held = answer(&layout, &exact, false);
    assert!((held.theta[0] - 17.0).abs() < 1e-3 && held.sigma[0] < 1.01e-4, "{}", held.theta[0]);
}
