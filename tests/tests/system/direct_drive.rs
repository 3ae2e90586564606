//! A measurement driven without the firmware equals that of the rig byte for byte.

use massline::support::bench_test::nominal_calibration;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_protocol::object::{DofResult, MeasurementResult, StoredEstimate};
use massline_shared::diagnosis::Code;
use massline_shared::layout::{HitTreatment, RigLayout};
use massline_shared::measurement::campaign::Start;
use massline_shared::measurement::{Measurement, Memory, NextAction};
use massline_shared::units::ScanIndex;
use massline_tests::campaign::{THREE_BAR_TESTS, layout_file, measure};

/// The result from the same scans without firmware, executor, flash and link; the head is taken from the
/// rig's.
fn directly(
    layout: &RigLayout,
    bench: &Bench,
    seed: u64,
    of_rig: &MeasurementResult,
) -> MeasurementResult {
    let mut source = BenchSource::new(bench, &layout.cast().unwrap(), seed).unwrap();
    let mut memory = Box::new(Memory::<f32>::new());
    let mut measurement = Measurement::new(source.adc(), &mut memory);
    measurement.set_layout(layout.clone());
    measurement.set_calibration(nominal_calibration(bench), None);
    measurement.start(Start::DEFAULT, false, true).unwrap();
    loop {
        match measurement.next_action() {
            NextAction::Sample => {
                measurement.sampling_started();
                let dof = measurement.campaign().unwrap().dof();
                source.armed(measurement.armings(), dof);
                for index in 0.. {
                    measurement.feed(ScanIndex(index), &[source.next_scan().unwrap()]);
                    if measurement.next_action() != NextAction::Sample {
                        break;
                    }
                }
            }
            NextAction::Compute => measurement.work(),
            NextAction::StoreLines { dof } => {
                panic!("DOF {dof} has lines under the mass-line profile")
            }
            NextAction::Store => break,
            NextAction::Wait => panic!("the campaign was interrupted"),
        }
    }
    let result = measurement.result();
    let dofs = result.dofs.iter().zip(result.mass_lines);
    MeasurementResult {
        head: of_rig.head.clone(),
        dofs: dofs.map(|(details, lines)| DofResult::of(details, lines)).collect(),
        lines: Default::default(),
        estimates: result.estimates.iter().map(StoredEstimate::from).collect(),
        diagnostics: result.diagnostics.clone(),
    }
}

#[test]
fn the_rig_and_a_direct_drive_give_the_same_bytes() {
    let mut bench = Bench::named("default").unwrap();
    for (k, test) in THREE_BAR_TESTS.into_iter().enumerate() {
        let mut layout = layout_file(test).rig_layout().unwrap();
        // In the last two tests, inconsistent hits occur and are withdrawn.
        if k > 1 {
            bench.operator.misplaced_rate = 0.2;
            layout.test.policy =
                layout.test.policy.with(Code::HitInconsistent, HitTreatment::Reject);
        }
        let seed = 3 + k as u64;
        let source = BenchSource::new(&bench, &layout.cast().unwrap(), seed).unwrap();
        let rig = measure(Box::new(source), &layout, &mut ());
        let direct = directly(&layout, &bench, seed, &rig);
        assert_eq!(rig.estimates.len(), 2, "{:?}", rig.diagnostics);
        let bytes = |result: &MeasurementResult| postcard::to_stdvec(result).unwrap();
        assert_eq!(bytes(&direct), bytes(&rig));
    }
}
