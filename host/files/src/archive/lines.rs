//! Lines of one DOF in an archive.

use massline_protocol::lines_head::LinesHead;
use massline_shared::layout::Dof;
use massline_shared::signal::{RESPONSES, SPECTRUM_BINS};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use crate::limited::at_most_of;
use crate::uff::{Frf, NodeDirection};

/// The frequency responses that a rig has stored of one DOF in the suspension profile, corrected for low-passes, delays
/// and cross-axis sensitivities. Line `k` is at `k` times the resolution of this profile, and at the decay rate of the
/// layout's exponential window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArchivedLines {
    /// The DOF, `node:±axis`.
    pub dof: String,
    /// Each response line by line from 0 Hz on, (m/s²)/N: real and imaginary part.
    #[serde(deserialize_with = "at_most_of::<RESPONSES, SPECTRUM_BINS, _, _>")]
    pub responses: Vec<Vec<[f32; 2]>>,
}

impl ArchivedLines {
    /// Each response line by line from 0 Hz on, (m/s²)/N.
    pub fn accelerance(&self) -> impl Iterator<Item = Vec<Complex<f64>>> {
        let number = |&[re, im]: &[f32; 2]| Complex::new(f64::from(re), f64::from(im));
        self.responses.iter().map(move |response| response.iter().map(number).collect())
    }

    /// The frequency responses along the axes of the sensors at these nodes, with lines of this distance, Hz. The line
    /// at zero is left out.
    pub(super) fn frfs(&self, nodes: &[u16], spacing: f64) -> Vec<Frf> {
        let Ok(dof) = self.dof.parse::<Dof>() else { return Vec::new() };
        let frequency_hz: Vec<f64> = (1..SPECTRUM_BINS).map(|line| line as f64 * spacing).collect();
        let each = nodes.iter().flat_map(|&node| (1..=3).map(move |direction| (node, direction)));
        each.zip(self.accelerance())
            .map(|((node, direction), accelerance)| Frf {
                response: NodeDirection { node: node.into(), direction },
                reference: NodeDirection::from(dof),
                frequency_hz: frequency_hz.clone(),
                accelerance: accelerance.into_iter().skip(1).collect(),
            })
            .collect()
    }

    /// Checks that the DOF is one of the result, with the lines of as many responses as its sensors have.
    ///
    /// # Errors
    /// What no test gives, in words.
    pub(super) fn check(&self, heads: &[LinesHead], sensors: usize) -> Result<(), &'static str> {
        if heads.iter().all(|head| head.dof.to_string() != self.dof) {
            return Err("the result has no such DOF");
        }
        let is_complete = self.responses.len() == 3 * sensors
            && self.responses.iter().all(|response| response.len() == SPECTRUM_BINS);
        if is_complete { Ok(()) } else { Err("it does not have the lines of all responses") }
    }
}
