//! The layout file: where the sensors sit and where the hammer lands, in TOML.
//!
//! [`LayoutFile::read`] returns a checked layout with nodes and local axes resolved to positions and
//! directions in the body frame. Every error names file, line and key, and says what to do. Whether a valid
//! layout can determine the ten properties (collinear sensors, concurrent hits) is not checked here but in
//! `massline_shared::layout`.

mod budget;
mod entry;
mod error;
mod keyed;
mod known;
mod policy;
mod raw;
mod resolve;
#[cfg(feature = "schema")]
mod schema;
mod source;
mod suspicion;
mod template;
mod tensor;
mod test_settings;
mod values;

use std::path::Path;

use massline_protocol::LayoutHash;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::Setting;
use massline_shared::layout::{Dof, HostLayout, RigLayout, TestProfile};

pub use budget::Uncertainty;
pub use error::{Fault, LayoutFileError, Place};
#[cfg(feature = "schema")]
pub use schema::schema;
pub use suspicion::size_suspicions;
pub use template::template;

use source::Source;

/// The JSON schema (draft 2020-12) of the layout file.
pub const SCHEMA: &str = include_str!("../../schemas/layout-file.schema.json");

/// Largest TOML file that is read, bytes: its tables take a hundred times that in memory.
pub const MAX_BYTES: u64 = 1 << 20;

/// A layout file, checked and resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutFile {
    /// The title; that of `layout` is cut to what a rig has room for.
    pub title: String,
    /// Sensors, hits and settings in the body frame.
    pub layout: HostLayout,
    /// The nodes, in the order of the file.
    pub nodes: Vec<Node>,
    /// Sensor properties besides the geometry, in the order of `layout.sensors`.
    pub sensors: Vec<SensorDetails>,
    /// Default uncertainties of sensors and hits.
    pub uncertainty: Uncertainty,
    /// Expected values to compare with.
    pub reference: Option<Reference>,
    /// What the report states and no program can know.
    pub statements: Statements,
    /// The text of the file.
    pub text: String,
    /// Keys of `[test]` that the file states for the other profile: the defaults are used in their place.
    pub set_aside: Vec<&'static str>,
    /// Where the file states the settings of the test.
    places: Vec<(Setting, Place)>,
}

/// A numbered point of the object.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its number.
    pub id: u16,
    /// Position in the body frame, m.
    pub position: [f64; 3],
    /// Local x, y and z axis, unit vectors of the body frame.
    pub axes: [[f64; 3]; 3],
    /// True where a sensor can be glued.
    pub can_carry_sensor: bool,
    /// The DOFs that a hammer can reach.
    pub can_hit: Vec<Dof>,
}

/// Properties of a sensor besides its geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDetails {
    /// Name of its calibration.
    pub calibration: Option<String>,
}

/// The `[report]` table: what a report states about the test and no program can know. Empty where nothing is stated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statements {
    /// What was measured.
    pub object: String,
    /// How it hung or stood.
    pub support: String,
    /// The hammer and its tip.
    pub hammer: String,
    /// The sensors and how they were mounted.
    pub sensors: String,
    /// Who measured.
    pub operator: String,
    /// Where it was measured.
    pub place: String,
    /// Anything else.
    pub remarks: String,
}

/// The `[reference]` table: expected values, each optional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Centre of mass in the body frame, m.
    pub center_of_mass_m: Option<[f64; 3]>,
    /// Inertia tensor about the centre of mass, kg m².
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
}

impl Reference {
    /// The ten properties in the order [m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz], each when known.
    pub fn properties(&self) -> [Option<f64>; 10] {
        let c = |k: usize| self.center_of_mass_m.map(|c| c[k]);
        let j = |a: usize, b: usize| self.inertia_kg_m2.map(|j| j[a][b]);
        let [cx, cy, cz] = [c(0), c(1), c(2)];
        let diagonal = [j(0, 0), j(1, 1), j(2, 2)];
        let products = [j(0, 1), j(0, 2), j(1, 2)];
        let [jxx, jyy, jzz] = diagonal;
        let [jxy, jxz, jyz] = products;
        [self.mass_kg, cx, cy, cz, jxx, jyy, jzz, jxy, jxz, jyz]
    }

    /// The ten properties when all are known.
    pub fn complete(&self) -> Option<[f64; 10]> {
        all_known(self.properties())
    }
}

/// The ten properties when all are known.
pub fn all_known(properties: [Option<f64>; 10]) -> Option<[f64; 10]> {
    let mut values = [0.0; 10];
    for (to, from) in values.iter_mut().zip(properties) {
        *to = from?;
    }
    Some(values)
}

impl LayoutFile {
    /// Reads and checks a layout file.
    ///
    /// # Errors
    /// When the file cannot be read, is not TOML, has an unknown key, or an invalid value.
    pub fn read(path: &Path) -> Result<Self, LayoutFileError> {
        Self::read_in_profile(path, None)
    }

    /// As [`LayoutFile::read`], in another profile than the file states, where one is given. Settings that the file
    /// leaves out, its band and its windows have the defaults of that profile.
    ///
    /// # Errors
    /// As [`LayoutFile::read`].
    pub fn read_in_profile(
        path: &Path,
        profile: Option<TestProfile>,
    ) -> Result<Self, LayoutFileError> {
        let file = path.display().to_string();
        let bytes = bytes_of(path)?;
        Self::parse_in_profile(utf8(&bytes, &file)?, &file, profile)
    }

    /// Checks a layout from raw bytes; `file` is its name in errors.
    ///
    /// # Errors
    /// As [`LayoutFile::read`], and when the bytes are not UTF-8.
    pub fn parse_bytes(bytes: &[u8], file: &str) -> Result<Self, LayoutFileError> {
        Self::parse(utf8(bytes, file)?, file)
    }

    /// Checks the text of a layout; `file` is its name in errors.
    ///
    /// # Errors
    /// As [`LayoutFile::read`].
    ///
    /// ```
    /// let layout = massline_files::layout_file::LayoutFile::parse(
    ///     r#"
    ///     sensors = [1, 2, 3]
    ///     hits = ["1:+X", "2:+Y", "3:+Z"]
    ///     node = [
    ///         { id = 1, position_m = [0.0, 0.0, 0.0] },
    ///         { id = 2, position_m = [0.2, 0.0, 0.0] },
    ///         { id = 3, position_m = [0.0, 0.2, 0.0] },
    ///     ]
    ///     "#,
    ///     "example.toml",
    /// )?;
    /// assert_eq!(layout.layout.hits[1].direction, [0.0, 1.0, 0.0]);
    /// # Ok::<(), massline_files::layout_file::LayoutFileError>(())
    /// ```
    pub fn parse(text: &str, file: &str) -> Result<Self, LayoutFileError> {
        Self::parse_in_profile(text, file, None)
    }

    fn parse_in_profile(
        text: &str,
        file: &str,
        profile: Option<TestProfile>,
    ) -> Result<Self, LayoutFileError> {
        let (mut raw, source) = (raw(text, file)?, Source { file, text });
        let set_aside = profile.map_or_else(Vec::new, |profile| raw.test.change_profile(profile));
        resolve::is_complete(&raw, &source)?;
        Ok(Self { set_aside, ..resolve::resolve(raw, &source)? })
    }

    /// As [`LayoutFile::read`], but for a file that may omit `sensors` and `hits`: its nodes are the
    /// candidates.
    ///
    /// # Errors
    /// As [`LayoutFile::read`].
    pub fn read_candidates(path: &Path) -> Result<Self, LayoutFileError> {
        let file = path.display().to_string();
        let text = utf8(&bytes_of(path)?, &file)?.to_owned();
        resolve::resolve(raw(&text, &file)?, &Source { file: &file, text: &text })
    }

    /// The file with these properties as its reference, unless it has one.
    #[must_use]
    pub fn with_reference(&self, body: &RigidBody<f64>) -> Self {
        if self.reference.is_some() {
            return self.clone();
        }
        let center: [f64; 3] = body.center_of_mass.into();
        // The tensor is symmetric: its columns are its rows.
        let inertia: [[f64; 3]; 3] = body.inertia.into();
        let text = format!(
            "{}\n\n# The properties of the simulated object.\n[reference]\nmass_kg = {:?}\n\
             center_of_mass_m = {center:?}\ninertia_kg_m2 = {inertia:?}\n",
            self.text, body.mass,
        );
        let reference = Some(Reference {
            mass_kg: Some(body.mass),
            center_of_mass_m: Some(center),
            inertia_kg_m2: Some(inertia),
        });
        Self { text, reference, ..self.clone() }
    }

    /// The layout in the precision and capacity of the rig; `None` when it has more sensors or hits than the
    /// rig has room for.
    pub fn rig_layout(&self) -> Option<RigLayout> {
        self.layout.cast()
    }

    /// Where the file states a setting of the test.
    pub fn place_of(&self, setting: Setting) -> Option<&Place> {
        self.places.iter().find(|(key, _)| *key == setting).map(|(_, place)| place)
    }

    /// The hash that identifies this layout on the wire and in files; `None` as for
    /// [`LayoutFile::rig_layout`].
    pub fn hash(&self) -> Option<u32> {
        self.rig_layout().map(|layout| layout.hash())
    }
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, LayoutFileError> {
    crate::file::read(path, MAX_BYTES)
        .map_err(|source| LayoutFileError::Read { file: path.to_owned(), source })
}

fn utf8<'a>(bytes: &'a [u8], file: &str) -> Result<&'a str, LayoutFileError> {
    std::str::from_utf8(bytes).map_err(|error| {
        let good = bytes.get(..error.valid_up_to()).unwrap_or_default();
        let line = good.iter().filter(|&&b| b == b'\n').count() + 1;
        let place = Place { file: file.to_owned(), line, key: String::new() };
        LayoutFileError::Malformed { place, message: "this is not UTF-8 text".into() }
    })
}

fn raw(text: &str, file: &str) -> Result<raw::RawLayout, LayoutFileError> {
    massline_toml::read(text).map_err(|error| LayoutFileError::Malformed {
        place: Place::of_toml_error(file, text, &error),
        message: error.message,
    })
}

/// Numbers and positions, body frame, m, of the nodes of a layout's sensors and hits: all that a rig stores of nodes.
pub fn nodes_of(layout: &HostLayout) -> Vec<(u16, [f64; 3])> {
    let sensors = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position));
    let hits = layout.hits.iter().map(|hit| (hit.dof.node, hit.position));
    let mut nodes: Vec<_> = sensors.chain(hits).collect();
    nodes.sort_by_key(|&(node, _)| node);
    nodes.dedup_by_key(|&mut (node, _)| node);
    nodes
}

#[cfg(test)]
mod tests;
