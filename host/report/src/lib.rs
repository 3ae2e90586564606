//! How a result is shown: sentences, text for terminals, JSON documents, pictures, pages, and files of other programs.
//! Nothing here computes a property, and only here are sentences made of findings.
//!
//! | module | subject |
//! | --- | --- |
//! | [`solution`] | what the program finds from the data of a test, and the result that it makes of it |
//! | [`words`] | diagnostics, verdicts and results in words |
//! | [`document`] | the JSON documents of all commands, and their schemas |
//! | [`self_test`] | what a rig reads at rest |
//! | [`calibration`] | calibrations, and what calibration tests find |
//! | [`recorded_hits`] | the graded hits of a recording |
//! | [`result_file`] | one result with its test: what pictures and pages are made of |
//! | [`picture`] | pictures |
//! | [`page`] | results as a page for people |
//! | [`export`] | results as files of other programs: URDF, Nastran, NumPy, … |
//! | [`table`], [`tone`], [`wrap`] | tables, colours and lines of a terminal |
//! | [`typography`] | signs of print in text that people read |
//! | [`projection`], [`readings`] | where a picture looks from; records in physical units |
#![forbid(unsafe_code)]

pub mod calibration;
pub mod document;
pub mod export;
pub mod page;
pub mod picture;
pub mod projection;
pub mod readings;
pub mod recorded_hits;
pub mod result_file;
pub mod self_test;
pub mod solution;
pub mod table;
pub mod tone;
pub mod typography;
pub mod words;
pub mod wrap;
