//! The self-test by buttons: a reading at rest, whose channels are measured one by one, and what it says about wiring
//! and parts.

use massline_shared::diagnosis::{Diagnostic, Diagnostics};
use massline_shared::measurement::{Measurement, RecordContent};
use massline_shared::signal::self_test::{ChannelAtRest, KnownSensors, SelfTest, left_capacitors};

use crate::info::BoardInfo;

/// Channels on a page.
pub const CHANNELS_PER_PAGE: usize = 4;

/// A self-test, as far as it has come.
pub(crate) enum SelfTestRun {
    /// The channels are being read.
    Reading,
    /// The channels before this one have been measured.
    Measuring(SelfTest<f32>, usize),
    /// What the channels read, none when the converter does not answer, and the faults, those that explain others
    /// first.
    Done(Option<SelfTest<f32>>, Diagnostics),
    /// Something else has taken the record.
    Disturbed,
}

/// State of a self-test, which decides what is shown and what a button does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfTestState {
    /// There is none.
    Off,
    /// It runs.
    Running {
        /// Percentage of it that is done.
        percent: u8,
    },
    /// It has ended.
    Done {
        /// Number of faults.
        findings: u8,
        /// Number of channels that have been measured.
        channels: u8,
    },
    /// Something else has taken the record.
    Disturbed,
}

impl SelfTestState {
    /// Number of pages: one for each fault, or one that says that there is none, then those of the channels.
    pub fn pages(self) -> u8 {
        match self {
            Self::Done { findings, channels } => {
                findings.max(1) + channels.div_ceil(CHANNELS_PER_PAGE as u8)
            }
            _ => 1,
        }
    }
}

impl SelfTestRun {
    /// Its state.
    pub fn state(&self) -> SelfTestState {
        match self {
            Self::Reading => SelfTestState::Running { percent: 0 },
            Self::Measuring(test, next) => {
                SelfTestState::Running { percent: (100 * next / test.count().max(1)) as u8 }
            }
            Self::Done(test, findings) => SelfTestState::Done {
                findings: findings.len() as u8,
                channels: test.map_or(0, |test| test.count() as u8),
            },
            Self::Disturbed => SelfTestState::Disturbed,
        }
    }

    /// What the channels read, once all have been measured.
    pub fn channels(&self) -> &[ChannelAtRest<f32>] {
        match self {
            Self::Done(Some(test), _) => test.channels(),
            _ => &[],
        }
    }

    /// The faults, once it has ended.
    pub fn findings(&self) -> &Diagnostics {
        const NONE: &Diagnostics = &Diagnostics::new();
        match self {
            Self::Done(_, findings) => findings,
            _ => NONE,
        }
    }

    /// Goes on with it by one channel; false when there is nothing to do until the rig changes.
    pub fn step(
        &mut self,
        measurement: &mut Measurement<'_, f32>,
        info: &BoardInfo,
        knows_sensors: bool,
    ) -> bool {
        let waits = matches!(self, Self::Reading) && measurement.reads();
        if waits || matches!(self, Self::Done(..) | Self::Disturbed) {
            return false;
        }
        *self = match (&mut *self, measurement.recorded()) {
            (Self::Reading, RecordContent::Reading) => {
                Self::Measuring(SelfTest::new(measurement.adc()), 0)
            }
            (Self::Reading, RecordContent::ReadingFailed) => {
                let (mut findings, hardware) = (Diagnostics::new(), info.hardware());
                put(&mut findings, &mut hardware.findings());
                put(&mut findings, &mut [hardware.converter_finding()].into_iter());
                Self::Done(None, findings)
            }
            (Self::Measuring(..), _) if !measurement.is_idle() => Self::Disturbed,
            (Self::Measuring(test, next), RecordContent::Reading) if *next < test.count() => {
                measurement.test_channel(test, *next);
                Self::Measuring(*test, *next + 1)
            }
            (Self::Measuring(test, _), RecordContent::Reading) => {
                let calibration = measurement.calibration();
                let known = knows_sensors.then_some(KnownSensors(calibration));
                let mut findings = Diagnostics::new();
                put(&mut findings, &mut info.hardware().findings());
                put(&mut findings, &mut test.findings(info.circuit, known).iter().copied());
                put(&mut findings, &mut left_capacitors(calibration));
                Self::Done(Some(*test), findings)
            }
            _ => Self::Disturbed,
        };
        true
    }
}

/// Adds faults to a list. One that is full names enough.
fn put(findings: &mut Diagnostics, more: &mut dyn Iterator<Item = Diagnostic>) {
    for diagnostic in more {
        let _ = findings.push(diagnostic);
    }
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;
    use std::vec::Vec;

    use massline_protocol::{BootReason, Clock, ConverterFault};
    use massline_shared::diagnosis::Code;
    use massline_shared::measurement::Memory;
    use massline_shared::signal::{AdcProperties, CHANNELS, RECORD_SCANS, Scan};
    use massline_shared::units::{Hertz, ScanIndex, Seconds, Volts};

    use super::*;
    use crate::info::{Circuit, StackUse, Supply};

    const INFO: BoardInfo = BoardInfo {
        name: "a-board",
        firmware: "1.2.3",
        git_hash: "",
        git_dirty: false,
        boot_reason: BootReason::PowerOn,
        clock: Clock::Internal,
        supply: Supply::STEADY,
        circuit: Circuit { flash_select: None },
        converter_fault: || (ConverterFault::WrongTag, 5),
        last_panic: "",
        stack: StackUse::default,
    };

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        bits: 12,
        channels: CHANNELS as u8,
        reference: Volts(3.3),
        channel_delay: Seconds(0.0),
    };

    fn codes(run: &SelfTestRun) -> Vec<Code> {
        run.findings().iter().map(|finding| finding.code).collect()
    }

    /// Runs a self-test after `feed`, until it has nothing to do; returns it and the number of its steps.
    fn run(feed: impl Fn(&mut Measurement<'_, f32>)) -> (SelfTestRun, usize) {
        let mut memory = Box::new(Memory::<f32>::new());
        let mut measurement = Measurement::new(ADC, &mut memory);
        measurement.take_reading().expect("the rig is idle");
        measurement.sampling_started();
        let (mut run, mut steps) = (SelfTestRun::Reading, 0);
        assert!(!run.step(&mut measurement, &INFO, false), "there is no reading yet");
        feed(&mut measurement);
        while run.step(&mut measurement, &INFO, false) {
            steps += 1;
        }
        (run, steps)
    }

    #[test]
    fn a_channel_is_measured_in_each_step_and_what_is_wrong_is_named() {
        // A code and a half of noise about 1.5 V on all inputs, but nothing on those of sensor 3.
        let noise = |scan: usize, channel: usize| {
            let mixed = ((scan * CHANNELS + channel) as u32).wrapping_mul(2_654_435_761);
            ((mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 16) as u16 % 6
        };
        let scan = |scan: usize| -> Scan {
            core::array::from_fn(|channel| match channel {
                7.. => 1,
                0 => 133 + noise(scan, 0),
                _ => 1860 + noise(scan, channel),
            })
        };
        let (run, steps) = run(|measurement| {
            let scans: Vec<Scan> = (0..RECORD_SCANS).map(scan).collect();
            measurement.feed(ScanIndex(0), &scans);
        });
        assert_eq!(steps, CHANNELS + 2);
        assert_eq!(run.state(), SelfTestState::Done { findings: 2, channels: 10 });
        assert_eq!(run.state().pages(), 5);
        assert_eq!(codes(&run), [Code::CrystalDead, Code::SensorSilent]);
        assert_eq!(run.channels().len(), CHANNELS);
    }

    #[test]
    fn a_converter_that_does_not_answer_is_named() {
        let (run, _) = run(|measurement| measurement.stopped());
        assert_eq!(codes(&run), [Code::CrystalDead, Code::ConverterWrongTag]);
        assert_eq!(run.state(), SelfTestState::Done { findings: 2, channels: 0 });
    }

    #[test]
    fn another_reading_between_two_channels_ends_it() {
        let mut memory = Box::new(Memory::<f32>::new());
        let mut measurement = Measurement::new(ADC, &mut memory);
        measurement.take_reading().expect("the rig is idle");
        measurement.sampling_started();
        measurement.feed(ScanIndex(0), &[[1000; CHANNELS]; RECORD_SCANS]);
        let mut run = SelfTestRun::Reading;
        for _ in 0..3 {
            assert!(run.step(&mut measurement, &INFO, false));
        }
        assert_eq!(run.state(), SelfTestState::Running { percent: 20 });
        measurement.take_reading().expect("the rig is idle");
        assert!(run.step(&mut measurement, &INFO, false));
        assert_eq!(run.state(), SelfTestState::Disturbed);
    }

    #[test]
    fn a_reading_that_is_taken_away_ends_it() {
        let (run, _) = run(|measurement| measurement.drop_reading());
        assert_eq!(run.state(), SelfTestState::Disturbed);
        assert_eq!(run.state().pages(), 1);
    }
}
