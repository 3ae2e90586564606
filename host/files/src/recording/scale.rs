//! The units of channels: read from the file, stated by the user, or reached by a sensitivity; and the conversion to N
//! and m/s².

use super::sensitivity::{Sensitivity, is_electrical};
use super::{
    Channel, LeftOutColumn, Recording, RecordingError, factors, is_named_force, six_digits,
};
use crate::units::{
    Measure, Quantity, UnitFault, force_unit, is_unscaled, is_unstated, motion_unit, unit_size,
};
use massline_result::{Error, Result};

/// The column of `--unit` that means all responses without a unit.
pub const EVERY_RESPONSE: &str = "*";

/// Units of other quantities, which a header or a row of units may have.
const OTHER_UNITS: [&str; 51] = [
    "°C",
    "degC",
    "C",
    "K",
    "°F",
    "degF",
    "Pa",
    "kPa",
    "MPa",
    "bar",
    "mbar",
    "hPa",
    "psi",
    "Nm",
    "N·m",
    "N.m",
    "N m",
    "deg",
    "°",
    "rad",
    "%",
    "W",
    "mA",
    "Ω",
    "ohm",
    "kg",
    "rpm",
    "1/min",
    "rad/s",
    "deg/s",
    "°/s",
    "dps",
    "rad/s^2",
    "rad/s2",
    "rad/s²",
    "deg/s^2",
    "deg/s2",
    "deg/s²",
    "°/s^2",
    "°/s²",
    "dB",
    "ue",
    "ustrain",
    "microstrain",
    "µε",
    "um/m",
    "µm/m",
    "mm/m",
    "m/m",
    "strain",
    "ppm",
];

/// The unit of a column as stated by the user, `COLUMN=UNIT`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatedUnit {
    /// Name of the column, or its number from 1, or [`EVERY_RESPONSE`].
    pub column: String,
    /// The unit.
    pub unit: String,
}

/// The sensitivity of a column as stated by the user, `COLUMN=2.3 mV/N`.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedSensitivity {
    /// Name of the column, or its number from 1.
    pub column: String,
    /// The sensitivity.
    pub sensitivity: Sensitivity,
}

/// What the user states about the columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statements {
    /// Units; they override those of the file.
    pub units: Vec<StatedUnit>,
    /// Sensitivities of the sensors whose signals are in mV, V, pC or counts.
    pub sensitivities: Vec<StatedSensitivity>,
    /// Columns whose sign is reversed.
    pub reversed: Vec<String>,
}

/// Where the unit of a channel was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSource {
    /// From a label of the file.
    File,
    /// From the units that the file states for all channels together.
    UnitSystem,
    /// From `--unit`.
    Option,
    /// From `--sensitivity`.
    Sensitivity,
}

/// How the samples of a channel become N or m/s².
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The unit in use.
    pub unit: String,
    /// Where it was read.
    pub source: UnitSource,
    /// Size of a unit in N or m/s², negative for a reversed channel.
    pub factor: f64,
}

/// The statements about one channel.
#[derive(Clone, Default)]
struct ChannelStatements<'s> {
    unit: Option<&'s str>,
    sensitivity: Option<Sensitivity>,
    reversed: bool,
}

/// The size of a label as a unit of any quantity that a recording may have.
pub(super) fn size(label: &str) -> Option<f64> {
    let measures = [
        Measure::Force,
        Measure::Motion(Quantity::Acceleration),
        Measure::Motion(Quantity::Velocity),
        Measure::Motion(Quantity::Displacement),
        Measure::Time,
        Measure::Frequency,
    ];
    let other = || (OTHER_UNITS.contains(&label) || is_unscaled(label)).then_some(f64::INFINITY);
    measures.into_iter().find_map(|measure| unit_size(label, measure).ok()).or_else(other)
}

/// True for the unit of anything that a recording may have.
pub(super) fn is_unit(label: &str) -> bool {
    !is_unstated(label) && size(label).is_some()
}

impl Recording {
    /// The force and the channels among `candidates` that may be responses. One whose unit is that of something else,
    /// and about which the user states nothing, is left out by name.
    ///
    /// # Errors
    /// When a statement names a column that does not exist.
    pub fn leave_out_other_units(
        &mut self,
        force: Option<usize>,
        statements: &Statements,
        candidates: &[usize],
    ) -> Result<Vec<usize>> {
        let stated = self.stated(statements)?;
        let mut used = Vec::new();
        for &k in candidates {
            let (Some(channel), Some(stated)) = (self.channels.get(k), stated.get(k)) else {
                continue;
            };
            let unit = channel.unit.as_str();
            let acceleration = unit_size(unit, Measure::Motion(Quantity::Acceleration));
            let is_used = Some(k) == force
                || stated.unit.is_some()
                || stated.sensitivity.is_some()
                || is_unstated(unit)
                || !matches!(acceleration, Err(UnitFault::Unknown(_)))
                || force_unit(unit).is_some()
                || is_named_force(&channel.name);
            if is_used {
                used.push(k);
            } else {
                let reason = format!("\"{unit}\" is no unit of force or acceleration");
                self.left_out.push(LeftOutColumn { name: column(k, channel), reason });
            }
        }
        Ok(used)
    }

    /// The statements about each channel.
    fn stated<'s>(&self, statements: &'s Statements) -> Result<Vec<ChannelStatements<'s>>> {
        let mut stated = vec![ChannelStatements::default(); self.channels.len()];
        for StatedUnit { column, unit } in &statements.units {
            if column != EVERY_RESPONSE && !self.is_time_column(column) {
                stated[self.named(column)?].unit = Some(unit);
            }
        }
        for StatedSensitivity { column, sensitivity } in &statements.sensitivities {
            stated[self.named(column)?].sensitivity = Some(sensitivity.clone());
        }
        for column in &statements.reversed {
            stated[self.named(column)?].reversed = true;
        }
        Ok(stated)
    }

    /// How the channels of `order`, of which the first is the force, become N and m/s²; with a note for each unit of
    /// the file that is not used.
    ///
    /// # Errors
    /// When a channel has no unit or one that is not that of a force or an acceleration, when a signal has no
    /// sensitivity or one that does not fit, when its samples cannot be used, or a statement names a column that does
    /// not exist.
    pub fn scales(
        &self,
        order: &[usize],
        statements: &Statements,
    ) -> Result<(Vec<Scale>, Vec<String>)> {
        let force = order.first().copied();
        let stated = self.stated(statements)?;
        let every = statements
            .units
            .iter()
            .rfind(|stated| stated.column == EVERY_RESPONSE)
            .map(|stated| stated.unit.as_str());
        let mut notes = Vec::new();
        let mut scales = Vec::new();
        let mut unstated = Vec::new();
        for &k in order {
            let (Some(channel), Some(stated)) = (self.channels.get(k), stated.get(k)) else {
                continue;
            };
            if let Some(fault) = &channel.fault {
                return Err(unusable(k, channel, fault));
            }
            let mut stated = stated.clone();
            let has_none = is_unstated(&channel.unit) && channel.factor.is_none();
            if stated.unit.is_none() && has_none && Some(k) != force {
                stated.unit = every;
            }
            if stated.unit.is_none() && has_none {
                unstated.push(k);
                continue;
            }
            scales.push(scale(k, channel, &stated, Some(k) == force, &mut notes)?);
        }
        match self.ask_for_units(&unstated, force) {
            Some(error) => Err(error),
            None => Ok((scales, notes)),
        }
    }

    /// Asks for the units of these channels, with the options that state them.
    fn ask_for_units(&self, unstated: &[usize], force: Option<usize>) -> Option<Error> {
        unstated.first()?;
        let named = |k: usize| Some((k, self.channels.get(k)?));
        let channels: Vec<_> = unstated.iter().filter_map(|&k| named(k)).collect();
        // What stands in brackets may be a unit that is not known here: none is proposed in its place.
        let is_open =
            |channel: &Channel| channel.name.contains(['(', '[']) || factors::of(channel).is_some();
        let option = |k: usize, channel: &Channel, usual: &str| {
            let of_name = unit_in_name(&channel.name);
            let unit = of_name.as_deref().filter(|_| factors::of(channel).is_none());
            let unit = unit.unwrap_or(if is_open(channel) { "UNIT" } else { usual });
            format!("--unit \"{}={unit}\"", column(k, channel))
        };
        let (forces, responses): (Vec<_>, Vec<_>) =
            channels.iter().partition(|(k, _)| Some(*k) == force);
        let mut options: Vec<String> =
            forces.iter().map(|(k, channel)| option(*k, channel, "N")).collect();
        let is_plain =
            |channel: &Channel| !is_open(channel) && unit_in_name(&channel.name).is_none();
        if responses.len() > 1 && responses.iter().all(|(_, channel)| is_plain(channel)) {
            options.push(format!("--unit \"{EVERY_RESPONSE}=m/s^2\""));
        } else {
            options.extend(responses.iter().map(|(k, channel)| option(*k, channel, "m/s^2")));
        }
        let names: Vec<String> = channels.iter().map(|(k, channel)| called(*k, channel)).collect();
        let message = format!(
            "no unit of a force or an acceleration is stated for {}; state the units in which the file is, for example \
             {}, or export the recording with its units (a signal in mV, pC or counts also needs --sensitivity)",
            names.join(", "),
            options.join(" ")
        );
        Some(Error::input("recording_no_unit", message))
    }

    /// The recording with the channels of `order` in N and m/s².
    pub fn scaled(mut self, order: &[usize], scales: &[Scale]) -> Self {
        for (n, (&k, scale)) in order.iter().zip(scales).enumerate() {
            for segment in &mut self.segments {
                let samples = segment.0.get_mut(k).map_or(&mut [][..], Vec::as_mut_slice);
                samples.iter_mut().for_each(|sample| *sample *= scale.factor);
            }
            if let Some(channel) = self.channels.get_mut(k) {
                channel.unit = if n == 0 { "N" } else { "m/s²" }.to_owned();
                channel.factor = None;
            }
        }
        self
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

/// The last word of a name such as `Acc_g` or `Force: kN`, where it is a unit of force or acceleration: the name may
/// state it.
fn unit_in_name(name: &str) -> Option<String> {
    let last = name.trim_end_matches(['}', ')', ']', ' ']);
    // Brackets hold a unit or none.
    let bracket = last.rfind(['{', '(', '[']);
    let at = bracket.or_else(|| last.rfind(['_', ' ', ':', '-']))?;
    let word = last.get(at + 1..)?;
    let is_unit = force_unit(word).is_some() || motion_unit(word, Quantity::Acceleration).is_some();
    is_unit.then(|| word.to_owned())
}

/// The scale of one channel, which has a unit.
fn scale(
    k: usize,
    channel: &Channel,
    stated: &ChannelStatements<'_>,
    is_force: bool,
    notes: &mut Vec<String>,
) -> Result<Scale> {
    let sign = if stated.reversed { -1.0 } else { 1.0 };
    let (name, column) = (called(k, channel), column(k, channel));
    let of_file = channel.unit.trim();
    let unit = stated.unit.unwrap_or(of_file);
    if let (None, Some(factor)) = (stated.unit, factors::of(channel)) {
        let message = format!(
            "{name}: {factor}, and not whether the numbers are multiplied already; state the unit of the numbers in \
             the file with --unit \"{column}=UNIT\", or export the recording without factors"
        );
        return Err(Error::input("recording_unit_contradicted", message));
    }
    if let Some(sensitivity) = &stated.sensitivity {
        let factor = sensitivity.factor(unit, is_force).map_err(|fault| {
            let message = format!("{name}: --sensitivity \"{column}={sensitivity}\": {fault}");
            Error::input("sensitivity_does_not_fit", message)
        })?;
        let unit = sensitivity.target().to_owned();
        return Ok(Scale { unit, source: UnitSource::Sensitivity, factor: sign * factor });
    }
    if stated.unit.is_none()
        && let Some(factor) = channel.factor
    {
        let name = if is_force { "N" } else { "m/s²" };
        let unit =
            if factor == 1.0 { name.to_owned() } else { format!("{} {name}", six_digits(factor)) };
        return Ok(Scale { unit, source: UnitSource::UnitSystem, factor: sign * factor });
    }
    if is_unscaled(of_file) && !is_unscaled(unit) {
        let message = format!(
            "{name}: the file states {of_file}, which is not {unit}; {}",
            sensitivity_advice(of_file, &column, is_force)
        );
        return Err(Error::input("recording_needs_sensitivity", message));
    }
    if let Some(unit) = stated.unit
        && !is_unstated(of_file)
        && of_file != unit
    {
        notes.push(format!("{name}: the file states {of_file}, using {unit} from --unit"));
    }
    let source = if stated.unit.is_some() { UnitSource::Option } else { UnitSource::File };
    let factor = size_of(k, channel, unit, is_force)?;
    let in_brackets = unit_in_name(&channel.name).filter(|_| channel.name.ends_with([')', ']']));
    if let Some(other) = in_brackets.filter(|_| stated.unit.is_none())
        && size_of(k, channel, &other, is_force).ok() != Some(factor)
    {
        let message = format!(
            "{name}: its name states {other}, and its unit is stated as {unit}; say which holds with --unit \
             \"{column}={unit}\" or --unit \"{column}={other}\""
        );
        return Err(Error::input("recording_unit_contradicted", message));
    }
    Ok(Scale { unit: unit.to_owned(), source, factor: sign * factor })
}

/// The size of a unit in N or m/s².
fn size_of(k: usize, channel: &Channel, unit: &str, is_force: bool) -> Result<f64> {
    let measure = if is_force { Measure::Force } else { Measure::Motion(Quantity::Acceleration) };
    unit_size(unit, measure).map_err(|fault| {
        let (name, column) = (called(k, channel), column(k, channel));
        if is_unscaled(unit) {
            let advice = sensitivity_advice(unit, &column, is_force);
            let message = format!("{name}: \"{unit}\" is the unit of an unscaled signal; {advice}");
            return Error::input("recording_needs_sensitivity", message);
        }
        let leave_out = if is_force { String::new() } else { format!(", leave it out with --leave-out \"{column}\"") };
        let message = format!(
            "{name}: \"{unit}\": {fault}; state the right unit with --unit \"{column}=UNIT\"{leave_out}, or export the \
             recording in such a unit"
        );
        Error::input("recording_unknown_unit", message)
    })
}

/// How to give the sensitivity of a signal in this unit.
fn sensitivity_advice(unit: &str, column: &str, is_force: bool) -> String {
    if !is_electrical(unit) {
        return format!(
            "state its true unit with --unit \"{column}=UNIT\" once it is known, or export the recording in N and m/s²"
        );
    }
    let lower = unit.to_ascii_lowercase();
    let number = match (lower.as_str(), is_force) {
        ("mv", true) => "2.3",
        ("mv", false) => "100",
        ("v", true) => "0.0023",
        ("v", false) => "0.1",
        ("pc", true) => "4",
        _ => "10",
    };
    let target = if is_force { "N" } else { "g" };
    let leave_out = if is_force {
        String::new()
    } else {
        format!(", or leave it out with --leave-out \"{column}\"")
    };
    format!(
        "give the sensitivity of its sensor, for example --sensitivity \"{column}={number} {unit}/{target}\"{leave_out}"
    )
}

fn unusable(k: usize, channel: &Channel, fault: &RecordingError) -> Error {
    let message =
        format!("{fault} (or leave the column out with --leave-out \"{}\")", column(k, channel));
    Error::input(fault.code(), message)
}

/// A channel as it is named in messages.
pub(super) fn called(k: usize, channel: &Channel) -> String {
    match channel.name.as_str() {
        "" => format!("channel {}", k + 1),
        name => format!("channel {} \"{name}\"", k + 1),
    }
}

/// A channel as it is named on the command line.
pub fn column(k: usize, channel: &Channel) -> String {
    if channel.name.is_empty() { (k + 1).to_string() } else { channel.name.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Segment;
    use massline_shared::STANDARD_GRAVITY;

    const ALL: [usize; 3] = [0, 1, 2];

    /// A recording of a hammer, a channel without a name and a channel `z`, in these units.
    fn recording(units: [&str; 3]) -> Recording {
        let names = ["Hammer", "", "z"];
        let channel = |(name, unit): (&str, &str)| Channel {
            name: name.into(),
            unit: unit.into(),
            ..Channel::default()
        };
        Recording {
            channels: names.into_iter().zip(units).map(channel).collect(),
            segments: vec![Segment(vec![vec![2.0], vec![3.0], vec![4.0]])],
            ..Recording::default()
        }
    }

    fn units(stated: &[(&str, &str)]) -> Statements {
        let stated = stated.iter();
        let unit = |&(column, unit): &(&str, &str)| StatedUnit {
            column: column.into(),
            unit: unit.into(),
        };
        Statements { units: stated.map(unit).collect(), ..Statements::default() }
    }

    fn samples(recording: Recording, statements: &Statements) -> [f64; 3] {
        let (scales, _) = recording.scales(&ALL, statements).unwrap();
        let scaled = recording.scaled(&ALL, &scales);
        ALL.map(|k| scaled.segments[0].0[k][0])
    }

    #[test]
    fn units_of_the_file_and_stated_ones_are_converted() {
        let converted = samples(recording(["kN", "g", "mm/s^2"]), &Statements::default());
        assert_eq!(converted, [2000.0, 3.0 * STANDARD_GRAVITY, 0.004]);
        let stated = units(&[("2", "g"), ("Z", "cm/s²")]);
        assert_eq!(
            samples(recording(["N", "", "m/s²"]), &stated),
            [2.0, 3.0 * STANDARD_GRAVITY, 0.04]
        );
        let (_, notes) = recording(["N", "g", "m/s²"]).scales(&ALL, &units(&[("z", "g")])).unwrap();
        assert_eq!(notes, ["channel 3 \"z\": the file states m/s², using g from --unit"]);
        // The star states the unit of the responses that have none.
        let stated = units(&[("*", "g"), ("Hammer", "N")]);
        assert_eq!(
            samples(recording(["", "", "m/s²"]), &stated),
            [2.0, 3.0 * STANDARD_GRAVITY, 4.0]
        );
        let reversed = Statements { reversed: vec!["hammer".into()], ..Statements::default() };
        assert_eq!(samples(recording(["N", "m/s²", "m/s²"]), &reversed)[0], -2.0);
    }

    #[test]
    fn a_unit_that_nobody_states_is_asked_for() {
        for (units_of_file, stated, options) in [
            (["", "", ""], &[][..], "--unit \"Hammer=N\" --unit \"*=m/s^2\""),
            (["N", "", ""], &[], "--unit \"*=m/s^2\""),
            (["N", "g", ""], &[], "--unit \"z=m/s^2\""),
            (["NONE", "g", "g"], &[], "--unit \"Hammer=N\""),
            (["", "", ""], &[("*", "g")], "--unit \"Hammer=N\","),
        ] {
            let error = recording(units_of_file).scales(&ALL, &units(stated)).unwrap_err();
            assert_eq!(error.code(), "recording_no_unit");
            assert!(error.to_string().contains(options), "{error}");
        }
    }

    #[test]
    fn a_unit_of_something_else_is_refused_by_name() {
        let code = |units_of_file, stated: &[(&str, &str)]| {
            recording(units_of_file).scales(&ALL, &units(stated)).unwrap_err().code().to_owned()
        };
        assert_eq!(code(["g", "g", "g"], &[]), "recording_unknown_unit");
        assert_eq!(code(["N", "N", "g"], &[]), "recording_unknown_unit");
        assert_eq!(code(["N", "g", "g"], &[("z", "furlong")]), "recording_unknown_unit");
        assert_eq!(code(["N", "g pk-pk", "g"], &[]), "recording_unknown_unit");
        assert_eq!(code(["mV", "g", "g"], &[]), "recording_needs_sensitivity");
        assert_eq!(code(["mV", "g", "g"], &[("Hammer", "N")]), "recording_needs_sensitivity");
        assert_eq!(code(["N", "g", "EU"], &[]), "recording_needs_sensitivity");
        assert_eq!(code(["N", "g", "g"], &[("7", "g")]), "no_such_channel");
        let mut others = recording(["N", "mm", "K"]);
        assert_eq!(
            others.leave_out_other_units(Some(0), &units(&[("2", "g")]), &ALL).unwrap(),
            [0, 1]
        );
        assert_eq!((others.left_out.len(), others.left_out[0].name.as_str()), (1, "z"));
    }

    #[test]
    fn units_for_the_whole_file_give_way_to_those_of_a_column() {
        let mut millimeters = recording(["N", "g", ""]);
        millimeters.channels[2].factor = Some(1e-3);
        assert_eq!(samples(millimeters.clone(), &Statements::default())[2], 0.004);
        assert_eq!(samples(millimeters, &units(&[("z", "g")]))[2], 4.0 * STANDARD_GRAVITY);
    }
}
