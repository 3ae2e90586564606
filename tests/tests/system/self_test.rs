//! The self-test of a rig against faults of wiring and parts, and against rigs without any.

mod circuit;
mod faults;
mod sound;

use std::sync::Arc;

use massline_analysis::self_test::RigAtRest;
use massline_client::flash::board::circuit_of;
use massline_firmware::board::{Clock, Supply};
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::signal::{AdcProperties, Scan};
use massline_tests::campaign::{connect, steady_hand, three_bar};
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

use circuit::{Circuit, RealBoard};

/// Outputs of the ten channels at the rig's inputs, V, and the time, s.
type Wires = [f64; 10];
/// What a fault does to them.
type Effect = Arc<dyn Fn(&mut Wires, f64) + Send + Sync>;

/// A bench whose wires pass a fault on their way to the converter.
struct FaultySource {
    bench: BenchSource,
    effect: Effect,
    scans: u32,
}

impl ScanSource for FaultySource {
    fn adc(&self) -> AdcProperties {
        self.bench.adc()
    }

    fn started(&mut self) {
        self.bench.started();
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.bench.armed(arming, dof);
    }

    fn next_scan(&mut self) -> Option<Scan> {
        let scan = self.bench.next_scan()?;
        let adc = self.adc();
        let code = f64::from(adc.volts_per_code());
        let mut wires = scan.map(|sample| f64::from(sample) * code);
        (self.effect)(&mut wires, f64::from(self.scans) / f64::from(adc.rate.0));
        self.scans += 1;
        Some(wires.map(|volts| (volts / code).round().clamp(0.0, adc.full_scale().into()) as u16))
    }
}

/// A rig, sound or with a fault.
struct Rig {
    bench: Bench,
    effect: Effect,
    clock: Clock,
    supply: Supply,
    calibration: CalibrationRecord,
}

impl Rig {
    /// A rig on this bench whose calibration is that of the data sheets.
    fn on(bench: Bench) -> Self {
        Self {
            bench,
            effect: Arc::new(|_, _| ()),
            clock: Clock::Crystal,
            supply: Supply::STEADY,
            calibration: CalibrationRecord::default(),
        }
    }

    /// What its self-test finds: the code and the subject of each finding.
    fn examine(&self, board: RealBoard, seed: u64) -> Vec<String> {
        let bench = BenchSource::new(&self.bench, &three_bar().layout, seed).expect("is sound");
        let source = FaultySource { bench, effect: self.effect.clone(), scans: 0 };
        let (clock, supply) = (self.clock, self.supply);
        let options =
            VirtualRigOptions { clock, supply, ..VirtualRigOptions::new(Box::new(source)) };
        let rig = VirtualRig::start(options).expect("the rig starts");
        let mut client = connect(&rig);
        let adc = client.identify().unwrap().adc;
        assert_eq!(adc, board.adc);
        client.rest_statistics().unwrap();
        let record = client.rest_record().unwrap().expect("the rig gives its record");
        let hardware = client.hardware().unwrap().unwrap();
        let check =
            RigAtRest::of(&record, &adc, circuit_of(board.name), &self.calibration, hardware);
        check.findings.iter().map(massline_report::self_test::name).collect()
    }
}

/// A bench with the converter and the supply of a board.
fn bench(board: RealBoard) -> Bench {
    let mut bench = steady_hand("default");
    bench.adc.rate_hz = board.adc.rate.0.into();
    bench.adc.bits = board.adc.bits;
    bench.adc.reference_v = board.adc.reference.0.into();
    bench.adc.channel_delay_s = board.adc.channel_delay.0.into();
    bench.supply.voltage_v = board.supply;
    bench
}

#[test]
fn every_fault_is_named_on_every_board_and_nothing_else_is() {
    let mut wrong = Vec::new();
    for board in circuit::boards() {
        let circuit = Circuit::around(board);
        let cases = faults::cases(&circuit);
        assert!(cases.len() >= 40, "{}", cases.len());
        for case in cases {
            let findings = case.rig.examine(board, 1);
            if findings != case.named {
                let (name, named) = (case.name, case.named);
                wrong.push(format!("{}, {name}: {findings:?} instead of {named:?}", board.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn two_hundred_sound_rigs_pass() {
    let circuits = circuit::boards().map(Circuit::around);
    let failed: Vec<_> = (1..=200)
        .zip(circuits.iter().cycle())
        .map(|(seed, circuit)| (seed, sound::rig(circuit, seed).examine(circuit.board, seed)))
        .filter(|(_, findings)| !findings.is_empty())
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
