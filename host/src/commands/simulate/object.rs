//! What `massline simulate` simulates: the object that the layout states, or that of a bench.

use std::path::Path;

use massline_physics::Bench;
use massline_physics::suspension::Suspension;
use massline_shared::STANDARD_GRAVITY;
use massline_shared::body::RigidBody;
use massline_shared::layout::{HostLayout, TestProfile};
use massline_shared::signal::Calibration;
use nalgebra::{SVector, Vector3};

use crate::output::counted;
use crate::support::bench_test::{BenchArgs, open_bench};
use crate::{Error, Result};
use massline_analysis::bench_error::bench_error;
use massline_files::layout_file::LayoutFile;
use massline_report::words::as_exact_as;

/// Frequency of the highest suspension mode of an object whose mass lines are measured, Hz: cords that are soft enough
/// for the default band.
const SOFT_HZ: f64 = 3.0;
/// The same where the suspension modes themselves are measured, Hz: as on the wheel of the literature.
const STIFF_HZ: f64 = 7.5;

/// Part of a sensor's range up to which a person lets an object move.
const COMFORTABLE: f64 = 0.7;
/// Part of it below which a person hits harder.
const FEEBLE: f64 = 0.05;
/// A person does not hit harder, N: the hammer's channel ends at 128 N.
const HARDEST_N: f64 = 100.0;

/// A simulated object on its bench.
#[derive(Clone, Debug)]
pub(super) struct SimulatedObject {
    /// The bench.
    pub(super) bench: Bench,
    /// What is simulated, in a line.
    pub(super) description: String,
}

impl SimulatedObject {
    /// The object of `--bench` or, without it, the one that the layout's `[reference]` states, as a rigid body on soft
    /// cords.
    ///
    /// # Errors
    /// When the bench is bad, or the layout does not state an object.
    pub(super) fn of(
        args: &BenchArgs,
        suspension_hz: Option<f64>,
        file: &LayoutFile,
        path: &Path,
    ) -> Result<Self> {
        let (bench, place) = match &args.bench {
            Some(name) => (args.open()?, format!(", bench {name}")),
            None => {
                let stated = stated(file, suspension_hz);
                let (bench, place) = stated.map_err(|error| error.within(path.display()))?;
                (args.with_faults(bench), place)
            }
        };
        let description = describe(&bench, &place);
        Ok(Self { bench, description })
    }
}

/// What a bench simulates, in a line; `place` follows.
pub(in crate::commands) fn describe(bench: &Bench, place: &str) -> String {
    // Three digits.
    let mass = as_exact_as(bench.body.mass, Some(bench.body.mass * 1e-1));
    let elastic = match bench.elastic.len() {
        0 => "no elastic modes".into(),
        count => counted(count, "elastic mode"),
    };
    let suspension = match &bench.suspension {
        Suspension::Frequencies { hz, .. } => {
            format!("suspension {} Hz", hz.iter().fold(0.0_f64, |most, f| most.max(*f)))
        }
        Suspension::Cords { cords, .. } => counted(cords.len(), "cord"),
    };
    let is_rigid = bench.elastic.is_empty() && bench.sprung_part.is_none();
    let kind = if is_rigid { "rigid body" } else { "body" };
    format!("simulated: {kind} of {mass} kg, {elastic}, {suspension}{place}")
}

/// Lets a person hit a light object so gently that no sensor comes near the end of its range, but as hard as the rig
/// accepts, and a heavy one harder than usual; returns how, for a description.
fn suit(force_n: &mut [f64; 2], layout: &HostLayout, body: &RigidBody<f64>) -> String {
    let hits = (0..layout.hits.len()).filter_map(|hit| layout.accelerance(body, hit));
    let most = hits.map(|accelerance| accelerance.largest()).fold(0.0, f64::max);
    let range = (Calibration::ADXL326_RANGE_G - 1.0) * STANDARD_GRAVITY;
    let [weakest, hardest] = *force_n;
    let least = layout.test.trigger_n.max(layout.test.min_peak_force_n);
    let gentle = (COMFORTABLE * range / most).max(least * hardest / weakest);
    let is_feeble = most * hardest < FEEBLE * range;
    if gentle >= hardest && !is_feeble {
        return String::new();
    }
    let suited = gentle.min(HARDEST_N);
    *force_n = [suited * weakest / hardest, suited];
    format!(", hits of {:.0} to {suited:.0} N", force_n[0])
}

/// The bench with the object that a layout states, and how it is hit where that is not as usual.
fn stated(file: &LayoutFile, suspension_hz: Option<f64>) -> Result<(Bench, String)> {
    let reference = file.reference.and_then(|reference| reference.complete());
    let theta = reference.ok_or_else(|| {
        Error::input(
            "object_not_stated",
            "the layout does not state which object to simulate: give all ten properties in [reference] (mass_kg, \
             center_of_mass_m, inertia_kg_m2; estimates from CAD will do), or choose a bench, such as --bench default, \
             the three-bar frame of the demo",
        )
    })?;
    if file.is_reference_doubtful() {
        let text = format!("this object is not simulated: {}", file.suspicions().join("; "));
        return Err(Error::input("object_doubtful", text));
    }
    let body = RigidBody::from_theta(&SVector::from(theta));
    let (chain, usual_hz) = match file.layout.test.profile {
        TestProfile::MassLine => ("default", SOFT_HZ),
        // A soft mallet and records of 40 s.
        TestProfile::Suspension => ("wheel", STIFF_HZ),
    };
    let mut chain = open_bench(chain)?;
    if let Some(gravity) = file.layout.gravity {
        chain.gravity = Vector3::from(gravity);
    }
    let hits = suit(&mut chain.tap.force_n, &file.layout, &body);
    let highest_hz = suspension_hz.unwrap_or(usual_hz);
    let bench = chain.with_rigid_body(body, highest_hz);
    Ok((bench.map_err(|error| bench_error(error).within("[reference]"))?, hits))
}
