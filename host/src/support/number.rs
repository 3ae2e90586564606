//! Numeric arguments: an invalid value is rejected with a message that states the valid range.

use std::ops::RangeInclusive;

use clap::{Arg, Command};

/// Range of positive quantities in SI units.
const POSITIVE: RangeInclusive<f64> = 1e-12..=1e12;

/// Parses a positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| POSITIVE.contains(value));
    value.ok_or_else(|| "give a positive number, at most 1e12".into())
}

/// Parses zero or a positive number.
pub fn not_negative(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| *value == 0.0 || POSITIVE.contains(value));
    value.ok_or_else(|| "give zero or a positive number, at most 1e12".into())
}

/// Parses a seed.
pub fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("give a whole number from 0 to {}", u64::MAX))
}

/// Makes all options of the command and its subcommands accept `-5` as a number, so that the number's parser
/// reports what is wrong with it instead of clap reporting an unknown option `-5`.
pub fn with_negative_numbers(command: Command) -> Command {
    let takes = |arg: Arg| {
        let value = arg.get_action().takes_values() && !arg.is_allow_hyphen_values_set();
        if value { arg.allow_negative_numbers(true) } else { arg }
    };
    command.mut_args(takes).mut_subcommands(with_negative_numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_quantity_is_refused() {
        for text in ["nan", "inf", "-inf", "1e400", "-1", "1e13", "", "x", "1,5"] {
            assert!(positive(text).is_err() && not_negative(text).is_err(), "{text}");
        }
        assert!(positive("0").is_err());
        assert_eq!((not_negative("0"), not_negative("-0")), (Ok(0.0), Ok(0.0)));
        assert_eq!(positive("2.5e-3"), Ok(0.0025));
    }
}
