//! The result of a test: the one type of an answer between the solvers and everything that shows it.
//!
//! [`TestResult`] is made where a test is solved, is kept in archives, and is what text, page, pictures, exports and
//! lists read. It is written and read with the same types; [`read()`] names the place of what is wrong in a file.
//!
//! Quantities are in SI units, which the keys state. What is not known is `null`.

mod agreement;
mod calibration_sigma;
mod check;
mod details;
mod error;
mod error_source;
mod estimate;
mod fault;
mod file_path;
mod finding;
mod finding_code;
mod frequency_responses;
mod hit_log;
mod json;
mod measured;
mod modes;
mod named;
mod precision;
mod properties;
mod read;
#[cfg(feature = "schema")]
mod schema;
mod test_result;
mod verdict;

pub use agreement::{Agreement, CombinedAnswer, Doubt, MethodSigma, Pair};
pub use calibration_sigma::CalibrationSigma;
pub use check::Contradiction;
pub use details::{
    BudgetTerm, Details, ErrorBudget, HitDetails, Influence, LearnedFrom, SensorDetails,
};
pub use error::{Error, ErrorCode, ErrorKind, Result};
pub use error_source::ErrorSource;
pub use estimate::{ChiSquared, Estimate, LearnedBudget, PrincipalMoments};
pub use fault::{
    ErrorsOverStated, Fault, FaultOutcome, FaultUnit, ScoreTest, SingleFaults, Suspect,
};
pub use file_path::FilePath;
pub use finding::{Finding, Refusal, UnseenError, VerdictReason};
pub use finding_code::FindingCode;
pub use frequency_responses::{FrequencyResponsesRead, UnitsRead};
pub use hit_log::{HitVerdict, LoggedHit};
pub use json::{Json, JsonError};
pub use measured::{GlobalFit, MassLine, MeasuredDof};
pub use modes::{BetterHit, Indicator, Mode, Modes, ModesSoFar, NextPoint, Order, Pole, SeenMode};
pub use named::NamedValue;
pub use precision::{FurtherHit, HalfWidths, Precision, WorstProperty};
pub use properties::{Properties, Spread};
pub use read::{ADVICE, Document, ReadError, read};
#[cfg(feature = "schema")]
pub use schema::generate_schema;
pub use test_result::{RigAnswer, SCHEMA_VERSION, SolvedBy, TestResult};
pub use verdict::Verdict;
