//! Whether every point moves with its force, and every two hits do the same at each other.

use massline_shared::FrequencyResponses;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::{DofMassLines, ResponseInverse, check_reciprocity};
use massline_shared::layout::HostLayout;
use massline_shared::modes::reduce_line;
use nalgebra::{Complex, Vector6};

use super::HostFit;

/// Checks the lines about the modes, where the responses are far above the noise.
pub(super) fn reciprocity_of_modes(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
) -> Diagnostics {
    let (layout, reference) = (fit.layout(), fit.reference());
    let hits = layout.hits.len();
    let lines: Vec<usize> = fit.lines().below.iter().chain(&fit.lines().above).copied().collect();
    let mut motions = vec![Vector6::<Complex<f64>>::zeros(); lines.len() * hits];
    for (line, motions) in lines.iter().zip(motions.chunks_exact_mut(hits.max(1))) {
        if reduce_line(layout, readings, &reference, *line, motions).is_none() {
            return Diagnostics::new();
        }
    }
    let forces: Vec<_> = layout.hits.iter().map(|hit| hit.unit_force(&reference)).collect();
    // Near a mode an accelerance is imaginary, and a force that puts energy in makes it positive.
    check_reciprocity(&forces, lines.len(), |line, hit| motions[line * hits + hit], |h| h.im)
}

/// Checks mass lines.
pub fn reciprocity_of_mass_lines(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
) -> Diagnostics {
    let reference = layout.sensor_centroid();
    let length = layout.characteristic_length();
    let inverse = ResponseInverse::new(&layout.response_matrix(&reference), length);
    let inverse = inverse.filter(|inverse| inverse.rank == 6);
    let whole = lines.iter().map(|(hit, _)| *hit).eq(0..layout.hits.len());
    let Some(inverse) = inverse.filter(|_| whole) else { return Diagnostics::new() };
    let motion = |_line: usize, hit: usize| {
        inverse.motion(&lines[hit].1.accelerance).map(|v| Complex::new(v, 0.0))
    };
    let forces: Vec<_> = layout.hits.iter().map(|hit| hit.unit_force(&reference)).collect();
    check_reciprocity(&forces, 1, motion, |h| h.re)
}
