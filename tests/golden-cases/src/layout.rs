//! `g_layout_`: diagnosis, ranks, conditions and the bound of a layout. This module also reads the
//! layouts of the other cases from their inputs.

use heapless::Vec;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Rig;
use massline_shared::identify::DofMassLines;
use massline_shared::identify::maximum_likelihood::{Bound, RIG_WORKSPACE, bound};
use massline_shared::layout::{
    Axis, Dof, Hit, HitUncertainty, Layout, LayoutReport, Sensor, SensorUncertainty, Sign,
};
use massline_shared::{Real, Responses};
use nalgebra::SVector;

use crate::Check;

/// Number of sensors of a [`GoldenLayout`].
pub(crate) const SENSORS: usize = 3;
/// Number of responses of a [`GoldenLayout`].
pub(crate) const RESPONSES: usize = 3 * SENSORS;
/// The layout of a golden case: three triaxial sensors and up to five hits.
pub type GoldenLayout<R> = Layout<R, Rig>;
/// Responses of a [`GoldenLayout`].
pub(crate) type GoldenResponses<R> = Responses<R, Rig>;
/// Mass lines of the hit DOFs of a [`GoldenLayout`].
pub(crate) type GoldenDofs<R> = Vec<DofMassLines<R, Rig>, 5>;

impl<R: Real> Check<'_, '_, R> {
    /// The layout from the sensors, hits and gravity of the inputs.
    pub fn layout(&self) -> Option<GoldenLayout<R>> {
        Some(GoldenLayout {
            gravity: self.input_array::<3>("gravity"),
            sensors: self.sensors("sensors.p", "sensors.R")?,
            // A case without hits gives shapes or columns of forces.
            hits: self.hits("hits.q", "hits.d").unwrap_or_default(),
            ..GoldenLayout::default()
        })
    }

    /// Sensors from the inputs that hold their positions and axes; `None` when there are more than `N`.
    pub(crate) fn sensors<const N: usize>(
        &self,
        positions: &str,
        axes: &str,
    ) -> Option<Vec<Sensor<R>, N>> {
        let (mut positions, mut axes) = (self.input(positions)?, self.input(axes)?);
        let mut sensors = Vec::new();
        while let Some(position) = triple(&mut positions) {
            let [a, b, c] = [triple(&mut axes)?, triple(&mut axes)?, triple(&mut axes)?];
            // The columns of R are the axes.
            let axes = core::array::from_fn(|axis| [a[axis], b[axis], c[axis]]);
            let node = sensors.len() as u16 + 1;
            sensors.push(Sensor::new(node, position, axes)).ok()?;
        }
        Some(sensors)
    }

    /// Hits from the inputs that hold their points and directions; `None` when there are more than `N`.
    pub(crate) fn hits<const N: usize>(
        &self,
        points: &str,
        directions: &str,
    ) -> Option<Vec<Hit<R>, N>> {
        let (mut points, mut directions) = (self.input(points)?, self.input(directions)?);
        let mut hits = Vec::new();
        while let Some(point) = triple(&mut points) {
            let dof = Dof { node: hits.len() as u16 + 101, sign: Sign::Plus, axis: Axis::X };
            hits.push(Hit::new(dof, point, triple(&mut directions)?)).ok()?;
        }
        Some(hits)
    }

    /// The bound with the noise and the hit errors of the inputs and no other errors, averaged over
    /// `hits` hits at each DOF.
    pub(crate) fn bound(
        &self,
        layout: &GoldenLayout<R>,
        body: &RigidBody<R>,
        hits: u16,
    ) -> Option<Bound<R>> {
        let mut layout = layout.clone();
        layout.apparatus.hammer_gain = R::zero();
        for sensor in &mut layout.sensors {
            sensor.uncertainty = SensorUncertainty::none();
        }
        for hit in &mut layout.hits {
            hit.uncertainty = HitUncertainty {
                position: self.input_number("sig_q")?,
                direction: self.input_number("sig_d")?,
                ..HitUncertainty::none()
            };
        }
        let sigma = self.input_number("sigma")? / R::of(f64::from(hits)).sqrt();
        let noise = |_| GoldenResponses::repeat(SENSORS, sigma);
        bound(&layout, body, noise, hits, &mut [R::zero(); RIG_WORKSPACE])
    }
}

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    let body = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta")?));
    let report = LayoutReport::new(&layout, Some(&body));
    let names = report.diagnostics.iter().map(|d| d.code.name());
    check.names("diagnosis", names);
    check.numbers("L", &[report.length]);
    let whole = |rank: usize| R::of(rank as f64);
    check.numbers("rank_G", &[whole(report.rank_g)]);
    check.numbers("rank_F", &[whole(report.rank_f)]);
    check.numbers("rank_A", &[whole(report.rank_a?)]);
    check.numbers("cond_G", &[report.condition_g]);
    check.numbers("cond_A", &[report.condition_a?]);
    let hits = check.case.number("inputs.n_hits")? as u16;
    if let Some(bound) = check.bound(&layout, &body, hits) {
        check.numbers("sd", bound.sigma().as_slice());
        check.numbers("logdet_info", &[bound.log_det_information]);
    }
    Some(())
}

fn triple<R>(values: &mut impl Iterator<Item = R>) -> Option<[R; 3]> {
    Some([values.next()?, values.next()?, values.next()?])
}
