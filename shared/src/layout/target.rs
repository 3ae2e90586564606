//! The uncertainty that the user wants: the `[target]` table.

use crate::Real;

/// Largest half widths of the 95 % intervals, each where it is wanted. A measurement can stop when all are
/// reached.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target<R> {
    /// Of the mass, relative to the mass.
    pub mass: Option<R>,
    /// Of each coordinate of the centre of mass, m.
    pub center: Option<R>,
    /// Of each element of the inertia tensor, relative to `m L²`, L the characteristic length.
    pub inertia: Option<R>,
}

impl<R> Default for Target<R> {
    fn default() -> Self {
        Self { mass: None, center: None, inertia: None }
    }
}

impl<R: Real> Target<R> {
    pub(super) fn cast<Q: Real>(&self) -> Target<Q> {
        let to = |v: R| Q::of(v.to_f64());
        Target {
            mass: self.mass.map(to),
            center: self.center.map(to),
            inertia: self.inertia.map(to),
        }
    }
}
