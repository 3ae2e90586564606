//! Sorts short lists.

/// Sorts a list by insertion, with a number of steps that grows with the square of its length: for short lists.
/// Elements of which none `is_less` keep their order. Any `is_less` gives a permutation of the list, also one that
/// compares what is not a number.
///
/// The sort of `core` takes 2 to 3 KB of flash for each type of element.
pub(crate) fn sort_short<T>(list: &mut [T], is_less: impl Fn(&T, &T) -> bool) {
    for end in 1..list.len() {
        let mut at = end;
        while at > 0 && is_less(&list[at], &list[at - 1]) {
            list.swap(at, at - 1);
            at -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_list_is_sorted_as_core_sorts_it(list in prop::collection::vec(0_u8..20, 0..70)) {
            let mut expected: Vec<_> = list.iter().copied().enumerate().collect();
            let mut sorted = expected.clone();
            expected.sort_by_key(|(_, value)| *value);
            sort_short(&mut sorted, |a, b| a.1 < b.1);
            prop_assert_eq!(sorted, expected);
        }
    }

    #[test]
    fn what_is_not_a_number_loses_nothing() {
        let mut list = [3.0, f64::NAN, 1.0, 2.0, f64::NAN, 0.0];
        sort_short(&mut list, |a, b| a < b);
        assert_eq!(list.iter().filter(|value| value.is_nan()).count(), 2);
        assert_eq!(list.iter().filter(|value| !value.is_nan()).sum::<f64>(), 6.0);
    }
}
