//! Why a bench cannot be simulated, as an error of a command.

use massline_physics::BenchError;

use crate::Error;

/// A bench that is not there, that cannot be read, or that does not fit the layout: exit 2.
pub fn bench_error(error: impl Into<BenchError>) -> Error {
    let error = error.into();
    let code = match &error {
        BenchError::UnknownName { .. } => "unknown_bench",
        BenchError::File(_) => "malformed_bench",
        _ => "bench_does_not_fit",
    };
    Error::input(code, error.to_string())
}
