//! Valid and invalid bench files.

use nalgebra::Vector3;

use crate::bench::Bench;
use crate::file;

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
    // Theory, section 11: the frame's values from the same three bars, given to six decimals.
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
    // Conversion to decimal text and back is exact; only the symmetry of the composed tensor is rounded.
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
    // The tube lies along x, the block's long edge along y; both have the same centre.
    let along = tube * (0.01 + 0.0025) / 2.0 + 2.0 * (0.09 + 0.01) / 12.0;
    assert!((body.mass - tube - 2.0).abs() < 1e-12);
    assert!((body.inertia.m11 - along).abs() < 1e-12);
    assert_eq!(body.center_of_mass, Vector3::new(0.0, 0.0, 0.1));
}

#[test]
fn a_wrong_file_is_refused_with_line_and_key() {
    let cases = [
        ("x = 1", 1, "x", "there is no key"),
        ("\n[sensor]\ngain = 0.1", 3, "sensor.gain", "there is no key"),
        ("[hammer]\nrc_corner_hz = 400", 2, "hammer.rc_corner_hz", "there is no key"),
        ("[sensor]\n\nrange_g = \"a\"", 3, "sensor.range_g", "\"a\" stands where a number should"),
        ("title = \"a\"\nfaults = [\"flip:2w\"]", 2, "faults", "\"flip:2w\" is not a fault"),
        (
            "[sensor]\nrange_g = -1",
            2,
            "sensor.range_g",
            "-1.0 is out of range; give a number from 0.001 to 1000000",
        ),
        ("[adc]\nbits = 40", 2, "adc.bits", "from 8 to 16"),
        ("[adc]\nchannel_delay_s = 1e-3", 2, "adc.channel_delay_s", "next scan"),
        ("[tap]\nforce_n = [30, 20]", 2, "tap.force_n", "from <= to"),
        ("[tap]\nforce_n = [30]", 2, "tap.force_n", "1 value stands where 2 should"),
        ("[operator]\ndelay_s = nan", 2, "operator.delay_s", "finite"),
        ("[operator]\ndouble_gap_s = [0.1, inf]", 2, "operator.double_gap_s[1]", "finite"),
        (
            "[operator]\ntoo_weak_rate = 0.9\ntoo_hard_rate = 0.2",
            2,
            "operator.too_weak_rate",
            "add",
        ),
        (
            "[sensor]\ngain_sigma = 1e30",
            2,
            "sensor.gain_sigma",
            "1e30 is out of range; give a number from 0 to 1",
        ),
        ("[hammer]\nzero_v = -1e9", 2, "hammer.zero_v", "from 0 to 100"),
        ("[adc]\nrate_hz = 1e12", 2, "adc.rate_hz", "from 100 to 1000000"),
        ("[tap]\nforce_n = [1, 1e300]", 2, "tap.force_n", "<= to <= 1000000"),
        ("[sensor]\nbandwidth_hz = [1600, 1600, 0]", 2, "sensor.bandwidth_hz", "from 0.1"),
        (
            "[sensor]\nbandwidth_hz = 1600",
            2,
            "sensor.bandwidth_hz",
            "1600 stands where a list of 3 values in brackets should",
        ),
        ("[sensor]\nboard_mass_kg = -0.005", 2, "sensor.board_mass_kg", "from 0 to 1"),
        ("[sensor]\ndrift_v_per_s = 1e3", 2, "sensor.drift_v_per_s", "from -10 to 10"),
        ("[hammer]\ngain_error = -1", 2, "hammer.gain_error", "from -0.9 to 9"),
        ("[sensor]\nrc_within = 1", 2, "sensor.rc_within", "from 0 to 0.9"),
        ("[hammer]\nrc_error = -1", 2, "hammer.rc_error", "from -0.9 to 9"),
        ("[adc]\nlost_rate = 1", 2, "adc.lost_rate", "from 0 to 0.5"),
        ("[operator]\ndouble_share = [0.1, 2]", 2, "operator.double_share", "<= to <= 1"),
        ("[adc]\ninl_lsb = -1", 2, "adc.inl_lsb", "from 0 to 1000"),
        ("[adc]\nbow_lsb = 1e4", 2, "adc.bow_lsb", "from -1000 to 1000"),
        ("[adc]\nmemory = 0.9", 2, "adc.memory", "from 0 to 0.5"),
        ("[adc]\nclock_error = 1", 2, "adc.clock_error", "from -0.1 to 0.1"),
        ("[adc]\njitter_s = 1e-2", 2, "adc.jitter_s", "from 0 to 0.000025"),
        ("[adc]\njitter_s = 1e-3", 2, "adc.jitter_s", "from 0 to 0.000025"),
        ("[mains]\nfrequency_hz = 0", 2, "mains.frequency_hz", "from 1 to 1000"),
        ("[mains]\namplitude_v = -1", 2, "mains.amplitude_v", "from 0 to 100"),
        ("[mains]\nharmonics = [0.1, 2]", 2, "mains.harmonics", "2.0 is out of range"),
        ("[supply]\nvoltage_v = 0", 2, "supply.voltage_v", "from 1 to 10"),
        ("[supply]\nripple_v = -1", 2, "supply.ripple_v", "from 0 to 5"),
        ("[supply]\nripple_v = 2", 2, "supply.ripple_v", "exceed half of the supply"),
        ("[supply]\nripple_hz = 2e3", 2, "supply.ripple_hz", "from 1 to 1000"),
        ("[supply]\nripple_harmonics = [-1]", 2, "supply.ripple_harmonics", "from 0 to 1"),
        ("[supply]\nripple_v = 1\ndroop_v = 1.5", 3, "supply.droop_v", "exceed half"),
        ("[supply]\ndroop_s = 0", 2, "supply.droop_s", "from 0.000001 to 100"),
        ("[supply]\ndroop_rate_per_s = 1e3", 2, "supply.droop_rate_per_s", "from 0 to 100"),
        ("[supply]\nripple = 1", 2, "supply.ripple", "there is no key"),
        ("[sensor]\nnoise_corner_hz = -1", 2, "sensor.noise_corner_hz", "from 0 to 100"),
        ("[sensor]\nwander_v = -1", 2, "sensor.wander_v", "from 0 to 10"),
        ("[sensor]\nwander_s = 0", 2, "sensor.wander_s", "from 0.001"),
        ("[adc]\ndnl_lsb = 1.5", 2, "adc.dnl_lsb", "from 0 to 1"),
        ("[environment]\ndraught_n = -1", 2, "environment.draught_n", "from 0 to 1000"),
        ("[environment]\ndraught_s = 0", 2, "environment.draught_s", "from 0.001"),
        ("[environment]\ncreak_rate_per_s = 1e3", 2, "environment.creak_rate_per_s", "to 100"),
        ("[environment]\ncreak_n_s = nan", 2, "environment.creak_n_s", "finite"),
        ("[environment]\ncreak = 1", 2, "environment.creak", "there is no key"),
        (
            "[operator]\ntoo_weak_s = [0.1]",
            2,
            "operator.too_weak_s",
            "1 value stands where 2 should",
        ),
        ("[operator]\ntoo_hard_s = [0.2, 0.1]", 2, "operator.too_hard_s", "from <= to"),
        ("[operator]\nimpatient_rate = 2", 2, "operator.impatient_rate", "from 0 to 1"),
        ("[operator]\nimpatient_share = [0, 2]", 2, "operator.impatient_share", "<= to <= 1"),
        (
            "[sprung_part]\nshare = 1\nfrequency_hz = 50\ndamping_ratio = 0.03",
            2,
            "sprung_part.share",
            "to 0.99",
        ),
        (
            "[sprung_part]\nshare = 0.5\nfrequency_hz = 50",
            1,
            "sprung_part",
            "`damping_ratio` is missing",
        ),
        ("[tap]\noffset_m = 2", 2, "tap.offset_m", "from 0 to 1"),
        ("[tap]\nfree_moment_m = -0.1", 2, "tap.free_moment_m", "from 0 to 1"),
        ("[tap]\nlateral = 1.5", 2, "tap.lateral", "from 0 to 1"),
        ("[operator]\nflat_rate = 2", 2, "operator.flat_rate", "from 0 to 1"),
        ("[operator]\nflat_level = -1", 2, "operator.flat_level", "from 0 to 1"),
        ("gravity_m_per_s2 = [0, 0, -1e9]", 1, "gravity_m_per_s2", "from -100 to 100"),
        (
            "[hammer]\ngain_sigma 0.1",
            2,
            "",
            "gain_sigma 0.1 cannot be read: a line is `key = value`",
        ),
        ("[body]\nmass_kg = 1", 1, "body", "all three"),
        (
            "[[body.box]]\nsize_m = [1, 1, 0]\ncenter_m = [0, 0, 0]",
            2,
            "body.box[0].size_m",
            "out of range",
        ),
        ("[[body.point]]\nmass_kg = 1\nposition_m = [0, 0, 0]", 1, "body", "no object"),
        ("[[body.box]]\nsize_m = [1, 1, 1]\ncenter_m = [0, 0, 0]", 1, "body.box[0]", "density"),
        ("[[body.box]]\nsize_m = [1, 1, 1]", 1, "body.box", "the key `center_m` is missing"),
        ("[suspension]\ndamping_ratio = 0.02", 1, "suspension", "either"),
        (
            "[suspension]\nfrequencies_hz = [1, 2]",
            2,
            "suspension.frequencies_hz",
            "2 values stand where 6 should",
        ),
        (
            "[[suspension.cord]]\npoint_m = [0, 0, 0]",
            1,
            "suspension.cord[0]",
            "has no stiffness: give axial_n_per_m",
        ),
        (
            "[[suspension.cord]]\npoint_m = [0, 0, 0]\naxial_n_per_m = 0",
            3,
            "suspension.cord[0].axial_n_per_m",
            "0.0 is out of range",
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
        let colon = if key.is_empty() { "" } else { ": " };
        assert!(error.to_string().starts_with(&format!("bench.toml:{line}: {key}{colon}")));
    }
}

#[test]
fn a_value_of_a_wrong_type_is_answered_without_names_of_the_program() {
    let tables = [
        "body",
        "suspension",
        "sensor",
        "hammer",
        "adc",
        "mains",
        "supply",
        "environment",
        "tap",
        "operator",
        "sprung_part",
        "body.box",
        "node",
    ];
    let lists =
        ["elastic_mode", "suspension.cord", "faults", "node", "body.cylinder", "body.point"];
    let texts = tables.map(|key| format!("{key} = 5")).into_iter();
    for text in texts.chain(lists.map(|key| format!("{key} = [5]"))) {
        let message = file::parse(&text, "b").unwrap_err().to_string();
        for word in ["struct", "enum", "Table", "Settings", "Part"] {
            assert!(!message.contains(word), "{text}: {message}");
        }
    }
}

#[test]
fn every_bundled_bench_is_good() {
    for bundled in Bench::BUNDLED {
        assert!(!Bench::named(bundled.name).unwrap().title.is_empty(), "{}", bundled.name);
    }
}

#[test]
fn an_unknown_bench_is_refused_with_those_that_there_are() {
    let error = Bench::named("defualt").unwrap_err();
    assert!(error.to_string().contains("default, ideal"), "{error}");
}
