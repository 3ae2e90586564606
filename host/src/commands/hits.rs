//! `massline hits`: grades recorded hammer data.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use massline_shared::diagnosis::Code;
use massline_shared::layout::{HitPolicy, HitTreatment, TestSettings};
use serde_json::json;

use crate::output::Output;
use crate::support::number::{not_negative, positive};
use crate::{Error, Result};
use massline_analysis::hits::{Options, PreparedRecording};
use massline_files::recording::{
    Decimal, Recording, Sensitivity, StatedSensitivity, StatedUnit, Statements,
};
use massline_report::recorded_hits::{
    hits_json, hits_text, understanding_json, understanding_text,
};

/// Arguments of `massline hits`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = r#"Reads LabVIEW measurement (.lvm), text with columns (CSV: semicolons, tabs, commas or blanks; up to
1000 lines of header), UFF time records (dataset 58, type 1) and NumPy arrays ((segments,) samples,
channels). Text may be UTF-8, UTF-16, Windows-1252 or Shift-JIS. A file of several segments has a
hit in each, and so has a short one that begins with a hit; a continuous one is cut by the trigger.

The first line of the answer says what was understood: channels, units, rate and what is left out.
A unit is read from the file or asked for, never assumed. A signal in mV, V, pC or counts needs the
sensitivity of its sensor. Samples that are missing are never closed up: such a file is refused.

Examples:
  massline hits impact.lvm
  massline hits taps.csv --force Hammer --rate-hz 4000 --force-range-n 120
  massline hits old.csv --unit Hammer=lbf --unit "*=g" --leave-out Temperature
  massline hits volts.csv --sensitivity "1=2.3 mV/N" --sensitivity "2=100 mV/g"
  massline hits pulls.csv --reverse Hammer
  massline hits ticks.csv --unit "time_us=us"
  massline hits taps.npy --unit 1=N --unit "*=m/s^2" --rate-hz 51200 --json"#
)]
pub struct Args {
    /// The recording.
    file: PathBuf,
    /// Column of the force: its name, or its number from 1 (a time column does not count).
    #[arg(long, value_name = "COLUMN")]
    force: Option<String>,
    /// Column that is no accelerometer, for example a temperature: its name or number; may be repeated.
    #[arg(long, value_name = "COLUMN")]
    leave_out: Vec<String>,
    /// Unit of a column, where the file does not state it or states a wrong one: COLUMN=UNIT, for example
    /// "2=g"; may be repeated. "*=g" states it for every response without a unit. A time column may be named too
    /// ("time=us" for one without a name).
    #[arg(long, value_name = "COLUMN=UNIT", value_parser = unit)]
    unit: Vec<StatedUnit>,
    /// Sensitivity of the sensor of a column in mV, V, pC or counts: COLUMN=VALUE, for example "Force=2.3 mV/N",
    /// "2=100 mV/g" or "3=10.2 mV/(m/s^2)"; may be repeated.
    #[arg(long, value_name = "COLUMN=VALUE", value_parser = sensitivity)]
    sensitivity: Vec<StatedSensitivity>,
    /// Column whose sign is reversed, such as a hammer whose compression is negative; may be repeated.
    #[arg(long, value_name = "COLUMN")]
    reverse: Vec<String>,
    /// Decimal sign of a text, where it cannot be told from a separator of thousands: point or comma.
    #[arg(long, value_name = "SIGN", value_parser = decimal)]
    decimal: Option<Decimal>,
    /// Sampling rate, for a file that does not state it.
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate_hz: Option<f64>,
    /// Force above which the hammer counts as overloaded, N.
    #[arg(long, value_name = "N", value_parser = positive)]
    force_range_n: Option<f64>,
    /// Deviation from the zero level above which a response counts as overloaded, m/s².
    #[arg(long, value_name = "M_PER_S2", value_parser = positive)]
    response_range_m_per_s2: Option<f64>,
    /// Force at which a hit begins, N.
    #[arg(long, value_name = "N", value_parser = positive, default_value_t = test_defaults().trigger_n)]
    trigger_n: f64,
    /// Minimum peak force, N; a hit with a smaller peak is too weak.
    #[arg(long, value_name = "N", value_parser = not_negative, default_value_t = test_defaults().min_peak_force_n)]
    min_peak_force_n: f64,
    /// Quiet time before a hit of a continuous recording, s.
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = 0.02)]
    pre_trigger_s: f64,
    /// Length of the record of a hit in a continuous recording, s.
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = 0.512)]
    record_s: f64,
    /// Ends of the band that the force must excite and in which hits are compared, Hz.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], value_parser = positive,
          default_values_t = TestSettings::<f64>::default_band())]
    band_hz: Vec<f64>,
    /// Half width of the force window about the peak, s.
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = test_defaults().force_window_s)]
    force_window_s: f64,
    /// Decay rate of the exponential window, 1/s.
    #[arg(long, value_name = "PER_S", value_parser = not_negative, default_value_t = test_defaults().exponential_decay)]
    exponential_decay_per_s: f64,
    /// Treatment of a fault: CODE=keep, warn or reject; may be repeated.
    #[arg(long, value_name = "CODE=TREATMENT", value_parser = policy_entry)]
    policy: Vec<(Code, HitTreatment)>,
    /// Largest number of hits to keep: the most consistent ones.
    #[arg(long, value_name = "COUNT", value_parser = count)]
    keep: Option<NonZeroUsize>,
}

/// The settings of a test that states none.
fn test_defaults() -> TestSettings<f64> {
    TestSettings::default()
}

/// Runs the command.
///
/// # Errors
/// Exit 2 when the file or an option is bad, or the file has no hit; exit 3 when every hit was rejected.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = args.file.display();
    let options = options(args)?;
    let recording = Recording::read(&args.file, args.decimal)?;
    let recording =
        PreparedRecording::new(recording, &options).map_err(|error| error.within(&file))?;
    if output.json() {
        output.explain(&json!({ "recording": understanding_json(recording.understanding()) }));
    } else {
        output.text(format!("{file}: {}", understanding_text(recording.understanding())))?;
    }
    let hits = recording.grade(&options).map_err(|error| error.within(&file))?;
    hits.warnings.iter().for_each(|warning| output.warn(warning));
    if hits.hits.iter().any(|hit| hit.report.good()) {
        return output.answer(&hits_json(&hits), |_| hits_text(&hits));
    }
    if output.json() {
        output.explain(&hits_json(&hits));
    } else {
        output.text(hits_text(&hits))?;
    }
    let count = hits.hits.len();
    let text = format!("all {count} hits were rejected; the sentence beside each says what to do");
    Err(Error::undetermined("all_hits_rejected", text).within(&file))
}

fn options(args: &Args) -> Result<Options> {
    let band_hz = match args.band_hz.as_slice() {
        &[low, high] if low < high => [low, high],
        _ => {
            return Err(Error::input("usage", "--band-hz: give LOW and HIGH, LOW below HIGH"));
        }
    };
    let policy = args
        .policy
        .iter()
        .fold(HitPolicy::default(), |policy, &(code, treatment)| policy.with(code, treatment));
    Ok(Options {
        force: args.force.clone(),
        leave_out: args.leave_out.clone(),
        statements: Statements {
            units: args.unit.clone(),
            sensitivities: args.sensitivity.clone(),
            reversed: args.reverse.clone(),
        },
        rate_hz: args.rate_hz,
        force_range_n: args.force_range_n,
        response_range: args.response_range_m_per_s2,
        pre_trigger_s: args.pre_trigger_s,
        record_s: args.record_s,
        keep: args.keep.map(NonZeroUsize::get),
        test: TestSettings {
            band_hz: Some(band_hz),
            exponential_decay: args.exponential_decay_per_s,
            force_window_s: args.force_window_s,
            trigger_n: args.trigger_n,
            min_peak_force_n: args.min_peak_force_n,
            policy,
            ..TestSettings::default()
        },
    })
}

fn unit(text: &str) -> std::result::Result<StatedUnit, String> {
    let wrong = "write COLUMN=UNIT, for example 2=g or Hammer=lbf";
    let (column, unit) = text.rsplit_once('=').ok_or(wrong)?;
    let (column, unit) = (column.trim().to_owned(), unit.trim().to_owned());
    if column.is_empty() || unit.is_empty() {
        Err(wrong.into())
    } else {
        Ok(StatedUnit { column, unit })
    }
}

fn sensitivity(text: &str) -> std::result::Result<StatedSensitivity, String> {
    let wrong = "write COLUMN=VALUE, for example Force=2.3 mV/N";
    let (column, value) = text.rsplit_once('=').ok_or(wrong)?;
    let sensitivity: Sensitivity = value.parse()?;
    let column = column.trim().to_owned();
    if column.is_empty() {
        Err(wrong.into())
    } else {
        Ok(StatedSensitivity { column, sensitivity })
    }
}

fn decimal(text: &str) -> std::result::Result<Decimal, String> {
    Decimal::from_name(text).ok_or_else(|| "write point or comma".into())
}

fn count(text: &str) -> std::result::Result<NonZeroUsize, String> {
    let count = text.parse().ok().and_then(NonZeroUsize::new);
    count.ok_or_else(|| {
        "give a whole number of hits, at least 1; leave --keep out to keep all".into()
    })
}

fn policy_entry(text: &str) -> std::result::Result<(Code, HitTreatment), String> {
    let (name, treatment) = text.split_once('=').ok_or("write CODE=TREATMENT")?;
    let code = HitPolicy::CODES.into_iter().find(|code| code.name() == name).ok_or_else(|| {
        let codes: Vec<_> = HitPolicy::CODES.iter().map(|code| code.name()).collect();
        format!("no such code; one of {}", codes.join(", "))
    })?;
    let treatment = HitTreatment::from_name(treatment).ok_or("keep, warn or reject is wanted")?;
    Ok((code, treatment))
}
