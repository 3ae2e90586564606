//! The methods that use the suspension modes, on what they share: the motions of the reference point, the modes, and
//! the lines about them.
//!
//! [`SuspensionFit`] is made once from the frequency responses of a test. From it each method answers, and the answers
//! to slightly changed data or a slightly changed layout show how uncertain they are and what they have in common
//! ([`agreement`](super::agreement)).

mod answers;
mod checks;
mod deviations;
mod fit;
mod judgement;
mod known;
mod points;
mod selection;

use crate::body::RigidBody;
use crate::diagnosis::Code;
use crate::modes::{Lines, Modes, OriginResponses};

pub(in crate::identify) use checks::refuse_mixed_modes;
pub use checks::{clear_modes, mixed_mode, mode_findings, truncated_mode, undetermined_property};
pub use deviations::ModeDeviations;
pub use fit::SuspensionFit;
pub use judgement::{add_doubts, judged_estimate, refusal_of_property};
pub use known::KnownProperty;

/// Fewest modes that can determine the ten properties: what is known of fewer leaves one of them open.
pub const FEWEST_MODES: usize = 5;

/// Findings about modes that put a method off which uses their shapes.
pub(super) const DOUBTS_OF_SHAPES: &[Code] = &[
    Code::ModeComplex,
    Code::ModesClose,
    Code::ModeAtBandEdge,
    Code::ModePoorlyExcited,
    Code::ModesNotSeparated,
];

/// Whether a layout with this code rules out a method that uses the modes: they do not need three hits, one that
/// excites every mode is enough.
pub(super) fn is_blocked(code: Code, _prior: bool) -> bool {
    !matches!(
        code,
        Code::FewerThanThreeHits
            | Code::HitsAllParallel
            | Code::HitsConcurrent
            | Code::HitsThroughCentreOfMass
            | Code::TenParametersNotIdentifiable
    )
}

/// What a method uses. All of it is about the reference point and includes the attached bodies.
#[derive(Clone, Copy, Debug)]
pub struct Suspension<'a, R> {
    /// The motions.
    pub responses: &'a OriginResponses<'a, R>,
    /// The modes, at most six.
    pub modes: &'a Modes<R>,
    /// The lines about the modes.
    pub lines: &'a Lines,
    /// Standard deviation of the noise of a reading, (m/s²)/N, of a complex number.
    pub noise: R,
    /// Properties that are known before the test.
    pub known: &'a [KnownProperty<R>],
}

/// What a method answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<R> {
    /// The body with the attached ones; its centre of mass is relative to the reference point.
    pub body: RigidBody<R>,
    /// Condition of the balanced equations.
    pub condition: R,
    /// Root mean square of what the answer leaves of its equations, over that of their right sides, where it is
    /// comparable between methods.
    pub misfit: Option<R>,
}
