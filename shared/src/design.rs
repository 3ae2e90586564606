//! Which nodes to put the sensors on and where to hit, chosen among candidates.
//!
//! A *candidate* is a place where a sensor could be glued or a DOF that could be hit; a [`Choice`] is a set
//! of both, and its *cost* is any number to be minimised. [`Search`] finds a choice by exchange. The caller
//! provides the cost: [`cost`] contains the two that theory, section 8, compares.
//!
//! A [`Criterion`] predicts the uncertainty of a layout with its whole error budget; [`parts`] shows which
//! error sources limit it.
//!
//! During a campaign, [`Precision`] compares the intervals so far with the target of the layout, and
//! [`FurtherHitSearch`] finds the hit that would narrow the widest of them most.

pub mod cost;

mod criterion;
mod error_sources;
mod exchange;
mod further_hit;
mod precision;
mod predict;

pub use cost::total;
pub use criterion::{Criterion, DEFAULT_NOISE};
pub use error_sources::{Part, parts};
pub use exchange::{BestChoice, Choice, Counts, Search, SearchError};
pub use further_hit::{FurtherHit, FurtherHitSearch, HitCandidates};
pub use precision::{Precision, Widths};
pub use predict::Predict;
