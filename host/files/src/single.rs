//! Numbers of a file that are kept in single precision, each checked where it is read, so that the reader of the file
//! can say where a wrong one stands.

/// A number in single precision, if `is_good`; other numbers than zero that would become zero or infinite are not.
///
/// # Errors
/// A sentence with what is wanted.
pub fn single(value: f64, is_good: impl Fn(f64) -> bool, wanted: &str) -> Result<f32, String> {
    let rounded = value as f32;
    let is_kept = rounded.is_normal() || value == 0.0;
    match is_kept && is_good(value) {
        true => Ok(rounded),
        false => Err(format!("{value} is not valid; use {wanted}")),
    }
}

/// A type for a number of a file: its name, what it is, when it is good, and what is wanted otherwise.
macro_rules! number {
    ($(#[$doc:meta])* $name:ident, $is_good:expr, $wanted:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(try_from = "f64", into = "f32")]
        pub(super) struct $name(pub(super) f32);

        impl TryFrom<f64> for $name {
            type Error = String;

            fn try_from(value: f64) -> Result<Self, String> {
                $crate::single::single(value, $is_good, $wanted).map(Self)
            }
        }

        impl From<$name> for f32 {
            fn from(number: $name) -> Self {
                number.0
            }
        }
    };
}
pub(crate) use number;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_single_precision_does_not_hold_is_refused() {
        let any = |value| single(value, |_| true, "a number");
        assert_eq!((any(0.0), any(0.02)), (Ok(0.0), Ok(0.02)));
        for value in [1e-50, 1e39, f64::NAN, f64::INFINITY] {
            assert_eq!(any(value), Err(format!("{value} is not valid; use a number")));
        }
        assert!(single(-1.0, |v| v > 0.0, "a positive number").is_err());
    }
}
