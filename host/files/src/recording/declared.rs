//! A sampling rate or interval that a line of text before the numbers states: `Sample rate: 5120 Hz`.

use super::DeclaredRate;
use super::dialect::Row;
use super::number::{Decimal, last_digit};
use crate::units::{Measure, unit_size};

/// What such a line begins with, for a rate.
const RATES: [&str; 24] = [
    "sample rate",
    "sampling rate",
    "samplerate",
    "samplingrate",
    "sample_rate",
    "sampling_rate",
    "sampling frequency",
    "sample frequency",
    "sampling freq",
    "acquisition rate",
    "scan rate",
    "rate",
    "fs",
    "abtastrate",
    "abtastfrequenz",
    "fréquence d'échantillonnage",
    "frequence d'echantillonnage",
    "taux d'échantillonnage",
    "frecuencia de muestreo",
    "frequenza di campionamento",
    "frequência de amostragem",
    "サンプリング周波数",
    "サンプリングレート",
    "采样频率",
];
/// What it begins with, for the time from one sample to the next.
const INTERVALS: [&str; 17] = [
    "interval",
    "sample interval",
    "sampling interval",
    "sample_interval",
    "sampling_interval",
    "sample period",
    "sampling period",
    "sampling time",
    "time step",
    "time increment",
    "delta t",
    "delta_t",
    "dt",
    "abtastintervall",
    "abtastzeit",
    "pas de temps",
    "サンプリング周期",
];

/// The rate that these lines state first.
pub(super) fn rate(header: &[Row]) -> Option<DeclaredRate> {
    header.iter().find_map(|row| of_line(&row.fields.join(" "), row.line))
}

fn of_line(text: &str, line: usize) -> Option<DeclaredRate> {
    let text = text.trim_start_matches(|c: char| !c.is_alphanumeric()).trim();
    let (is_rate, rest) = (RATES.iter().map(|word| (true, word)))
        .chain(INTERVALS.iter().map(|word| (false, word)))
        .filter_map(|(is_rate, word)| Some((is_rate, after(text, word)?)))
        .min_by_key(|(_, rest)| rest.len())?;
    // A unit may stand in brackets before the number.
    let rest = rest.trim_start();
    let (before, rest) = match rest.strip_prefix(['(', '[']) {
        Some(rest) => rest.split_once([')', ']'])?,
        None => ("", rest),
    };
    let rest = rest.trim_start_matches(|c: char| c.is_whitespace() || ":=,;\"".contains(c));
    let is_part = |c: char| c.is_ascii_digit() || ".,eE+-".contains(c);
    let (number, rest) = rest.split_at_checked(rest.find(|c| !is_part(c)).unwrap_or(rest.len()))?;
    let number = number.trim_end_matches(['.', ',']);
    let word = rest.split_whitespace().next().unwrap_or_default();
    let word = word.trim_matches(|c: char| "()[],;.\"".contains(c));
    let unit = if before.is_empty() { word } else { before.trim() };
    let decimal = if number.contains(',') { Decimal::Comma } else { Decimal::Point };
    let value = decimal.number(number).filter(|value| *value > 0.0 && value.is_finite())?;
    let rounded = 0.5 * last_digit(number) / value;
    // Several columns may have one rate.
    let mut others = rest.split_whitespace().map_while(|word| decimal.number(word));
    if others.any(|other| other != value) {
        return None;
    }
    let is_unstated = unit.is_empty() || Decimal::Point.number(unit).is_some();
    let (hz, uncertainty) = match is_rate {
        // Whole numbers are exact.
        true => (
            value * if is_unstated { 1.0 } else { hertz(unit)? },
            rounded * f64::from(u8::from(last_digit(number) < 1.0)),
        ),
        false if is_unstated => return None,
        false => ((value * unit_size(unit, Measure::Time).ok()?).recip(), rounded),
    };
    // A comma before three digits may separate thousands.
    let is_clear = decimal == Decimal::Point
        || number.split(',').nth(1).is_some_and(|decimals| decimals.len() != 3);
    let entry = format!("line {line} (\"{}\")", text.chars().take(60).collect::<String>());
    is_clear.then_some(DeclaredRate { hz, uncertainty, entry, states_unit: !is_unstated })
}

/// What follows this word at the beginning of a text.
fn after<'t>(text: &'t str, word: &str) -> Option<&'t str> {
    let mut rest = text;
    for expected in word.chars() {
        let mut characters = rest.chars();
        let character = characters.next()?;
        if !character.to_lowercase().eq(expected.to_lowercase()) {
            return None;
        }
        rest = characters.as_str();
    }
    (!rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')).then_some(rest)
}

/// The size of a unit of a rate, Hz.
fn hertz(unit: &str) -> Option<f64> {
    let of_samples = || {
        let names =
            ["samples/second", "samples/sec", "samples/s", "sample/s", "sa/s", "s/s", "sps"];
        let lower = unit.to_ascii_lowercase();
        let prefix = names.iter().find_map(|name| lower.strip_suffix(name))?;
        [("", 1.0), ("k", 1e3), ("m", 1e6)]
            .iter()
            .find(|(letter, _)| *letter == prefix)
            .map(|(_, size)| *size)
    };
    unit_size(unit, Measure::Frequency).ok().or_else(of_samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_read_as_programs_write_it() {
        for (text, hz, states_unit) in [
            ("Sample rate: 5000", 5000.0, false),
            ("# Sampling frequency = 5 kHz", 5000.0, true),
            ("Sample Rate (Hz) 5000", 5000.0, true),
            ("fs=5120", 5120.0, false),
            ("Abtastrate: 5,12 kHz", 5120.0, true),
            ("Sampling interval: 0.0002 s", 5000.0, true),
            ("dt [ms]: 0.2", 5000.0, true),
            ("#Sample rate: 100000Hz", 1e5, true),
            ("Sample Rate: 44100 Hz. Sample values on linear scale.", 44_100.0, true),
            ("Sampling Rate 51.2 kS/s", 51_200.0, true),
            ("Fréquence d'échantillonnage : 5000 Hz", 5000.0, true),
            ("Sample rate 5120 5120", 5120.0, false),
        ] {
            let declared = of_line(text, 1).unwrap_or_else(|| panic!("{text}"));
            assert!((declared.hz / hz - 1.0).abs() < 1e-12, "{text}: {}", declared.hz);
            assert_eq!(declared.states_unit, states_unit, "{text}");
        }
        for text in [
            "Sample rates vary",
            "Sample time: 12:00:01",
            "Force (N) Acc (g)",
            "Sample rate: 5,000 Hz",
            "Rated 5000 N",
            "dt 0.001",
            "fs",
            "",
            "Sample rate: 0 Hz",
            "Sample rate 5120 2560",
            "Sample rate 5 0 kHz",
            "Sample rate: 5 furlongs",
        ] {
            assert_eq!(of_line(text, 1), None, "{text}");
        }
    }
}
