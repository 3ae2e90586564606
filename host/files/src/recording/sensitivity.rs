//! Sensitivities of sensors: `2.3 mV/N`, `100 mV/g`, `4 pC/N`, `1000 counts/N`.

use std::fmt;
use std::str::FromStr;

use crate::units::{Measure, Quantity, is_unscaled, is_unstated, unit_size};

/// What an electrical unit measures, its spellings in small letters, and its size.
const ELECTRICAL: [(Signal, &[&str], f64); 10] = [
    (Signal::Voltage, &["v", "volt", "volts"], 1.0),
    (Signal::Voltage, &["mv", "millivolt", "millivolts"], 1e-3),
    (Signal::Voltage, &["µv", "uv", "microvolt", "microvolts"], 1e-6),
    (Signal::Voltage, &["kv"], 1e3),
    (Signal::Charge, &["pc", "picocoulomb", "picocoulombs"], 1e-12),
    (Signal::Charge, &["nc", "nanocoulomb", "nanocoulombs"], 1e-9),
    (Signal::Current, &["ma"], 1e-3),
    (Signal::Current, &["µa", "ua"], 1e-6),
    (Signal::Counts, &["count", "counts", "cts", "ct", "lsb", "adc", "digits", "raw"], 1.0),
    (Signal::Counts, &["bit", "bits"], 1.0),
];

/// What an electrical unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Signal {
    Voltage,
    Charge,
    Current,
    Counts,
}

/// The sensitivity of a sensor: its signal per newton or per m/s².
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    text: String,
    signal: Signal,
    /// Signal per unit of the target, in SI.
    value: f64,
    target: String,
    is_force: bool,
}

/// Size and kind of an electrical unit.
fn electrical(label: &str) -> Option<(Signal, f64)> {
    let label = label.trim().replace('μ', "µ").to_lowercase();
    let label = label.strip_suffix("rms").map_or(label.as_str(), str::trim_end);
    let (signal, _, size) = ELECTRICAL.iter().find(|(_, names, _)| names.contains(&label))?;
    Some((*signal, *size))
}

/// True for the unit of a signal to which a sensitivity can be given.
pub(super) fn is_electrical(label: &str) -> bool {
    electrical(label).is_some()
}

/// Size of a unit of force or acceleration, and whether it is one of force.
fn mechanical(label: &str) -> Option<(f64, bool)> {
    let force = unit_size(label, Measure::Force).ok().map(|size| (size, true));
    force.or_else(|| Some((unit_size(label, Measure::Motion(Quantity::Acceleration)).ok()?, false)))
}

impl FromStr for Sensitivity {
    type Err = String;

    /// Reads a number and a ratio of units: signal per force or acceleration, or the reverse.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!("\"{text}\" is no sensitivity; write for example 2.3 mV/N, 100 mV/g or 4 pC/N")
        };
        let is_of_number = |c: char| c.is_ascii_digit() || "+-.,eE".contains(c);
        let end = text.trim().find(|c: char| !is_of_number(c)).ok_or_else(wrong)?;
        let (number, unit) = text.trim().split_at_checked(end).ok_or_else(wrong)?;
        let number: f64 = number.replace(',', ".").parse().map_err(|_| wrong())?;
        if !(number.is_finite() && number > 0.0) {
            return Err(format!(
                "\"{text}\": a sensitivity is above zero; turn a channel with --reverse"
            ));
        }
        let (over, under) = unit.trim().split_once('/').ok_or_else(wrong)?;
        let parts = [(over, under, number), (under, over, number.recip())];
        let read = |(signal, target, number): (&str, &str, f64)| {
            let (signal, size) = electrical(signal)?;
            let (target_size, is_force) = mechanical(target)?;
            let value = number * size / target_size;
            let target = target.trim().trim_matches(['(', ')']).to_owned();
            Some(Self { text: text.trim().to_owned(), signal, value, target, is_force })
        };
        parts.into_iter().find_map(read).ok_or_else(wrong)
    }
}

impl fmt::Display for Sensitivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Sensitivity {
    /// The unit of the force or the acceleration.
    pub fn target(&self) -> &str {
        &self.target
    }

    /// Whether it is that of a force sensor.
    pub fn is_of_force(&self) -> bool {
        self.is_force
    }

    /// The factor from samples in `unit` to N or m/s².
    pub(super) fn factor(&self, unit: &str, is_force: bool) -> Result<f64, String> {
        if is_force != self.is_force {
            let [is, must] =
                if self.is_force { ["force", "acceleration"] } else { ["acceleration", "force"] };
            return Err(format!(
                "it is the sensitivity of a sensor of {is}, and the channel is one of {must}"
            ));
        }
        if is_unstated(unit) {
            return Err(
                "the unit of the samples is not stated; state it as well: --unit \"COLUMN=mV\""
                    .into(),
            );
        }
        let Some((signal, size)) = electrical(unit) else {
            let has_none =
                if is_unscaled(unit) { "has no sensitivity" } else { "needs no sensitivity" };
            return Err(format!(
                "the channel is in {unit}, which {has_none}; leave the option out or state the true unit with --unit"
            ));
        };
        if signal != self.signal {
            return Err(format!(
                "the channel is in {unit}, which is not the signal of this sensitivity"
            ));
        }
        Ok(size / self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::STANDARD_GRAVITY;

    #[test]
    fn a_sensitivity_converts_a_signal() {
        for (text, unit, is_force, expected) in [
            ("2.3 mV/N", "mV", true, 1.0 / 2.3),
            ("2.3mV/N", "V", true, 1e3 / 2.3),
            ("2,3 mV/N", "mV", true, 1.0 / 2.3),
            ("0.0023 V/N", "mV", true, 1.0 / 2.3),
            ("10.2 mV/lbf", "mV", true, 4.448_221_615_260_5 / 10.2),
            ("100 mV/g", "mV", false, STANDARD_GRAVITY / 100.0),
            ("10.2 mV/(m/s²)", "mV", false, 1.0 / 10.2),
            ("10.2 mV/(m/s^2)", "µV", false, 1e-3 / 10.2),
            ("10.2 mV/m/s^2", "mV", false, 1.0 / 10.2),
            ("10.2 mV/ms-2", "mV", false, 1.0 / 10.2),
            ("4 pC/N", "pC", true, 0.25),
            ("4 pC/N", "nC", true, 250.0),
            ("1000 counts/N", "LSB", true, 1e-3),
            ("0.5 N/mV", "mV", true, 0.5),
            ("1e2 mV/g", "mV rms", false, STANDARD_GRAVITY / 100.0),
        ] {
            let sensitivity: Sensitivity = text.parse().unwrap();
            let factor = sensitivity.factor(unit, is_force).unwrap();
            assert!((factor / expected - 1.0).abs() < 1e-12, "{text} {unit}: {factor}");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        for text in [
            "",
            "2.3",
            "mV/N",
            "2.3 mV",
            "2.3 N",
            "0 mV/N",
            "-2.3 mV/N",
            "2.3 mV/m",
            "2.3 g/N",
            "nan mV/N",
            "1e999 mV/N",
        ] {
            assert!(text.parse::<Sensitivity>().is_err(), "{text}");
        }
        let hammer: Sensitivity = "2.3 mV/N".parse().unwrap();
        for (unit, is_force, words) in [
            ("N", true, "needs no sensitivity"),
            ("pC", true, "not the signal"),
            ("counts", true, "not the signal"),
            ("", true, "--unit"),
            ("EU", true, "has no sensitivity"),
            ("mV", false, "acceleration"),
        ] {
            let fault = hammer.factor(unit, is_force).unwrap_err();
            assert!(fault.contains(words), "{fault}");
        }
    }
}
