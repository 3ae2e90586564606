//! `massline calibrate tumble`: static readings in six positions.

use std::path::PathBuf;

use massline_shared::calibration::tumble::{Position, RestHum, RestVoltages, Tumble, TumbleLimits};
use massline_shared::layout::RIG_SENSORS;

use super::helper::{Helper, Lines, ScreenHelper};
use super::rig::{RigArgs, TumbleRig};
use super::{OriginArgs, Warnings, conversion_order, store};
use crate::output::Output;
use crate::support::rest::without_campaign;
use crate::{Error, ErrorKind, Result};
use massline_analysis::calibration::electronics::Memory;
use massline_analysis::calibration::orientation::find_misplaced_sensor;
use massline_files::tumble_file::{TumbleFile, check_rest};
use massline_files::units::GRAVITY_ON_EARTH;
use massline_report::calibration::{self as report, electronics};
use massline_report::document::{Hum, TumbleCalibration};
use massline_report::words::channel_name;

/// Arguments of `massline calibrate tumble`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Fix all sensors side by side on a square block, along its edges, and put it on a level table. Each
of its six faces comes down once; the hammer lies still. A reading takes half a second; mains hum is
taken out of it and named. Where a sensor axis is converted before the hammer, the readings show what
the hammer's channel keeps of its voltage (memory of the multiplexer). Every reading is kept in a file
until the calibration is stored: after Ctrl-C the same command goes on.

Examples:
  massline calibrate tumble
  massline calibrate tumble --gravity 9.7803 --sensor-ids A17,A18,A21
  massline calibrate tumble --rig virtual --seed 7 --flash rig.bin")]
pub struct Args {
    #[command(flatten)]
    rig: RigArgs,
    #[command(flatten)]
    origin: OriginArgs,
    /// Local acceleration of gravity, m/s²; it differs by 0.3 % between equator and pole.
    #[arg(long, value_name = "M_PER_S2", default_value_t = massline_shared::STANDARD_GRAVITY)]
    gravity: f64,
    /// Largest tilt of a position, rad; more is rejected.
    #[arg(long, value_name = "RAD", default_value_t = 0.02)]
    tilt: f64,
    /// Store the readings in this file until all six are complete.
    #[arg(long, value_name = "FILE", default_value = "massline-tumble.toml")]
    readings: PathBuf,
    /// Discard the readings of an interrupted test.
    #[arg(long)]
    restart: bool,
    /// Compute and print, but do not change the calibration on the rig.
    #[arg(long)]
    dry_run: bool,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached or refuses, or the readings do not determine a calibration.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let limits = args.limits()?;
    let origin = args.origin.origin(RIG_SENSORS)?;
    let mut readings = TumbleFile::open(&args.readings)?;
    if args.restart {
        readings.forget();
    }
    let mut rig = args.rig.tumble_rig(output)?;
    // Before a person turns the block, not after it.
    without_campaign(&mut rig.client, false)?;
    if !readings.is_empty() {
        output.note(format!("resuming with the readings of {}", args.readings.display()));
    }
    let on_screen = rig.can_repeat() && args.rig.screen.wants_screen(output);
    let hum = if on_screen {
        let mut helper =
            ScreenHelper::open(&mut rig.client, &readings.missing_positions(), output)?;
        let taken = take(&mut rig, &mut readings, &limits, &mut helper);
        // Who leaves during the last reading wants nothing stored.
        taken.and_then(|hum| helper.unless_interrupted().map(|()| hum)).map_err(goes_on)
    } else {
        take(&mut rig, &mut readings, &limits, &mut Lines::new(output))
    }?;
    let mut warnings = Warnings::default();
    if let Some(loudest) = hum.iter().max_by(|a, b| a.volts().total_cmp(&b.volts())) {
        warnings.add(loudest.text(), output);
    }
    let tumble = readings.solve(&limits)?;
    judge_level(&tumble, &limits)?;
    let order = conversion_order(&rig.identity);
    let memory = Memory::of_readings(readings.readings(), &order);
    memory
        .iter()
        .filter_map(electronics::memory_warning)
        .for_each(|text| warnings.add(text, output));
    let mut record = rig.client.calibration()?;
    record.take_tumble(&tumble.sensors, tumble.hammer_zero);
    origin.write(&mut record);
    if !args.dry_run {
        store(&mut rig.client, &record)?;
        readings.forget();
    }
    let hum = hum.iter().copied().map(PositionHum::to_json).collect();
    let value = TumbleCalibration {
        verdict: warnings.verdict(),
        calibration: report::record_json(&record),
        tumble: report::tumble_json(&tumble, hum, memory),
        stored: !args.dry_run,
    };
    output.answer(&value, |output| {
        let text =
            report::tumble_text(&tumble, &record, &report::tumble_memory_text(memory.as_ref()));
        format!("{}\n{text}", warnings.first_line(output))
    })
}

/// The error, with what becomes of the readings when the person leaves.
fn goes_on(error: Error) -> Error {
    match error.kind {
        ErrorKind::Interrupted => {
            error.advising("what has been read is kept: the same command goes on")
        }
        _ => error,
    }
}

impl Args {
    fn limits(&self) -> Result<TumbleLimits<f64>> {
        let sound = GRAVITY_ON_EARTH.contains(&self.gravity);
        if !sound {
            return Err(Error::input(
                "gravity_out_of_range",
                format!(
                    "--gravity {} m/s² does not occur on Earth; expected 9.75 to 9.85 m/s²",
                    self.gravity
                ),
            ));
        }
        Ok(TumbleLimits { gravity: self.gravity, tilt: self.tilt, ..TumbleLimits::default() })
    }
}

/// Mains hum in the reading of a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionHum {
    /// The position.
    pub position: Position,
    /// The hum, which was taken out.
    pub hum: RestHum<f64>,
}

impl PositionHum {
    /// Amplitude in the loudest channel, V.
    fn volts(&self) -> f64 {
        self.hum.amplitude[self.hum.loudest()]
    }

    fn text(&self) -> String {
        let PositionHum { position, hum } = self;
        format!(
            "{} picks up {:.1} mV of mains hum at {:.1} Hz (position {position}); it is taken out of the readings, but \
             check shielding and ground, or run the rig from a battery",
            channel_name(hum.loudest()),
            1e3 * self.volts(),
            hum.frequency,
        )
    }

    fn to_json(self) -> Hum {
        Hum {
            position: self.position.name().into(),
            frequency_hz: self.hum.frequency,
            loudest: channel_name(self.hum.loudest()),
            amplitude_v: self.hum.amplitude,
        }
    }
}

/// The output of all channels at the moment, and the mains hum that was taken out of it.
fn read(rig: &mut TumbleRig) -> Result<(RestVoltages<f64>, Option<RestHum<f64>>)> {
    let statistics = rig.client.rest_statistics()?;
    if let Some(scans) = rig.client.rest_record()? {
        let mut room = vec![0.0; scans.len()];
        if let Some(reading) = RestVoltages::of_record(&scans, &rig.identity.adc, &mut room) {
            return Ok(reading);
        }
    }
    Ok((RestVoltages::of(&statistics, &rig.identity.adc), None))
}

/// Reads every position that is still missing; returns the mains hum in them.
///
/// # Errors
/// When the rig refuses, there is nobody to turn the sensors, or those of a simulated rig move.
pub fn take(
    rig: &mut TumbleRig,
    readings: &mut TumbleFile,
    limits: &TumbleLimits<f64>,
    helper: &mut dyn Helper,
) -> Result<Vec<PositionHum>> {
    let mut heard = Vec::new();
    let record = rig.client.calibration()?;
    for position in readings.missing_positions() {
        let (reading, hum) = loop {
            rig.turn_to(position, |client, identity| helper.ask(position, client, identity))?;
            let (reading, hum) = read(rig)?;
            let good = check_rest(&reading, position, limits)
                .and_then(|()| readings.check_turned(&reading, limits))
                .and_then(|()| {
                    match find_misplaced_sensor(&reading, position, &record, &rig.identity) {
                        None => Ok(()),
                        Some(lies) => Err(report::misplaced_error(position, lies)),
                    }
                });
            match good {
                Err(wrong) if rig.can_repeat() => helper.again(&wrong),
                other => break other.map(|()| (reading, hum))?,
            }
        };
        heard.extend(hum.map(|hum| PositionHum { position, hum }));
        readings.add(position, reading, limits)?;
        helper.done(position);
    }
    Ok(heard)
}

/// Rejects positions that were not level.
///
/// # Errors
/// Exit 3 with the sensor and axis of the largest deviation.
pub fn judge_level(tumble: &Tumble<f64>, limits: &TumbleLimits<f64>) -> Result<()> {
    if tumble.is_level(limits) {
        return Ok(());
    }
    let worst =
        tumble.sensors.iter().zip(1..).max_by(|(a, _), (b, _)| a.worst.1.total_cmp(&b.worst.1));
    let Some((sensor, number)) = worst else { return Ok(()) };
    let (axis, angle) = sensor.worst;
    Err(Error::undetermined(
        "position_tilted",
        format!(
            "sensor {number}: with {axis:?} up and down the readings are off by {:.1} mrad, a sign \
             that one of the two positions is tilted by twice that; read them again on a level table \
             (--restart), or allow it by --tilt",
            1e3 * angle,
        ),
    ))
}
