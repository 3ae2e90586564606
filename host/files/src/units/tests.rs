use super::*;
use Quantity::*;

const G: f64 = STANDARD_GRAVITY;
const LBF: f64 = POUND_FORCE;

/// Each label with the size of its unit, to the last digits of a product of two numbers.
fn check(measure: Measure, labels: &[(&str, f64)]) {
    for &(label, expected) in labels {
        let size = unit_size(label, measure).unwrap_or_else(|fault| panic!("{label}: {fault}"));
        assert!((size / expected - 1.0).abs() < 1e-14, "{label}: {size} for {expected}");
    }
}

#[test]
fn accelerations_are_read_as_people_write_them() {
    let meters = [
        "m/s^2",
        "(m/s²)",
        "m/sec**2",
        "m/s/s",
        "m s-2",
        "m.s^-2",
        "m·s⁻²",
        "m*s^-2",
        "ms-2",
        "ms^-2",
        "[m/s2]",
        "M/S^2",
        "m/s^{2}",
        "m s^(-2)",
        "m/s^2 rms",
        "m/s² (RMS)",
        "m/s^2 peak",
        "m/s^2 0-pk",
        "m/(s*s)",
        "m/s-s",
        "meters/second^2",
        "m per s^2",
        "m/sec/sec",
        "1 m/s^2",
        "m⋅s−2",
    ];
    check(Measure::Motion(Acceleration), &meters.map(|label| (label, 1.0)));
    let gravities =
        ["g", "G", "gn", "g_n", "g0", "g's", "G's", "gs", "g rms", "gRMS", "g pk", "g’s"];
    check(Measure::Motion(Acceleration), &gravities.map(|label| (label, G)));
    check(
        Measure::Motion(Acceleration),
        &[
            ("mg", 1e-3 * G),
            ("ug", 1e-6 * G),
            ("µg", 1e-6 * G),
            ("mm/s²", 1e-3),
            ("MM/S2", 1e-3),
            ("cm/s^2", 1e-2),
            ("Gal", 1e-2),
            ("mGal", 1e-5),
            ("in/s2", 0.0254),
            ("in/sec^2", 0.0254),
            ("ft/s^2", 0.3048),
            ("µm/s^2", 1e-6),
            ("μm/s^2", 1e-6),
            ("km/s^2", 1e3),
        ],
    );
}

#[test]
fn forces_are_read_as_people_write_them_and_case_tells_mega_from_milli() {
    check(
        Measure::Force,
        &[
            ("N", 1.0),
            ("n", 1.0),
            ("Newton", 1.0),
            ("NEWTONS", 1.0),
            ("kN", 1e3),
            ("KN", 1e3),
            ("kilonewton", 1e3),
            ("mN", 1e-3),
            ("MN", 1e6),
            ("daN", 10.0),
            ("DAN", 10.0),
            ("µN", 1e-6),
            ("N rms", 1.0),
            ("lbf", LBF),
            ("lbF", LBF),
            ("LBF", LBF),
            ("lb", LBF),
            ("lbs", LBF),
            ("lb-f", LBF),
            ("klbf", 1e3 * LBF),
            ("kip", 1e3 * LBF),
            ("ozf", LBF / 16.0),
            ("kgf", G),
            ("Kgf", G),
            ("kp", G),
            ("gf", 1e-3 * G),
            ("dyn", 1e-5),
            ("pdl", POUNDAL),
            ("kg*m/s^2", 1.0),
        ],
    );
    for label in ["mn", "Mn", "g", "kg", "m/s^2", "N/m", "n N", "N 2", "1000 N"] {
        assert_eq!(
            unit_size(label, Measure::Force),
            Err(UnitFault::Unknown(Measure::Force)),
            "{label}"
        );
    }
}

#[test]
fn ratios_are_read_as_people_write_them() {
    let units = [
        ("m/s^2/N", 1.0),
        ("(m/s²)/N", 1.0),
        ("m/(N s^2)", 1.0),
        ("m/N s^2", 1.0),
        ("m/(N*s²)", 1.0),
        ("m/Ns^2", 1.0),
        ("m s-2 N-1", 1.0),
        ("1/kg", 1.0),
        ("kg^-1", 1.0),
        ("kg-1", 1.0),
        ("(m/s^2)/(N)", 1.0),
        ("m/s^2/N rms", 1.0),
        ("mm/s²/N", 1e-3),
        ("m/s²/kN", 1e-3),
        ("g/N", G),
        ("g/lbf", 1.0 / POUND),
        ("G/LBF", 1.0 / POUND),
        ("in/s^2/lbf", 0.0254 / LBF),
        ("1/lbm", 1.0 / POUND),
    ];
    check(Measure::MotionOverForce(Acceleration), &units);
    let units = [
        ("m/N", 1.0),
        ("µm/N", 1e-6),
        ("in/lbf", 0.0254 / LBF),
        ("mm/kN", 1e-6),
        ("(N/m)^-1", 1.0),
    ];
    check(Measure::MotionOverForce(Displacement), &units);
    let units =
        [("m/s/N", 1.0), ("m/(N s)", 1.0), ("mm/s/N", 1e-3), ("(m/s)/N", 1.0), ("s/kg", 1.0)];
    check(Measure::MotionOverForce(Velocity), &units);
    for label in ["m/s^2", "N/m", "1/g", "1/lb", "m/N"] {
        let measure = Measure::MotionOverForce(Acceleration);
        assert_eq!(unit_size(label, measure), Err(UnitFault::Unknown(measure)), "{label}");
    }
}

#[test]
fn other_motions_times_and_frequencies_are_read() {
    check(
        Measure::Motion(Velocity),
        &[("in/s", 0.0254), ("ips", 0.0254), ("mm/sec", 1e-3), ("ms-1", 1.0)],
    );
    check(
        Measure::Motion(Displacement),
        &[("ft", 0.3048), ("mil", 2.54e-5), ("micron", 1e-6), ("nm", 1e-9)],
    );
    check(
        Measure::Time,
        &[
            ("s", 1.0),
            ("sec", 1.0),
            ("Seconds", 1.0),
            ("ms", 1e-3),
            ("msec", 1e-3),
            ("MSEC", 1e-3),
            ("milliseconds", 1e-3),
            ("us", 1e-6),
            ("µs", 1e-6),
            ("μs", 1e-6),
            ("usec", 1e-6),
            ("ns", 1e-9),
            ("[ns]", 1e-9),
            ("min", 60.0),
            ("h", 3600.0),
        ],
    );
    let turn = std::f64::consts::TAU;
    check(
        Measure::Frequency,
        &[
            ("Hz", 1.0),
            ("HZ", 1.0),
            ("Hertz", 1.0),
            ("kHz", 1e3),
            ("KHz", 1e3),
            ("1/s", 1.0),
            ("s^-1", 1.0),
            ("s-1", 1.0),
            ("1/sec", 1.0),
            ("cycles/s", 1.0),
            ("rad/s", 1.0 / turn),
            ("rad/sec", 1.0 / turn),
            ("rpm", 1.0 / 60.0),
        ],
    );
    for label in ["Ms", "epoch", "samples", "m", "°C", "", "1"] {
        assert_eq!(time_unit(label), None, "{label}");
    }
}

#[test]
fn what_is_no_unit_of_the_quantity_is_refused() {
    for (label, quantity) in [
        ("m/s", Acceleration),
        ("g", Velocity),
        ("furlong/s^2", Acceleration),
        ("gf", Acceleration),
    ] {
        let measure = Measure::Motion(quantity);
        assert_eq!(unit_size(label, measure), Err(UnitFault::Unknown(measure)), "{label}");
    }
    for label in [
        "m/s^2 foo",
        "m/",
        "/s^2",
        "(m/s^2",
        "m/s^2)",
        "m/s^99",
        "m^/s",
        "",
        "  ",
        "m//s^2",
        "m/s^2 x",
        "m/s\u{fffd}",
    ] {
        assert_eq!(motion_unit(label, Acceleration), None, "{label}");
    }
    let nested = format!("{}m/s^2{}", "(".repeat(1 << 20), ")".repeat(1 << 20));
    assert_eq!(motion_unit(&nested, Acceleration), None);
    for label in ["g pk-pk", "m/s^2 p-p", "g peak-to-peak", "mm/s² (pkpk)", "gpp"] {
        assert_eq!(
            unit_size(label, Measure::Motion(Acceleration)),
            Err(UnitFault::PeakToPeak),
            "{label}"
        );
    }
}

#[test]
fn the_units_of_unscaled_signals_are_recognized() {
    for label in [
        "V", "mV", "MV", "volts", "µV", "pC", "counts", "LSB", "EU", "%FS", "% FS", "mV/N",
        "V rms", "adc", "mA",
    ] {
        assert!(is_unscaled(label), "{label}");
    }
    for label in ["N", "g", "mg", "furlong", "", "C", "m/s^2", "vm"] {
        assert!(!is_unscaled(label), "{label}");
    }
    for label in ["", " ", "NONE", "none", "[-]", "()", "n/a"] {
        assert!(is_unstated(label), "{label}");
    }
}

#[test]
fn a_newton_is_the_same_force_in_every_system() {
    // 1 lbf = 4.448 222 N, 1 poundal = 0.138 255 N: the usual six digits.
    assert!((POUND_FORCE - 4.448_222).abs() < 1e-6);
    assert!((POUNDAL - 0.138_255).abs() < 1e-6);
}
