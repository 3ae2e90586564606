//! Tests of what crosses the packages of massline. They live in `tests/`; this library is empty.
