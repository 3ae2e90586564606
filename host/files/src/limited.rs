//! Lists of a file with a largest length: elements of a few bytes each would otherwise need more memory than the
//! largest file that is read.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// Reads a list of at most `MOST` elements.
pub fn at_most<'de, const MOST: usize, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    Ok(LimitedList::<MOST, T>::deserialize(deserializer)?.0)
}

/// Reads a list of at most `MOST` lists of at most `EACH` elements.
pub fn at_most_of<'de, const MOST: usize, const EACH: usize, T, D>(
    deserializer: D,
) -> Result<Vec<Vec<T>>, D::Error>
where
    T: Deserialize<'de>,
    D: Deserializer<'de>,
{
    let lists = LimitedList::<MOST, LimitedList<EACH, T>>::deserialize(deserializer)?.0;
    Ok(lists.into_iter().map(|list| list.0).collect())
}

struct LimitedList<const MOST: usize, T>(Vec<T>);

impl<'de, const MOST: usize, T: Deserialize<'de>> Deserialize<'de> for LimitedList<MOST, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Elements::<MOST, T>(PhantomData)).map(Self)
    }
}

struct Elements<const MOST: usize, T>(PhantomData<T>);

impl<'de, const MOST: usize, T: Deserialize<'de>> Visitor<'de> for Elements<MOST, T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of at most {MOST} elements")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Vec<T>, A::Error> {
        let mut list = Vec::new();
        while let Some(element) = elements.next_element()? {
            if list.len() == MOST {
                return Err(A::Error::invalid_length(MOST + 1, &self));
            }
            list.push(element);
        }
        Ok(list)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_that_is_too_long_is_refused_with_its_limit() {
        #[derive(Debug, PartialEq, serde::Deserialize)]
        struct Lists {
            #[serde(deserialize_with = "at_most::<2, _, _>")]
            one: Vec<u8>,
            #[serde(deserialize_with = "at_most_of::<2, 1, _, _>")]
            two: Vec<Vec<u8>>,
        }
        let read = |text: &str| serde_json::from_str::<Lists>(text);
        let good = Lists { one: vec![1, 2], two: vec![vec![1], vec![]] };
        assert_eq!(read(r#"{"one":[1,2],"two":[[1],[]]}"#).unwrap(), good);
        for wrong in [r#"{"one":[1,2,3]}"#, r#"{"one":[],"two":[[1,1]]}"#, r#"{"two":[[],[],[]]}"#]
        {
            let message = read(wrong).unwrap_err().to_string();
            assert!(message.contains("expected a list of at most"), "{message}");
        }
    }
}
