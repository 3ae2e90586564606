//! The part of a stored result that is shown, read from the flash piece by piece, because there is no
//! memory for a whole result.

use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::lines_head::LinesHead;
use massline_protocol::object::{DofResult, ResultHead, StoredEstimate};
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::Estimate;
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
    /// Diagnostics of the estimate and of the campaign.
    pub findings: Diagnostics,
}

/// Number of pages of an estimate, before the diagnostics.
pub const ANSWER_PAGES: u8 = 6;

impl Summary {
    /// Number of pages of this result.
    pub fn pages(&self) -> u8 {
        let answer = if self.answer.is_some() { ANSWER_PAGES } else { 1 };
        answer + self.findings.len() as u8
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
    /// This many estimates, then the diagnostics.
    Estimates(u32),
    Done,
}

/// Parses the bytes of a result step by step.
struct Walk {
    stage: Stage,
    at: usize,
    summary: Summary,
}

impl Walk {
    fn new() -> Self {
        let findings = Diagnostics::new();
        let summary = Summary { number: 0, layout_hash: 0, answer: None, findings };
        Self { stage: Stage::Head, at: 0, summary }
    }

    /// Parses the item at the front of the piece, which begins at offset `at`.
    // Never inlined: this saves 0.5 KB of the firmware's deepest stack.
    #[inline(never)]
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
                self.decode::<DofResult>(piece)?;
                Stage::Dofs(left - 1)
            }
            Stage::Lines(0) => Stage::Estimates(self.decode(piece)?),
            Stage::Lines(left) => {
                self.decode::<LinesHead>(piece)?;
                Stage::Lines(left - 1)
            }
            Stage::Estimates(0) | Stage::Done => {
                let DiagnosticList(campaign) = self.decode(piece)?;
                let findings = &mut self.summary.findings;
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
        self.at += piece.len() - rest.len();
        Ok(value)
    }
}

#[cfg(test)]
mod tests;
