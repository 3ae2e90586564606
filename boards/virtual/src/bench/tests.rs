//! The bench as a whole: what its scans say of the object.

use massline_shared::layout::{Dof, Hit, HostLayout, Sensor, TestSettings};
use massline_shared::signal::{CHANNELS, Scan};
use nalgebra::{Complex, DMatrix, DVector, Matrix3, Matrix3x6, Vector3, Vector6};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::chain::Channels;
use super::errors::TestErrors;
use super::simulation::Simulation;
use super::taps::{Contact, Tap, TapKind};
use super::{Bench, BenchError, BenchSource, file};
use crate::source::ScanSource;

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn sensor(node: u16, position: [f64; 3]) -> Sensor<f64> {
    Sensor { node, position, axes: IDENTITY, senses_gravity: true }
}

/// One of the paper's tests on the nodes of the default bench.
fn layout(sensors: [u16; 3], hits: [&str; 3]) -> HostLayout {
    let bench = Bench::named("default").unwrap();
    let position = |id: u16| bench.nodes.iter().find(|n| n.id == id).unwrap().position_m;
    let hit = |name: &str| {
        let dof: Dof = name.parse().unwrap();
        let direction = IDENTITY[dof.axis.index()].map(|v| v * dof.sign.factor());
        Hit { dof, position: position(dof.node), direction }
    };
    HostLayout {
        title: "three-bar".try_into().unwrap(),
        gravity: Some(bench.gravity.into()),
        sensors: sensors.iter().map(|&n| sensor(n, position(n))).collect(),
        hits: hits.into_iter().map(hit).collect(),
        test: TestSettings::default(),
    }
}

fn test_one() -> HostLayout {
    layout([1, 2, 3], ["1:+Y", "2:+Z", "4:+X"])
}

fn no_errors(bench: &Bench) -> TestErrors {
    let mut ideal = bench.clone();
    ideal.sensor.rc_tolerance = 0.0;
    ideal.hammer.rc_tolerance = 0.0;
    ideal.sensor.zero_sigma_v = 0.0;
    ideal.hammer.zero_sigma_v = 0.0;
    TestErrors::draw(&ideal, 3, &mut ChaCha8Rng::seed_from_u64(1))
}

/// The analogue outputs, free of noise, after a tap of 20 N at a hit of the layout, less what the
/// sensors show at rest.
fn tapped(bench: &Bench, layout: &HostLayout, dof: usize, scans: usize) -> Vec<Channels> {
    let mut simulation = Simulation::new(bench, layout, &no_errors(bench)).unwrap();
    simulation.reset(&mut ChaCha8Rng::seed_from_u64(2));
    let hit = &layout.hits[dof];
    let tap = Tap {
        dof,
        kind: TapKind::Good,
        point: hit.position.into(),
        direction: hit.direction.into(),
        contacts: vec![Contact { start: 0.01013, duration: 0.0047, peak: 20.0 }],
    };
    let drives = [simulation.drive(bench, hit.dof.node, tap).unwrap()];
    let rest = simulation.scan_inputs(&drives);
    (0..scans)
        .map(|_| {
            let mut values = simulation.scan_inputs(&drives);
            values.iter_mut().zip(&rest).for_each(|(v, r)| *v -= r);
            values
        })
        .collect()
}

/// Laplace transform of one channel of the sampled record.
fn laplace(record: &[Channels], channel: usize, s: Complex<f64>, rate: f64) -> Complex<f64> {
    let mut sum = Complex::new(0.0, 0.0);
    for (n, values) in record.iter().enumerate() {
        sum += (s * -(n as f64 / rate)).exp() * values[channel];
    }
    sum / rate
}

fn lines() -> impl Iterator<Item = Complex<f64>> {
    (5..=60).map(|k| Complex::new(10.0, std::f64::consts::TAU * 2.0 * f64::from(k)))
}

/// The accelerance from the spectra, the channels' delay taken off, with the force's spectrum.
fn accelerance(
    bench: &Bench,
    record: &[Channels],
    channel: usize,
    s: Complex<f64>,
) -> (Complex<f64>, f64) {
    let (rate, delay) = (bench.adc.rate_hz, bench.adc.channel_delay_s);
    let force = laplace(record, 0, s, rate);
    let response = laplace(record, channel, s, rate) * (s * -(channel as f64 * delay)).exp();
    (response / force, force.norm())
}

/// Constant term of a sum of these powers of `s` fitted to the accelerance, weighted by the force.
fn mass_line(bench: &Bench, record: &[Channels], channel: usize, powers: &[i32]) -> f64 {
    let mut rows = Vec::new();
    let mut right = Vec::new();
    for s in lines() {
        let (h, weight) = accelerance(bench, record, channel, s);
        let basis: Vec<_> = powers.iter().map(|&p| (s / 200.0).powi(p)).collect();
        rows.extend(basis.iter().map(|b| b.re * weight));
        rows.extend(basis.iter().map(|b| b.im * weight));
        right.extend([h.re * weight, h.im * weight]);
    }
    let a = DMatrix::from_row_slice(right.len(), powers.len(), &rows);
    a.svd(true, true).solve(&DVector::from_vec(right), 1e-13).unwrap()[0]
}

/// Largest error of the mass lines over the paper's tests, relative to the largest accelerance.
fn worst_mass_line(bench: &Bench, powers: &[i32]) -> f64 {
    let tests = [
        test_one(),
        layout([1, 2, 4], ["1:+Y", "2:+Z", "4:+X"]),
        layout([1, 2, 3], ["1:+X", "2:+Z", "2:+Y"]),
    ];
    let mut worst = 0.0_f64;
    for layout in &tests {
        for dof in 0..3 {
            let record = tapped(bench, layout, dof, 6000);
            let truth = rigid_accelerance(bench, layout, dof);
            let largest = truth.iter().fold(0.0_f64, |m, h| m.max(h.abs()));
            for (i, h) in truth.iter().enumerate() {
                let a = mass_line(bench, &record, i + 1, powers);
                worst = worst.max((a - h).abs() / largest);
            }
        }
    }
    worst
}

/// Constant accelerances of the rigid body (theory, section 2): `G M⁻¹ F`.
fn rigid_accelerance(bench: &Bench, layout: &HostLayout, dof: usize) -> Vec<f64> {
    let hit = &layout.hits[dof];
    let (q, d) = (Vector3::from(hit.position), Vector3::from(hit.direction));
    let torque = q.cross(&d);
    let force = Vector6::from_iterator(d.iter().chain(&torque).copied());
    let x0 = bench.body.mass_matrix().try_inverse().unwrap() * force;
    let readings = layout.sensors.iter().flat_map(|s| {
        let mut g = Matrix3x6::zeros();
        g.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        g.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Vector3::from(s.position).cross_matrix());
        let a = g * x0;
        [a.x, a.y, a.z]
    });
    readings.collect()
}

#[test]
fn an_empty_file_is_the_default_bench() {
    let mut empty = Bench::parse("", "empty").unwrap();
    let default = Bench::named("default").unwrap();
    empty.title.clone_from(&default.title);
    assert_eq!(empty, default);
}

#[test]
fn the_default_object_is_the_frame_of_the_paper() {
    let body = Bench::named("default").unwrap().truth();
    let theta = body.theta();
    // Theory, section 11: the frame's values from the same three bars, printed to six digits after
    // the point.
    let expected =
        [1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706];
    for (value, expected) in theta.iter().zip(expected) {
        assert!((value - expected).abs() < 6e-7, "{value} {expected}");
    }
}

#[test]
fn ten_numbers_describe_the_same_body_as_its_parts() {
    let body = Bench::named("default").unwrap().body;
    let (c, j) = (body.center_of_mass, body.inertia);
    let text = format!(
        "[body]\nmass_kg = {}\ncenter_of_mass_m = [{}, {}, {}]\ninertia_kg_m2 = [{}, {}, {}, {}, {}, {}]",
        body.mass, c.x, c.y, c.z, j.m11, j.m22, j.m33, j.m12, j.m13, j.m23
    );
    let direct = Bench::parse(&text, "ten numbers").unwrap();
    assert_eq!(direct.body.mass, body.mass);
    assert_eq!(direct.body.center_of_mass, c);
    // Decimal text and back is exact; only the symmetry of the composed tensor is rounded.
    assert!((direct.body.inertia - j).norm() < 1e-17);
    assert!(direct.elastic.is_empty());
}

#[test]
fn a_cylinder_and_a_turned_box_are_composed() {
    let text = "[[body.cylinder]]\nradius_m = 0.1\ninner_radius_m = 0.05\nlength_m = 0.2\n\
                center_m = [0, 0, 0.1]\ndensity_kg_m3 = 1000\naxes = [[0, 1, 0], [0, 0, 1]]\n\
                [[body.box]]\nsize_m = [0.3, 0.2, 0.1]\ncenter_m = [0, 0, 0.1]\nmass_kg = 2.0\n\
                axes = [[0, 1, 0], [-1, 0, 0]]";
    let body = Bench::parse(text, "text").unwrap().body;
    let tube = std::f64::consts::PI * (0.01 - 0.0025) * 0.2 * 1000.0;
    // The tube lies along x, the block's long edge along y; both about the same centre.
    let along = tube * (0.01 + 0.0025) / 2.0 + 2.0 * (0.09 + 0.01) / 12.0;
    assert!((body.mass - tube - 2.0).abs() < 1e-12);
    assert!((body.inertia.m11 - along).abs() < 1e-12);
    assert_eq!(body.center_of_mass, Vector3::new(0.0, 0.0, 0.1));
}

#[test]
fn mass_lines_of_the_simulated_chain_are_those_of_the_rigid_body() {
    let bench = Bench::named("ideal").unwrap();
    // Suspension and elastic modes as series in 1/s and s²: what the series leave out is
    // (2.5 Hz/10 Hz)⁶ of the one and (120 Hz/314 Hz)⁶ of the other.
    let worst = worst_mass_line(&bench, &[0, -1, -2, -3, -4, 1, 2, 4]);
    assert!(worst < 5e-4, "{worst}");
}

#[test]
fn the_rigs_own_fit_finds_the_mass_lines_of_the_bench() {
    let bench = Bench::named("ideal").unwrap();
    // A + B/s² + C s² (theory, section 5) leaves out the damping of the cords and the fourth power of
    // 120 Hz/314 Hz, which is 2 % at the upper end of the band.
    let worst = worst_mass_line(&bench, &[0, -2, 2]);
    assert!(worst < 4e-3, "{worst}");
}

#[test]
fn without_elastic_modes_the_mass_lines_are_exact() {
    let mut bench = Bench::named("ideal").unwrap();
    bench.elastic.clear();
    let worst = worst_mass_line(&bench, &[0, -1, -2, -3, -4]);
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn a_sensor_in_gravity_seems_to_sit_elsewhere() {
    // Theory, section 2: it appears at p + g/s², which is p − g/ω² on the axis of frequencies.
    let mut bench = Bench::named("ideal").unwrap();
    bench.adc.channel_delay_s = 0.0;
    bench.elastic.clear();
    let p = Vector3::new(0.1, -0.05, 0.03);
    let blind =
        |position: Vector3<f64>| Sensor { senses_gravity: false, ..sensor(9, position.into()) };
    let mut layout = test_one();
    layout.sensors =
        [sensor(9, p.into()), blind(p), blind(p + bench.gravity * 0.01)].into_iter().collect();
    let record = tapped(&bench, &layout, 2, 6000);
    for s in lines().step_by(7) {
        for axis in 0..3 {
            let [felt, here, there] =
                [1, 4, 7].map(|k| laplace(&record, k + axis, s, bench.adc.rate_hz));
            let expected = here + (there - here) * 100.0 / (s * s);
            // What the samples alias: the pulse's spectrum above 3.9 kHz, about 1e-5 of its mean.
            let scale = laplace(&record, 0, s, bench.adc.rate_hz).norm();
            assert!((felt - expected).norm() < 1e-5 * scale, "{s} {axis}: {felt} {expected}");
        }
    }
}

#[test]
fn a_later_channel_reads_what_comes_later() {
    let mut bench = Bench::named("ideal").unwrap();
    let layout = test_one();
    let delayed = tapped(&bench, &layout, 0, 4000);
    let delay = std::mem::take(&mut bench.adc.channel_delay_s);
    let together = tapped(&bench, &layout, 0, 4000);
    for s in lines().step_by(11) {
        for k in [1, 4, 9] {
            let a = laplace(&delayed, k, s, bench.adc.rate_hz);
            let b = laplace(&together, k, s, bench.adc.rate_hz);
            let lead = (s * (k as f64 * delay)).exp();
            let scale = laplace(&together, 2, s, bench.adc.rate_hz).norm();
            // Aliased parts of the elastic modes move with another phase.
            assert!((a - b * lead).norm() < 1e-4 * scale, "{k} {s}");
        }
    }
}

#[test]
fn a_finer_grid_changes_nothing() {
    let mut bench = Bench::named("ideal").unwrap();
    let coarse = tapped(&bench, &test_one(), 2, 600);
    bench.adc.oversampling = 128;
    let fine = tapped(&bench, &test_one(), 2, 600);
    for (a, b) in coarse.iter().zip(&fine) {
        for (a, b) in a.iter().zip(b) {
            // 1e-4 of up to 100 m/s²: the curvature within 1/64 ms, most of it of the third elastic mode.
            assert!((a - b).abs() < 1e-2, "{a} {b}");
        }
    }
}

fn scans(source: &mut BenchSource, count: usize) -> Vec<Scan> {
    (0..count).map(|_| source.next_scan().unwrap()).collect()
}

#[test]
fn taps_come_after_the_delay_and_do_not_clip() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_weak_rate = 0.0;
    bench.operator.too_hard_rate = 0.0;
    for (sensors, hits) in [
        ([1, 2, 3], ["1:+Y", "2:+Z", "4:+X"]),
        ([1, 2, 4], ["1:+Y", "2:+Z", "4:+X"]),
        ([1, 2, 3], ["1:+X", "2:+Z", "2:+Y"]),
        ([1, 2, 4], ["1:+X", "2:+Z", "2:+Y"]),
    ] {
        let layout = layout(sensors, hits);
        let mut source = BenchSource::new(&bench, &layout, 5).unwrap();
        for arming in 0..30 {
            source.armed(arming, arming as usize % 3);
            let record = scans(&mut source, 1500);
            let touched = record.iter().position(|s| s[0] > 137 + 60).unwrap();
            assert!((1200..1215).contains(&touched), "{touched}");
            for (k, zero) in source.errors().zero_v.iter().enumerate().skip(1) {
                for scan in &record {
                    let g = (f64::from(scan[k]) * 3.0 / 4096.0 - 1.5 - zero) / 0.057;
                    assert!(g.abs() < 15.0, "channel {k} reads {g} g");
                }
            }
        }
    }
}

#[test]
fn a_tap_that_is_too_hard_drives_channels_to_their_ends() {
    let mut bench = Bench::named("default").unwrap();
    bench.operator.too_hard_rate = 1.0;
    bench.operator.too_weak_rate = 0.0;
    let mut source = BenchSource::new(&bench, &test_one(), 5).unwrap();
    source.armed(1, 0);
    let record = scans(&mut source, 1500);
    let largest = |k: usize| record.iter().map(|s| s[k]).max().unwrap();
    assert_eq!(largest(0), 4095);
    // Sensor 1 along the hit: 3.06 (m/s²)/N times 150 N is far beyond 16 g.
    let g = (f64::from(largest(2)) * 3.0 / 4096.0 - 1.5 - source.errors().zero_v[2]) / 0.057;
    assert!((15.8..16.1).contains(&g), "{g}");
}

#[test]
fn scans_depend_on_seed_arming_and_dof_alone() {
    let bench = Bench::named("default").unwrap();
    let layout = test_one();
    let run = |seed, earlier: &[(u32, usize)], arming, dof| {
        let mut source = BenchSource::new(&bench, &layout, seed).unwrap();
        for &(arming, dof) in earlier {
            source.armed(arming, dof);
            scans(&mut source, 1300);
        }
        source.armed(arming, dof);
        scans(&mut source, 1400)
    };
    let first = run(3, &[], 4, 1);
    assert_eq!(first, run(3, &[(1, 0), (2, 2)], 4, 1));
    assert_ne!(first, run(4, &[], 4, 1));
    assert_ne!(first, run(3, &[], 5, 1));
    assert_ne!(first, run(3, &[], 4, 2));
}

#[test]
fn ideal_is_the_default_without_placement_and_gain_errors() {
    let default = Bench::named("default").unwrap();
    let ideal = Bench::named("ideal").unwrap();
    assert_eq!(default.body, ideal.body);
    assert_eq!(default.elastic, ideal.elastic);
    let source = BenchSource::new(&ideal, &test_one(), 8).unwrap();
    let other = BenchSource::new(&default, &test_one(), 8).unwrap();
    assert_eq!(source.errors().zero_v, other.errors().zero_v);
    assert_eq!(source.errors().rc, other.errors().rc);
    assert_eq!(source.errors().hammer_gain, 0.0);
    for sensor in &source.errors().sensors {
        assert_eq!(sensor.position, Vector3::zeros());
        assert_eq!(sensor.rotation, Vector3::zeros());
        assert_eq!(sensor.sensitivity, Matrix3::identity());
    }
    assert!(other.errors().sensors.iter().all(|s| s.position.norm() > 0.0));
}

#[test]
fn a_manual_operator_taps_when_told_to() {
    let bench = Bench::named("default").unwrap();
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    let handle = source.manual();
    handle.tap();
    source.armed(1, 0);
    let touched = |record: &[Scan]| record.iter().any(|s| s[0] > 137 + 60);
    assert!(!touched(&scans(&mut source, 4000)), "a key pressed before the arming is forgotten");
    let other = handle.clone();
    std::thread::spawn(move || other.tap()).join().unwrap();
    assert!(touched(&scans(&mut source, 400)));
    assert!(!touched(&scans(&mut source, 400)));
    handle.tap();
    assert!(touched(&scans(&mut source, 400)));
}

#[test]
fn an_arming_for_a_dof_that_is_not_there_is_quiet() {
    let bench = Bench::named("default").unwrap();
    let mut source = BenchSource::new(&bench, &test_one(), 8).unwrap();
    source.armed(1, 77);
    assert!(scans(&mut source, 2000).iter().all(|s| s[0] < 160));
    assert!(source.last_tap().is_none());
}

#[test]
fn a_node_without_elastic_shape_is_refused_by_number() {
    let bench = Bench::named("default").unwrap();
    let mut layout = test_one();
    layout.sensors[1].node = 7;
    let error = BenchSource::new(&bench, &layout, 1).unwrap_err();
    assert!(matches!(error, BenchError::NodeWithoutShape(7)), "{error}");
    layout.sensors[1] = sensor(2, [0.0, 0.3, 0.0]);
    let error = BenchSource::new(&bench, &layout, 1).unwrap_err();
    assert!(matches!(error, BenchError::NodeElsewhere { node: 2, .. }), "{error}");
}

#[test]
fn a_fourth_sensor_is_refused() {
    let bench = Bench::named("default").unwrap();
    let mut layout = test_one();
    layout.sensors.push(sensor(4, [0.0; 3])).unwrap();
    let error = BenchSource::new(&bench, &layout, 1).unwrap_err();
    assert!(matches!(error, BenchError::TooManySensors(4)), "{error}");
}

#[test]
fn channels_of_missing_sensors_are_not_announced() {
    let bench = Bench::named("default").unwrap();
    let mut layout = test_one();
    layout.sensors.pop();
    let source = BenchSource::new(&bench, &layout, 1).unwrap();
    assert_eq!(source.adc().channels, 7);
    assert_eq!(CHANNELS, 10);
}

#[test]
fn a_wrong_file_is_refused_with_line_and_key() {
    let cases = [
        ("x = 1", 1, "x", "unknown field"),
        ("\n[sensor]\ngain = 0.1", 3, "sensor.gain", "unknown field"),
        ("[sensor]\n\nrange_g = \"a\"", 3, "sensor.range_g", "invalid type"),
        ("[sensor]\nrange_g = -1", 2, "sensor.range_g", "must be positive"),
        ("[adc]\nbits = 40", 2, "adc.bits", "between 8 and 16"),
        ("[adc]\nchannel_delay_s = 1e-3", 2, "adc.channel_delay_s", "next scan"),
        ("[tap]\nforce_n = [30, 20]", 2, "tap.force_n", "from <= to"),
        ("[tap]\nforce_n = [30]", 2, "tap.force_n", "invalid length"),
        ("[operator]\ndelay_s = nan", 2, "operator.delay_s", "finite"),
        ("[operator]\ndouble_gap_s = [0.1, inf]", 2, "operator.double_gap_s[1]", "finite"),
        (
            "[operator]\ntoo_weak_rate = 0.9\ntoo_hard_rate = 0.2",
            2,
            "operator.too_weak_rate",
            "add",
        ),
        ("[hammer]\ngain_sigma 0.1", 2, "gain_sigma 0.1", "="),
        ("[body]\nmass_kg = 1", 1, "body", "all three"),
        (
            "[[body.box]]\nsize_m = [1, 1, 0]\ncenter_m = [0, 0, 0]",
            2,
            "body.box[0].size_m",
            "positive",
        ),
        ("[[body.point]]\nmass_kg = 1\nposition_m = [0, 0, 0]", 1, "body", "no object"),
        ("[[body.box]]\nsize_m = [1, 1, 1]\ncenter_m = [0, 0, 0]", 1, "body.box[0]", "density"),
        ("[[body.box]]\nsize_m = [1, 1, 1]", 1, "body.box[0]", "missing field `center_m`"),
        ("[suspension]\ndamping_ratio = 0.02", 1, "suspension", "either"),
        ("[suspension]\nfrequencies_hz = [1, 2]", 2, "suspension.frequencies_hz", "length"),
        (
            "[[suspension.cord]]\npoint_m = [0, 0, 0]",
            1,
            "suspension.cord[0].axial_n_per_m",
            "positive",
        ),
        (
            "[[suspension.cord]]\npoint_m = [0, 0, 0]\naxial_n_per_m = 100",
            1,
            "suspension",
            "cannot hold",
        ),
        ("[[node]]\nid = 1\nposition_m = [0, 0, 0]", 1, "elastic_mode[0].shape", "no [[node]]"),
        (
            "[[node]]\nid = 1\nposition_m = [0, 0, 0]\n[[node]]\nid = 1\nposition_m = [0, 0, 0]",
            5,
            "node[1].id",
            "twice",
        ),
    ];
    for (text, line, key, message) in cases {
        let error = file::parse(text, "bench.toml").unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (line, key), "{text}\n{error}");
        assert!(error.message.contains(message), "{text}\n{error}");
        assert!(error.to_string().starts_with(&format!("bench.toml:{line}: {key}: ")));
    }
}

#[test]
fn a_bench_that_is_neither_bundled_nor_a_file_is_named() {
    let error = Bench::open("defualt").unwrap_err();
    assert!(error.to_string().contains("default, ideal"), "{error}");
    let error = Bench::open("missing.toml").unwrap_err();
    assert!(error.to_string().starts_with("missing.toml: "), "{error}");
}
