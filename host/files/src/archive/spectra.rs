//! Spectra of one DOF in an archive.

use std::ops::RangeInclusive;

use massline_shared::layout::Dof;
use massline_shared::signal::{Calibration, RESPONSES};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use crate::limited::{at_most, at_most_of};
use crate::uff::{Frf, NodeDirection};

/// Largest number of bins of a spectrum.
const BINS: usize = 4096;
/// The resolutions of spectra, Hz, and the fastest decay of a window, 1/s.
const RESOLUTIONS_HZ: RangeInclusive<f64> = 1e-6..=1e6;
const FASTEST_DECAY: f64 = 1e6;

/// Auto and cross spectra of the hits at one DOF. Each hit is divided by the root of its force's energy in the band, so
/// the force has no unit and the responses are in (m/s²)/N. Bin `k` is at `k` times the resolution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArchivedSpectra {
    /// The DOF, `node:±axis`.
    pub dof: String,
    /// Number of hits averaged.
    pub hits: u8,
    /// Frequency resolution, Hz.
    pub resolution_hz: f64,
    /// Decay rate σ of the exponential window, 1/s.
    pub decay_per_s: f64,
    /// G_FF bin by bin.
    #[serde(deserialize_with = "at_most::<BINS, _, _>")]
    pub force_auto: Vec<f32>,
    /// G_XF of each response bin by bin: real and imaginary part. Corrected for low-passes and delays, not for
    /// cross-axis sensitivities.
    #[serde(deserialize_with = "at_most_of::<RESPONSES, BINS, _, _>")]
    pub cross: Vec<Vec<[f32; 2]>>,
    /// G_XX of each response bin by bin.
    #[serde(deserialize_with = "at_most_of::<RESPONSES, BINS, _, _>")]
    pub response_auto: Vec<Vec<f32>>,
}

impl ArchivedSpectra {
    /// Checks that every response has as many bins as the force, at frequencies of a test.
    ///
    /// # Errors
    /// What no test gives, in words.
    pub(super) fn check(&self) -> Result<(), &'static str> {
        let bins = self.force_auto.len();
        let is_complete = self.cross.len() == RESPONSES
            && self.response_auto.len() == RESPONSES
            && self.cross.iter().all(|spectrum| spectrum.len() == bins)
            && self.response_auto.iter().all(|spectrum| spectrum.len() == bins);
        if !is_complete {
            return Err("its lists have different lengths");
        }
        if !RESOLUTIONS_HZ.contains(&self.resolution_hz) {
            return Err("resolution_hz is not that of a spectrum");
        }
        if !(0.0..=FASTEST_DECAY).contains(&self.decay_per_s) {
            return Err("decay_per_s is not that of a window");
        }
        Ok(())
    }

    /// Coherence of a response bin by bin, γ² = |G_XF|²/(G_FF G_XX), without the bin at zero; zero in a bin without
    /// power. Cross-axis sensitivities are not undone.
    pub fn coherence(&self, response: usize) -> Vec<f64> {
        let (Some(cross), Some(auto)) =
            (self.cross.get(response), self.response_auto.get(response))
        else {
            return Vec::new();
        };
        let of_bin = |((&[re, im], &auto), &force): ((&[f32; 2], &f32), &f32)| {
            let power = f64::from(auto) * f64::from(force);
            let cross = f64::from(re).powi(2) + f64::from(im).powi(2);
            if power > 0.0 { cross / power } else { 0.0 }
        };
        cross.iter().zip(auto).zip(&self.force_auto).skip(1).map(of_bin).collect()
    }

    /// H1 of each response bin by bin, (m/s²)/N, zero in a bin without force.
    fn h1(&self) -> Vec<Vec<Complex<f64>>> {
        let ratio = |(&[re, im], &force): (&[f32; 2], &f32)| {
            let cross = Complex::new(f64::from(re), f64::from(im));
            if force > 0.0 { cross.unscale(force.into()) } else { Complex::ZERO }
        };
        self.cross
            .iter()
            .map(|spectrum| spectrum.iter().zip(&self.force_auto).map(ratio).collect())
            .collect()
    }

    /// The frequency responses along the axes of the sensors at these nodes. The first bin, at zero, is left out.
    pub(super) fn frfs(&self, nodes: &[u16], calibration: &Calibration) -> Vec<Frf> {
        let Ok(dof) = self.dof.parse::<Dof>() else { return Vec::new() };
        let mut h1 = self.h1();
        let bins = h1.iter().map(Vec::len).min().unwrap_or(0);
        for bin in 0..bins {
            let mut of_bin: Vec<Complex<f64>> = h1.iter().map(|response| response[bin]).collect();
            calibration.undo_cross_axis(&mut of_bin);
            h1.iter_mut().zip(of_bin).for_each(|(response, corrected)| response[bin] = corrected);
        }
        let frequency_hz: Vec<f64> = (1..bins).map(|bin| bin as f64 * self.resolution_hz).collect();
        let reference = NodeDirection::from(dof);
        let each = nodes.iter().flat_map(|&node| (1..=3).map(move |direction| (node, direction)));
        each.zip(h1)
            .map(|((node, direction), accelerance)| Frf {
                response: NodeDirection { node: node.into(), direction },
                reference,
                frequency_hz: frequency_hz.clone(),
                accelerance: accelerance.into_iter().skip(1).take(frequency_hz.len()).collect(),
            })
            .collect()
    }
}
