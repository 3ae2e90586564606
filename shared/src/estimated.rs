//! A number and how well it is known.

/// An estimated number with its standard deviation, both in the unit that its place states.
///
/// `S` is `Option<R>` where a deviation may be missing, such as that of a mass from single hits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimated<R, S = R> {
    /// The number.
    pub value: R,
    /// Its standard deviation.
    pub sigma: S,
}
