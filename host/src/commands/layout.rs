//! `massline layout`: creates, checks, improves and shows layout files.

mod check;
mod suggest;

use std::path::PathBuf;

use massline_shared::layout::{Hit, HitPolicy, HostLayout, Sensor, TEST_KEYS, TestProfile};

use super::measure::profile;
use crate::Result;
use crate::output::{self, Output};
use crate::support::files;
use crate::support::files::ReplaceArgs;
use massline_files::file;
use massline_files::layout_file::{LayoutFile, SCHEMA, template};
use massline_report::document::{LayoutTemplate, WrittenFile};
use massline_report::document::{ShownHit, ShownLayout, ShownSensor};
use massline_report::words::hash_text;

/// Arguments of `massline layout`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline layout new > frame.toml
  massline layout check frame.toml
  massline layout suggest frame.toml --hits 5
  massline layout show frame.toml --json
  massline layout schema > layout.schema.json")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Print a commented layout to start from.
    #[command(
        after_help = "Examples:\n  massline layout new > frame.toml\n  massline layout new -o frame.toml\n  massline \
                      layout new --profile suspension > wheel.toml"
    )]
    New {
        /// What is measured: mass lines, or the suspension modes in long records.
        #[arg(long, value_name = "PROFILE", default_value = "mass-line", value_parser = profile())]
        profile: TestProfile,
        /// Write to this file instead.
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
        #[command(flatten)]
        replace: ReplaceArgs,
    },
    /// Check whether this layout can determine all ten properties; exit 3 when it cannot.
    Check(check::Args),
    /// Choose better sensors and hits among the nodes of a layout.
    Suggest(suggest::Args),
    /// Print the layout with resolved positions and directions in the body frame.
    #[command(after_help = "Examples:\n  massline layout show frame.toml")]
    Show {
        /// The layout file.
        layout: PathBuf,
    },
    /// Print the JSON schema of layout files, for editors.
    #[command(after_help = "Examples:\n  massline layout schema > layout.schema.json")]
    Schema,
}

/// Runs the command.
///
/// # Errors
/// When the file is bad, or with `check` and `suggest` no layout determines the ten properties.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    match &args.command {
        Command::New { output: None, profile, .. } if output.json() => {
            output.answer(&LayoutTemplate { layout: template(*profile) }, |_| String::new())
        }
        // Unwrapped: a comment that goes on in a line of its own is none.
        Command::New { output: None, profile, .. } => {
            output.verbatim(template(*profile).trim_end())
        }
        Command::New { output: Some(path), replace, profile } => {
            file::write(path, template(*profile).as_bytes(), replace.existing())?;
            output.answer(&WrittenFile { written: path.into() }, |_| {
                format!("{} written", path.display())
            })
        }
        Command::Check(args) => check::run(args, output),
        Command::Suggest(args) => suggest::run(args, output),
        Command::Show { layout } => {
            let file = files::layout(layout, output)?;
            output.answer(&show_json(&file), |_| show_text(&file))
        }
        Command::Schema => output.verbatim(SCHEMA.trim_end()),
    }
}

fn show_json(file: &LayoutFile) -> ShownLayout {
    let layout = &file.layout;
    let test = &layout.test;
    let sensor = |sensor: &Sensor<f64>| ShownSensor {
        node: sensor.node,
        position_m: sensor.position,
        axes: sensor.axes,
        senses_gravity: sensor.senses_gravity,
    };
    let hit = |hit: &Hit<f64>| ShownHit {
        dof: hit.dof.to_string(),
        position_m: hit.position,
        direction: hit.direction,
    };
    let treatments = HitPolicy::CODES.map(|code| (code.name(), test.policy.treatment(code).name()));
    ShownLayout {
        title: file.title.clone(),
        layout_hash: file.hash().and_then(hash_text),
        gravity_m_per_s2: layout.gravity,
        characteristic_length_m: layout.characteristic_length(),
        sensors: layout.sensors.iter().map(sensor).collect(),
        hits: layout.hits.iter().map(hit).collect(),
        test: TEST_KEYS.iter().map(|key| (key.name.to_owned(), test.value(key).into())).collect(),
        uncertainty: file
            .uncertainty
            .sigmas()
            .map(|(key, sigma)| (key.name.to_owned(), sigma))
            .collect(),
        policy: treatments
            .into_iter()
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect(),
    }
}

fn show_text(file: &LayoutFile) -> String {
    let layout: &HostLayout = &file.layout;
    let mut table = output::table();
    table.set_header(["", "node", "position, mm", "direction"]);
    for s in &layout.sensors {
        let axes = s.axes.map(vector).join("  ");
        table.add_row(["sensor".into(), s.node.to_string(), millimeters(s.position), axes]);
    }
    for h in &layout.hits {
        let direction = vector(h.direction);
        table.add_row(["hit".into(), h.dof.to_string(), millimeters(h.position), direction]);
    }
    let gravity = layout.gravity.map_or("not given".into(), vector);
    let band = layout.test.band_hz;
    let band = band.map_or("from the data".into(), |[low, high]| format!("{low} to {high} Hz"));
    format!(
        "{}\n{table}\ngravity {gravity} m/s², L = {:.1} mm, {} hits per DOF, band {band}, hash {}",
        file.title,
        layout.characteristic_length() * 1e3,
        layout.test.hits_per_dof,
        file.hash().and_then(hash_text).unwrap_or_else(|| "none: too large for a rig".into()),
    )
}

fn millimeters(position: [f64; 3]) -> String {
    position.map(|v| format!("{:8.1}", v * 1e3)).join(" ")
}

fn vector(direction: [f64; 3]) -> String {
    format!(
        "({})",
        direction
            .map(|v| format!("{v:.4}").trim_end_matches('0').trim_end_matches('.').to_owned())
            .join(" ")
    )
}
