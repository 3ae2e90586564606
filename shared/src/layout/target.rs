//! The precision that the user wants: the `[target]` table.

use crate::Real;

/// Largest half widths of the 95 % intervals, each where one is wanted. A campaign asks whether to finish as
/// soon as all of them are reached.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target<R> {
    /// Of the mass, relative to the mass.
    pub mass: Option<R>,
    /// Of each coordinate of the centre of mass, m.
    pub center: Option<R>,
    /// Of each element of the inertia tensor, relative to `m L²`, with the characteristic length L.
    pub inertia: Option<R>,
}

impl<R> Default for Target<R> {
    /// Nothing is wanted.
    fn default() -> Self {
        Self { mass: None, center: None, inertia: None }
    }
}

impl<R: Real> Target<R> {
    /// The half widths that are wanted.
    pub fn wanted(&self) -> impl Iterator<Item = R> {
        [self.mass, self.center, self.inertia].into_iter().flatten()
    }

    /// True when a half width is wanted.
    pub fn is_set(&self) -> bool {
        self.wanted().next().is_some()
    }

    /// The same target in another precision.
    pub fn cast<Q: Real>(&self) -> Target<Q> {
        let to = |v: R| Q::of(v.to_f64());
        Target {
            mass: self.mass.map(to),
            center: self.center.map(to),
            inertia: self.inertia.map(to),
        }
    }
}
