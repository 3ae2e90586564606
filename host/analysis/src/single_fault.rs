//! After a campaign: finds the single mistake that explains data that contradict the error budget, and the
//! mistakes that the data would not reveal.
//!
//! | χ² of the nominal layout | action |
//! | --- | --- |
//! | agrees with the budget | nothing is suspected; with a known mass a common gain is tried |
//! | contradicts the budget | every mistake is fitted, the one with the least χ² is named |
//! | contradicts the stated budget, and no mistake explains it, but the learned budget does | the errors are larger than stated, and by how much is said |
//!
//! A mistake is one of a list (a reversed axis, swapped cables or nodes, a hit at another node), or one of unknown size
//! that is fitted (a gain, a coordinate, a point beside its node). Mistakes whose χ² is hardly larger than the least
//! are named beside it, because the data cannot distinguish them. Each suspect has the ten properties as they would be
//! without the mistake; they are never the answer.

mod judgement;
mod linear_start;
mod search;
mod sized;
mod sized_fit;

use massline_protocol::object::MeasurementResult;
use massline_shared::EstimatedValue;
use massline_shared::capacity::Unbounded;
use massline_shared::identify::maximum_likelihood::BudgetScales;
use massline_shared::identify::single_fault::SingleFault;
use massline_shared::identify::{Consistency, DofMassLines, Estimate};
use massline_shared::layout::{HostLayout, RIG_HITS, RIG_SENSORS};

use crate::identification::{layout_of, lines_of};
use massline_files::archive::ArchivedLayout;
use massline_files::layout_file::{LayoutFile, Reference, nodes_of};
use search::Search;
pub(crate) use sized::used_nodes;
pub use sized::{SizedFault, SizedMistake};
pub(crate) use sized_fit::whole;

/// The nominal test: its layout, the points that could be hit by mistake, and what is expected of the object.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalTest {
    /// The layout.
    pub layout: HostLayout,
    /// Numbers and positions of the nodes, body frame, m.
    pub nodes: Vec<(u16, [f64; 3])>,
    /// Expected values to compare with, where a layout file states some.
    pub reference: Option<Reference>,
    /// What in the layout file looks like values in another unit, in sentences.
    pub unit_suspicions: Vec<String>,
}

impl NominalTest {
    /// The test with all nodes of a layout file.
    pub fn of_file(file: &LayoutFile) -> Self {
        Self {
            layout: file.layout.clone(),
            nodes: file.nodes.iter().map(|node| (node.id, node.position)).collect(),
            reference: file.reference,
            unit_suspicions: file.suspicions(),
        }
    }

    /// The test with the nodes of its sensors and hits only, as a rig stores them.
    pub fn of_layout(layout: HostLayout) -> Self {
        let nodes = nodes_of(&layout);
        Self { layout, nodes, reference: None, unit_suspicions: Vec::new() }
    }

    /// The test of an archive. The positions are those of the archive, whatever its layout file says.
    pub fn of_archive(layout: &ArchivedLayout) -> Self {
        let file = layout.toml.as_deref().and_then(|text| LayoutFile::parse(text, "").ok());
        Self {
            layout: layout.resolved.clone(),
            nodes: layout.nodes.iter().map(|node| (node.id, node.position_m)).collect(),
            reference: file.as_ref().and_then(|file| file.reference),
            unit_suspicions: file.as_ref().map(LayoutFile::suspicions).unwrap_or_default(),
        }
    }

    /// Looks for single mistakes in mass lines.
    pub fn examine(&self, lines: &[DofMassLines<f64, Unbounded>]) -> Examination {
        examine(&self.layout, &self.nodes, lines)
    }

    /// Looks for single mistakes in a rig's result.
    pub fn examine_result(&self, result: &MeasurementResult) -> Examination {
        let layout = layout_of(result, &self.layout);
        examine(&layout, &self.nodes, &lines_of(result, &layout))
    }
}

/// A mistake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// One of a list, without a size.
    Listed(SingleFault<f64>),
    /// One of a size that was fitted.
    Sized(SizedMistake),
}

/// The size of a mistake, fitted to the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultSize {
    /// The readings over their true values.
    Gain(EstimatedValue<f64>),
    /// The true minus the written coordinate, m.
    Displacement(EstimatedValue<f64>),
    /// The true minus the nominal point, body frame, m.
    Displacements([EstimatedValue<f64>; 3]),
}

/// A mistake with the χ² of its fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// The mistake.
    pub mistake: Mistake,
    /// χ² of the fit with this mistake.
    pub consistency: Consistency<f64>,
    /// The ten properties as they would be without the mistake, which is fitted along: never the answer. `None` for a
    /// mistake that is not suspected, and when that fit has no answer.
    pub corrected: Option<Estimate<f64>>,
}

/// What the search for a single mistake has found.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The nominal layout agrees with the data and the stated budget.
    NothingSuspicious,
    /// One mistake explains the data, or several that the data cannot distinguish: the best first.
    Suspected(Vec<Suspect>),
    /// The data contradict the stated budget, no single mistake explains them, and errors of the stated kinds do that
    /// are larger by these factors.
    LargerErrors(BudgetScales<f64>),
    /// The data contradict the budget, and neither a single mistake nor larger errors explain that.
    Unexplained,
}

/// The result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Examination {
    /// χ² of the nominal layout; `None` when that fit has no answer.
    pub plain: Option<Consistency<f64>>,
    /// The outcome.
    pub outcome: Outcome,
    /// The best mistake that is not suspected.
    pub runner_up: Option<Suspect>,
    /// Number of mistakes that were considered.
    pub tested: usize,
    /// Mistakes that were not tried, because hits and sensors do not determine the ten properties with them.
    pub untried: Vec<SingleFault<f64>>,
    /// Mistakes that these data would not reveal, of those that have no size: the smallest of the others never show.
    /// `None` without a search: when the nominal layout has no fit that agrees with the data, and for layouts larger
    /// than a rig's, where the search takes too long.
    pub hidden: Option<Vec<SingleFault<f64>>>,
}

impl Examination {
    /// The suspected mistakes, the best first.
    pub fn suspects(&self) -> &[Suspect] {
        match &self.outcome {
            Outcome::Suspected(suspects) => suspects,
            _ => &[],
        }
    }
}

/// Looks for single mistakes in a test. `nodes` are the points that could have been hit, with their
/// positions in the body frame, m.
pub fn examine(
    layout: &HostLayout,
    nodes: &[(u16, [f64; 3])],
    lines: &[DofMassLines<f64, Unbounded>],
) -> Examination {
    let fits_rig = layout.sensors.len() <= RIG_SENSORS && layout.hits.len() <= RIG_HITS;
    Search::new(layout, nodes, lines).examine(fits_rig)
}
