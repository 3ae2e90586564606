//! The self-test of a rig at rest as text and JSON.

use std::fmt::Write;

use massline_analysis::self_test::RigAtRest;
use massline_result::Finding;
use massline_shared::diagnosis::{Diagnostic, Subject};
use massline_shared::signal::self_test::ChannelAtRest;
use massline_shared::signal::{Calibration, HAMMER};

use crate::document::{ChannelCheck, DeviceCheck};
use crate::words::{channel_name, message};

/// As a document.
pub fn json(at_rest: &RigAtRest) -> DeviceCheck {
    let channels = at_rest.channels().iter().enumerate();
    let finding = |diagnostic: &Diagnostic| Finding {
        code: diagnostic.code.into(),
        severity: diagnostic.severity.into(),
        message: message(diagnostic),
    };
    DeviceCheck {
        channels: channels.map(|(channel, at_rest)| channel_json(channel, at_rest)).collect(),
        findings: at_rest.findings.iter().map(finding).collect(),
    }
}

/// For people: a table of the channels, and the faults.
pub fn text(at_rest: &RigAtRest) -> String {
    let mut text = match at_rest.channels() {
        [] => String::new(),
        channels => channel_table(channels),
    };
    if at_rest.findings.is_empty() {
        return text + "no fault found (checked at rest only)";
    }
    text += "what is wrong";
    for diagnostic in &at_rest.findings {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n- {}: {}", diagnostic.code, message(diagnostic));
    }
    text
}

fn channel_table(channels: &[ChannelAtRest<f64>]) -> String {
    let head = |headings: [&str; 6]| {
        let [channel, level, noise, hum_50, hum_60, screen] = headings;
        format!("{channel:12}{level:>8}{noise:>9}{hum_50:>9}{hum_60:>9}{screen:>9}\n")
    };
    let mut text = head(["channel", "level", "noise", "50 Hz", "60 Hz", "screen"]);
    text += &head(["", "V", "mV rms", "mV", "mV", "mV"]);
    for (channel, at_rest) in channels.iter().enumerate() {
        let ChannelAtRest { level, noise, hum_50_hz, hum_60_hz, screen, .. } = *at_rest;
        let name = channel_name(channel);
        let _ = write!(text, "{name:12}{level:8.3}");
        for volts in [noise, hum_50_hz, hum_60_hz, screen] {
            let _ = write!(text, "{:9.2}", 1e3 * volts);
        }
        text.push('\n');
    }
    let _ = writeln!(text, "1 mg of a sensor is {:.3} mV", Calibration::ADXL326_VOLT_PER_G);
    text
}

fn channel_json(channel: usize, at_rest: &ChannelAtRest<f64>) -> ChannelCheck {
    let per_g = Calibration::ADXL326_VOLT_PER_G;
    ChannelCheck {
        channel: channel_name(channel),
        level_v: at_rest.level,
        noise_v: at_rest.noise,
        noise_g: (channel != HAMMER).then_some(at_rest.noise / per_g),
        hum_50_hz_v: at_rest.hum_50_hz,
        hum_60_hz_v: at_rest.hum_60_hz,
        screen_v: at_rest.screen,
    }
}

/// Code and subject of a finding, as in `axis_silent: sensor 1 x`.
pub fn name(diagnostic: &Diagnostic) -> String {
    let code = diagnostic.code.to_string();
    match diagnostic.subject {
        Subject::Channel(channel) => format!("{code}: {}", channel_name(channel.into())),
        Subject::Sensor(sensor) => format!("{code}: sensor {}", u16::from(sensor) + 1),
        _ => code,
    }
}

#[cfg(test)]
mod tests {
    use massline_protocol::message::Hardware;
    use massline_protocol::{Clock, ConverterFault};

    use super::*;

    #[test]
    fn a_converter_that_does_not_answer_is_named_by_its_frames() {
        let codes = |converter: ConverterFault, clock: Clock| {
            let (converter, clock) = (converter.into(), clock.into());
            let hardware = Hardware { converter, wrong_tag: 5, clock, ..Hardware::default() };
            RigAtRest::of_stopped(hardware).findings.iter().map(name).collect::<Vec<_>>()
        };
        let alone = |converter| codes(converter, Clock::Crystal);
        assert_eq!(alone(ConverterFault::None), ["sampler_stopped"]);
        assert_eq!(alone(ConverterFault::LineHigh), ["converter_line_high"]);
        assert_eq!(alone(ConverterFault::LineLow), ["converter_line_low"]);
        assert_eq!(alone(ConverterFault::NoCommands), ["converter_without_commands"]);
        let both = codes(ConverterFault::WrongTag, Clock::Internal);
        assert_eq!(both, ["crystal_dead", "converter_wrong_tag"]);
        let hardware = Hardware {
            converter: ConverterFault::WrongTag.into(),
            wrong_tag: 5,
            ..Hardware::default()
        };
        assert!(text(&RigAtRest::of_stopped(hardware)).contains("says channel 5"));
    }
}
