//! What is shown of a stored result, read from the flash piece by piece: a whole result does not fit
//! beside what the rig holds already.

use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::diagnostic::DiagnosticList;
use massline_protocol::message::Reason;
use massline_protocol::object::{DofResult, StoredEstimate};
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::{Consistency, symmetric};
use massline_shared::layout::FrfEstimator;
use massline_shared::mass_line::Terms;
use nalgebra::{ComplexField, SMatrix, SVector};
use serde::de::DeserializeOwned;

use crate::store::{Kept, Store};

/// The answer of a result with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Raw [`massline_shared::identify::Method`].
    pub method: u8,
    /// [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz], SI.
    pub properties: [f32; 10],
    /// Their standard deviations.
    pub sigmas: Option<[f32; 10]>,
    /// Principal moments, ascending, kg m²; none of an inertia that is not finite.
    pub moments: Option<[f32; 3]>,
    /// Their standard deviations.
    pub moment_sigmas: Option<[f32; 3]>,
    /// Condition of the balanced regression matrix.
    pub condition: f32,
    /// Whether the data agree with their error budget.
    pub consistency: Option<Consistency<f32>>,
}

/// What is shown of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Number of the result.
    pub number: u32,
    /// Hash of the layout that it was measured with.
    pub layout_hash: u32,
    /// The best answer.
    pub answer: Option<Answer>,
    /// What is to be said about the answer and the campaign.
    pub findings: Diagnostics,
}

/// Pages of an answer before the findings.
pub const ANSWER_PAGES: u8 = 5;

impl Summary {
    /// Pages of this result.
    pub fn pages(&self) -> u8 {
        let answer = if self.answer.is_some() { ANSWER_PAGES } else { 1 };
        answer + self.findings.len() as u8
    }
}

impl From<&StoredEstimate> for Answer {
    fn from(estimate: &StoredEstimate) -> Self {
        let body = RigidBody::from_theta(&SVector::from(estimate.properties));
        let principal = body.principal();
        let covariance: Option<SMatrix<f32, 10, 10>> = symmetric(&estimate.covariance);
        let deviation = |k: usize, c: &SMatrix<f32, 10, 10>| ComplexField::sqrt(c[(k, k)].max(0.0));
        Self {
            method: estimate.method,
            properties: estimate.properties,
            sigmas: covariance.as_ref().map(|c| core::array::from_fn(|k| deviation(k, c))),
            moments: principal.map(|principal| principal.moments.into()),
            moment_sigmas: principal.zip(covariance).map(|(p, c)| p.moment_sigmas(&c).into()),
            condition: estimate.condition,
            consistency: estimate.consistency,
        }
    }
}

impl Answer {
    /// The property that is known least for its size, and its standard deviation over that size: mass,
    /// radius of gyration or mean moment. `None` without standard deviations.
    pub fn least_known(&self) -> Option<(usize, f32)> {
        let [mass, _, _, _, xx, yy, zz, ..] = self.properties;
        let moment = (xx + yy + zz) / 3.0;
        let radius = ComplexField::sqrt((1.5 * moment / mass).max(0.0));
        let mut worst = None;
        for (k, sigma) in self.sigmas?.into_iter().enumerate() {
            let size = [mass, radius, moment][usize::from(k > 0) + usize::from(k > 3)];
            let relative = sigma / size;
            // False for a body without size.
            if relative.is_finite() && worst.is_none_or(|(_, most)| relative > most) {
                worst = Some((k, relative));
            }
        }
        worst
    }
}

/// The start of a stored result, up to the number of its DOFs.
type Head = (u32, u32, u32, heapless::String<16>, FrfEstimator, Terms, bool, u32);

/// The most bytes of a piece: an estimate, or the mass lines of a DOF.
pub(super) const PIECE: usize = 512;

/// Reads what is shown of a result, through `piece`.
///
/// # Errors
/// [`Reason::StoreFailed`] when the flash does not give it back whole.
pub(super) async fn open<F: NorFlash>(
    store: &mut Store<F>,
    kept: &Kept,
    piece: &mut [u8; PIECE],
) -> Result<Summary, Reason> {
    let mut walk = Walk::new();
    while walk.stage != Stage::Done {
        store.read_result(kept, walk.at, piece).await?;
        walk.take(piece)?;
    }
    Ok(walk.summary)
}

/// What comes next in the bytes of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Head,
    /// So many DOFs, then the number of estimates.
    Dofs(u32),
    /// So many estimates, then the findings.
    Estimates(u32),
    Done,
}

/// Walks through the bytes of a result.
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

    /// Takes what stands at the front of the piece, which begins at `at`.
    #[inline(never)]
    fn take(&mut self, piece: &[u8]) -> Result<(), Reason> {
        self.stage = match self.stage {
            Stage::Head => {
                let head: Head = self.decode(piece)?;
                (self.summary.number, self.summary.layout_hash) = (head.0, head.1);
                Stage::Dofs(head.7)
            }
            Stage::Dofs(0) => Stage::Estimates(self.decode(piece)?),
            Stage::Dofs(left) => {
                self.decode::<DofResult>(piece)?;
                Stage::Dofs(left - 1)
            }
            Stage::Estimates(0) | Stage::Done => {
                let DiagnosticList(campaign) = self.decode(piece)?;
                let findings = &mut self.summary.findings;
                // What does not fit beside what is said of the answer is left to the host.
                let room = findings.capacity() - findings.len();
                findings.extend(campaign.into_iter().take(room));
                Stage::Done
            }
            Stage::Estimates(left) => {
                let estimate: StoredEstimate = self.decode(piece)?;
                if self.summary.answer.is_none() {
                    self.summary.answer = Some(Answer::from(&estimate));
                    self.summary.findings = estimate.diagnostics;
                }
                Stage::Estimates(left - 1)
            }
        };
        Ok(())
    }

    fn decode<T: DeserializeOwned>(&mut self, piece: &[u8]) -> Result<T, Reason> {
        let (value, rest) = postcard::take_from_bytes(piece).map_err(|_| Reason::StoreFailed)?;
        self.at += piece.len() - rest.len();
        Ok(value)
    }
}

#[cfg(test)]
mod tests;
