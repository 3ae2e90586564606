//! `g_layout_`: diagnosis, ranks, conditions and the bound of a layout. And the layout that the other
//! cases read from their inputs.

use massline_shared::Real;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::{
    Axis, Budget, Dof, Hit, Layout, LayoutReport, Sensor, Sign, TestSettings, predict,
};
use nalgebra::SVector;

use crate::Check;

/// The layout of a golden case: three triaxial sensors and up to four hits.
pub type GoldenLayout<R> = Layout<R, 3, 4>;
/// Responses of a [`GoldenLayout`].
pub(crate) const RESPONSES: usize = 9;

impl<R: Real> Check<'_, '_, R> {
    /// Sensors, hits and gravity of the inputs.
    pub fn layout(&self) -> Option<GoldenLayout<R>> {
        let mut layout = GoldenLayout {
            title: heapless::String::new(),
            gravity: self.input_array::<3>("gravity"),
            sensors: heapless::Vec::new(),
            hits: heapless::Vec::new(),
            test: TestSettings::default(),
        };
        let mut positions = self.input("sensors.p")?;
        let mut axes = self.input("sensors.R")?;
        let count = self.case.array("inputs.sensors.p")?.shape.first().copied()?;
        for node in (1..).take(count) {
            let position = triple(&mut positions)?;
            let [a, b, c] = [triple(&mut axes)?, triple(&mut axes)?, triple(&mut axes)?];
            // The columns of R are the axes.
            let axes = core::array::from_fn(|axis| [a[axis], b[axis], c[axis]]);
            let sensor = Sensor { node, position, axes, senses_gravity: true };
            layout.sensors.push(sensor).ok()?;
        }
        let mut points = self.input("hits.q")?;
        let mut directions = self.input("hits.d")?;
        let count = self.case.array("inputs.hits.q")?.shape.first().copied()?;
        for node in (101..).take(count) {
            let dof = Dof { node, sign: Sign::Plus, axis: Axis::X };
            let (position, direction) = (triple(&mut points)?, triple(&mut directions)?);
            layout.hits.push(Hit { dof, position, direction }).ok()?;
        }
        Some(layout)
    }
}

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    let body = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta")?));
    let report = LayoutReport::new(&layout, Some(&body));
    let names = report.diagnostics.iter().filter_map(Diagnostic::known_code).map(|c| c.name());
    check.names("diagnosis", names);
    check.numbers("L", &[report.length]);
    let whole = |rank: usize| R::of(rank as f64);
    check.numbers("rank_G", &[whole(report.rank_g)]);
    check.numbers("rank_F", &[whole(report.rank_f)]);
    check.numbers("rank_A", &[whole(report.rank_a?)]);
    check.numbers("cond_G", &[report.condition_g]);
    check.numbers("cond_A", &[report.condition_a?]);
    let budget = Budget {
        accelerance: check.input_number("sigma")?,
        hit_position: check.input_number("sig_q")?,
        hit_direction: check.input_number("sig_d")?,
        hits: check.case.number("inputs.n_hits")? as u16,
    };
    if let Some(prediction) = predict::<R, 3, 4, RESPONSES>(&layout, &body, &budget) {
        check.numbers("sd", prediction.sigma().as_slice());
        check.numbers("logdet_info", &[prediction.log_det_information]);
    }
    Some(())
}

fn triple<R>(values: &mut impl Iterator<Item = R>) -> Option<[R; 3]> {
    Some([values.next()?, values.next()?, values.next()?])
}
