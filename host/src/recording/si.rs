//! Converts the channels of a recording to N and m/s², by the units that the file declares or the user states.

use crate::error::{Error, Result};
use crate::recording::{Channel, Recording};
use crate::units::{Quantity, force_unit, motion_unit};

/// The units that are known, for error messages.
const FORCES: &str = "N, mN, kN, lbf, kgf and pdl";
const ACCELERATIONS: &str = "m/s^2, cm/s^2, mm/s^2, in/s^2, ft/s^2 and g";

/// The unit of a column as stated by the user, `COLUMN=UNIT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatedUnit {
    /// Name of the column, or its number from 1.
    pub column: String,
    /// The unit.
    pub unit: String,
}

impl Recording {
    /// The recording with the channels of `order`, its force in N and the others in m/s²; the force is the first
    /// of `order`. A channel whose unit neither the file nor `stated` gives is taken to be in these units; where
    /// both give one, `stated` holds. Returns also a note for each unit of the file that is not used, and one
    /// that names the channels without a unit. The channels that are not in `order` stay as they are.
    ///
    /// # Errors
    /// When a unit is not that of a force or of an acceleration, or `stated` names a column that does not exist.
    pub fn in_si(mut self, order: &[usize], stated: &[StatedUnit]) -> Result<(Self, Vec<String>)> {
        let force = order.first().copied().unwrap_or_default();
        let mut units: Vec<Option<&str>> = vec![None; self.channels.len()];
        for StatedUnit { column, unit } in stated {
            let place = self.named(column)?;
            units[place] = Some(unit);
        }
        let mut notes = Vec::new();
        let mut factors = Vec::new();
        let mut silent = Vec::new();
        for (k, (channel, unit)) in self.channels.iter().zip(units).enumerate() {
            if !order.contains(&k) {
                factors.push(1.0);
                continue;
            }
            if let Some(unit) = unit
                && !channel.unit.is_empty()
                && channel.unit != unit
            {
                let name = called(k, channel);
                notes.push(format!(
                    "{name}: the file states {}, using {unit} from --unit",
                    channel.unit
                ));
            }
            let declared = channel.factor.filter(|_| unit.is_none());
            if unit.is_none() && channel.unit.trim().is_empty() && declared.is_none() {
                silent.push(k);
            }
            factors.push(match declared {
                Some(declared) => declared,
                None => factor(k, channel, unit.unwrap_or(&channel.unit), k == force)?,
            });
        }
        notes.extend(self.unstated(force, &silent));
        for segment in &mut self.segments {
            for (samples, factor) in segment.0.iter_mut().zip(&factors) {
                samples.iter_mut().for_each(|sample| *sample *= factor);
            }
        }
        for (k, channel) in self.channels.iter_mut().enumerate().filter(|(k, _)| order.contains(k))
        {
            channel.unit = if k == force { "N" } else { "m/s²" }.to_owned();
            channel.factor = None;
        }
        Ok((self, notes))
    }

    /// Says which channels have no unit, and what is taken instead.
    fn unstated(&self, force: usize, silent: &[usize]) -> Option<String> {
        let example = column(*silent.last()?, self.channels.get(*silent.last()?)?);
        let taken = |&k: &usize| {
            let name = called(k, self.channels.get(k)?);
            Some(format!("{name} is taken to be in {}", if k == force { "N" } else { "m/s²" }))
        };
        let taken: Vec<_> = silent.iter().filter_map(taken).collect();
        let unit = if silent.last() == Some(&force) { "lbf" } else { "g" };
        Some(format!(
            "no unit is stated: {}; state another with --unit, for example --unit \"{example}={unit}\"",
            taken.join(", ")
        ))
    }

    /// The channel with this name or this number, from 1.
    ///
    /// # Errors
    /// When there is none.
    pub fn named(&self, wanted: &str) -> Result<usize> {
        let number = wanted.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
        let place = self
            .channels
            .iter()
            .position(|channel| channel.name.eq_ignore_ascii_case(wanted))
            .or(number.filter(|&n| n < self.channels.len()));
        place.ok_or_else(|| {
            let message =
                format!("there is no channel \"{wanted}\"; the recording has {}", self.list());
            Error::input("no_such_channel", message)
        })
    }

    /// Numbers and names of all channels.
    pub fn list(&self) -> String {
        let names =
            self.channels.iter().enumerate().map(|(k, channel)| match channel.name.as_str() {
                "" => format!("{}", k + 1),
                name => format!("{} \"{name}\"", k + 1),
            });
        names.collect::<Vec<_>>().join(", ")
    }
}

/// The factor from a unit to N or m/s²; one for an empty unit.
fn factor(k: usize, channel: &Channel, unit: &str, is_force: bool) -> Result<f64> {
    if unit.trim().is_empty() {
        return Ok(1.0);
    }
    let size = if is_force { force_unit(unit) } else { motion_unit(unit, Quantity::Acceleration) };
    size.ok_or_else(|| {
        let (name, column) = (called(k, channel), column(k, channel));
        let (what, known, example) = if is_force {
            ("a force", FORCES, "N")
        } else {
            ("an acceleration", ACCELERATIONS, "g")
        };
        let message = format!(
            "{name}: \"{unit}\" is not a known unit of {what} ({known} are); state the right one with \
             --unit \"{column}={example}\", leave the column out with --leave-out \"{column}\", or export the \
             recording in such a unit"
        );
        Error::input("recording_unknown_unit", message)
    })
}

/// A channel as it is named in messages.
fn called(k: usize, channel: &Channel) -> String {
    match channel.name.as_str() {
        "" => format!("channel {}", k + 1),
        name => format!("channel {} \"{name}\"", k + 1),
    }
}

/// A channel as it is named on the command line.
fn column(k: usize, channel: &Channel) -> String {
    if channel.name.is_empty() { (k + 1).to_string() } else { channel.name.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Segment;
    use massline_shared::STANDARD_GRAVITY;

    fn recording(units: [&str; 3]) -> Recording {
        let names = ["Hammer", "", "z"];
        let channels = names.iter().zip(units).map(|(name, unit)| Channel {
            name: (*name).into(),
            unit: unit.into(),
            factor: None,
        });
        Recording {
            rate_hz: None,
            channels: channels.collect(),
            segments: vec![Segment(vec![vec![2.0], vec![3.0], vec![4.0]])],
        }
    }

    const ALL: [usize; 3] = [0, 1, 2];

    fn stated(column: &str, unit: &str) -> StatedUnit {
        StatedUnit { column: column.into(), unit: unit.into() }
    }

    fn samples(units: [&str; 3], stated: &[StatedUnit]) -> Vec<f64> {
        let (converted, _) = recording(units).in_si(&ALL, stated).unwrap();
        converted.segments[0].0.iter().map(|channel| channel[0]).collect()
    }

    #[test]
    fn declared_units_are_converted_and_silence_means_si() {
        assert_eq!(samples(["", "", ""], &[]), [2.0, 3.0, 4.0]);
        let found = samples(["kN", "g", "mm/s^2"], &[]);
        assert_eq!(found, [2000.0, 3.0 * STANDARD_GRAVITY, 0.004]);
        let pounds = samples(["lbf", "", ""], &[])[0];
        // Two pounds-force to six digits.
        assert!((pounds - 8.896_44).abs() < 1e-5, "{pounds}");
    }

    #[test]
    fn the_unit_stated_for_a_column_holds() {
        let found = samples(["N", "", "m/s²"], &[stated("2", "g"), stated("Z", "cm/s²")]);
        assert_eq!(found, [2.0, 3.0 * STANDARD_GRAVITY, 0.04]);
        let (_, notes) = recording(["N", "", "m/s²"]).in_si(&ALL, &[stated("z", "g")]).unwrap();
        let unused = "channel 3 \"z\": the file states m/s², using g from --unit";
        let silent = "no unit is stated: channel 2 is taken to be in m/s²; state another with --unit, for \
                      example --unit \"2=g\"";
        assert_eq!(notes, [unused, silent]);
        let (_, notes) = recording(["", "g", ""]).in_si(&ALL, &[]).unwrap();
        assert!(notes[0].contains("\"Hammer\" is taken to be in N, channel 3 \"z\""), "{notes:?}");
        assert!(recording(["N", "g", "g"]).in_si(&ALL, &[]).unwrap().1.is_empty());
    }

    #[test]
    fn a_unit_of_something_else_is_refused_by_name() {
        for units in [["V", "", ""], ["g", "", ""], ["", "N", ""], ["N", "", "m/s"]] {
            let error = recording(units).in_si(&ALL, &[]).unwrap_err().to_string();
            assert!(error.contains("is not a known unit") && error.contains("--unit"), "{error}");
        }
        let error = recording(["", "", "EU"]).in_si(&ALL, &[]).unwrap_err().to_string();
        assert!(error.contains("channel 3 \"z\"") && error.contains("\"EU\""), "{error}");
        assert!(recording(["", "", ""]).in_si(&ALL, &[stated("7", "g")]).is_err());
    }

    #[test]
    fn units_for_the_whole_file_give_way_to_those_of_a_column() {
        let mut millimetres = recording(["", "", ""]);
        millimetres.channels[2].factor = Some(1e-3);
        let (found, notes) = millimetres.clone().in_si(&ALL, &[]).unwrap();
        assert_eq!(found.segments[0].0[2], [0.004]);
        assert!(!notes[0].contains("channel 3"), "{notes:?}");
        let (found, _) = millimetres.in_si(&ALL, &[stated("z", "g")]).unwrap();
        assert_eq!(found.segments[0].0[2], [4.0 * STANDARD_GRAVITY]);
    }

    #[test]
    fn a_channel_that_is_not_used_may_have_any_unit() {
        let (found, _) = recording(["N", "°C", "g"]).in_si(&[0, 2], &[]).unwrap();
        assert_eq!(found.segments[0].0[1], [3.0]);
        assert_eq!(found.channels[1].unit, "°C");
    }
}
