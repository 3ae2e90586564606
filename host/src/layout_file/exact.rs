//! Arrays that have exactly as many elements as wanted. Serde's own reader of fixed arrays leaves what a TOML array
//! has too many unread.

use serde::de::{Deserialize, Deserializer, Error};
use toml::Spanned;

/// A value made of numbers in lists of exact lengths.
pub(super) trait Exact: Sized {
    /// The same with lists of any length.
    type Listed;

    /// The value, or the length of the first list with another length and the wanted one.
    fn of(listed: Self::Listed) -> Result<Self, (usize, usize)>;
}

impl Exact for f64 {
    type Listed = f64;

    fn of(listed: f64) -> Result<Self, (usize, usize)> {
        Ok(listed)
    }
}

impl<T: Exact, const N: usize> Exact for [T; N] {
    type Listed = Vec<T::Listed>;

    fn of(listed: Self::Listed) -> Result<Self, (usize, usize)> {
        let found = listed.len();
        let elements: Vec<T> = listed.into_iter().map(T::of).collect::<Result<_, _>>()?;
        elements.try_into().map_err(|_| (found, N))
    }
}

/// An array in a place where the text's position is of no use.
pub(super) fn array<'de, D, T>(deserializer: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: Exact<Listed: Deserialize<'de>>,
{
    checked(T::Listed::deserialize(deserializer)?)
}

/// As [`array()`], where the key may be left out.
pub(super) fn optional_array<'de, D, T>(deserializer: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Exact<Listed: Deserialize<'de>>,
{
    array(deserializer).map(Some)
}

/// An array with its position in the text.
pub(super) fn spanned<'de, D, T>(deserializer: D) -> Result<Spanned<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Exact<Listed: Deserialize<'de>>,
{
    let listed = Spanned::<T::Listed>::deserialize(deserializer)?;
    let span = listed.span();
    Ok(Spanned::new(span, checked(listed.into_inner())?))
}

/// As [`spanned`], where the key may be left out.
pub(super) fn optional_spanned<'de, D, T>(deserializer: D) -> Result<Option<Spanned<T>>, D::Error>
where
    D: Deserializer<'de>,
    T: Exact<Listed: Deserialize<'de>>,
{
    spanned(deserializer).map(Some)
}

fn checked<T: Exact, E: Error>(listed: T::Listed) -> Result<T, E> {
    T::of(listed).map_err(|(found, wanted)| {
        E::invalid_length(found, &format!("an array of length {wanted}").as_str())
    })
}
