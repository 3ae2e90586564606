//! The layout file as serde reads it: nothing is checked beyond types. The comments are the descriptions in
//! the JSON schema, which is generated from these types.

use massline_shared::layout::{
    FrfEstimator, HOST_HITS, HOST_SENSORS, MAX_HITS_PER_DOF, TestProfile,
};
use massline_shared::mass_line::Terms;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::entry::{RawHit, RawSensor};
use super::keyed::{BudgetKeys, KeyedTable, PolicyKeys};
use super::values::{NodeNumber, RawAxes, RawBand, RawKnown};

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
    #[schemars(with = "RawTest")]
    pub(super) test: Option<RawTest>,
    /// How hits with a fault are treated.
    #[serde(default)]
    pub(super) policy: KeyedTable<PolicyKeys>,
    /// The error budget: one standard deviation of each error source. What is not stated is the default; `gain`,
    /// `cross_axis` and `hammer_gain` then follow the calibration, if there is one.
    #[serde(default)]
    #[schemars(with = "KeyedTable<BudgetKeys>")]
    pub(super) uncertainty: Option<KeyedTable<BudgetKeys>>,
    /// The precision that is wanted: half widths of the 95 % intervals. `massline measure` asks whether to
    /// finish as soon as all of them are reached.
    #[serde(default)]
    #[schemars(with = "RawTarget")]
    pub(super) target: Option<RawTarget>,
    /// Prior knowledge about the object.
    #[serde(default)]
    #[schemars(with = "RawPrior")]
    pub(super) prior: Option<RawPrior>,
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

/// Settings of the test.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table [test]")]
#[schemars(rename = "test")]
pub(super) struct RawTest {
    /// What is measured: mass lines above the suspension modes, or these modes. The defaults of the other settings depend
    /// on it.
    #[schemars(with = "String", extend("enum" = ["mass-line", "suspension"]))]
    pub(super) profile: Option<TestProfile>,
    /// Accepted hits required at each DOF.
    #[schemars(with = "u8", range(min = 1, max = MAX_HITS_PER_DOF))]
    pub(super) hits_per_dof: Option<Spanned<i64>>,
    /// Band of the mass line fit, or of the suspension modes.
    #[schemars(with = "RawBand")]
    pub(super) band_hz: Option<Spanned<RawBand>>,
    /// Decay rate of the exponential window, 1/s; zero for no window.
    #[schemars(with = "f64", range(min = 0))]
    pub(super) exponential_decay_per_s: Option<Spanned<f64>>,
    /// Half width of the force window about the peak, s.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) force_window_s: Option<Spanned<f64>>,
    /// Trigger level: the force that starts a record, N.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) trigger_n: Option<Spanned<f64>>,
    /// Minimum peak force, N; a hit with a smaller peak is too weak.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) min_peak_force_n: Option<Spanned<f64>>,
    /// Smallest and largest impulse of a hit in the suspension profile, N s.
    #[schemars(with = "[f64; 2]", inner(range(min = 0)))]
    pub(super) impulse_ns: Option<Spanned<[f64; 2]>>,
    /// Estimator of the frequency responses from averaged spectra.
    #[schemars(with = "String", extend("enum" = ["h1", "h2", "hv"]))]
    pub(super) frf_estimator: Option<FrfEstimator>,
    /// Terms of the mass line fit: A, B/s², C s².
    #[schemars(with = "String", extend("enum" = ["a", "ab", "abc"]))]
    pub(super) terms: Option<Terms>,
}

impl RawTest {
    /// Puts these settings under another profile: band and windows that were meant for the former have its own defaults.
    /// Returns their keys.
    pub(super) fn change_profile(&mut self, profile: TestProfile) -> Vec<&'static str> {
        if self.profile.replace(profile).unwrap_or_default() == profile {
            return Vec::new();
        }
        let stated = [
            ("band_hz", self.band_hz.take().is_some()),
            ("exponential_decay_per_s", self.exponential_decay_per_s.take().is_some()),
            ("force_window_s", self.force_window_s.take().is_some()),
        ];
        stated.into_iter().filter_map(|(key, is_stated)| is_stated.then_some(key)).collect()
    }
}

/// The precision that is wanted: half widths of the 95 % intervals.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table [target]")]
#[schemars(rename = "target")]
pub(super) struct RawTarget {
    /// Of the mass, relative to the mass.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) mass: Option<Spanned<f64>>,
    /// Of each coordinate of the centre of mass, m.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) center_m: Option<Spanned<f64>>,
    /// Of each element of the inertia tensor, relative to m L², L being the root mean square distance of the
    /// sensors from their centre.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub(super) inertia: Option<Spanned<f64>>,
}

/// Prior knowledge about the object.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table [prior]")]
#[schemars(rename = "prior")]
#[allow(non_snake_case, reason = "the names of the properties")]
pub(super) struct RawPrior {
    /// Mass, kg.
    #[schemars(with = "RawKnown")]
    pub(super) mass_kg: Option<Spanned<RawKnown>>,
    /// Centre of mass, x, m.
    #[schemars(with = "RawKnown")]
    pub(super) cx_m: Option<Spanned<RawKnown>>,
    /// Centre of mass, y, m.
    #[schemars(with = "RawKnown")]
    pub(super) cy_m: Option<Spanned<RawKnown>>,
    /// Centre of mass, z, m.
    #[schemars(with = "RawKnown")]
    pub(super) cz_m: Option<Spanned<RawKnown>>,
    /// Inertia about the centre of mass, xx, kg m².
    #[schemars(with = "RawKnown")]
    pub(super) Jxx_kg_m2: Option<Spanned<RawKnown>>,
    /// Inertia about the centre of mass, yy, kg m².
    #[schemars(with = "RawKnown")]
    pub(super) Jyy_kg_m2: Option<Spanned<RawKnown>>,
    /// Inertia about the centre of mass, zz, kg m².
    #[schemars(with = "RawKnown")]
    pub(super) Jzz_kg_m2: Option<Spanned<RawKnown>>,
    /// Inertia about the centre of mass, xy, kg m².
    #[schemars(with = "RawKnown")]
    pub(super) Jxy_kg_m2: Option<Spanned<RawKnown>>,
    /// Inertia about the centre of mass, xz, kg m².
    #[schemars(with = "RawKnown")]
    pub(super) Jxz_kg_m2: Option<Spanned<RawKnown>>,
    /// Inertia about the centre of mass, yz, kg m².
    #[schemars(with = "RawKnown")]
    pub(super) Jyz_kg_m2: Option<Spanned<RawKnown>>,
}

/// A body that hangs on the object but does not belong to it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table [[attached]]")]
#[schemars(rename = "attached")]
pub(super) struct RawAttached {
    /// Mass, kg.
    #[schemars(with = "RawKnown")]
    pub(super) mass_kg: Spanned<RawKnown>,
    /// Centre of mass in the body frame, m.
    #[schemars(with = "[f64; 3]")]
    pub(super) center_of_mass_m: Spanned<[f64; 3]>,
    /// Inertia tensor about its own centre of mass, kg m², J_xy = −∫xy dm. Default: a point mass.
    #[schemars(with = "[[f64; 3]; 3]")]
    #[serde(default)]
    pub(super) inertia_kg_m2: Option<Spanned<[[f64; 3]; 3]>>,
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
