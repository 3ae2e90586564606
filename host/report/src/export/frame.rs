//! The frame of the exported properties: what is asked for, and where it lies.

use std::fmt;
use std::str::FromStr;

use nalgebra::{Matrix3, Vector3};

/// A frame, as it is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// The body frame of the layout.
    #[default]
    Body,
    /// Origin at the centre of mass, axes of the body frame.
    CenterOfMass,
    /// Origin at the centre of mass, along the principal axes in ascending order of their moments.
    Principal,
    /// Origin at a node, along its local axes.
    Node(u16),
}

impl FromStr for Frame {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "body" => Ok(Self::Body),
            "com" => Ok(Self::CenterOfMass),
            "principal" => Ok(Self::Principal),
            number => number
                .parse()
                .map(Self::Node)
                .map_err(|_| "give body, com, principal, or the number of a node".into()),
        }
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Body => f.write_str("body"),
            Self::CenterOfMass => f.write_str("com"),
            Self::Principal => f.write_str("principal"),
            Self::Node(number) => write!(f, "{number}"),
        }
    }
}

/// Where a frame lies in the body frame of the layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Which frame it is.
    pub frame: Frame,
    /// Its origin in the body frame, in the unit of length of the export.
    pub origin: Vector3<f64>,
    /// Its axes as rows: unit vectors in the body frame.
    pub axes: Matrix3<f64>,
}

impl Placement {
    /// The body frame itself.
    pub fn body() -> Self {
        Self { frame: Frame::Body, origin: Vector3::zeros(), axes: Matrix3::identity() }
    }

    /// What it is, as a sentence without full stop.
    pub(super) fn words(&self) -> String {
        match self.frame {
            Frame::Body => "body frame of the layout".into(),
            Frame::CenterOfMass => "origin at the centre of mass, axes of the body frame".into(),
            Frame::Principal => {
                "origin at the centre of mass, along the principal axes (ascending moments)".into()
            }
            Frame::Node(number) => format!("origin at node {number}, along its local axes"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_read_as_it_is_printed() {
        for frame in [Frame::Body, Frame::CenterOfMass, Frame::Principal, Frame::Node(12)] {
            assert_eq!(frame.to_string().parse(), Ok(frame));
        }
        assert!("tip".parse::<Frame>().is_err() && "-1".parse::<Frame>().is_err());
    }
}
