//! Numbers of results as an argument.

use std::str::FromStr;

/// A number of a result, or a range of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbers {
    first: u32,
    last: u32,
}

impl Numbers {
    /// True for a number of the range.
    pub fn contains(self, number: u32) -> bool {
        (self.first..=self.last).contains(&number)
    }

    /// The number, when it is a single one.
    pub fn single(self) -> Option<u32> {
        (self.first == self.last).then_some(self.first)
    }
}

impl FromStr for Numbers {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str| text.trim().parse::<u32>().ok().filter(|&number| number > 0);
        let ends = match text.split_once('-') {
            None => number(text).map(|one| (one, one)),
            Some((first, "")) => number(first).map(|first| (first, u32::MAX)),
            Some((first, last)) => number(first).zip(number(last)),
        };
        let (first, last) = ends
            .filter(|(first, last)| first <= last)
            .ok_or("give a number such as 3, or a range such as 2-5 or 2-")?;
        Ok(Self { first, last })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges_are_read() {
        let parse =
            |text: &str| text.parse::<Numbers>().ok().map(|numbers| (numbers.first, numbers.last));
        assert_eq!(parse("3"), Some((3, 3)));
        assert_eq!(parse("2-5"), Some((2, 5)));
        assert_eq!(parse("2-"), Some((2, u32::MAX)));
        for wrong in ["", "0", "-", "-3", "5-2", "a", "1-b", "1.5"] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
