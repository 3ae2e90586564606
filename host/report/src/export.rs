//! Results as files of other programs: simulators, finite element models, numerics.
//!
//! [`read_subject`] reads a result, [`ExportedResult::in_frame`] and [`ExportedResult::in_units`] say how it is wanted,
//! [`ExportedResult::check`] refuses what no body can have, and [`Format::write`] makes the bytes of a file.
//! [`Format`] is the one list of formats: command line, help and tests read it.
//!
//! Every file states its units, its frame and the convention of its products of inertia. Results of this program hold
//! elements of the tensor about the centre of mass, `J_xy = −∫ x y dm`; a format with another convention is converted,
//! and its file has the source of that convention.

mod abaqus;
mod csv;
mod document;
mod frame;
mod heading;
mod json;
mod mat;
mod mjcf;
mod nastran;
mod npz;
mod number;
mod sdf;
mod subject;
mod test_data;
mod transform;
mod uff;
mod units;
mod urdf;
mod xml;
mod yaml;

use clap::ValueEnum;

use massline_result::{Error, Result};

pub use document::{MAX_BYTES, of_document, of_result, read_document, read_subject};
pub use frame::{Frame, Placement};
pub use subject::{ExportedResult, Matrix10, Vector10};
pub use test_data::one_line;
pub use test_data::{Node, Responses, TestData};
pub use uff::universal_file;
pub use units::UnitSystem;

/// The formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Robot description of ROS: one link with its inertial. SI
    Urdf,
    /// SDFormat, of Gazebo and Drake: a model with one link. SI
    Sdf,
    /// MuJoCo model: one free body. SI
    Mjcf,
    /// Nastran bulk data: GRID and CONM2 in the large field format
    Conm2,
    /// Abaqus input: a node with MASS and ROTARYI elements
    Abaqus,
    /// YAML: values, standard deviations, covariance
    Yaml,
    /// CSV: a row for each property, with its interval and covariances
    Csv,
    /// JSON: values, standard deviations, intervals, covariance
    Json,
    /// NumPy archive: arrays of the values, standard deviations, covariance
    Npz,
    /// Universal file: units (164), nodes (15), frequency responses (58). SI
    Uff,
    /// MATLAB 5 file: matrices of the values, standard deviations, covariance
    Mat,
}

/// What distinguishes a format.
struct Entry {
    /// The bytes of a file.
    write: fn(&ExportedResult) -> Result<Vec<u8>>,
    /// True when the bytes are no text.
    is_binary: bool,
    /// True when the format itself defines its units as SI.
    is_si: bool,
    /// True when the file holds responses instead of the ten properties.
    holds_responses: bool,
}

impl Format {
    fn entry(self) -> Entry {
        let plain_entry =
            |write| Entry { write, is_binary: false, is_si: false, holds_responses: false };
        match self {
            Self::Urdf => Entry { is_si: true, ..plain_entry(urdf::write) },
            Self::Sdf => Entry { is_si: true, ..plain_entry(sdf::write) },
            Self::Mjcf => Entry { is_si: true, ..plain_entry(mjcf::write) },
            Self::Conm2 => plain_entry(nastran::write),
            Self::Abaqus => plain_entry(abaqus::write),
            Self::Yaml => plain_entry(yaml::write),
            Self::Csv => plain_entry(csv::write),
            Self::Json => plain_entry(json::write),
            Self::Npz => Entry { is_binary: true, ..plain_entry(npz::write) },
            Self::Uff => Entry { is_si: true, holds_responses: true, ..plain_entry(uff::write) },
            Self::Mat => Entry { is_binary: true, ..plain_entry(mat::write) },
        }
    }

    /// Name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// True when the file is no text.
    pub fn is_binary(self) -> bool {
        self.entry().is_binary
    }

    /// True when the file holds frequency responses instead of the ten properties.
    pub fn holds_responses(self) -> bool {
        self.entry().holds_responses
    }

    /// Checks that the format can hold a result in these units and this frame.
    ///
    /// # Errors
    /// Exit 2 when the format itself defines other units, or has no place for a frame.
    pub fn check(self, units: UnitSystem, frame: Frame) -> Result<()> {
        let Entry { is_si, holds_responses, .. } = self.entry();
        let name = self.name();
        if is_si && units != UnitSystem::Si {
            return Err(Error::input(
                "units_not_for_format",
                format!(
                    "{name} files are in kg, m and s by definition: --units {} cannot be used with \
                     --format {name}; leave it out",
                    units.name()
                ),
            ));
        }
        if holds_responses && frame != Frame::Body {
            return Err(Error::input(
                "frame_not_for_format",
                format!(
                    "a {name} file holds frequency responses along the local axes of the nodes, which \
                     --frame {frame} cannot change; leave it out"
                ),
            ));
        }
        Ok(())
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// Exit 2 when the result lacks what the format is for: frequency responses for a universal file.
    pub fn write(self, exported: &ExportedResult) -> Result<Vec<u8>> {
        (self.entry().write)(exported)
    }
}

#[cfg(test)]
mod tests;
