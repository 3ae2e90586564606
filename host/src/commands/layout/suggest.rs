//! `massline layout suggest`: better sensors and hits among the nodes of a layout file.

use std::path::{Path, PathBuf};

use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout, RIG_HITS, RIG_SENSORS};
use toml_edit::{Array, DocumentMut, Item, Table, Value};

use super::check::{AssumptionArgs, forecast_of};
use crate::output::Output;
use crate::support::files::{self, ReplaceArgs};
use crate::support::number::seed;
use crate::support::rig_layout::not_for_a_rig;
use crate::support::show;
use crate::{Error, Result};
use massline_analysis::design::{Options, RequestedCount, suggest};
use massline_files::file::{self, ExistingFile};
use massline_files::layout_file::{LayoutFile, MAX_BYTES};
use massline_report::document::LayoutSuggestion;
use massline_report::words::{layout_check as report, message_in};
use massline_result::FilePath;

/// Arguments of `massline layout suggest`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The file may leave out `sensors` and `hits`. Candidates are all its [[node]]s and the directions
of their local axes, except where a node says otherwise: `can_carry_sensor = false`, `can_hit =
[\"+X\", \"-Z\"]`. The suggestion has the smallest sum of the ten variances over the squares of
[m, L, L, L, m L² × 6] under the error budget of [uncertainty], for the body of [reference], else
an assumed one. L is the root mean square distance of the sensors from their centroid: for the
search, of all nodes that can carry one; in the answer, of those suggested, as in `layout check`.
In the suspension profile the uncertainty is that of six modes, as in `layout check`.
Exchange search from the file's own layout and several random ones; equal seeds give equal suggestions.

Examples:
  massline layout suggest frame.toml
  massline layout suggest frame.toml --sensors 3 --hits 5 --write better.toml
  massline layout suggest frame.toml --keep-sensors --hits 6
  massline layout suggest frame.toml --starts 40 --seed 7 --json")]
pub struct Args {
    /// The layout file with the candidate nodes.
    layout: PathBuf,
    /// Sensors wanted; default: as many as the file has, 3 when it has none.
    #[arg(long, value_name = "N",
          allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=HOST_SENSORS as i64))]
    sensors: Option<u8>,
    /// Hit DOFs wanted; default: as many as the file has, 5 when it has none.
    #[arg(long, value_name = "N",
          allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=HOST_HITS as i64))]
    hits: Option<u8>,
    /// Accepted hits at each DOF; default: the number in [test].
    #[arg(long, value_name = "N",
          allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=50))]
    hits_per_dof: Option<u8>,
    /// Keep the sensors of the file, for example if they are glued already: choose only hits.
    #[arg(long, conflicts_with = "sensors")]
    keep_sensors: bool,
    /// Keep the hits of the file: choose only sensors.
    #[arg(long, conflicts_with_all = ["hits", "keep_sensors"])]
    keep_hits: bool,
    #[command(flatten)]
    assumed: AssumptionArgs,
    /// Number of random starts of the search.
    #[arg(long, value_name = "N", default_value_t = 10,
          allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    starts: u32,
    /// Seed of the random starts.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed)]
    seed: u64,
    /// Write the file with the suggested sensors and hits to a new file; everything else, comments included,
    /// stays.
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
}

/// Runs the command.
///
/// # Errors
/// When the file is bad or has too few candidates, no choice determines the ten properties, the new file
/// cannot be written, or on Ctrl-C.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = files::candidates(&args.layout, output)?;
    there_is_something_to_keep(args, &file).map_err(|e| e.within(args.layout.display()))?;
    if let Some(path) = &args.write {
        file::check(path, args.replace.existing())?;
    }
    let assumed = args.assumed.of(&file)?;
    let noise = args.assumed.noise(&file.layout, &assumed)?;
    let options = options(args, &file, noise);
    let bar = output.bar(u64::from(args.starts), "starts");
    let interrupt = output.interrupt();
    let guard = interrupt.guard();
    let is_interrupted = || interrupt.pressed();
    let suggestion =
        suggest(&file, &assumed, &options, &is_interrupted, |done| bar.set_position(done));
    drop(guard);
    bar.finish_and_clear();
    let suggestion = suggestion.map_err(|error| error.within(args.layout.display()))?;
    if let Some(path) = &args.write {
        write(&args.layout, path, &suggestion.layout, args.replace.existing())?;
    }
    let layout = &suggestion.layout;
    let forecast = forecast_of(layout, &assumed, &suggestion.criterion, output)?;
    let message_of = |d: &Diagnostic| message_in(d, layout);
    let diagnostics = &suggestion.findings.diagnostics;
    let notes = file.suspicions().into_iter().chain(not_for_a_rig(&file));
    let document = LayoutSuggestion {
        written: args.write.as_ref().map(FilePath::from),
        ..report::suggestion_json(&suggestion, &options, forecast.as_ref(), notes.collect())
    };
    if !output.json() {
        if let Some(reason) = not_for_a_rig(&file) {
            output.warn(format!("{reason}; only `massline solve` takes it"));
        }
        show::list(diagnostics, message_of, output);
        output.note(&suggestion.whose);
        if layout.sensors.len() > RIG_SENSORS || layout.hits.len() > RIG_HITS {
            output.note(format!(
                "a rig takes {RIG_SENSORS} sensors and {RIG_HITS} hits; only `massline solve` takes more"
            ));
        }
        if let Some(path) = &args.write {
            output.note(format!("{} written", path.display()));
        }
    }
    output.answer(&document, |_| {
        let forecast =
            forecast.map(|forecast| report::forecast_text(&forecast, layout)).unwrap_or_default();
        format!("{}{forecast}{}", report::suggestion_text(&suggestion), report::lines(layout))
    })
}

fn there_is_something_to_keep(args: &Args, file: &LayoutFile) -> Result<()> {
    let layout = &file.layout;
    let nothing = |option: &str, key: &str| {
        let text = format!(
            "{option}: the layout has no `{key}` to keep; write them, or leave {option} out"
        );
        Err(Error::input("nothing_to_keep", text))
    };
    match args {
        _ if args.keep_sensors && layout.sensors.is_empty() => nothing("--keep-sensors", "sensors"),
        _ if args.keep_hits && layout.hits.is_empty() => nothing("--keep-hits", "hits"),
        _ => Ok(()),
    }
}

fn options(args: &Args, file: &LayoutFile, noise: f64) -> Options {
    let wanted = |keep, given: Option<u8>, present: usize, usual| {
        let present = if present == 0 { usual } else { present };
        if keep {
            RequestedCount::Keep
        } else {
            RequestedCount::Best(given.map_or(present, usize::from))
        }
    };
    let layout = &file.layout;
    Options {
        sensors: wanted(args.keep_sensors, args.sensors, layout.sensors.len(), 3),
        hits: wanted(args.keep_hits, args.hits, layout.hits.len(), 5),
        hits_per_dof: args.hits_per_dof.unwrap_or(layout.test.hits_per_dof),
        noise,
        starts: args.starts,
        seed: args.seed,
    }
}

/// Copies a layout file with other sensors and hits.
fn write(from: &Path, to: &Path, layout: &HostLayout, existing: ExistingFile) -> Result<()> {
    let bytes = file::read(from, MAX_BYTES).map_err(|e| file::cannot(to, e))?;
    let text = edited(&String::from_utf8_lossy(&bytes), layout).map_err(|e| file::cannot(to, e))?;
    file::write(to, text.as_bytes(), existing)
}

/// The text of a layout file with these sensors, hits and hits per DOF. Entries that stay keep their
/// settings.
fn edited(text: &str, layout: &HostLayout) -> std::result::Result<String, toml_edit::TomlError> {
    let mut document: DocumentMut = text.parse()?;
    let nodes = layout.sensors.iter().map(|s| Value::from(i64::from(s.node)));
    replace(&mut document, "sensors", "node", nodes.collect());
    let dofs = layout.hits.iter().map(|h| Value::from(h.dof.to_string()));
    replace(&mut document, "hits", "dof", dofs.collect());
    let hits_per_dof = i64::from(layout.test.hits_per_dof);
    let present = document.get("test").and_then(|test| test.get("hits_per_dof")?.as_integer());
    if present.unwrap_or(5) != hits_per_dof {
        let test = document.entry("test").or_insert(Item::Table(Table::new()));
        match test.get_mut("hits_per_dof").and_then(Item::as_value_mut) {
            Some(value) => {
                let decor = value.decor().clone();
                *value = hits_per_dof.into();
                *value.decor_mut() = decor;
            }
            None => test["hits_per_dof"] = toml_edit::value(hits_per_dof),
        }
    }
    Ok(document.to_string())
}

/// Replaces the list under `list`. An old entry that equals a new one, itself or by its member `name`, stays
/// as it is.
fn replace(document: &mut DocumentMut, list: &str, name: &str, new: Vec<Value>) {
    let same = |a: &Value, b: &Value| match (a.as_str(), b.as_str()) {
        (Some(a), Some(b)) => a.trim() == b,
        _ => a.as_integer().is_some() && a.as_integer() == b.as_integer(),
    };
    let old: Vec<Value> = match document.get(list) {
        Some(Item::Value(Value::Array(array))) => array.iter().cloned().collect(),
        Some(Item::ArrayOfTables(tables)) => {
            tables.iter().map(|table| table.clone().into_inline_table().into()).collect()
        }
        _ => Vec::new(),
    };
    let names_the_same = |entry: &Value, value: &Value| {
        let inner = entry.as_inline_table().and_then(|table| table.get(name));
        same(inner.unwrap_or(entry), value)
    };
    let entries = new.into_iter().map(|value| {
        let mut entry =
            old.iter().find(|entry| names_the_same(entry, &value)).cloned().unwrap_or(value);
        entry.decor_mut().clear();
        entry
    });
    let array: Array = entries.collect();
    let mut value = Value::Array(array);
    match document.get_mut(list) {
        Some(Item::Value(present)) => {
            *value.decor_mut() = present.decor().clone();
            *present = value;
        }
        _ => {
            document.insert(list, Item::Value(value));
        }
    }
}

#[cfg(test)]
mod tests;
