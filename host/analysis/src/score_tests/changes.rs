//! What each small fault does to the readings of mass lines.

use massline_shared::body::RigidBody;
use massline_shared::capacity::Unbounded;
use massline_shared::layout::AttachedBody;
use massline_shared::responses::Responses;
use nalgebra::{DMatrix, DVector, SVector};

use super::left_over::LeftOver;
use super::small_fault::SmallFault;

/// Displacement, m, and turn, rad, over which readings are differentiated. They are linear in both.
const DIFFERENCE: f64 = 1e-4;

impl SmallFault {
    /// The changes of all readings per unit of its size, one column for each of its directions; `None` where a reading
    /// cannot be computed.
    pub(super) fn changes(self, left_over: &LeftOver<'_>) -> Option<DMatrix<f64>> {
        let layout = &left_over.layout;
        let one = |column: Option<DVector<f64>>| column.map(|column| vec![column]);
        let columns = match self {
            Self::HammerDrifts => one(drift(left_over, -1.0, None)),
            Self::ChannelDrifts { sensor, axis } => {
                one(drift(left_over, 1.0, Some(3 * sensor + axis.index())))
            }
            Self::MarksLoaded => one(left_over.column(|_, hit| load(left_over, hit))),
            _ => {
                let changes = self.changes_of_layout(layout);
                changes
                    .iter()
                    .map(|change| {
                        let changed = |size: f64| {
                            let mut changed = layout.clone();
                            change(&mut changed, size);
                            left_over.readings(&changed)
                        };
                        Some((changed(DIFFERENCE)? - changed(-DIFFERENCE)?) / (2.0 * DIFFERENCE))
                    })
                    .collect()
            }
        };
        columns.map(|columns| DMatrix::from_columns(&columns))
    }
}

/// The change of the readings of a DOF with a mass at its mark, per kg.
fn load(left_over: &LeftOver<'_>, hit: usize) -> Option<Responses<f64, Unbounded>> {
    let layout = &left_over.layout;
    let mark = layout.hits.get(hit)?.position;
    let step = DIFFERENCE * left_over.whole.mass;
    let with = |mass: f64| {
        let pad = SVector::from(AttachedBody::point(mass, 0.0, mark).phi);
        layout.accelerance(&RigidBody::from_phi(&(left_over.whole.phi() + pad))?, hit)
    };
    let change = &with(step)? - &with(-step)?;
    Some(&change / (2.0 * step))
}

/// The change of the readings with a gain that changes by one from the first hit of the test to the last, in the order
/// of the DOFs: of one response, or of all.
fn drift(left_over: &LeftOver<'_>, sign: f64, response: Option<usize>) -> Option<DVector<f64>> {
    let hits: f64 = left_over.lines.iter().map(|(_, lines)| f64::from(lines.hits.max(1))).sum();
    let before = |place: usize| {
        let earlier = left_over.lines.iter().take(place);
        earlier.map(|(_, lines)| f64::from(lines.hits.max(1))).sum::<f64>()
    };
    left_over.column(|place, hit| {
        let own = f64::from(left_over.lines.get(place)?.1.hits.max(1));
        // From −1/2 to 1/2.
        let time = (before(place) + 0.5 * own) / hits - 0.5;
        let mut readings = left_over.layout.accelerance(&left_over.whole, hit)?;
        for (k, reading) in readings.iter_mut().enumerate() {
            *reading *=
                if response.is_none_or(|response| response == k) { sign * time } else { 0.0 };
        }
        Some(readings)
    })
}
