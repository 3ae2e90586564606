//! The part of a stored result that is shown, read from the flash piece by piece, because there is no
//! memory for a whole result.

use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::lines::take_head;
use massline_protocol::object::{DofResult, ResultHead, StoredEstimate};
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::{Estimate, MASS_LINE_METHODS, Verdict};
use serde::de::DeserializeOwned;

use crate::store::{ResultHandle, Store, StoreError};

/// The part of a result that is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Number of the result.
    pub number: u32,
    /// Hash of the layout that it was measured with.
    pub layout_hash: u32,
    /// The best estimate.
    pub answer: Option<Estimate<f32>>,
    /// Whether it can be used.
    pub verdict: Option<Verdict>,
    /// Number of places whose lines are stored; 0 in the mass line profile.
    pub places_with_lines: u8,
    /// Diagnostics of the estimate and of the campaign.
    pub findings: Diagnostics,
}

/// A page of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// There is no answer.
    NoAnswer,
    /// Lines are stored, which the program solves.
    Lines,
    /// Mass and centre of mass.
    Mass,
    /// Moments of inertia.
    Moments,
    /// Products of inertia.
    Products,
    /// Principal moments.
    Principal,
    /// What limits the accuracy.
    Limits,
    /// What the data have taught about the error budget.
    Budget,
    /// A diagnostic.
    Finding(u8),
}

/// Pages of an answer, in their order.
const OF_ANSWER: &[Page] =
    &[Page::Mass, Page::Moments, Page::Products, Page::Principal, Page::Limits, Page::Budget];

impl Summary {
    /// Number of pages of this result.
    pub fn pages(&self) -> u8 {
        (self.of_answer().len() + self.findings.len()) as u8
    }

    /// The page at this place.
    pub fn page(&self, place: u8) -> Page {
        let of_answer = self.of_answer();
        match of_answer.get(usize::from(place)) {
            Some(page) => *page,
            None => Page::Finding(place - of_answer.len() as u8),
        }
    }

    fn of_answer(&self) -> &'static [Page] {
        match self.answer {
            Some(_) => OF_ANSWER,
            None if self.places_with_lines > 0 => &[Page::Lines],
            None => &[Page::NoAnswer],
        }
    }
}

/// Most bytes of a piece: an estimate, or the mass lines of a DOF.
pub(super) const PIECE: usize = 512;

/// Reads the summary of a result; `piece` is a buffer.
///
/// # Errors
/// [`StoreError::Failed`] when a part of the result cannot be read or decoded.
pub(super) async fn open<F: NorFlash>(
    store: &mut Store<F>,
    stored: &ResultHandle,
    piece: &mut [u8; PIECE],
) -> Result<Summary, StoreError> {
    let mut walk = Walk::new();
    while walk.stage != Stage::Done {
        store.read_result(stored, walk.at, piece).await?;
        walk.take(piece)?;
    }
    Ok(walk.summary)
}

/// The next item in the bytes of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Head,
    /// The number of DOFs.
    Counted,
    /// This many DOFs, then the number of DOFs with lines.
    Dofs(u32),
    /// This many DOFs with lines, then the number of estimates.
    Lines(u32),
    /// This many estimates, then the diagnostics of the campaign.
    Estimates(u32),
    Done,
}

/// Parses the bytes of a result item by item. Every item fits a piece.
struct Walk {
    stage: Stage,
    /// Offset of the next item.
    at: usize,
    /// Number of estimates.
    estimates: u32,
    summary: Summary,
}

impl Walk {
    fn new() -> Self {
        let summary = Summary {
            number: 0,
            layout_hash: 0,
            answer: None,
            verdict: None,
            places_with_lines: 0,
            findings: Diagnostics::new(),
        };
        Self { stage: Stage::Head, at: 0, estimates: 0, summary }
    }

    /// Parses the item at the front of the piece, which begins at offset `at`.
    fn take(&mut self, piece: &[u8]) -> Result<(), StoreError> {
        self.stage = match self.stage {
            Stage::Head => {
                let head: ResultHead = self.decode(piece)?;
                (self.summary.number, self.summary.layout_hash) = (head.number, head.layout_hash);
                Stage::Counted
            }
            Stage::Counted => Stage::Dofs(self.decode(piece)?),
            Stage::Dofs(0) => Stage::Lines(self.decode(piece)?),
            Stage::Dofs(left) => {
                self.passed(piece, DofResult::take(piece).map(|(_, rest)| rest))?;
                Stage::Dofs(left - 1)
            }
            Stage::Lines(0) => {
                self.estimates = self.decode(piece)?;
                Stage::Estimates(self.estimates)
            }
            Stage::Lines(left) => {
                let (_, rest) = take_head(piece).ok_or(StoreError::Failed)?;
                self.summary.places_with_lines = self.summary.places_with_lines.saturating_add(1);
                self.passed(piece, Some(rest))?;
                Stage::Lines(left - 1)
            }
            Stage::Estimates(0) | Stage::Done => {
                let DiagnosticList(campaign) = self.decode(piece)?;
                let is_complete = self.estimates as usize == MASS_LINE_METHODS;
                let Summary { answer, verdict, findings, .. } = &mut self.summary;
                *verdict =
                    answer.as_ref().map(|answer| Verdict::on(answer, &campaign, is_complete));
                // The campaign's diagnostics that do not fit after those of the estimate are shown by the
                // host only.
                let room = findings.capacity() - findings.len();
                findings.extend(campaign.into_iter().take(room));
                Stage::Done
            }
            Stage::Estimates(left) => {
                let estimate: StoredEstimate = self.decode(piece)?;
                if self.summary.answer.is_none() {
                    self.summary.answer = estimate.estimate();
                    self.summary.findings = estimate.diagnostics;
                }
                Stage::Estimates(left - 1)
            }
        };
        Ok(())
    }

    fn decode<T: DeserializeOwned>(&mut self, piece: &[u8]) -> Result<T, StoreError> {
        let (value, rest) = postcard::take_from_bytes(piece).map_err(|_| StoreError::Failed)?;
        self.passed(piece, Some(rest))?;
        Ok(value)
    }

    /// Passes over an item of the piece, after which this is left.
    fn passed(&mut self, piece: &[u8], rest: Option<&[u8]>) -> Result<(), StoreError> {
        self.at += piece.len() - rest.ok_or(StoreError::Failed)?.len();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
