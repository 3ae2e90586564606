//! The layout file as serde reads it: nothing is checked beyond types. The comments are the descriptions in
//! the JSON schema, which is generated from these types.

use massline_shared::layout::{HOST_HITS, HOST_SENSORS};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::budget::BudgetKeys;
use super::entry::{RawHit, RawSensor};
use super::keyed::KeyedTable;
use super::known::{PriorKeys, RawAttached};
use super::policy::PolicyKeys;
use super::test_settings::{TargetKeys, TestKeys};
use super::values::{NodeNumber, RawAxes};

/// Where the sensors sit and where the hammer lands. SI units; positions and directions in the body frame.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "massline layout")]
pub(super) struct RawLayout {
    /// Free text without control characters. A rig keeps 48 bytes of it: 48 letters, fewer if some are not ASCII.
    #[serde(default)]
    #[schemars(with = "String", regex(pattern = r"^[^\x00-\x1f\x7f-\x9f]*$"))]
    pub(super) title: Option<Spanned<String>>,
    /// Gravity in the body frame with the object hanging as in the test, m/s².
    #[schemars(with = "[f64; 3]")]
    #[serde(default)]
    pub(super) gravity: Option<Spanned<[f64; 3]>>,
    /// Triaxial accelerometers in the order of the rig's inputs.
    #[serde(default)]
    #[schemars(with = "Vec<RawSensor>", length(max = HOST_SENSORS))]
    pub(super) sensors: Option<Vec<Spanned<RawSensor>>>,
    /// Degrees of freedom that the hammer excites, in the order of the campaign.
    #[serde(default)]
    #[schemars(with = "Vec<RawHit>", length(max = HOST_HITS))]
    pub(super) hits: Option<Vec<Spanned<RawHit>>>,
    /// The points of the object.
    #[serde(default)]
    pub(super) node: Vec<RawNode>,
    /// Settings of the test.
    #[serde(default)]
    pub(super) test: KeyedTable<TestKeys>,
    /// How hits with a fault are treated.
    #[serde(default)]
    pub(super) policy: KeyedTable<PolicyKeys>,
    /// The error budget: one standard deviation of each error source. What is not stated is the default; `gain`,
    /// `cross_axis` and `hammer_gain` then follow the calibration, if there is one.
    #[serde(default)]
    pub(super) uncertainty: KeyedTable<BudgetKeys>,
    /// The precision that is wanted: half widths of the 95 % intervals. `massline measure` asks whether to
    /// finish as soon as all of them are reached.
    #[serde(default)]
    pub(super) target: KeyedTable<TargetKeys>,
    /// Prior knowledge about the object.
    #[serde(default)]
    pub(super) prior: KeyedTable<PriorKeys>,
    /// Bodies that hang on the object but do not belong to it; they are subtracted from the result.
    #[serde(default)]
    pub(super) attached: Vec<RawAttached>,
    /// Expected values to compare with.
    #[serde(default)]
    #[schemars(with = "RawReference")]
    pub(super) reference: Option<RawReference>,
    /// What `massline report` states about the test and no program can know.
    #[serde(default)]
    #[schemars(with = "RawStatements")]
    pub(super) report: Option<RawStatements>,
}

/// What `massline report` states about the test and no program can know: free text without control characters.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table [report]")]
#[schemars(rename = "report")]
pub(super) struct RawStatements {
    /// What was measured: description, serial number, condition.
    #[schemars(with = "String")]
    pub(super) object: Option<Spanned<String>>,
    /// How it hung or stood: cords, springs, foam.
    #[schemars(with = "String")]
    pub(super) support: Option<Spanned<String>>,
    /// The hammer: model, mass, tip.
    #[schemars(with = "String")]
    pub(super) hammer: Option<Spanned<String>>,
    /// The sensors: model, how they were mounted.
    #[schemars(with = "String")]
    pub(super) sensors: Option<Spanned<String>>,
    /// Who measured.
    #[schemars(with = "String")]
    pub(super) operator: Option<Spanned<String>>,
    /// Where it was measured: laboratory, temperature.
    #[schemars(with = "String")]
    pub(super) place: Option<Spanned<String>>,
    /// Anything else.
    #[schemars(with = "String")]
    pub(super) remarks: Option<Spanned<String>>,
}

/// A numbered point of the object.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table [[node]] such as { id = 1, position_m = [0, 0, 0] }"
)]
#[schemars(rename = "node")]
pub(super) struct RawNode {
    /// Number of the node; a UFF file uses the same number.
    #[schemars(with = "NodeNumber")]
    pub(super) id: Spanned<i64>,
    /// Position in the body frame, m.
    #[schemars(with = "[f64; 3]")]
    pub(super) position_m: Spanned<[f64; 3]>,
    /// Local x and y, unit vectors of the body frame; z = x × y. Default: the body frame.
    #[schemars(with = "RawAxes")]
    #[serde(default)]
    pub(super) axes: Option<Spanned<RawAxes>>,
    /// False where no sensor can be glued: `massline layout suggest` places none there.
    #[serde(default)]
    #[schemars(with = "bool", extend("default" = true))]
    pub(super) can_carry_sensor: Option<bool>,
    /// The directions along the local axes in which a hammer can push here: `massline layout suggest` uses no
    /// others. Default: all six.
    #[serde(default)]
    #[schemars(with = "Vec<String>", inner(regex(pattern = r"^\s*[+-][XYZxyz]\s*$")))]
    pub(super) can_hit: Option<Vec<Spanned<String>>>,
}

/// Expected values to compare with, for example from CAD.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table [reference]")]
#[schemars(rename = "reference")]
pub(super) struct RawReference {
    /// Mass, kg.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) mass_kg: Option<Spanned<f64>>,
    /// Centre of mass in the body frame, m.
    #[schemars(with = "[f64; 3]")]
    #[serde(default)]
    pub(super) center_of_mass_m: Option<Spanned<[f64; 3]>>,
    /// Inertia tensor about the centre of mass, kg m², J_xy = −∫xy dm.
    #[schemars(with = "[[f64; 3]; 3]")]
    #[serde(default)]
    pub(super) inertia_kg_m2: Option<Spanned<[[f64; 3]; 3]>>,
}
