//! What a finished DOF with lines says besides them.

use massline_shared::layout::Dof;
use massline_shared::measurement::long_hit::LineScatter;
use massline_shared::measurement::stored_lines::StoredLines;
use massline_shared::measurement::{DofData, MeasuredDof, RestoredDof};
use massline_shared::signal::RESPONSES;
use serde::{Deserialize, Serialize};

/// What a DOF says besides its lines: the head of its object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinesHead {
    /// The DOF.
    pub dof: Dof,
    /// Its index in the layout.
    pub index: u8,
    /// Number of hits averaged.
    pub hits: u16,
    /// Lower and upper end of the band, Hz.
    pub band_hz: [f32; 2],
    /// Mean coherence over the band for each response; `None` for a single hit, whose coherence carries no
    /// information.
    pub coherence: Option<[f32; RESPONSES]>,
    /// Square of the mean of the hits over all responses and the lines of the band, ((m/s²)/N)².
    pub mean_squared: f32,
    /// Sum of the squared distances of the hits from it, ((m/s²)/N)².
    pub scatter_squared: f32,
}

impl LinesHead {
    /// Converts a measured DOF for storage.
    pub fn of(details: &MeasuredDof<f32>, lines: &StoredLines<f32>) -> Self {
        Self {
            dof: details.dof,
            index: lines.dof,
            hits: lines.hits,
            band_hz: details.band_hz,
            coherence: details.coherence,
            mean_squared: lines.scatter.mean_squared,
            scatter_squared: lines.scatter.scatter_squared,
        }
    }

    /// The measured DOF.
    pub fn measured(&self) -> RestoredDof<f32> {
        let Self { dof, index, hits, band_hz, coherence, mean_squared, scatter_squared } = *self;
        let details = MeasuredDof { dof, band_hz, coherence };
        let scatter = LineScatter { mean_squared, scatter_squared };
        (details, DofData::Lines(StoredLines { dof: index, hits, scatter }))
    }
}
