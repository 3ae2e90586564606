//! Pictures of a test and of its result, as SVG and PNG files.
//!
//! A picture is one file here with a [`Drawing`]: what it shows, taken from the data of a result, and how it is drawn. The
//! list of [`Picture`]s says which there are; `massline plot` and the report read that list.

mod assurance;
mod canvas;
mod estimates;
mod indicators;
mod layout;
mod list;
mod responses;
mod source;
mod stabilisation;
mod theme;

pub use assurance::Assurance;
pub use canvas::{Drawing, ImageFormat, render};
pub use estimates::{Estimates, Series};
pub use indicators::Indicators;
pub use layout::InSpace;
pub use list::{DrawnFile, Picture};
pub use responses::Responses;
pub use source::{LAYOUT_NEEDED, ShownModes, Source};
pub use stabilisation::Stabilisation;
