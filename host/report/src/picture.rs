//! Pictures of a test and of its result, as SVG and PNG files.
//!
//! A picture is one file here with a [`Drawing`]: what it shows, taken from the data of a result, and how it is drawn.
//! The list of [`Picture`]s says which there are; `massline plot` and the report read that list.

mod assurance;
mod bitmap;
mod budget;
mod canvas;
mod clip;
mod driving_points;
mod estimates;
mod hits;
mod indicators;
mod labels;
mod layout;
mod legend;
mod list;
mod nodes;
mod outline;
mod panel;
mod phase;
mod pulls;
mod responses;
mod ruler;
mod scale;
mod stabilisation;
mod theme;
mod vector;
mod view;

pub use assurance::Assurance;
pub use budget::Budget;
pub use canvas::{Drawing, FONT_LICENCE, ImageFormat, render};
pub use driving_points::DrivingPoints;
pub use estimates::{Estimates, Series};
pub use hits::HitsOfDof;
pub use indicators::Indicators;
pub use layout::{LayoutInSpace, ellipsoid};
pub use list::{DrawnFile, Picture};
pub use nodes::{NamedNode, nodes_without_sensor};
pub use pulls::{Pull, Pulls};
pub use responses::Responses;
pub use stabilisation::Stabilisation;
