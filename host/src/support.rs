//! What several commands share.
//!
//! | module | subject |
//! | --- | --- |
//! | [`config`] | the user's configuration file |
//! | [`help`], [`color`], [`version`] | help texts: their width, their colours; the version |
//! | [`number`], [`method`], [`responses`] | arguments: numbers, a method, how a universal file is read |
//! | [`connect`], [`rest`], [`rig_layout`] | a rig: at which port, free of a campaign, fit for a layout |
//! | [`files`], [`archive`] | files that commands read and write; where an archive goes |
//! | [`collected`] | what a campaign reads from the rig for its archive |
//! | [`sources`], [`measured`] | the results that are shown and exported, solved again |
//! | [`show`], [`progress`], [`keyboard`] | how results and progress are printed; single keys |
//! | [`simulated`], [`bench_test`] | a campaign on a simulated rig; a test on a bench |
//! | [`compare`], [`beside_truth`] | results beside the truth of a bench |

pub mod archive;
pub mod bench_test;
pub mod beside_truth;
pub mod collected;
pub mod color;
pub mod compare;
pub mod config;
pub mod connect;
pub mod files;
pub mod help;
pub mod keyboard;
pub mod measured;
pub mod method;
pub mod number;
pub mod progress;
pub mod responses;
pub mod rest;
pub mod rig_layout;
pub mod show;
pub mod simulated;
pub mod sources;
pub mod version;
