//! The layout file as serde reads it: nothing is checked beyond types. The comments are the descriptions in
//! the JSON schema, which is generated from these types.

use serde::Deserialize;
use toml::Spanned;

use super::budget::BudgetKeys;
use super::entry::{RawHit, RawSensor};
use super::keyed::KeyedTable;
use super::known::{PriorKeys, RawAttached};
use super::policy::PolicyKeys;
use super::test_settings::{TargetKeys, TestKeys};
use super::values::RawAxes;

/// Where the sensors sit and where the hammer lands. SI units; positions and directions in the body frame.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(title = "massline layout"))]
#[serde(deny_unknown_fields)]
pub(super) struct RawLayout {
    /// Free text without control characters. A rig keeps 48 bytes of it: 48 letters, fewer if some are not ASCII.
    #[serde(default)]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "String", regex(pattern = r"^[^\x00-\x1f\x7f-\x9f]*$"))
    )]
    pub(super) title: Option<Spanned<String>>,
    /// Gravity in the body frame with the object hanging as in the test, m/s².
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    #[serde(default)]
    pub(super) gravity: Option<Spanned<[f64; 3]>>,
    /// Triaxial accelerometers in the order of the rig's inputs.
    #[serde(default)]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Vec<RawSensor>", length(max = massline_shared::layout::HOST_SENSORS))
    )]
    pub(super) sensors: Option<Vec<Spanned<RawSensor>>>,
    /// Degrees of freedom that the hammer excites, in the order of the campaign.
    #[serde(default)]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Vec<RawHit>", length(max = massline_shared::layout::HOST_HITS))
    )]
    pub(super) hits: Option<Vec<Spanned<RawHit>>>,
    /// The points of the object.
    #[serde(default)]
    pub(super) node: Vec<RawNode>,
    /// Settings of the test.
    #[serde(default)]
    pub(super) test: KeyedTable<TestKeys>,
    /// How hits with a fault are treated: keep the hit, keep it with a warning, or reject it so that it must be
    /// repeated.
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
    /// Prior knowledge about the object: a value with its standard deviation.
    #[serde(default)]
    pub(super) prior: KeyedTable<PriorKeys>,
    /// Bodies that hang on the object but do not belong to it; they are subtracted from the result.
    #[serde(default)]
    pub(super) attached: Vec<RawAttached>,
    /// Expected values to compare with.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "RawReference"))]
    pub(super) reference: Option<RawReference>,
    /// What `massline report` states about the test and no program can know.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "RawStatements"))]
    pub(super) report: Option<RawStatements>,
}

/// What `massline report` states about the test and no program can know: free text without control characters.
#[derive(Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default, expecting = "a table [report]")]
pub(super) struct RawStatements {
    /// What was measured: description, serial number, condition.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) object: Option<Spanned<String>>,
    /// How it hung or stood: cords, springs, foam.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) support: Option<Spanned<String>>,
    /// The hammer: model, mass, tip.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) hammer: Option<Spanned<String>>,
    /// The sensors: model, how they were mounted.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) sensors: Option<Spanned<String>>,
    /// Who measured.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) operator: Option<Spanned<String>>,
    /// Where it was measured: laboratory, temperature.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) place: Option<Spanned<String>>,
    /// Anything else.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub(super) remarks: Option<Spanned<String>>,
}

/// A numbered point of the object.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "a table [[node]] such as { id = 1, position_m = [0, 0, 0] }"
)]
pub(super) struct RawNode {
    /// Number of the node; a UFF file uses the same number.
    #[cfg_attr(feature = "schema", schemars(with = "super::schema::NodeNumber"))]
    pub(super) id: Spanned<i64>,
    /// Position in the body frame, m.
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub(super) position_m: Spanned<[f64; 3]>,
    /// Local x and y, unit vectors of the body frame; z = x × y. Default: the body frame.
    #[cfg_attr(feature = "schema", schemars(with = "RawAxes"))]
    #[serde(default)]
    pub(super) axes: Option<Spanned<RawAxes>>,
    /// False where no sensor can be glued: `massline layout suggest` places none there.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "bool", extend("default" = true)))]
    pub(super) can_carry_sensor: Option<bool>,
    /// The directions along the local axes in which a hammer can push here: `massline layout suggest` uses no
    /// others. Default: all six.
    #[serde(default)]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Vec<String>", inner(regex(pattern = r"^\s*[+-][XYZxyz]\s*$")))
    )]
    pub(super) can_hit: Option<Vec<Spanned<String>>>,
}

/// Expected values to compare with, for example from CAD.
#[derive(Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default, expecting = "a table [reference]")]
pub(super) struct RawReference {
    /// Mass, kg.
    #[cfg_attr(feature = "schema", schemars(with = "f64", extend("exclusiveMinimum" = 0)))]
    pub(super) mass_kg: Option<Spanned<f64>>,
    /// Centre of mass in the body frame, m.
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    #[serde(default)]
    pub(super) center_of_mass_m: Option<Spanned<[f64; 3]>>,
    /// Inertia tensor about the centre of mass, kg m², J_xy = −∫xy dm.
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 3]; 3]"))]
    #[serde(default)]
    pub(super) inertia_kg_m2: Option<Spanned<[[f64; 3]; 3]>>,
}
