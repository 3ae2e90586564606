//! The record of one hit.
