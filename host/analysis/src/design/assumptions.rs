//! What a prediction assumes of an object that nobody has measured yet: its body and, in the suspension profile, how it
//! hangs.

use massline_physics::Bench;
use massline_physics::suspension::{RigidMode, Suspension, rigid_modes};
use massline_shared::body::RigidBody;
use massline_shared::design::{Criterion, DEFAULT_NOISE};
use massline_shared::layout::{HostLayout, TestProfile, TestSettings};
use massline_shared::signal::ringing_s;
use nalgebra::Vector3;

use super::assumed_body::body_for_checks;
use super::criterion::LayoutCriterion;
use super::noise;
use super::suspension::SuspensionCriterion;
use crate::Result;
use crate::bench_error::bench_error;
use massline_files::layout_file::LayoutFile;

/// Bench with the measuring chain of a test that is only computed.
const COMPUTED: &str = "ideal";
/// Damping ratio of an assumed suspension: that of elastic cords, 1 to 2 %.
const DAMPING_RATIO: f64 = 0.015;
/// Where the assumed modes lie in the band, from 0 at its lower to 1 at its upper end on a logarithmic scale, along x,
/// y and z, then about the principal axes: 2 to 8 Hz in the default band.
const PLACES: [f64; 6] = [0.43, 0.50, 0.57, 0.65, 0.75, 0.86];

/// The assumed object.
#[derive(Clone, Debug, PartialEq)]
pub struct Assumptions {
    /// Its properties.
    pub body: RigidBody<f64>,
    /// A sentence that names their origin.
    pub whose: String,
    /// In the suspension profile, how it hangs.
    pub hanging: Option<HangingObject>,
}

/// The object as it hangs.
#[derive(Clone, Debug, PartialEq)]
pub struct HangingObject {
    /// The bench that it hangs on.
    pub bench: Bench,
    /// Its six modes.
    pub modes: [RigidMode; 6],
}

impl Assumptions {
    /// What a layout file states, or the object of this bench.
    ///
    /// # Errors
    /// When the object of the bench cannot hang as described.
    pub fn of(file: &LayoutFile, bench: Option<&Bench>) -> Result<Self> {
        let (body, whose) = match bench {
            Some(bench) => (
                bench.truth(),
                format!("the layout was checked with the object of bench {:?}", bench.title),
            ),
            None => body_for_checks(file),
        };
        let test = &file.layout.test;
        if test.profile == TestProfile::MassLine {
            return Ok(Self { body, whose, hanging: None });
        }
        let (bench, whose) = match bench {
            Some(bench) => (bench.clone(), whose),
            None => {
                let gravity = file.layout.gravity.map_or_else(Vector3::zeros, Vector3::from);
                let assumed = assumed_bench(body, gravity, test)?;
                (assumed, format!("{whose}; {}", about_suspension(test)))
            }
        };
        let modes =
            rigid_modes(&bench.body, &bench.suspension, &bench.gravity).map_err(bench_error)?;
        Ok(Self { body, whose, hanging: Some(HangingObject { bench, modes }) })
    }

    /// The noise of an accelerance of one hit that is assumed for the test of a layout where none is stated, relative
    /// to 1/m.
    pub fn usual_noise(&self, layout: &HostLayout) -> f64 {
        match &self.hanging {
            None => DEFAULT_NOISE,
            Some(hanging) => {
                let record_s = hanging.record_s(layout);
                noise::of_one_hit(&layout.test, self.body.mass, record_s) * self.body.mass
            }
        }
    }

    /// The criterion for the tests of a layout. `noise` is relative to 1/m; `length` scales the inertial parameters, m.
    pub fn criterion(&self, layout: &HostLayout, length: f64, noise: f64) -> LayoutCriterion {
        let plain = Criterion::new(self.body, length, noise);
        match &self.hanging {
            None => LayoutCriterion::MassLine(plain),
            Some(hanging) => {
                let record_s = hanging.record_s(layout);
                let criterion = SuspensionCriterion::new(plain, &hanging.modes, layout, record_s);
                LayoutCriterion::Suspension(Box::new(criterion))
            }
        }
    }
}

impl HangingObject {
    /// How long the object rings in a record of a test with this layout, s.
    pub(super) fn record_s(&self, layout: &HostLayout) -> f64 {
        ringing_s(&self.bench.converter(layout.sensors.len()))
    }
}

/// Frequencies of the assumed modes, Hz.
fn assumed_hz(test: &TestSettings<f64>) -> [f64; 6] {
    let [low, high] = test.expected_band();
    PLACES.map(|place| low * (high / low).powf(place))
}

fn assumed_bench(
    body: RigidBody<f64>,
    gravity: Vector3<f64>,
    test: &TestSettings<f64>,
) -> Result<Bench> {
    let suspension = Suspension::Frequencies { hz: assumed_hz(test), damping_ratio: DAMPING_RATIO };
    let computed = Bench::named(COMPUTED).map_err(bench_error)?;
    Ok(Bench { body, suspension, gravity, elastic: Vec::new(), nodes: Vec::new(), ..computed })
}

fn about_suspension(test: &TestSettings<f64>) -> String {
    let hz = assumed_hz(test).map(|hz| format!("{hz:.1}"));
    format!(
        "it is assumed to hang with modes along x, y and z at {}, {} and {} Hz and about its principal axes at {}, {} \
         and {} Hz, {} % damped; --bench takes object and suspension of a bench",
        hz[0],
        hz[1],
        hz[2],
        hz[3],
        hz[4],
        hz[5],
        100.0 * DAMPING_RATIO
    )
}
