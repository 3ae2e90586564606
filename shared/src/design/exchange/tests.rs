use super::*;
use crate::capacity::Fixed;
use std::vec::Vec;

/// Room for four sensors and six hits.
type Room = Fixed<4, 6>;

const SEARCH: Search = Search {
    candidates: Counts { sensors: 8, hits: 30 },
    wanted: Counts { sensors: 3, hits: 5 },
    starts: 6,
    seed: 1,
};

/// A cost that is small for high indices; it rejects two hits with the same remainder modulo seven.
fn cost(choice: &Choice<Room>) -> Option<f64> {
    let remainders: Vec<usize> = choice.hits.iter().map(|j| j % 7).collect();
    let twice = remainders.iter().enumerate().any(|(k, r)| remainders[..k].contains(r));
    let sum: usize = choice.sensors.iter().chain(choice.hits.iter()).sum();
    (!twice).then_some(1000.0 - sum as f64)
}

#[test]
fn the_best_of_a_cost_that_adds_up_is_found() {
    let best = SEARCH.run(None, cost).unwrap();
    let mut choice = best.choice;
    choice.sensors.sort_unstable();
    choice.hits.sort_unstable();
    assert_eq!(choice.sensors[..], [5, 6, 7]);
    assert_eq!(choice.hits[..], [25, 26, 27, 28, 29]);
    assert_eq!(best.cost, 1000.0 - 18.0 - 135.0);
}

#[test]
fn equal_seeds_give_equal_starts_and_others_differ() {
    let starts = |seed| -> Vec<Choice<Room>> {
        (0..4).map(|k| Search { seed, ..SEARCH }.start(k).unwrap()).collect()
    };
    assert_eq!(starts(1), starts(1));
    assert_ne!(starts(1), starts(2));
    assert_ne!(starts(1)[0], starts(1)[1]);
}

#[test]
fn a_start_has_every_candidate_at_most_once() {
    for index in 0..200 {
        let choice: Choice<Room> = SEARCH.start(index).unwrap();
        for (list, end) in [(&choice.sensors[..], 8), (&choice.hits[..], 30)] {
            assert!(list.iter().all(|&i| i < end));
            assert!((1..list.len()).all(|k| !list[..k].contains(&list[k])), "{list:?}");
        }
    }
}

#[test]
fn the_search_goes_on_from_a_given_choice() {
    let first = (0..).map(|k| SEARCH.start(k).unwrap()).find(|c| cost(c).is_some()).unwrap();
    let alone = Search { starts: 0, ..SEARCH };
    let best = alone.run(Some(&first), cost).unwrap();
    assert!(best.cost < cost(&first).unwrap());
    assert_eq!(alone.run::<f64, Room>(None, cost), Err(SearchError::NothingFound));
}

#[test]
fn what_cannot_be_chosen_is_said() {
    let wanting = |sensors, hits| Search { wanted: Counts { sensors, hits }, ..SEARCH };
    let run = |search: Search| search.run::<f64, Room>(None, cost);
    assert_eq!(run(wanting(9, 5)), Err(SearchError::TooManySensors));
    assert_eq!(run(wanting(5, 5)), Err(SearchError::TooManySensors), "a choice has room for 4");
    assert_eq!(run(wanting(3, 31)), Err(SearchError::TooManyHits));
    assert_eq!(SEARCH.run::<f64, Room>(None, |_| None), Err(SearchError::NothingFound));
}

#[test]
fn a_cost_that_only_wavers_ends_the_exchange() {
    // Imitates rounding in single precision: every call returns a little less than the one before.
    let mut calls = 0;
    let result = SEARCH.run::<f32, Room>(None, |_| {
        calls += 1;
        Some(1.0 - 1e-7 * calls as f32)
    });
    assert!(result.is_ok());
    // At most a few passes of 3 · 5 + 5 · 25 exchanges for each start.
    assert!(calls < 6 * 10 * 140, "{calls}");
}
