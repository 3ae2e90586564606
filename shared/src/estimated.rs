//! A number with its standard deviation.

/// An estimated number with its standard deviation, both in the unit stated where it is used.
///
/// `S` is `Option<R>` where a standard deviation may be missing, such as that of a mass from single hits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EstimatedValue<R, S = R> {
    /// The estimated value.
    pub value: R,
    /// Its standard deviation.
    pub sigma: S,
}
