//! `g_doptimal_`: an exchange search must reach the expected score.

use massline_shared::Real;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Rig;
use massline_shared::design::{Choice, Counts, Search, cost};
use nalgebra::SVector;

use crate::Check;
use crate::layout::GoldenLayout;

/// A choice of sensors and hits that fits a [`GoldenLayout`].
type GoldenChoice = Choice<Rig>;
/// A single start reaches the score from each of the seeds 1 to 20 (measured).
const STARTS: u32 = 2;

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let sensors = check.sensors::<16>("candidate_sensors.p", "candidate_sensors.R")?;
    let hits = check.hits::<32>("candidate_hits.q", "candidate_hits.d")?;
    let body = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta")?));
    let length = check.input_number("L")?;
    let count = |name: &str| Some(check.input_number(name)?.to_f64() as usize);
    let search = Search {
        candidates: Counts { sensors: sensors.len(), hits: hits.len() },
        wanted: Counts { sensors: count("n_sensors")?, hits: count("n_hits")? },
        starts: STARTS,
        seed: 1,
    };
    let best = search.run(None, |choice: &GoldenChoice| {
        let layout = GoldenLayout {
            sensors: choice.sensors.iter().filter_map(|&i| sensors.get(i).copied()).collect(),
            hits: choice.hits.iter().filter_map(|&j| hits.get(j).copied()).collect(),
            ..GoldenLayout::default()
        };
        let bound = check.bound(&layout, &body, 1)?;
        Some(cost::minus_log_det(&bound, layout.characteristic_length(), length))
    });
    check.numbers("best_logdet", &[-best.ok()?.cost]);
    Some(())
}
