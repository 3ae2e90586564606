//! When a record starts.
