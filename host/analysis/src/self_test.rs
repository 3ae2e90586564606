//! The self-test of a rig at rest, in double precision: what it reads, and the faults that this shows.

use massline_protocol::message::Hardware;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::signal::self_test::{
    ChannelAtRest, Circuit, KnownSensors, SelfTest, left_capacitors,
};
use massline_shared::signal::{AdcProperties, Scan};

/// What a rig reads at rest, and the faults that this shows.
#[derive(Debug)]
pub struct RigAtRest {
    /// What the channels read; `None` when the converter does not answer.
    test: Option<SelfTest<f64>>,
    /// The faults, those that explain others first.
    pub findings: Vec<Diagnostic>,
}

impl RigAtRest {
    /// Examines a record without motion from a rig with this circuit.
    pub fn of(
        record: &[Scan],
        adc: &AdcProperties,
        circuit: Circuit,
        calibration: &CalibrationRecord,
        hardware: Hardware,
    ) -> Self {
        let mut test = SelfTest::new(adc);
        let mut room = vec![0.0; record.len()];
        for channel in 0..test.count() {
            test.add(record, channel, &mut room);
        }
        let known =
            calibration.method.knows_sensors().then_some(KnownSensors(&calibration.calibration));
        let mut findings: Vec<_> = hardware.findings().collect();
        findings.extend(test.findings(circuit, known));
        findings.extend(left_capacitors(&calibration.calibration));
        Self { test: Some(test), findings }
    }

    /// A rig whose converter does not answer.
    pub fn of_stopped(hardware: Hardware) -> Self {
        let findings = hardware.findings().chain([hardware.converter_finding()]).collect();
        Self { test: None, findings }
    }

    /// What the channels read, the hammer first; none when the converter does not answer.
    pub fn channels(&self) -> &[ChannelAtRest<f64>] {
        self.test.as_ref().map_or(&[], SelfTest::channels)
    }
}
