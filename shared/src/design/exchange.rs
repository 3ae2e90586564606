//! Exchange search over a set of candidates: members of the choice are replaced one at a time by the
//! candidate that lowers the cost most, until no exchange does (Fedorov 1972; Cook & Nachtsheim 1980, the
//! modified algorithm). The result depends on the start, so several starts are tried.

use core::fmt;

use crate::capacity::{Capacity, List};
use crate::real::Real;

/// Number of sensors and number of hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Triaxial sensors.
    pub sensors: usize,
    /// Hit DOFs.
    pub hits: usize,
}

/// Sensors and hits as indices into the lists of candidates, without repetition.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice<C: Capacity> {
    /// Indices of the candidates that carry a sensor.
    pub sensors: C::Sensors<usize>,
    /// Indices of the candidates that are hit.
    pub hits: C::Hits<usize>,
}

/// A choice that no single exchange improves.
#[derive(Clone, Debug, PartialEq)]
pub struct BestChoice<R: Real, C: Capacity> {
    /// The sensors and hits.
    pub choice: Choice<C>,
    /// Cost of the choice.
    pub cost: R,
}

/// What is searched for, and for how long. Theory, section 8.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::body::scale;
/// # use massline_shared::capacity::Fixed;
/// # use massline_shared::design::{Choice, Counts, Criterion, DEFAULT_NOISE, Predict, Search};
/// # use massline_shared::identify::maximum_likelihood::workspace;
/// # use massline_shared::layout::{Hit, Layout};
/// let mut layout = frame::layout();
/// let present = layout.hits.clone();
/// let corner = [0.208, 0.0, 0.0];
/// // Candidates: the three hits there are, and two more at node 3.
/// let mut candidates: Vec<Hit<f64>> = present.iter().copied().collect();
/// for (dof, direction) in [("3:+Z", [0.0, 0.0, 1.0]), ("3:+Y", [0.0, 1.0, 0.0])] {
///     candidates.push(Hit::new(dof.parse().unwrap(), corner, direction));
/// }
/// let criterion = Criterion::new(frame::body(), 0.14, DEFAULT_NOISE);
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// let search = Search {
///     candidates: Counts { sensors: 3, hits: 5 },
///     wanted: Counts { sensors: 3, hits: 3 },
///     starts: 4,
///     seed: 1,
/// };
/// let best = search.run(None, |choice: &Choice<Fixed<3, 4>>| {
///     layout.hits = choice.hits.iter().map(|&hit| candidates[hit]).collect();
///     criterion.cost(&layout, &mut memory)
/// }).unwrap();
/// layout.hits = present;
/// assert!(best.cost <= criterion.cost(&layout, &mut memory).unwrap());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Search {
    /// Number of candidates.
    pub candidates: Counts,
    /// Number of them to choose.
    pub wanted: Counts,
    /// Number of random starts.
    pub starts: u32,
    /// Seed of the random starts; equal seeds give equal starts.
    pub seed: u64,
}

/// Why the search found no choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchError {
    /// More sensors are wanted than there are candidates, or than fit into a choice.
    TooManySensors,
    /// More hits are wanted than there are candidates, or than fit into a choice.
    TooManyHits,
    /// None of the choices tried has a cost.
    NothingFound,
}

impl fmt::Display for SearchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooManySensors => "more sensors are wanted than there are places for them",
            Self::TooManyHits => "more hits are wanted than there are DOFs to hit",
            Self::NothingFound => "no choice of these candidates is good enough",
        })
    }
}

impl core::error::Error for SearchError {}

impl Search {
    /// The best choice of all starts, and of `first` when it is given. `cost` returns `None` for a choice
    /// that is not acceptable. An exchange ends when a pass over all members lowers the cost by less than a
    /// ten-thousandth of itself, so it always ends when the cost is bounded below.
    ///
    /// # Errors
    /// When there are too few candidates or too little room, or when no choice has a cost.
    pub fn run<R: Real, C: Capacity>(
        &self,
        first: Option<&Choice<C>>,
        mut cost: impl FnMut(&Choice<C>) -> Option<R>,
    ) -> Result<BestChoice<R, C>, SearchError> {
        let mut best = first.and_then(|first| self.improve(first.clone(), &mut cost));
        for index in 0..self.starts {
            let improved_choice = self.improve(self.start(index)?, &mut cost);
            best = better(best, improved_choice);
        }
        best.ok_or(SearchError::NothingFound)
    }

    /// The random start with this index.
    ///
    /// # Errors
    /// When there are too few candidates or too little room.
    pub fn start<C: Capacity>(&self, index: u32) -> Result<Choice<C>, SearchError> {
        let mut random = SplitMix(self.seed ^ (u64::from(index) << 32));
        let Counts { sensors, hits } = self.wanted;
        Ok(Choice {
            sensors: draw(sensors, self.candidates.sensors, &mut random)
                .ok_or(SearchError::TooManySensors)?,
            hits: draw(hits, self.candidates.hits, &mut random).ok_or(SearchError::TooManyHits)?,
        })
    }

    /// Exchanges members of a choice for candidates until nothing lowers the cost any more. `None` when
    /// neither the choice nor any choice that differs from it by one member has a cost.
    pub fn improve<R: Real, C: Capacity>(
        &self,
        mut choice: Choice<C>,
        mut cost: impl FnMut(&Choice<C>) -> Option<R>,
    ) -> Option<BestChoice<R, C>> {
        let mut least = cost(&choice);
        loop {
            let before = least;
            for member in 0..choice.sensors.len() {
                least = self.exchange(&mut choice, Member::Sensor(member), least, &mut cost);
            }
            for member in 0..choice.hits.len() {
                least = self.exchange(&mut choice, Member::Hit(member), least, &mut cost);
            }
            match (before, least) {
                (_, None) => return None,
                (Some(before), Some(least)) if !falls(before, least) => {
                    return Some(BestChoice { choice, cost: least });
                }
                _ => {}
            }
        }
    }

    /// Replaces one member by the candidate that lowers the cost most, and returns the new cost.
    fn exchange<R: Real, C: Capacity>(
        &self,
        choice: &mut Choice<C>,
        member: Member,
        mut least: Option<R>,
        cost: &mut impl FnMut(&Choice<C>) -> Option<R>,
    ) -> Option<R> {
        let Some(mut best) = choice.get(member) else { return least };
        let candidates = match member {
            Member::Sensor(_) => self.candidates.sensors,
            Member::Hit(_) => self.candidates.hits,
        };
        for candidate in 0..candidates {
            if choice.contains(member, candidate) {
                continue;
            }
            let present = choice.set(member, candidate);
            let new_cost = cost(choice);
            if new_cost.is_some_and(|new_cost| least.is_none_or(|least| new_cost < least)) {
                (best, least) = (candidate, new_cost);
            }
            choice.set(member, present);
        }
        choice.set(member, best);
        least
    }
}

/// One of the sensors or hits of a choice.
#[derive(Clone, Copy)]
enum Member {
    Sensor(usize),
    Hit(usize),
}

impl<C: Capacity> Choice<C> {
    fn get(&self, member: Member) -> Option<usize> {
        match member {
            Member::Sensor(i) => self.sensors.get(i).copied(),
            Member::Hit(j) => self.hits.get(j).copied(),
        }
    }

    /// Puts a candidate in the place of a member and returns the previous one.
    fn set(&mut self, member: Member, candidate: usize) -> usize {
        let place = match member {
            Member::Sensor(i) => self.sensors.get_mut(i),
            Member::Hit(j) => self.hits.get_mut(j),
        };
        place.map_or(candidate, |place| core::mem::replace(place, candidate))
    }

    fn contains(&self, member: Member, candidate: usize) -> bool {
        match member {
            Member::Sensor(_) => self.sensors.contains(&candidate),
            Member::Hit(_) => self.hits.contains(&candidate),
        }
    }
}

fn better<R: Real, C: Capacity>(
    a: Option<BestChoice<R, C>>,
    b: Option<BestChoice<R, C>>,
) -> Option<BestChoice<R, C>> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.cost < a.cost { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// True when the cost falls by more than a ten-thousandth. A smaller gain is no better layout, and rounding
/// in single precision must not keep the exchange running.
fn falls<R: Real>(before: R, after: R) -> bool {
    before - after > before.abs() * R::of(1e-4)
}

/// `count` different numbers below `candidates`; `None` when there are fewer, or no room for them.
fn draw<L: List<usize>>(count: usize, candidates: usize, random: &mut SplitMix) -> Option<L> {
    let mut drawn = L::default();
    if count > candidates {
        return None;
    }
    // Floyd's algorithm (Bentley & Floyd 1987) draws each number at most once, without a list of all.
    for last in candidates - count..candidates {
        let number = random.below(last + 1);
        let number = if drawn.contains(&number) { last } else { number };
        drawn.push(number).ok()?;
    }
    Some(drawn)
}

/// The generator SplitMix64 (Steele, Lea & Flood 2014): small, identical on every machine, and good enough
/// for random starts.
struct SplitMix(u64);

impl SplitMix {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((u128::from(z ^ (z >> 31)) * end as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests;
