//! Chooses sensors and hits among the nodes of a layout file.

use massline_shared::capacity::Unbounded;
use massline_shared::design::{BestChoice, Choice, Counts, Predict, Search, SearchError};
use massline_shared::identify::maximum_likelihood::workspace;
use massline_shared::layout::{Hit, HostLayout, Sensor, TestProfile, extent};

use super::{Assumptions, Candidates, LayoutCriterion, LayoutFindings, PredictedUncertainty};
use crate::parallel::{Interrupted, pieces};
use crate::{Error, Result};
use massline_files::layout_file::LayoutFile;

/// How many sensors or hits are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestedCount {
    /// Exactly those in the file.
    Keep,
    /// The best choice of this many candidates.
    Best(usize),
}

/// Settings of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Sensors.
    pub sensors: RequestedCount,
    /// Hit DOFs.
    pub hits: RequestedCount,
    /// Accepted hits at each DOF.
    pub hits_per_dof: u8,
    /// Noise of one accelerance of one hit, relative to 1/m.
    pub noise: f64,
    /// Number of random starts.
    pub starts: u32,
    /// Equal seeds give equal suggestions.
    pub seed: u64,
}

/// A layout with a smaller predicted uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// The file's layout with the chosen sensors and hits.
    pub layout: HostLayout,
    /// Its predicted uncertainty.
    pub predicted: PredictedUncertainty,
    /// The predicted uncertainty of the file's own layout in the same scale; `None` when it does not
    /// determine the ten properties.
    pub before: Option<PredictedUncertainty>,
    /// Applicable methods and findings of the suggested layout; contains no errors.
    pub findings: LayoutFindings,
    /// The candidates of the search.
    pub candidates: Candidates,
    /// L of the scale of both predictions: [`HostLayout::characteristic_length`] of the suggestion, m.
    pub length: f64,
    /// The criterion of the predictions: body, noise and scale.
    pub criterion: LayoutCriterion,
    /// A sentence that names the body of the criterion.
    pub whose: String,
}

/// The sensors and hits among the nodes of a file with the smallest predicted sum of relative variances.
/// `progress` is called after every completed start. The search uses all cores; the answer does not depend on
/// their number.
///
/// # Errors
/// Exit 2 when there are fewer candidates than wanted, exit 3 when no choice of them determines the ten
/// properties, 130 when it `is_interrupted`.
pub fn suggest(
    file: &LayoutFile,
    assumed: &Assumptions,
    options: &Options,
    is_interrupted: Interrupted<'_>,
    progress: impl FnMut(u64) + Send,
) -> Result<Suggestion> {
    let mut candidates = Candidates::of(file);
    let wanted = Counts {
        sensors: narrow(&mut candidates.sensors, options.sensors, &file.layout.sensors),
        hits: narrow(&mut candidates.hits, options.hits, &file.layout.hits),
    };
    enough(wanted, &candidates)?;
    // The sensors, whose extent is the scale of a layout, are not chosen yet: their candidates stand for them.
    let (_, spread) = extent(candidates.sensors.iter().map(|sensor| sensor.position));
    let criterion = assumed.criterion(&file.layout, spread, options.noise);
    let mut empty = file.layout.clone();
    empty.sensors.clear();
    empty.hits.clear();
    empty.test.hits_per_dof = options.hits_per_dof;
    let job = Job { file, criterion: &criterion, candidates: &candidates, empty: &empty };
    let search = Search {
        candidates: Counts { sensors: candidates.sensors.len(), hits: candidates.hits.len() },
        wanted,
        starts: options.starts,
        seed: options.seed,
    };
    let nothing = || nothing(file.layout.test.profile);
    let layout = job.search(&search, is_interrupted, progress)?.ok_or_else(nothing)?;
    let length = layout.characteristic_length();
    let criterion = assumed.criterion(&layout, length, options.noise);
    let findings = LayoutFindings::new(&layout, criterion.body());
    if !findings.admits_any() {
        return Err(nothing());
    }
    Ok(Suggestion {
        predicted: PredictedUncertainty::of(&criterion, &layout).ok_or_else(nothing)?,
        before: PredictedUncertainty::of(&criterion, &file.layout),
        layout,
        findings,
        candidates,
        length,
        criterion,
        whose: assumed.whose.clone(),
    })
}

/// The number wanted; with [`RequestedCount::Keep`] the present entries become the only candidates.
fn narrow<T: Copy>(candidates: &mut Vec<T>, wanted: RequestedCount, present: &[T]) -> usize {
    match wanted {
        RequestedCount::Best(count) => count,
        RequestedCount::Keep => {
            *candidates = present.to_vec();
            present.len()
        }
    }
}

fn enough(wanted: Counts, candidates: &Candidates) -> Result<()> {
    let few = |kind: &str, wanted: usize, places: usize, how: &str| {
        let text = format!(
            "{wanted} {kind} are wanted and the nodes have places for {places}; add [[node]]s, {how}, \
             or want fewer"
        );
        Err(Error::input("too_few_candidates", text))
    };
    let (sensors, hits) = (candidates.sensors.len(), candidates.hits.len());
    if wanted.sensors > sensors {
        return few("sensors", wanted.sensors, sensors, "allow more (can_carry_sensor)");
    }
    if wanted.hits > hits {
        return few("hit DOFs", wanted.hits, hits, "allow more (can_hit)");
    }
    Ok(())
}

fn nothing(profile: TestProfile) -> Error {
    let why = match profile {
        TestProfile::MassLine => {
            "the lines of the hits must not all meet in one point and the nodes must not all be on one line"
        }
        TestProfile::Suspension => {
            "the hits must move every mode and the nodes must not all be on one line"
        }
    };
    let text = format!(
        "no choice of these nodes determines the ten properties: {why}; add nodes elsewhere, allow more directions \
         (can_hit), or want more sensors and hits"
    );
    Error::undetermined("ten_parameters_not_identifiable", text)
}

/// The inputs that all starts share.
struct Job<'a> {
    file: &'a LayoutFile,
    criterion: &'a LayoutCriterion,
    candidates: &'a Candidates,
    /// The file's layout without sensors and hits.
    empty: &'a HostLayout,
}

impl Job<'_> {
    /// The best layout of all starts; `None` when no choice determines the ten properties.
    fn search(
        &self,
        search: &Search,
        is_interrupted: Interrupted<'_>,
        progress: impl FnMut(u64) + Send,
    ) -> Result<Option<HostLayout>> {
        let first = self.present(search);
        // The file's own layout is an additional start.
        let starts = search.starts + u32::from(first.is_some());
        let start = |index: u32| match index.checked_sub(search.starts) {
            None => search.start(index),
            Some(_) => first.clone().ok_or(SearchError::NothingFound),
        };
        let memory = || vec![0.0; workspace(search.wanted.sensors, search.wanted.hits)];
        let results =
            pieces(starts.into(), None, is_interrupted, progress, memory, |memory, index| {
                let cost =
                    |choice: &Choice<Unbounded>| self.criterion.cost(&self.layout(choice), memory);
                start(index as u32).map(|start| search.improve(start, cost))
            });
        if results.len() < starts as usize {
            let text = format!("interrupted after {} of {starts} starts", results.len());
            return Err(Error::interrupted(text));
        }
        let mut best: Option<BestChoice<f64, Unbounded>> = None;
        for result in results {
            let result = result.map_err(|e| Error::input("too_few_candidates", e.to_string()))?;
            if let Some(improved) = result
                && best.as_ref().is_none_or(|best| improved.cost < best.cost)
            {
                best = Some(improved);
            }
        }
        Ok(best.map(|best| self.layout(&ordered(best.choice))))
    }

    /// The file's own sensors and hits as a choice, if all are candidates and their numbers are those wanted.
    fn present(&self, search: &Search) -> Option<Choice<Unbounded>> {
        let layout = &self.file.layout;
        let Candidates { sensors, hits } = self.candidates;
        let sensor = |own: &Sensor<f64>| sensors.iter().position(|s| s.node == own.node);
        let hit = |own: &Hit<f64>| hits.iter().position(|h| h.dof == own.dof);
        let choice = Choice::<Unbounded> {
            sensors: layout.sensors.iter().map(sensor).collect::<Option<_>>()?,
            hits: layout.hits.iter().map(hit).collect::<Option<_>>()?,
        };
        let counts = Counts { sensors: choice.sensors.len(), hits: choice.hits.len() };
        (counts == search.wanted).then_some(choice)
    }

    fn layout(&self, choice: &Choice<Unbounded>) -> HostLayout {
        let Candidates { sensors, hits } = self.candidates;
        HostLayout {
            sensors: choice.sensors.iter().filter_map(|&i| sensors.get(i).copied()).collect(),
            hits: choice.hits.iter().filter_map(|&j| hits.get(j).copied()).collect(),
            ..self.empty.clone()
        }
    }
}

/// Sorts a choice in the order of the candidates, which is that of the nodes.
fn ordered(mut choice: Choice<Unbounded>) -> Choice<Unbounded> {
    choice.sensors.sort_unstable();
    choice.hits.sort_unstable();
    choice
}
