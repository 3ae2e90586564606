//! The JSON documents that commands print with `--json`, as types, from which their schemas are generated.
//!
//! [`report`](crate::report) fills them. A key whose value is not known is `null`; numbers are in SI units, which their
//! keys state.

mod agreement;
mod details;
mod estimate;
mod fault;
mod finding;
mod modes;
mod solution;

use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde::Serialize;

pub use agreement::{Agreement, Combined, OfMethod, Pair};
pub use details::{Details, ErrorBudget, HitDetails, Influence, SensorDetails, StatedAndLearned};
pub use estimate::{ChiSquared, Estimate, LearnedBudget, PrincipalMoments};
pub use fault::{Fault, SingleFaults, Suspect};
pub use finding::{Cause, Failure, Finding, FoundBy, Refusal, Unseen};
pub use modes::{BetterHit, Indicator, Mode, Modes, Order, Pole};
pub use solution::{GlobalFit, MassLine, Solution};

/// A number, or several, with the standard deviation; `null` where that is not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "spread_of_{T}")]
pub struct Spread<T> {
    /// The value.
    pub value: T,
    /// Its standard deviation, in the same unit.
    pub sigma: Option<T>,
}

/// The same thing for each of the ten properties. Masses are in kg, distances in m, moments and products of inertia in kg m²;
/// `Jxy` is the element of the tensor, `−∫ x y dm`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "properties_of_{T}")]
#[allow(non_snake_case)] // As they are in the documents.
pub struct Properties<T> {
    /// The mass.
    pub mass: T,
    /// Coordinate x of the centre of mass.
    pub cx: T,
    /// Coordinate y of the centre of mass.
    pub cy: T,
    /// Coordinate z of the centre of mass.
    pub cz: T,
    /// Moment of inertia about x.
    pub Jxx: T,
    /// Moment of inertia about y.
    pub Jyy: T,
    /// Moment of inertia about z.
    pub Jzz: T,
    /// Product of inertia.
    pub Jxy: T,
    /// Product of inertia.
    pub Jxz: T,
    /// Product of inertia.
    pub Jyz: T,
}

impl<T: Copy> Properties<T> {
    /// Ten things in the order of `theta`.
    pub fn of(all: [T; 10]) -> Self {
        let [mass, cx, cy, cz, xx, yy, zz, xy, xz, yz] = all;
        Self { mass, cx, cy, cz, Jxx: xx, Jyy: yy, Jzz: zz, Jxy: xy, Jxz: xz, Jyz: yz }
    }
}

/// A document with the version of its schema, as it is printed.
#[derive(Serialize, JsonSchema)]
struct Versioned<T> {
    /// It is incremented whenever a key is renamed or removed or changes its meaning, but not when a key is added.
    schema_version: u32,
    #[serde(flatten)]
    document: T,
}

/// A document that has a schema.
pub struct Described {
    /// The command that prints it.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    schema: fn(&mut SchemaGenerator) -> Schema,
}

impl Described {
    /// Every document that has a schema.
    pub const ALL: [Self; 3] = [
        Self {
            name: "solve",
            summary: "The solution of frequency responses",
            schema: of::<Solution>,
        },
        Self {
            name: "error",
            summary: "A command that has failed, whichever it is",
            schema: of::<Failure>,
        },
        Self { name: "modes", summary: "The suspension modes", schema: of::<Modes> },
    ];

    /// The schema, draft 2020-12.
    pub fn schema(&self) -> Schema {
        let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
        (self.schema)(&mut generator)
    }
}

fn of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    std::mem::take(generator).into_root_schema_for::<Versioned<T>>()
}
