//! The part of a stored result that is shown, read from the flash piece by piece, because there is no
//! memory for a whole result.
//!
//! A result of the suspension profile has more pages than there is memory for: what one of them shows is read when it is
//! turned to.

use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::lines::take_head;
use massline_protocol::modes::{StoredAgreement, StoredMode, StoredRefusal};
use massline_protocol::object::{DofResult, ResultHead, StoredEstimate};
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::{Estimate, SUSPENSION_METHODS};
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
    /// Bit mask of the DOFs with lines, by their index in the layout; 0 in the mass line profile.
    pub dofs_with_lines: u16,
    /// Number of estimates.
    pub estimates: u8,
    /// Number of suspension modes.
    pub modes: u8,
    /// Number of methods without an answer.
    pub refusals: u8,
    /// True when methods were compared.
    pub compared: bool,
    /// What the page that is open shows besides.
    pub detail: Detail,
    /// Diagnostics of the estimate and of the campaign.
    pub findings: Diagnostics,
}

/// A page of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// There is no answer.
    NoAnswer,
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
    /// A suspension mode.
    Mode(u8),
    /// A property by every method, as an index in `theta`.
    Property(u8),
    /// How the methods agree.
    Agreement,
    /// A method without an answer.
    Refusal(u8),
    /// A diagnostic.
    Finding(u8),
}

impl Page {
    /// True when its [`Detail`] has to be read.
    pub fn has_detail(self) -> bool {
        matches!(self, Self::Mode(_) | Self::Property(_) | Self::Agreement | Self::Refusal(_))
    }
}

/// What a page shows that is not part of every summary.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// Nothing.
    Nothing,
    /// The mode of [`Page::Mode`].
    Mode(StoredMode),
    /// The property of [`Page::Property`].
    Property {
        /// Number of each method with its value and standard deviation, SI.
        each: Vec<(u8, Spread), SUSPENSION_METHODS>,
        /// The combined estimate.
        combined: Option<Spread>,
    },
    /// The agreement of [`Page::Agreement`].
    Agreement(StoredAgreement),
    /// The method of [`Page::Refusal`], and why it has no answer.
    Refusal(StoredRefusal),
}

/// A value and its standard deviation, if known.
pub type Spread = (f32, Option<f32>);

/// Pages of an answer by mass lines, in their order.
const OF_MASS_LINES: &[Page] =
    &[Page::Mass, Page::Moments, Page::Products, Page::Principal, Page::Limits, Page::Budget];
/// Pages of an answer by the suspension modes: its methods learn no error budget.
const OF_MODES: &[Page] =
    &[Page::Mass, Page::Moments, Page::Products, Page::Principal, Page::Limits];
/// Number of properties, each of which has a page by all methods.
const PROPERTIES: u8 = 10;

impl Summary {
    /// Number of pages of this result.
    pub fn pages(&self) -> u8 {
        self.parts().iter().map(|(pages, _)| pages).sum()
    }

    /// The page at this place.
    pub fn page(&self, place: u8) -> Page {
        let mut place = place;
        for (pages, page) in self.parts() {
            match place.checked_sub(pages) {
                None => return page(self, place),
                Some(rest) => place = rest,
            }
        }
        Page::Finding(place)
    }

    /// The parts of a result in their order: the number of pages of each, and its page at a place.
    fn parts(&self) -> [(u8, fn(&Self, u8) -> Page); 6] {
        let compares = self.estimates > 1 && self.is_of_modes();
        [
            (self.of_answer().len() as u8, |of, k| {
                of.of_answer().get(usize::from(k)).copied().unwrap_or(Page::NoAnswer)
            }),
            (self.modes, |_, k| Page::Mode(k)),
            (if compares { PROPERTIES } else { 0 }, |_, k| Page::Property(k)),
            (self.compared.into(), |_, _| Page::Agreement),
            (self.refusals, |_, k| Page::Refusal(k)),
            (self.findings.len() as u8, |_, k| Page::Finding(k)),
        ]
    }

    fn of_answer(&self) -> &'static [Page] {
        match self.answer {
            None => &[Page::NoAnswer],
            Some(_) if self.is_of_modes() => OF_MODES,
            Some(_) => OF_MASS_LINES,
        }
    }

    fn is_of_modes(&self) -> bool {
        self.dofs_with_lines != 0
    }
}

/// Most bytes of a piece: an estimate, or the mass lines of a DOF.
pub(super) const PIECE: usize = 512;

/// Reads the summary of a result with what this page shows; `piece` is a buffer.
///
/// # Errors
/// [`StoreError::Failed`] when a part of the result cannot be read or decoded.
pub(super) async fn open<F: NorFlash>(
    store: &mut Store<F>,
    stored: &ResultHandle,
    piece: &mut [u8; PIECE],
    page: Page,
) -> Result<Summary, StoreError> {
    let mut walk = Walk::new(page);
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
    /// This many estimates, then the number of modes.
    Estimates(u32),
    /// This many modes, then the number of refusals.
    Modes(u32),
    /// This many refusals, then the agreement.
    Refusals(u32),
    /// The diagnostics of the campaign.
    Campaign,
    Done,
}

/// Parses the bytes of a result item by item. Every item fits a piece.
struct Walk {
    stage: Stage,
    /// Offset of the next item.
    at: usize,
    /// The page whose detail is wanted.
    page: Page,
    summary: Summary,
}

impl Walk {
    fn new(page: Page) -> Self {
        let detail = match page {
            Page::Property(_) => Detail::Property { each: Vec::new(), combined: None },
            _ => Detail::Nothing,
        };
        let summary = Summary {
            number: 0,
            layout_hash: 0,
            answer: None,
            dofs_with_lines: 0,
            estimates: 0,
            modes: 0,
            refusals: 0,
            compared: false,
            detail,
            findings: Diagnostics::new(),
        };
        Self { stage: Stage::Head, at: 0, page, summary }
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
                self.passed(piece, DofResult::take(piece).map(|(_, rest)| rest))?;
                Stage::Dofs(left - 1)
            }
            Stage::Lines(0) => Stage::Estimates(self.decode(piece)?),
            Stage::Lines(left) => {
                let (head, rest) = take_head(piece).ok_or(StoreError::Failed)?;
                self.summary.dofs_with_lines |= 1_u16.checked_shl(head.index.into()).unwrap_or(0);
                self.passed(piece, Some(rest))?;
                Stage::Lines(left - 1)
            }
            Stage::Estimates(0) => Stage::Modes(self.decode(piece)?),
            Stage::Estimates(left) => {
                let estimate: StoredEstimate = self.decode(piece)?;
                self.take_estimate(estimate);
                Stage::Estimates(left - 1)
            }
            Stage::Modes(0) => Stage::Refusals(self.decode(piece)?),
            Stage::Modes(left) => {
                let mode: StoredMode = self.decode(piece)?;
                if self.page == Page::Mode(self.summary.modes) {
                    self.summary.detail = Detail::Mode(mode);
                }
                self.summary.modes = self.summary.modes.saturating_add(1);
                Stage::Modes(left - 1)
            }
            Stage::Refusals(0) => {
                let agreement: Option<StoredAgreement> = self.decode(piece)?;
                self.take_agreement(agreement);
                Stage::Campaign
            }
            Stage::Refusals(left) => {
                let refusal: StoredRefusal = self.decode(piece)?;
                if self.page == Page::Refusal(self.summary.refusals) {
                    self.summary.detail = Detail::Refusal(refusal);
                }
                self.summary.refusals = self.summary.refusals.saturating_add(1);
                Stage::Refusals(left - 1)
            }
            Stage::Campaign | Stage::Done => {
                let DiagnosticList(campaign) = self.decode(piece)?;
                let findings = &mut self.summary.findings;
                // The campaign's diagnostics that do not fit after those of the estimate are shown by the
                // host only.
                let room = findings.capacity() - findings.len();
                findings.extend(campaign.into_iter().take(room));
                Stage::Done
            }
        };
        Ok(())
    }

    fn take_estimate(&mut self, estimate: StoredEstimate) {
        self.summary.estimates = self.summary.estimates.saturating_add(1);
        let known = estimate.estimate();
        if let (Page::Property(k), Detail::Property { each, .. }) =
            (self.page, &mut self.summary.detail)
            && let Some(value) = estimate.properties.get(usize::from(k))
        {
            let sigma = known.as_ref().and_then(Estimate::sigma);
            let sigma = sigma.and_then(|sigma| sigma.get(usize::from(k)).copied());
            // A rig has no more methods.
            let _ = each.push((estimate.method, (*value, sigma)));
        }
        if self.summary.answer.is_none() {
            self.summary.answer = known;
            self.summary.findings = estimate.diagnostics;
        }
    }

    fn take_agreement(&mut self, agreement: Option<StoredAgreement>) {
        self.summary.compared = agreement.is_some();
        match (self.page, &mut self.summary.detail, agreement) {
            (Page::Property(k), Detail::Property { combined, .. }, Some(agreement)) => {
                let StoredAgreement { properties, sigma, .. } = &agreement;
                let k = usize::from(k);
                *combined = properties.get(k).map(|value| (*value, sigma.get(k).copied()));
            }
            (Page::Agreement, detail, Some(agreement)) => *detail = Detail::Agreement(agreement),
            _ => {}
        }
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
