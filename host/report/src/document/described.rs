//! The documents that have a schema: what other programs read.

/// A document that has a schema.
pub struct DocumentKind {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// The commands that print it.
    pub commands: &'static [&'static str],
    /// Its schema, draft 2020-12.
    pub schema: &'static str,
}

impl DocumentKind {
    /// Every document that has a schema.
    pub const ALL: [Self; 8] = [
        Self {
            name: "result",
            summary: "the result of a test",
            commands: &["measure", "solve", "results get", "replay"],
            schema: include_str!("../../../schemas/result.schema.json"),
        },
        Self {
            name: "simulation",
            summary: "a simulated test beside the truth",
            commands: &["simulate"],
            schema: include_str!("../../../schemas/simulation.schema.json"),
        },
        Self {
            name: "simulated-runs",
            summary: "many simulated tests of a layout, from --runs",
            commands: &["simulate"],
            schema: include_str!("../../../schemas/simulated-runs.schema.json"),
        },
        Self {
            name: "layout",
            summary: "a layout with resolved positions and directions",
            commands: &["layout show"],
            schema: include_str!("../../../schemas/layout.schema.json"),
        },
        Self {
            name: "layout-check",
            summary: "how accurate a layout will be, and what limits it",
            commands: &["layout check"],
            schema: include_str!("../../../schemas/layout-check.schema.json"),
        },
        Self {
            name: "device",
            summary: "who a rig is and what it is doing",
            commands: &["device identify"],
            schema: include_str!("../../../schemas/device.schema.json"),
        },
        Self {
            name: "calibration",
            summary: "the calibration of a rig",
            commands: &["calibrate show", "calibrate push"],
            schema: include_str!("../../../schemas/calibration.schema.json"),
        },
        Self {
            name: "error",
            summary: "why a command has failed",
            commands: &[],
            schema: include_str!("../../../schemas/error.schema.json"),
        },
    ];
}
