//! The precision that the user wants: the `[target]` table.

use crate::real::Real;

/// A key of `[target]`: the largest half width of a 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetKey {
    /// As a layout file writes it.
    pub name: &'static str,
    /// What it says, with its unit where the name has none.
    pub meaning: &'static str,
    /// A value for a precise test.
    pub example: f64,
}

/// The keys of `[target]`, in the order of [`Target::values`].
pub const TARGET_KEYS: [TargetKey; 3] = [
    TargetKey {
        name: "mass",
        meaning: "half width for the mass, relative: 0.01 is 1 %",
        example: 0.01,
    },
    TargetKey {
        name: "center_m",
        meaning: "half width for each coordinate of the centre of mass",
        example: 0.001,
    },
    TargetKey {
        name: "inertia",
        meaning: "half width for each element of the inertia tensor, relative to m L², L being the root mean square \
                  distance of the sensors from their centre",
        example: 0.02,
    },
];

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
    /// The half widths, each where one is wanted.
    pub fn values(&self) -> [Option<R>; 3] {
        [self.mass, self.center, self.inertia]
    }

    /// The half widths that are wanted.
    pub fn requested_half_widths(&self) -> impl Iterator<Item = R> {
        self.values().into_iter().flatten()
    }

    /// True when a half width is wanted.
    pub fn is_set(&self) -> bool {
        self.requested_half_widths().next().is_some()
    }

    /// The same target in another precision.
    pub fn cast<Q: Real>(&self) -> Target<Q> {
        self.values().map(|width| width.map(|v| Q::of(v.to_f64()))).into()
    }
}

impl<R> From<[Option<R>; 3]> for Target<R> {
    fn from([mass, center, inertia]: [Option<R>; 3]) -> Self {
        Self { mass, center, inertia }
    }
}
