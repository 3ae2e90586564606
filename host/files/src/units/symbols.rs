//! The symbols of units, their names and prefixes.

use massline_shared::STANDARD_GRAVITY;

use super::{FOOT, INCH, KILOGRAM_FORCE, POUND, POUND_FORCE, POUNDAL};

/// A unit: its size in SI, and the powers of mass, length and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub(super) size: f64,
    pub(super) dimensions: [i32; 3],
}

impl Unit {
    /// A number.
    pub(super) const ONE: Self = Self { size: 1.0, dimensions: [0; 3] };

    /// The product with a power of another unit.
    pub(super) fn times(self, other: Self, power: i32) -> Self {
        let size = match power {
            0.. => self.size * other.size.powi(power),
            // Exact for a unit whose size is a whole number.
            _ => self.size / other.size.powi(-power),
        };
        let pairs = std::iter::zip(self.dimensions, other.dimensions);
        let mut dimensions = [0; 3];
        dimensions.iter_mut().zip(pairs).for_each(|(to, (a, b))| *to = a + power * b);
        Self { size, dimensions }
    }
}

/// Prefixes: spelling, symbol, name and factor. The two letters of `da` come before `d`.
const PREFIXES: [(&str, &str, &str, f64); 11] = [
    ("G", "G", "giga", 1e9),
    ("M", "M", "mega", 1e6),
    ("k", "k", "kilo", 1e3),
    ("K", "k", "kilo", 1e3),
    ("da", "da", "deca", 1e1),
    ("d", "d", "deci", 1e-1),
    ("c", "c", "centi", 1e-2),
    ("m", "m", "milli", 1e-3),
    ("µ", "u", "micro", 1e-6),
    ("u", "u", "micro", 1e-6),
    ("n", "n", "nano", 1e-9),
];

/// A unit, all names of which mean the same. The first is its symbol.
struct Symbol {
    names: &'static [&'static str],
    /// The prefixes that it takes.
    prefixes: &'static [&'static str],
    /// Size and dimensions; `None` for the unit of an unscaled signal.
    unit: Option<Unit>,
}

const fn unit(size: f64, dimensions: [i32; 3]) -> Option<Unit> {
    Some(Unit { size, dimensions })
}

const LENGTH: [i32; 3] = [0, 1, 0];
const MASS: [i32; 3] = [1, 0, 0];
const TIME: [i32; 3] = [0, 0, 1];
const FREQUENCY: [i32; 3] = [0, 0, -1];
const VELOCITY: [i32; 3] = [0, 1, -1];
const ACCELERATION: [i32; 3] = [0, 1, -2];
const FORCE: [i32; 3] = [1, 1, -2];

const fn symbol(
    names: &'static [&'static str],
    prefixes: &'static [&'static str],
    unit: Option<Unit>,
) -> Symbol {
    Symbol { names, prefixes, unit }
}

const SYMBOLS: &[Symbol] = &[
    symbol(
        &["m", "meter", "metre", "meters", "metres"],
        &["k", "d", "c", "m", "u", "n"],
        unit(1.0, LENGTH),
    ),
    symbol(&["in", "inch", "inches"], &[], unit(INCH, LENGTH)),
    symbol(&["mil", "mils", "thou"], &[], unit(1e-3 * INCH, LENGTH)),
    symbol(&["ft", "foot", "feet"], &[], unit(FOOT, LENGTH)),
    symbol(&["micron", "microns"], &[], unit(1e-6, LENGTH)),
    symbol(
        &[
            "s", "sec", "secs", "second", "seconds", "seconde", "secondes", "sekunde", "sekunden",
            "segundo", "segundos", "secondo", "secondi",
        ],
        &["m", "u", "n"],
        unit(1.0, TIME),
    ),
    symbol(&["min", "mins", "minute", "minutes"], &[], unit(60.0, TIME)),
    symbol(&["h", "hr", "hrs", "hour", "hours"], &[], unit(3600.0, TIME)),
    symbol(&["Hz", "hertz", "cps"], &["k", "M", "m"], unit(1.0, FREQUENCY)),
    symbol(&["rpm", "cpm"], &[], unit(1.0 / 60.0, FREQUENCY)),
    symbol(&["rad", "radian", "radians"], &[], unit(1.0 / std::f64::consts::TAU, [0; 3])),
    symbol(&["cycle", "cycles"], &[], unit(1.0, [0; 3])),
    symbol(&["ips"], &[], unit(INCH, VELOCITY)),
    symbol(&["fps"], &[], unit(FOOT, VELOCITY)),
    symbol(
        &["g", "gn", "g_n", "g0", "g's", "gs", "gee", "gees"],
        &["m", "u"],
        unit(STANDARD_GRAVITY, ACCELERATION),
    ),
    symbol(&["Gal", "gals"], &["m"], unit(1e-2, ACCELERATION)),
    symbol(&["N", "newton", "newtons"], &["G", "M", "k", "da", "c", "m", "u"], unit(1.0, FORCE)),
    symbol(
        &["lbf", "lb", "lbs", "lbsf", "lb-f", "lb_f", "pound", "pounds", "pound-force"],
        &["k"],
        unit(POUND_FORCE, FORCE),
    ),
    symbol(&["kip", "kips"], &[], unit(1e3 * POUND_FORCE, FORCE)),
    symbol(&["ozf", "oz-f", "oz_f"], &[], unit(POUND_FORCE / 16.0, FORCE)),
    symbol(&["kgf", "kg-f", "kg_f", "kp"], &[], unit(KILOGRAM_FORCE, FORCE)),
    symbol(&["gf", "g-f", "g_f"], &[], unit(1e-3 * KILOGRAM_FORCE, FORCE)),
    symbol(&["tf"], &[], unit(1e3 * KILOGRAM_FORCE, FORCE)),
    symbol(&["dyn", "dyne", "dynes"], &[], unit(1e-5, FORCE)),
    symbol(&["pdl", "poundal", "poundals"], &[], unit(POUNDAL, FORCE)),
    symbol(&["kg", "kilogram", "kilograms"], &[], unit(1.0, MASS)),
    symbol(&["lbm"], &[], unit(POUND, MASS)),
    symbol(&["slug", "slugs"], &[], unit(POUND_FORCE / FOOT, MASS)),
    symbol(&["V", "volt", "volts"], &["k", "m", "u", "n"], None),
    symbol(&["mA", "µA", "uA", "nA", "pC", "nC"], &[], None),
    symbol(&["count", "counts", "cts", "ct", "lsb", "adc", "bit", "bits", "digits"], &[], None),
    symbol(&["EU", "raw", "FS", "%", "%FS", "dB"], &[], None),
];

/// What a word of a label means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    /// A unit.
    Unit(Unit),
    /// The unit of an unscaled signal.
    Unscaled,
}

impl Symbol {
    fn scaled(&self, factor: f64) -> Meaning {
        match self.unit {
            Some(unit) => Meaning::Unit(Unit { size: unit.size * factor, ..unit }),
            None => Meaning::Unscaled,
        }
    }
}

/// Whether two spellings are equal.
type Equal = fn(&str, &str) -> bool;

/// The meaning of a word: first as it is written, then in other letters. A word in capitals or in small letters whose
/// prefix may be mega or milli means nothing.
pub(super) fn meaning(word: &str) -> Option<Meaning> {
    let exactly: Equal = |a, b| a == b;
    let in_any_case: Equal = |a, b| a.eq_ignore_ascii_case(b);
    named(word, exactly)
        .map(|symbol| symbol.scaled(1.0))
        .or_else(|| prefixed(word, exactly))
        .or_else(|| named(word, in_any_case).map(|symbol| symbol.scaled(1.0)))
        .or_else(|| if is_in_one_case(word) { prefixed(word, in_any_case) } else { None })
        .or_else(|| with_name_of_prefix(word))
}

fn named(word: &str, equal: Equal) -> Option<&'static Symbol> {
    SYMBOLS.iter().find(|symbol| symbol.names.iter().any(|name| equal(name, word)))
}

/// A symbol after the symbol of a prefix, where only one prefix is possible.
fn prefixed(word: &str, equal: Equal) -> Option<Meaning> {
    let mut meanings = PREFIXES.iter().filter_map(|&(spelling, prefix, _, factor)| {
        let (front, rest) = word.split_at_checked(spelling.len())?;
        let symbol = named(rest, equal).filter(|symbol| symbol.prefixes.contains(&prefix))?;
        equal(front, spelling).then(|| symbol.scaled(factor))
    });
    let first = meanings.next()?;
    meanings.all(|other| other == first).then_some(first)
}

/// A name after the name of a prefix: millisecond.
fn with_name_of_prefix(word: &str) -> Option<Meaning> {
    let word = word.to_ascii_lowercase();
    PREFIXES.iter().find_map(|&(_, prefix, name, factor)| {
        let rest = word.strip_prefix(name).filter(|rest| rest.len() > 2)?;
        let symbol = named(rest, |a, b| a == b).filter(|symbol| symbol.prefixes.contains(&prefix));
        Some(symbol?.scaled(factor))
    })
}

fn is_in_one_case(word: &str) -> bool {
    !(word.chars().any(char::is_lowercase) && word.chars().any(char::is_uppercase))
}
