//! Diagnosis of a layout.
