//! `massline device stats`: the rig's counters since power-on, and what they mean.

use std::fmt::Write;

use massline_protocol::message::{Battery, Hardware, Identity, STEP_LIMIT_MS, Stats};
use massline_protocol::{BootReason, Clock};

use massline_report::document::{BatteryCharge, CounterFinding, DeviceStats};

/// Identity and counters of a rig.
#[derive(Debug)]
pub(super) struct Report<'a> {
    pub identity: &'a Identity,
    pub stats: Stats,
    pub hardware: Hardware,
    pub battery: Option<Battery>,
}

/// A counter for display.
struct StatLine {
    /// Its name on the wire, in `--json` and, with spaces, on the screen.
    name: &'static str,
    /// `None` when the rig does not have this counter.
    value: Option<u64>,
    unit: &'static str,
    /// What a value other than zero means, and what to do; empty when it needs no attention.
    meaning: &'static str,
}

const LITTLE_STACK: &str = "less than an eighth of the stack has never been used: nothing is wrong yet; \
                            please report it with these counters";
/// Below this supply an STM32 cannot be relied on to write its flash, mV.
const LOWEST_BROWN_OUT_MV: u16 = 2700;
const NO_CRYSTAL: &str = "the crystal does not oscillate, so the rig runs on the chip's own oscillator, which is a few \
                          per cent off: frequencies are wrong by as much, and USB may fail. Look for a broken joint at \
                          the crystal; else use another board";
const DEEP_BROWN_OUT: &str = "when its supply fails, the chip goes on for too long, and may spoil what it stores: \
                              `massline device brown-out` mends it";
const SUPPLY_LOW: &str = "its supply is too low to write flash, so nothing is stored: charge its battery, or try \
                          another cable or USB port";
const BATTERY_LOW: &str = "its cell is below 3.5 V: charge it";
const RESTARTED: &str = "it has restarted by itself and data that were not stored are lost: please report it with \
                         the last panic, if one is shown";

impl Report<'_> {
    pub fn json(&self) -> DeviceStats {
        let Self { identity, stats, hardware, battery } = self;
        let findings = self.findings().into_iter();
        DeviceStats {
            firmware: identity.firmware.as_str().to_owned(),
            boot_reason: BootReason::from(identity.boot_reason).name().into(),
            last_panic: identity.last_panic.as_str().to_owned(),
            clock: Clock::from(hardware.clock).name().into(),
            brown_out_mv: hardware.brown_out_mv,
            supply_is_low: hardware.supply_is_low,
            battery: battery
                .map(|Battery { millivolts, percent }| BatteryCharge { millivolts, percent }),
            uptime_ms: stats.uptime_ms,
            scans: stats.scans,
            triggers: stats.triggers,
            scans_lost: stats.scans_lost,
            overruns: stats.overruns,
            hits_aborted: stats.hits_aborted,
            longest_step_us: stats.longest_step_us,
            deadlines_missed: stats.deadlines_missed,
            frames_in: stats.frames_in,
            frames_out: stats.frames_out,
            frames_broken: stats.frames_broken,
            frames_unsent: stats.frames_unsent,
            bytes_dropped: stats.bytes_dropped,
            requests_refused: stats.requests_refused,
            requests_repeated: stats.requests_repeated,
            events_dropped: stats.events_dropped,
            stream_scans_dropped: stats.stream_scans_dropped,
            reconnects: stats.reconnects,
            flash_erases: stats.flash_erases,
            flash_bytes_written: stats.flash_bytes_written,
            read_back_failures: stats.read_back_failures,
            store_failures: stats.store_failures,
            stack_high_water: self.of_stack(stats.stack_high_water),
            stack_size: self.of_stack(stats.stack_size),
            stack_free: self.of_stack(self.stack_free()),
            findings: findings
                .map(|(counter, text)| CounterFinding {
                    counter: counter.into(),
                    text: text.into(),
                })
                .collect(),
        }
    }

    /// A number about the stack, where the board measures its use.
    fn of_stack(&self, bytes: u32) -> Option<u32> {
        (self.stats.stack_high_water > 0).then_some(bytes)
    }

    fn stack_free(&self) -> u32 {
        self.stats.stack_size.saturating_sub(self.stats.stack_high_water)
    }

    pub fn text(&self) -> String {
        let identity = self.identity;
        let started = BootReason::from(identity.boot_reason).name();
        let mut text = format!(
            "{}, firmware {}, up {}, started by {started}",
            identity.board,
            identity.firmware,
            duration(self.stats.uptime_ms),
        );
        // Writing to a String cannot fail.
        let clock = Clock::from(self.hardware.clock);
        if clock != Clock::Unknown {
            let _ = write!(text, "\nclock: {}", clock.name());
        }
        if let Some(level) = self.hardware.brown_out_mv {
            let volts = f64::from(level) / 1000.0;
            let _ =
                write!(text, "\nbrown-out level: {volts:.1} V, below which the chip resets itself");
        }
        if let Some(Battery { millivolts, percent }) = self.battery {
            let volts = f64::from(millivolts) / 1000.0;
            let _ = write!(text, "\nbattery: {percent} %, {volts:.2} V");
        }
        if !identity.last_panic.is_empty() {
            let _ = write!(text, "\nlast panic: {}", identity.last_panic);
        }
        for (group, lines) in self.groups() {
            let _ = write!(text, "\n{group}");
            for StatLine { name, value, unit, .. } in lines {
                let value = value.map_or("not counted".into(), |value| format!("{value} {unit}"));
                let name = name.trim_end_matches("_us").trim_end_matches("_ms").replace('_', " ");
                let _ = write!(text, "\n  {name:22}{}", value.trim_end());
            }
        }
        let findings = self.findings();
        if findings.is_empty() {
            return text + "\nnothing here needs attention";
        }
        text += "\nwhat that means";
        for (counter, meaning) in findings {
            let _ = write!(text, "\n- {}: {meaning}", counter.replace('_', " "));
        }
        text
    }

    /// The counters that need attention, and their meanings.
    fn findings(&self) -> Vec<(&'static str, &'static str)> {
        let lines = self.groups().into_iter().flat_map(|(_, lines)| lines);
        let mut findings: Vec<_> = lines
            .filter(|line| !line.meaning.is_empty() && line.value.is_some_and(|value| value > 0))
            .map(|line| (line.name, line.meaning))
            .collect();
        let Stats { stack_high_water, stack_size, .. } = self.stats;
        if stack_high_water > 0 && self.stack_free() < stack_size / 8 {
            findings.push(("stack_free", LITTLE_STACK));
        }
        if matches!(self.identity.boot_reason.into(), BootReason::Watchdog | BootReason::Panic) {
            findings.push(("boot_reason", RESTARTED));
        }
        findings.extend(self.of_hardware());
        findings
    }

    /// What clock and supply need.
    fn of_hardware(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let Hardware { clock, brown_out_mv, supply_is_low, .. } = self.hardware;
        let is_internal = Clock::from(clock) == Clock::Internal;
        let is_deep = brown_out_mv.is_some_and(|level| level < LOWEST_BROWN_OUT_MV);
        let conditions = [
            (is_internal, ("clock", NO_CRYSTAL)),
            (is_deep, ("brown_out_mv", DEEP_BROWN_OUT)),
            (supply_is_low, ("supply_is_low", SUPPLY_LOW)),
            (self.battery.is_some_and(|battery| battery.is_low()), ("battery", BATTERY_LOW)),
        ];
        conditions.into_iter().filter(|(applies, _)| *applies).map(|(_, finding)| finding)
    }

    fn groups(&self) -> [(&'static str, Vec<StatLine>); 5] {
        [
            ("sampling", self.sampling()),
            ("computing", self.computing()),
            ("link", self.link()),
            ("flash", self.flash()),
            ("stack", self.stack()),
        ]
    }

    fn sampling(&self) -> Vec<StatLine> {
        let Stats { scans, scans_lost, triggers, .. } = self.stats;
        vec![
            line("scans", scans, ""),
            line("triggers", triggers, ""),
            line("scans_lost", scans_lost, "").means(
                "the rig did not fetch them in time. Any hit affected was discarded and requested \
                 again; the results are right. If it continues, please report it",
            ),
            line("overruns", self.stats.overruns, "times"),
            line("hits_aborted", self.stats.hits_aborted, "").means(
                "scans of their records were lost: each of these hits was rejected and requested again",
            ),
        ]
    }

    fn computing(&self) -> Vec<StatLine> {
        let Stats { uptime_ms, deadlines_missed, .. } = self.stats;
        debug_assert_eq!(STEP_LIMIT_MS, 40, "the words below say so");
        vec![
            line("uptime_ms", uptime_ms, "ms"),
            line("longest_step_us", self.stats.longest_step_us, "µs of 40000 allowed"),
            line("deadlines_missed", deadlines_missed, "").means(
                "the rig computed for longer than 40 ms at a stretch; scans may have been lost then, \
                 which is counted above. Please report it",
            ),
        ]
    }

    fn link(&self) -> Vec<StatLine> {
        let stats = &self.stats;
        vec![
            line("frames_in", stats.frames_in, ""),
            line("frames_out", stats.frames_out, ""),
            line("frames_broken", stats.frames_broken, "").means(
                "invalid data arrived: a damaged message, a bad cable, or another program writing to \
                 this port. It was dropped and requested again; if the number grows, try another \
                 cable and close other programs",
            ),
            line("bytes_dropped", self.stats.bytes_dropped, "bytes"),
            line("requests_refused", stats.requests_refused, ""),
            line("requests_repeated", stats.requests_repeated, "").means(
                "an answer was lost or late on its way here and was sent again; nothing was done \
                 twice",
            ),
            line("frames_unsent", stats.frames_unsent, "").means(
                "nobody read them: this computer was suspended, or a program held the port and did \
                 not read. Measuring went on",
            ),
            line("events_dropped", stats.events_dropped, "").means(
                "hits that no program was told of because none was reading; they are measured and \
                 in the result",
            ),
            line("stream_scans_dropped", self.stats.stream_scans_dropped, "").means(
                "the stream has gaps there, because the link or the program was too slow. Plug the \
                 rig in directly and record again",
            ),
            line("reconnects", self.stats.reconnects, "times"),
        ]
    }

    fn flash(&self) -> Vec<StatLine> {
        vec![
            line("flash_erases", self.stats.flash_erases, "pages"),
            line("flash_bytes_written", self.stats.flash_bytes_written, "bytes"),
            line("read_back_failures", self.stats.read_back_failures, ""),
            line("store_failures", self.stats.store_failures, "").means(
                "the flash did not keep what was written, or something kept was found torn. A write \
                 is tried again elsewhere. When it grows the flash is worn out: download the results \
                 with `massline results`, then use another board",
            ),
        ]
    }

    fn stack(&self) -> Vec<StatLine> {
        let Stats { stack_high_water, stack_size, .. } = self.stats;
        let bytes = |name, value| {
            let value = self.of_stack(value).map(u64::from);
            StatLine { name, value, unit: "bytes", meaning: "" }
        };
        vec![
            bytes("stack_high_water", stack_high_water),
            bytes("stack_size", stack_size),
            bytes("stack_free", self.stack_free()),
        ]
    }
}

fn line(name: &'static str, value: impl Into<u64>, unit: &'static str) -> StatLine {
    StatLine { name, value: Some(value.into()), unit, meaning: "" }
}

impl StatLine {
    fn means(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }
}

/// A duration as text for people.
fn duration(milliseconds: u64) -> String {
    let seconds = milliseconds / 1000;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    match (hours, minutes) {
        (0, 0) => format!("{}.{} s", seconds, milliseconds / 100 % 10),
        (0, _) => format!("{minutes} min {} s", seconds % 60),
        _ => format!("{hours} h {minutes} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::signal::AdcProperties;
    use massline_shared::units::{Hertz, Seconds, Volts};

    fn identity(boot_reason: BootReason) -> Identity {
        let text = |text: &str| text.try_into().unwrap();
        Identity {
            protocol_major: 1,
            protocol_minor: 0,
            firmware: "0.1.0".try_into().unwrap(),
            git_hash: text("0123"),
            git_dirty: false,
            board: "virtual".try_into().unwrap(),
            adc: AdcProperties {
                rate: Hertz(4000.0),
                channels: 10,
                bits: 12,
                reference: Volts(3.0),
                channel_delay: Seconds(0.0),
            },
            record_scans: 2048,
            pre_trigger_scans: 80,
            max_sensors: 3,
            max_hits: 12,
            streams: true,
            boot_reason: boot_reason.into(),
            last_panic: Default::default(),
        }
    }

    fn findings(stats: Stats, boot_reason: BootReason) -> Vec<&'static str> {
        let identity = identity(boot_reason);
        let report =
            Report { identity: &identity, stats, hardware: Hardware::default(), battery: None };
        report.findings().into_iter().map(|(counter, _)| counter).collect()
    }

    #[test]
    fn a_dead_crystal_a_deep_level_and_a_low_supply_are_named() {
        let identity = identity(BootReason::PowerOn);
        let findings = |clock: Clock, brown_out_mv, supply_is_low| -> Vec<_> {
            let hardware = Hardware {
                clock: clock.into(),
                brown_out_mv,
                supply_is_low,
                ..Hardware::default()
            };
            let battery = supply_is_low.then_some(Battery { millivolts: 3400, percent: 3 });
            let report = Report { identity: &identity, stats: Stats::default(), hardware, battery };
            report.of_hardware().map(|(name, _)| name).collect()
        };
        assert_eq!(findings(Clock::Crystal, Some(2700), false), [""; 0]);
        assert_eq!(findings(Clock::Unknown, None, false), [""; 0]);
        assert_eq!(findings(Clock::Internal, Some(2800), false), ["clock"]);
        assert_eq!(
            findings(Clock::Internal, Some(1700), true),
            ["clock", "brown_out_mv", "supply_is_low", "battery"]
        );
    }

    #[test]
    fn a_rig_in_order_needs_no_attention() {
        let stats = Stats {
            scans: 5,
            frames_in: 3,
            requests_refused: 1,
            flash_erases: 3,
            reconnects: 4,
            ..Stats::default()
        };
        assert_eq!(findings(stats, BootReason::PowerOn), [""; 0]);
    }

    #[test]
    fn every_trouble_is_named_with_what_to_do() {
        let stats = Stats {
            scans_lost: 1,
            hits_aborted: 1,
            deadlines_missed: 1,
            frames_broken: 1,
            stack_high_water: 90,
            stack_size: 100,
            ..Stats::default()
        };
        assert_eq!(
            findings(stats, BootReason::Watchdog),
            [
                "scans_lost",
                "hits_aborted",
                "deadlines_missed",
                "frames_broken",
                "stack_free",
                "boot_reason"
            ]
        );
    }

    #[test]
    fn a_stack_that_is_not_measured_has_no_numbers() {
        let identity = identity(BootReason::PowerOn);
        let report = Report {
            identity: &identity,
            stats: Stats::default(),
            hardware: Hardware::default(),
            battery: None,
        };
        assert_eq!(report.json().stack_free, None);
    }

    #[test]
    fn the_document_has_every_counter_that_the_text_has() {
        let identity = identity(BootReason::PowerOn);
        let counted = Stats {
            uptime_ms: 1,
            scans: 2,
            scans_lost: 3,
            deadlines_missed: 4,
            triggers: 5,
            frames_in: 6,
            frames_broken: 7,
            requests_refused: 8,
            requests_repeated: 9,
            frames_out: 10,
            frames_unsent: 11,
            events_dropped: 12,
            store_failures: 13,
            stack_high_water: 14,
            overruns: 15,
            hits_aborted: 16,
            longest_step_us: 17,
            stream_scans_dropped: 18,
            bytes_dropped: 19,
            reconnects: 20,
            flash_erases: 21,
            flash_bytes_written: 22,
            read_back_failures: 23,
            stack_size: 24,
        };
        let report = Report {
            identity: &identity,
            stats: counted,
            hardware: Hardware::default(),
            battery: None,
        };
        let document = serde_json::to_value(report.json()).unwrap();
        let groups = report.groups();
        let lines: Vec<&StatLine> = groups.iter().flat_map(|(_, lines)| lines).collect();
        assert_eq!(lines.len(), 25);
        for line in lines {
            assert_eq!(document[line.name].as_u64(), line.value, "{}", line.name);
        }
    }

    #[test]
    fn an_uptime_reads_like_a_person_says_it() {
        let read = [900, 61_000, 7_260_000].map(duration);
        assert_eq!(read, ["0.9 s", "1 min 1 s", "2 h 1 min"]);
    }
}
