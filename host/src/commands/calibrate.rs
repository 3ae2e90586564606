//! `massline calibrate`: calibrates new sensors and a new hammer, and stores the calibration on the rig.

pub mod block;
pub mod demo;
pub mod helper;
pub mod keep;
mod origin;
pub mod rig;
pub mod tumble;

use massline_analysis::calibration::electronics::ConversionOrder;
use massline_client::flash::board;
use massline_protocol::message::Identity;
use massline_shared::calibration::CalibrationRecord;

use origin::Origin;

use crate::output::{Output, counted};
use crate::{Error, Result};
use massline_files::calibration_file::short;
use massline_files::day::Day;
use massline_result::Verdict;

/// Arguments of `massline calibrate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Two tests, in this order; each is stored on the rig when it is done.
  tumble   hold the sensors still with each axis up and down: zero, gain, axes
  block    hit a hanging block of known mass: hammer gain, RC cutoffs
The block test alone gives the ratio of the sensors to the hammer, which is all that a measurement
needs, but its cross-axis sensitivities are only as accurate as the direction of your hits.

Examples:
  massline calibrate tumble --temperature 21
  massline calibrate block --mass 2.000 --mass-sigma 0.001
  massline calibrate verify --mass 2.000      does it still hold?
  massline calibrate pull rig.toml            keep it in a file
  massline calibrate demo                     watch it on the simulated bench")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Read six static positions: zero, sensitivity and cross-axis matrix of every sensor.
    Tumble(tumble::Args),
    /// Hit a hanging block of known mass: the hammer against the sensors, RC cutoffs.
    Block(block::Args),
    /// Check the calibration on the rig with a quick block test; exit 3 when it has drifted.
    Verify(block::VerifyArgs),
    /// Print the calibration on the rig.
    Show(keep::ShowArgs),
    /// Write the calibration on the rig to a file.
    Pull(keep::PullArgs),
    /// Store the calibration of a file on the rig.
    Push(keep::PushArgs),
    /// Calibrate on the simulated bench, and measure before and after it.
    Demo(demo::Args),
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, the rig cannot be reached or refuses, the data do not determine a calibration, the
/// calibration has drifted, or the user interrupts the command.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    match &args.command {
        Command::Tumble(args) => tumble::run(args, output),
        Command::Block(args) => block::run(args, output),
        Command::Verify(args) => block::verify(args, output),
        Command::Show(args) => keep::show(args, output),
        Command::Pull(args) => keep::pull(args, output),
        Command::Push(args) => keep::push(args, output),
        Command::Demo(args) => demo::run(args, output),
    }
}

/// Temperatures at which an ADXL326 works, °C.
const TEMPERATURES_C: std::ops::RangeInclusive<f32> = -40.0..=85.0;

/// Information that is stored with a calibration.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct OriginArgs {
    /// Date of the calibration, yyyy-mm-dd; default: today.
    #[arg(long, value_name = "DAY")]
    date: Option<Day>,
    /// Temperature, °C.
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    temperature: Option<f32>,
    /// Name or serial number of the hammer, at most 12 letters.
    #[arg(long, value_name = "ID")]
    hammer_id: Option<String>,
    /// Names or serial numbers of the sensors in the order of the inputs, at most 12 letters each.
    #[arg(long, value_name = "ID,ID,ID", value_delimiter = ',')]
    sensor_ids: Vec<String>,
}

impl OriginArgs {
    /// The origin of a calibration of this number of sensors.
    fn origin(&self, count: usize) -> Result<Origin> {
        if let Some(temperature) = self.temperature.filter(|t| !TEMPERATURES_C.contains(t)) {
            let (least, most) = (TEMPERATURES_C.start(), TEMPERATURES_C.end());
            let message = format!(
                "--temperature {temperature}: give a temperature from {least} to {most} °C"
            );
            return Err(Error::input("temperature_out_of_range", message));
        }
        if !self.sensor_ids.is_empty() && self.sensor_ids.len() != count {
            let message = format!(
                "--sensor-ids names {} sensors; give {count}, one for each in the order of the inputs",
                self.sensor_ids.len(),
            );
            return Err(Error::input("sensor_ids", message));
        }
        let id = |option: &str, text: &str| {
            short(text).map_err(|reason| Error::input("id_too_long", format!("{option}: {reason}")))
        };
        let sensors = self.sensor_ids.iter().map(|text| id("--sensor-ids", text));
        Ok(Origin {
            date: self.date.unwrap_or_else(Day::today).text(),
            temperature: self.temperature,
            hammer: id("--hammer-id", self.hammer_id.as_deref().unwrap_or_default())?,
            sensors: sensors.collect::<Result<_>>()?,
        })
    }
}

/// Stores a calibration on a rig and reads it back.
fn store(client: &mut massline_client::Client, record: &CalibrationRecord) -> Result<()> {
    client.put_calibration(record)?;
    if client.calibration()? == *record {
        return Ok(());
    }
    Err(crate::Error::device(
        "calibration_not_kept",
        "the calibration read back from the rig differs from the one sent; `massline device stats` \
         may show why",
    ))
}

/// Warnings about a calibration, each printed when it is found.
#[derive(Clone, Copy, Debug, Default)]
struct Warnings {
    count: usize,
}

impl Warnings {
    /// Prints a warning.
    fn add(&mut self, text: impl AsRef<str>, output: &mut Output) {
        self.count += 1;
        output.warn(text);
    }

    /// The verdict on the calibration. One that is contradicted is refused before it is stored.
    fn verdict(self) -> Verdict {
        if self.count == 0 { Verdict::Good } else { Verdict::UseWithCare }
    }

    /// The first line of the text, which states the verdict.
    fn first_line(self, output: &Output) -> String {
        let line = match self.count {
            0 => "Good: nothing puts this calibration in doubt".to_owned(),
            count => format!("Use with care: {}, above", counted(count, "warning")),
        };
        output.verdict_line(self.verdict(), &line)
    }
}

/// The order in which the converters of a rig convert the channels; by their numbers where the board states none.
pub fn conversion_order(identity: &Identity) -> ConversionOrder {
    let by_number = || vec![(0..identity.adc.channels).collect()];
    ConversionOrder(board::conversion_order(&identity.board).unwrap_or_else(by_number))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(name: &str) -> ConversionOrder {
        ConversionOrder(board::conversion_order(name).unwrap())
    }

    #[test]
    fn who_follows_whom_depends_on_the_board() {
        // Constant reference before the hammer; sensor 1 x after it.
        let black_pill = order("blackpill-f411");
        assert_eq!((black_pill.before(0), black_pill.after(0)), (None, Some(1)));
        // Even and odd channels have a converter each, and each comes past an input of constant voltage.
        let nucleo = order("nucleo-g474re");
        assert_eq!((nucleo.before(0), nucleo.after(0)), (None, Some(2)));
        assert_eq!((nucleo.before(1), nucleo.before(3)), (None, Some(1)));
        // Round and round.
        let pico = order("pico2");
        assert_eq!((pico.before(0), pico.after(0), pico.after(9)), (Some(9), Some(1), Some(0)));
        assert_eq!(board::conversion_order("virtual"), None);
    }
}
