//! Names of degrees of freedom: `1:+Y`.

use core::fmt;
use core::str::FromStr;

/// A local axis of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Axis {
    /// Local x.
    X,
    /// Local y.
    Y,
    /// Local z.
    Z,
}

/// The letters of the axes of a sensor.
pub const AXIS_LETTERS: [char; 3] = ['x', 'y', 'z'];

impl Axis {
    /// x, y, z.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// The index 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// x, y or z.
    pub fn letter(self) -> char {
        AXIS_LETTERS[self.index()]
    }
}

/// Along an axis or against it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Sign {
    /// Along the axis.
    Plus,
    /// Against the axis.
    Minus,
}

impl Sign {
    /// +1 or −1.
    pub fn factor(self) -> f64 {
        match self {
            Self::Plus => 1.0,
            Self::Minus => -1.0,
        }
    }
}

/// A node and a signed local axis. As a hit, `1:+Y` means that the force on the body acts along +Y of node 1:
/// the hammer moves in that direction, and a push is positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Dof {
    /// The node's number.
    pub node: u16,
    /// Along or against the axis.
    pub sign: Sign,
    /// The local axis.
    pub axis: Axis,
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.sign {
            Sign::Plus => '+',
            Sign::Minus => '-',
        };
        let axis = match self.axis {
            Axis::X => 'X',
            Axis::Y => 'Y',
            Axis::Z => 'Z',
        };
        write!(f, "{}:{sign}{axis}", self.node)
    }
}

/// Why a text is not a valid DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DofError {
    /// The text is not `node ':' sign axis`.
    Malformed,
    /// Only the sign is missing.
    NoSign,
}

impl fmt::Display for DofError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Malformed => "a DOF is written node:±axis, for example 1:+Y or 12:-Z",
            Self::NoSign => "a DOF needs a sign, for example 1:+Y or 1:-Y",
        })
    }
}

impl core::error::Error for DofError {}

impl FromStr for Dof {
    type Err = DofError;

    /// Parses `1:+Y`; lower-case letters are accepted.
    fn from_str(text: &str) -> Result<Self, DofError> {
        let (node, direction) = text.trim().split_once(':').ok_or(DofError::Malformed)?;
        let digits = !node.is_empty() && node.bytes().all(|b| b.is_ascii_digit());
        let node = node.parse().ok().filter(|_| digits).ok_or(DofError::Malformed)?;
        let signs = [('+', Sign::Plus), ('-', Sign::Minus)];
        let signed =
            signs.into_iter().find_map(|(c, sign)| Some((sign, direction.strip_prefix(c)?)));
        let (_, axis) = signed.unwrap_or((Sign::Plus, direction));
        let axis = match axis {
            "X" | "x" => Axis::X,
            "Y" | "y" => Axis::Y,
            "Z" | "z" => Axis::Z,
            _ => return Err(DofError::Malformed),
        };
        let (sign, _) = signed.ok_or(DofError::NoSign)?;
        Ok(Self { node, sign, axis })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_dof_reads_back_what_it_shows() {
        for text in ["1:+Y", "12:-Z", "65535:+X"] {
            let dof: Dof = text.parse().unwrap();
            assert_eq!(dof.to_string(), text);
        }
    }

    #[test]
    fn a_missing_sign_is_told_from_nonsense() {
        assert_eq!("3:y".parse::<Dof>(), Err(DofError::NoSign));
        assert_eq!("3:+y".parse::<Dof>().map(|dof| dof.sign), Ok(Sign::Plus));
    }

    #[test]
    fn text_that_is_no_dof_is_refused() {
        for text in ["", ":", "1", "1:", "1:+", "1:+W", "+1:+X", "70000:+X", "1:++X", "1:+X+"] {
            assert_eq!(text.parse::<Dof>(), Err(DofError::Malformed), "{text}");
        }
    }
}
