//! `massline layout check`: the predicted uncertainty of a layout before anything is glued.

use std::path::PathBuf;

use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::{HostLayout, Sensor, TestProfile};

use crate::output::Output;
use crate::support::bench_test::open_bench;
use crate::support::files;
use crate::support::number::positive;
use crate::support::rig_layout::not_for_a_rig;
use crate::support::show;
use crate::{Error, Result};
use massline_analysis::design::{
    Assumptions, DesignReport, Forecast, LayoutCriterion, MassRange, forecast,
};
use massline_files::layout_file::LayoutFile;
use massline_report::words::layout_check as report;
use massline_report::words::{glued, has_undeclared_mass, mass_warning, masses_text, message_in};

/// Arguments of `massline layout check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Predicts the standard deviations of the ten properties under the error budget of [uncertainty]
(the Cramér-Rao bound, which maximum likelihood reaches), for the body of [reference], else an
assumed one. % of scale are % of [m, L, L, L, m L² × 6] with L the root mean square distance of
the sensors from their centroid. Exit 3 when no method can determine all ten; a warning when only
the inertia restraint method cannot.

In the suspension profile the bound is that of six modes. One test is also computed by formula and
solved: what each method would answer, and which hit shows which mode. Object and suspension are
assumed, or those of --bench.

It also states the masses that the sensors (±16 g) and the hammer can measure with this layout, and
warns when the mass of [reference], [prior] or --bench is outside of them.

Examples:
  massline layout check frame.toml
  massline layout check frame.toml --json
  massline layout check frame.toml --noise 0.002
  massline layout check wheel.toml --bench wheel")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    #[command(flatten)]
    assumed: AssumptionArgs,
}

/// What a prediction assumes.
#[derive(Clone, Debug, clap::Args)]
pub struct AssumptionArgs {
    /// Standard deviation of the noise of one accelerance of one hit, relative to 1/mass, up to 1 for mass lines;
    /// default: 0.005, in the suspension profile what sensors and converter leave after the window and the impulses of
    /// [test].
    #[arg(long, value_name = "PART", allow_negative_numbers = true, value_parser = positive)]
    noise: Option<f64>,
    /// Predict for the object of this bench, and in the suspension profile as it hangs there: a bundled bench or a TOML
    /// file; default: the body of [reference] or an assumed one, and assumed modes.
    #[arg(long, value_name = "NAME|FILE")]
    bench: Option<String>,
}

impl AssumptionArgs {
    /// What is assumed for the tests of a file.
    ///
    /// # Errors
    /// When the bench is bad.
    pub fn of(&self, file: &LayoutFile) -> Result<Assumptions> {
        let bench = self.bench.as_deref().map(open_bench).transpose()?;
        Assumptions::of(file, bench.as_ref())
    }

    /// The mass of the object, kg, where the file or a bench states one.
    fn mass(&self, file: &LayoutFile, assumed: &Assumptions) -> Option<f64> {
        let is_prior = file.layout.priors.iter().any(|prior| prior.property == 0);
        let has_reference = file.reference.is_some_and(|body| body.mass_kg.is_some());
        (self.bench.is_some() || is_prior || has_reference).then_some(assumed.body.mass)
    }

    /// The noise for the tests of a layout, relative to 1/mass.
    ///
    /// # Errors
    /// When mass lines would drown in it. Suspension modes rise above it by as much as their damping is small.
    pub fn noise(&self, layout: &HostLayout, assumed: &Assumptions) -> Result<f64> {
        match self.noise {
            None => Ok(assumed.usual_noise(layout)),
            Some(noise) if noise > 1.0 && layout.test.profile == TestProfile::MassLine => {
                let text =
                    format!("--noise {noise}: of mass lines, give a part up to 1, such as 0.005");
                Err(Error::input("usage", text))
            }
            Some(noise) => Ok(noise),
        }
    }
}

/// What each method would answer in the suspension profile.
///
/// # Errors
/// When the object cannot hang as described.
pub fn forecast_of(
    layout: &HostLayout,
    assumed: &Assumptions,
    criterion: &LayoutCriterion,
    output: &Output,
) -> Result<Option<Forecast>> {
    let Some(hanging) = &assumed.hanging else { return Ok(None) };
    let bar = output.bar(0, "changes");
    let forecast = forecast(layout, hanging, criterion, |done, total| {
        bar.set_length(total.into());
        bar.set_position(done.into());
    });
    bar.finish_and_clear();
    forecast.map(Some)
}

/// Asks for the mass of the sensors, with what to write.
fn ask_for_mass(file: &LayoutFile) -> String {
    let entry = |sensor: &Sensor<f64>| {
        format!("    {{ node = {}, attached_mass_kg = 0.005 }},\n", sensor.node)
    };
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
    let assumed = args.assumed.of(&file)?;
    let noise = args.assumed.noise(&file.layout, &assumed)?;
    let design_report = DesignReport::of(&file, &assumed, noise);
    let forecast = forecast_of(&file.layout, &assumed, &design_report.criterion, output)?;
    let is_determined = design_report.predicted.is_some();
    let is_possible = is_determined && forecast.as_ref().is_none_or(Forecast::has_answer);
    let diagnostics = &design_report.findings.diagnostics;
    let message_of = |d: &Diagnostic| message_in(d, &file.layout);
    let asked = has_undeclared_mass(&file.layout).then(|| ask_for_mass(&file));
    let masses = MassRange::of(&file.layout, &assumed.body);
    let outside =
        args.assumed.mass(&file, &assumed).and_then(|mass| mass_warning(masses.as_ref()?, mass));
    let notes = asked.iter().cloned().chain(file.suspicions()).chain(not_for_a_rig(&file));
    let notes = notes.chain(outside.clone()).collect();
    let document =
        report::design_report_json(&design_report, &file, noise, forecast.as_ref(), notes);
    if !output.json() {
        // The errors are reported together at the end.
        let lesser: Vec<_> = diagnostics.iter().copied().filter(|d| !d.is_error()).collect();
        show::list(&lesser, message_of, output);
        if let Some(reason) = not_for_a_rig(&file) {
            output.warn(format!("{reason}; only `massline solve` takes it"));
        }
        outside.iter().for_each(|text| output.warn(text));
        output.note(&design_report.whose);
        asked.iter().for_each(|text| output.note(format!("note: {text}")));
    }
    if is_possible {
        let forecast = forecast.map(|forecast| report::forecast_text(&forecast, &file.layout));
        return output.answer(&document, |_| {
            format!(
                "{} sensors, {} hits: this layout determines all ten properties\n{}\n{}\n{}",
                file.layout.sensors.len(),
                file.layout.hits.len(),
                report::design_report_text(&design_report, &file).trim_end(),
                masses.map_or_else(String::new, |masses| masses_text(&masses)),
                forecast.unwrap_or_default(),
            )
            .trim_end()
            .to_owned()
        });
    }
    output.explain(&document);
    Err(show::first_error(diagnostics, message_of).unwrap_or_else(|| {
        let refusal = forecast.as_ref().and_then(Forecast::first_reason);
        if let Some((method, reason)) = refusal.filter(|_| is_determined) {
            let text = format!(
                "none of the methods of the suspension profile would answer; {} says: {}",
                method.name(),
                message_of(&reason)
            );
            return Error::undetermined(reason.code.name(), text);
        }
        let unmoved =
            forecast.map(|forecast| report::unmoved(&forecast, &file.layout)).unwrap_or_default();
        let text = "the layout does not determine the ten properties; spread sensors and hits";
        let lines: Vec<&str> = std::iter::once(text).chain(unmoved.lines()).collect();
        Error::undetermined("ten_parameters_not_identifiable", lines.join("; "))
    }))
}
