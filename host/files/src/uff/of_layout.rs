//! The frequency responses of a layout as functions of a universal file.

use massline_shared::FrequencyResponses;
use massline_shared::layout::{Dof, HostLayout};

use super::{Frf, NodeDirection};

impl From<Dof> for NodeDirection {
    fn from(dof: Dof) -> Self {
        let sign = if dof.sign.factor() < 0.0 { -1 } else { 1 };
        Self { node: dof.node.into(), direction: sign * (dof.axis.index() as i64 + 1) }
    }
}

/// The functions of all hits and sensors, the responses along the axes of the sensors, each called after its node.
pub fn functions_of(layout: &HostLayout, readings: &FrequencyResponses<'_, f64>) -> Vec<Frf> {
    let lines = 0..readings.frequencies().len();
    let function = |hit: usize, channel: usize| Frf {
        response: NodeDirection {
            node: layout.sensors[channel / 3].node.into(),
            direction: (channel % 3) as i64 + 1,
        },
        reference: layout.hits[hit].dof.into(),
        frequency_hz: readings.frequencies().to_vec(),
        accelerance: lines.clone().map(|line| readings.at(line, channel, hit)).collect(),
    };
    let hits = 0..layout.hits.len();
    hits.flat_map(|hit| (0..3 * layout.sensors.len()).map(move |channel| (hit, channel)))
        .map(|(hit, channel)| function(hit, channel))
        .collect()
}
