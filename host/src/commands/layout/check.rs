//! `massline layout check`: the predicted uncertainty of a layout before anything is glued.

use std::path::PathBuf;

use massline_shared::design::DEFAULT_NOISE;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::Sensor;

use super::super::{files, show};
use crate::design::{DesignReport, report};
use crate::error::{Error, Result};
use crate::layout_file::LayoutFile;
use crate::output::Output;
use crate::report::{glued, has_undeclared_mass, message_in};

/// Arguments of `massline layout check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Predicts the standard deviations of the ten properties under the error budget of [uncertainty]
(the Cramér-Rao bound, which maximum likelihood reaches), for the body of [reference], else an
assumed one. % of scale are % of [m, L, L, L, m L² × 6] with L the root mean square distance of
the sensors from their centroid. Exit 3 when no method can determine all ten; a warning when only
the inertia restraint method cannot.

Examples:
  massline layout check frame.toml
  massline layout check frame.toml --json
  massline layout check frame.toml --noise 0.002")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    #[command(flatten)]
    noise: NoiseArgs,
}

/// The noise of a prediction.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct NoiseArgs {
    /// Standard deviation of the noise of one accelerance of one hit, relative to 1/mass.
    #[arg(long, value_name = "PART", default_value_t = DEFAULT_NOISE,
          allow_negative_numbers = true, value_parser = positive)]
    pub noise: f64,
}

fn positive(text: &str) -> std::result::Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    let good = value.is_finite() && value > 0.0 && value <= 1.0;
    good.then_some(value).ok_or_else(|| "give a part above 0 and up to 1, such as 0.005".into())
}

/// Asks for the mass of the sensors, with what to write.
fn ask_for_mass(file: &LayoutFile) -> String {
    let entry =
        |of: &Sensor<f64>| format!("    {{ node = {}, attached_mass_kg = 0.005 }},\n", of.node);
    let entries: String = glued(&file.layout).map(entry).collect();
    format!(
        "no mass of the sensors is declared, so it counts as the object's: weigh a sensor with its glue and the cable \
         up to where it is held, and write it in place of 0.005 (a sensor that is a table already gets the key \
         attached_mass_kg; other bodies are [[attached]]):\nsensors = [\n{entries}]",
    )
}

/// Runs the command.
///
/// # Errors
/// When the file is bad, or the layout cannot determine the ten properties.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = files::layout(&args.layout, output)?;
    let design_report = DesignReport::of(&file, args.noise.noise);
    let found = &design_report.applicability.diagnostics;
    let message_of = |d: &Diagnostic| message_in(d, &file.layout);
    let asked = has_undeclared_mass(&file.layout).then(|| ask_for_mass(&file));
    let notes = asked.iter().cloned().chain(file.suspicion()).chain(file.not_for_a_rig());
    let noise = args.noise.noise;
    let document = report::design_report_json(&design_report, &file, noise, notes.collect());
    if !output.json() {
        // The errors are reported together at the end.
        let lesser: Vec<_> = found.iter().copied().filter(|d| !d.is_error()).collect();
        show::list(&lesser, message_of, output);
        if let Some(found) = file.not_for_a_rig() {
            output.warn(format!("{found}; only `massline solve` takes it"));
        }
        output.note(&design_report.whose);
        asked.iter().for_each(|text| output.note(format!("note: {text}")));
    }
    if design_report.predicted.is_some() {
        return output.answer(&document, |_| {
            format!(
                "{} sensors, {} hits: this layout determines all ten properties\n{}",
                file.layout.sensors.len(),
                file.layout.hits.len(),
                report::design_report_text(&design_report, &file).trim_end(),
            )
        });
    }
    output.explain(&document);
    Err(show::first_error(found, message_of).unwrap_or_else(|| {
        let text = "the layout does not determine the ten properties; spread sensors and hits";
        Error::undetermined("ten_parameters_not_identifiable", text)
    }))
}
