//! The bench file: reads TOML into a checked [`Bench`].
//!
//! An empty file is the default bench. A file that describes another `[body]` starts without elastic
//! modes and on a suspension given by frequencies, because those of the default belong to the default
//! body.

use std::ops::RangeInclusive;

use serde::Deserialize;

use super::body::BodyTable;
use super::locate::{BenchFileError, LocatedText};
use super::settings::{
    AdcSettings, ElasticMode, EnvironmentSettings, ErrorsFrom, Fault, HammerSettings,
    MainsSettings, Node, OperatorSettings, SIGMA, SensorSettings, SupplySettings, TapSettings,
};
use super::sprung_part::SprungPart;
use super::suspension::{Cord, Suspension, rigid_modes};
use crate::bench::{Bench, BenchError};

/// The default bench, from which tables missing in a file are taken.
pub const DEFAULT: &str = include_str!("../benches/default.toml");

/// A bench that is built into the program.
#[derive(Clone, Copy, Debug)]
pub struct BundledBench {
    /// Its name.
    pub name: &'static str,
    /// A few words on what distinguishes it.
    pub about: &'static str,
    /// The text of its file.
    pub(super) text: &'static str,
}

/// All bundled benches.
pub(super) const BUNDLED: [BundledBench; 6] = [
    BundledBench { name: "default", about: "the three-bar frame of the paper", text: DEFAULT },
    BundledBench {
        name: "ideal",
        about: "no errors of placement, rotation, cross-axis and gain",
        text: include_str!("../benches/ideal.toml"),
    },
    BundledBench {
        name: "uncalibrated",
        about: "parts out of the box",
        text: include_str!("../benches/uncalibrated.toml"),
    },
    BundledBench {
        name: "block",
        about: "the block to calibrate them with",
        text: include_str!("../benches/block.toml"),
    },
    BundledBench {
        name: "wheel",
        about: "a wheel of 17.3 kg with modes up to 7.7 Hz",
        text: include_str!("../benches/wheel.toml"),
    },
    BundledBench {
        name: "wheel-with-tyre",
        about: "the same with 9 kg of it on springs of 50 Hz",
        text: concat!(
            include_str!("../benches/wheel.toml"),
            include_str!("../benches/wheel-with-tyre.toml")
        ),
    },
];

/// Allowed fraction of critical damping: modes have to oscillate.
const DAMPING: RangeInclusive<f64> = 0.0..=0.4;
/// Allowed stiffness of a cord, N/m.
const STIFFNESS: RangeInclusive<f64> = 1e-3..=1e9;
/// Allowed frequency of a mode, Hz.
const FREQUENCY: RangeInclusive<f64> = 1e-3..=1e5;
/// Allowed share of a part on springs of its own: the sensors sit on the rest.
const SPRUNG_SHARE: RangeInclusive<f64> = 1e-6..=0.99;
/// Largest allowed acceleration of gravity along an axis, m/s².
const MOST_GRAVITY: f64 = 100.0;

impl Bench {
    /// The bundled benches.
    pub const BUNDLED: &[BundledBench] = &BUNDLED;

    /// A bundled bench.
    ///
    /// # Errors
    /// When no bundled bench has this name.
    pub fn named(name: &str) -> Result<Self, BenchError> {
        let bundled = BUNDLED.iter().find(|bundled| bundled.name == name);
        let bundled = bundled.ok_or_else(|| BenchError::UnknownName {
            name: name.to_owned(),
            bundled: BUNDLED.map(|bundled| bundled.name).join(", "),
        })?;
        Self::parse(bundled.text, name)
    }

    /// A bench from the text of a bench file; `file` is its name in errors.
    ///
    /// # Errors
    /// Names file, line and key of the first thing that is wrong.
    pub fn parse(text: &str, file: &str) -> Result<Self, BenchError> {
        Ok(parse(text, file)?)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BenchFile {
    #[serde(default)]
    title: String,
    #[serde(default = "standard_gravity")]
    gravity_m_per_s2: [f64; 3],
    #[serde(default)]
    gravity_tilt_sigma_rad: f64,
    #[serde(default)]
    errors: ErrorsFrom,
    #[serde(default)]
    mounting: u16,
    body: Option<BodyTable>,
    suspension: Option<SuspensionTable>,
    sprung_part: Option<SprungPart>,
    node: Option<Vec<Node>>,
    elastic_mode: Option<Vec<ElasticMode>>,
    #[serde(default)]
    sensor: SensorSettings,
    #[serde(default)]
    hammer: HammerSettings,
    #[serde(default)]
    adc: AdcSettings,
    #[serde(default)]
    mains: MainsSettings,
    #[serde(default)]
    supply: SupplySettings,
    #[serde(default)]
    environment: EnvironmentSettings,
    #[serde(default)]
    tap: TapSettings,
    #[serde(default)]
    operator: OperatorSettings,
    #[serde(default)]
    faults: Vec<Fault>,
}

fn standard_gravity() -> [f64; 3] {
    [0.0, 0.0, -massline_shared::STANDARD_GRAVITY]
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [suspension]")]
struct SuspensionTable {
    #[serde(default = "one_percent")]
    damping_ratio: f64,
    frequencies_hz: Option<[f64; 6]>,
    #[serde(default)]
    cord: Vec<Cord>,
}

fn one_percent() -> f64 {
    0.01
}

/// Reads the text of a bench file; `name` is the file's name in errors.
///
/// # Errors
/// Names file, line and key of the first thing that is wrong.
pub fn parse(text: &str, name: &str) -> Result<Bench, BenchFileError> {
    let at = LocatedText::parse(text, name)?;
    let file: BenchFile = at.deserialize()?;
    for g in file.gravity_m_per_s2 {
        at.within(g, &(-MOST_GRAVITY..=MOST_GRAVITY), "gravity_m_per_s2")?;
    }
    at.within(file.gravity_tilt_sigma_rad, &SIGMA, "gravity_tilt_sigma_rad")?;
    for (section, problem) in [
        ("sensor", file.sensor.problem()),
        ("hammer", file.hammer.problem()),
        ("adc", file.adc.problem()),
        ("mains", file.mains.problem()),
        ("supply", file.supply.problem()),
        ("environment", file.environment.problem()),
        ("tap", file.tap.problem()),
        ("operator", file.operator.problem()),
    ] {
        if let Some((key, message)) = problem {
            return Err(at.error(&format!("{section}.{key}"), message));
        }
    }
    let (body, suspension, nodes, elastic) = match &file.body {
        Some(table) => (
            table.body(&at)?,
            Suspension::Frequencies { hz: [1.1, 1.3, 2.6, 1.6, 2.1, 2.9], damping_ratio: 0.01 },
            Vec::new(),
            Vec::new(),
        ),
        None if text == DEFAULT => {
            return Err(at.error("body", "the default bench needs a body"));
        }
        None => {
            let base = parse(DEFAULT, "default")?;
            (base.body, base.suspension, base.nodes, base.elastic)
        }
    };
    let bench = Bench {
        title: file.title,
        gravity: file.gravity_m_per_s2.into(),
        gravity_tilt_sigma_rad: file.gravity_tilt_sigma_rad,
        errors: file.errors,
        body,
        suspension: match file.suspension {
            Some(table) => suspension_of(table, &at)?,
            None => suspension,
        },
        sprung_part: checked_part(file.sprung_part, &at)?,
        nodes: file.node.unwrap_or(nodes),
        elastic: file.elastic_mode.unwrap_or(elastic),
        sensor: file.sensor,
        hammer: file.hammer,
        adc: file.adc,
        mains: file.mains,
        supply: file.supply,
        environment: file.environment,
        tap: file.tap,
        operator: file.operator,
        mounting: file.mounting,
        faults: file.faults,
    };
    check_elastic(&bench, &at)?;
    rigid_modes(&bench.body, &bench.suspension, &bench.gravity)
        .map_err(|e| at.error("suspension", e.to_string()))?;
    Ok(bench)
}

fn suspension_of(table: SuspensionTable, at: &LocatedText) -> Result<Suspension, BenchFileError> {
    let damping_ratio = table.damping_ratio;
    at.within(damping_ratio, &DAMPING, "suspension.damping_ratio")?;
    for (i, cord) in table.cord.iter().enumerate() {
        let key = |name| format!("suspension.cord[{i}].{name}");
        match cord.spring_n_per_m {
            Some(spring) => {
                for k in spring {
                    at.within(k, &(0.0..=*STIFFNESS.end()), &key("spring_n_per_m"))?;
                }
            }
            None => {
                let Some(axial) = cord.axial_n_per_m else {
                    let text = "has no stiffness: give axial_n_per_m (N/m along the cord) or spring_n_per_m";
                    return Err(at.error(&format!("suspension.cord[{i}]"), text));
                };
                at.within(axial, &STIFFNESS, &key("axial_n_per_m"))?;
                at.within(cord.length_m, &(1e-3..=1e3), &key("length_m"))?;
                let pointed = cord.direction.iter().any(|&d| d != 0.0);
                at.require(pointed, &key("direction"), "must not be zero")?;
            }
        }
    }
    match (table.frequencies_hz, table.cord.is_empty()) {
        (Some(hz), true) => {
            for f in hz {
                at.within(f, &FREQUENCY, "suspension.frequencies_hz")?;
            }
            Ok(Suspension::Frequencies { hz, damping_ratio })
        }
        (None, false) => Ok(Suspension::Cords { cords: table.cord, damping_ratio }),
        _ => {
            Err(at.error("suspension", "give either frequencies_hz or [[suspension.cord]] tables"))
        }
    }
}

fn checked_part(
    part: Option<SprungPart>,
    at: &LocatedText,
) -> Result<Option<SprungPart>, BenchFileError> {
    if let Some(part) = &part {
        at.within(part.share, &SPRUNG_SHARE, "sprung_part.share")?;
        at.within(part.frequency_hz, &FREQUENCY, "sprung_part.frequency_hz")?;
        at.within(part.damping_ratio, &DAMPING, "sprung_part.damping_ratio")?;
    }
    Ok(part)
}

fn check_elastic(bench: &Bench, at: &LocatedText) -> Result<(), BenchFileError> {
    for (i, node) in bench.nodes.iter().enumerate() {
        let twice = bench.nodes[..i].iter().any(|n| n.id == node.id);
        at.require(!twice, &format!("node[{i}].id"), "is there twice")?;
    }
    for (i, mode) in bench.elastic.iter().enumerate() {
        let key = |name| format!("elastic_mode[{i}].{name}");
        at.within(mode.frequency_hz, &FREQUENCY, &key("frequency_hz"))?;
        at.within(mode.damping_ratio, &DAMPING, &key("damping_ratio"))?;
        for node in &bench.nodes {
            let count = mode.shape.iter().filter(|s| s.node == node.id).count();
            let message = format!("node {} must have one shape, it has {count}", node.id);
            at.require(count == 1, &key("shape"), message)?;
        }
        if let Some(s) = mode.shape.iter().find(|s| bench.nodes.iter().all(|n| n.id != s.node)) {
            return Err(at.error(&key("shape"), format!("there is no [[node]] {}", s.node)));
        }
    }
    Ok(())
}
