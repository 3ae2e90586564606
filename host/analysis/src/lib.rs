//! What the data of a test say of the object, and what a test would say that is not made yet: solvers beyond those of a
//! rig, the agreement of methods, single mistakes, judgement, predictions, Monte Carlo. All in double precision, and as
//! data.
//!
//! | module | subject |
//! | --- | --- |
//! | [`identification`] | the ten properties in double precision, and the nuisance parameters of the fit |
//! | [`suspension`] | suspension modes: the search, the methods that use them, the global fit, how the methods agree |
//! | [`modes_so_far`] | during a campaign: the modes seen so far, and the point that helps most |
//! | [`where_to_hit`] | which hits would show what those of a test do not show |
//! | [`precision`] | during a campaign: how precise the answer would be so far |
//! | [`single_fault`] | which mistake explains data that contradict their budget |
//! | [`score_tests`] | small faults, which the data show before they contradict their budget |
//! | [`plausibility`] | what in a layout or an answer looks like another unit |
//! | [`hits`] | grades the hits of a recording: each on its own, then against the others |
//! | [`judgement`] | whether a result can be used, and why not |
//! | [`limits`] | what limits an answer |
//! | [`calibration`] | what calibration tests say of sensors, hammer and electronics |
//! | [`self_test`] | what a rig reads at rest, and the faults that this shows |
//! | [`design`] | the predicted uncertainty of a layout, and better layouts |
//! | [`monte_carlo`] | many simulated tests, compared with the truth and the Cramér-Rao bound |
//! | [`rig_findings`] | which findings of a rig stand beside the program's own answer |
//! | [`bench_error`] | why a bench cannot be simulated |
//! | [`parallel`] | long computations in pieces, on all cores |
#![forbid(unsafe_code)]

pub mod bench_error;
pub mod calibration;
pub mod design;
pub mod hits;
pub mod identification;
pub mod judgement;
pub mod limits;
pub mod modes_so_far;
pub mod monte_carlo;
pub mod parallel;
pub mod plausibility;
pub mod precision;
pub mod rig_findings;
pub mod score_tests;
pub mod self_test;
pub mod single_fault;
pub mod suspension;
pub mod where_to_hit;

use massline_result::{Error, Result};
