//! The lines that a rig has measured in the suspension profile, and the answers to them.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;
use massline_shared::mass_line::window_correlation;
use massline_shared::signal::{AdcProperties, SPECTRUM_BINS, bins_of_band, resolution};
use nalgebra::Complex;

use super::{ModalSettings, SuspensionSolution, find_modes, solve};

/// Frequency responses of one DOF: response by response, all bins from 0 Hz on, (m/s²)/N.
#[derive(Clone, Debug, PartialEq)]
pub struct DofLines {
    /// Index of the DOF in the layout.
    pub dof: usize,
    /// The responses in use, each with [`SPECTRUM_BINS`] bins.
    pub lines: Vec<Complex<f64>>,
}

/// The lines of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct TestLines {
    /// The layout with the DOFs that were measured.
    layout: HostLayout,
    frequencies: Vec<f64>,
    /// `[bin][channel][hit]`, (m/s²)/N.
    accelerance: Vec<Complex<f64>>,
    /// Distance of the bins, Hz.
    spacing: f64,
}

impl TestLines {
    /// The lines within the band of the layout. A DOF whose lines are not those of all responses is left out.
    pub fn new(layout: &HostLayout, adc: &AdcProperties, dofs: &[DofLines]) -> Self {
        let channels = 3 * layout.sensors.len();
        let whole = |dof_lines: &&DofLines| {
            dof_lines.dof < layout.hits.len() && dof_lines.lines.len() == channels * SPECTRUM_BINS
        };
        let measured: Vec<&DofLines> = dofs.iter().filter(whole).collect();
        let spacing = resolution::<f64>(adc, layout.test.profile);
        let bins = bins_of_band(layout.test.expected_band(), spacing);
        let bins = *bins.start()..bins.end().saturating_add(1).min(SPECTRUM_BINS);
        let at = |bin: usize, channel: usize, dof_lines: &DofLines| {
            dof_lines.lines[channel * SPECTRUM_BINS + bin]
        };
        let accelerance = bins
            .clone()
            .flat_map(|bin| (0..channels).map(move |channel| (bin, channel)))
            .flat_map(|(bin, channel)| {
                measured.iter().map(move |dof_lines| at(bin, channel, dof_lines))
            })
            .collect();
        let mut with = layout.clone();
        with.hits = measured.iter().map(|dof_lines| layout.hits[dof_lines.dof]).collect();
        let frequencies = bins.map(|bin| bin as f64 * spacing).collect();
        Self { layout: with, frequencies, accelerance, spacing }
    }

    /// The layout with the DOFs that were measured.
    pub fn layout(&self) -> &HostLayout {
        &self.layout
    }

    /// The frequency responses, at `s = σ + iω` with σ of the layout's exponential window.
    ///
    /// # Errors
    /// `frf_missing` when nothing was measured.
    pub fn responses(&self) -> Result<FrequencyResponses<'_, f64>, Diagnostics> {
        let (channels, hits) = (3 * self.layout.sensors.len(), self.layout.hits.len());
        let responses =
            FrequencyResponses::new(&self.frequencies, &self.accelerance, channels, hits);
        let missing = Diagnostic::whole(Code::FrfMissing, Severity::Error, 0.0);
        let responses =
            responses.filter(|_| hits > 0).ok_or_else(|| Diagnostics::from_array([missing]))?;
        let decay = self.layout.test.exponential_decay;
        // The window makes bins of this distance dependent as if the record were as long as their distance permits.
        Ok(responses.windowed(decay, window_correlation(decay, self.spacing.recip())))
    }

    /// The answers of these methods, and what all of them say together; `record_s` is how long the object rings in a
    /// record, s.
    ///
    /// # Errors
    /// Why there is no answer.
    pub fn solve(
        &self,
        record_s: f64,
        wanted: &[Method],
        progress: impl FnMut(u32, u32) + Send,
    ) -> Result<SuspensionSolution, Diagnostics> {
        let responses = self.responses()?;
        let first = find_modes(&self.layout, &responses, record_s)?;
        let settings = ModalSettings { named: wanted.len() == 1, ..ModalSettings::default() };
        let mut solution = solve(&self.layout, &responses, wanted, settings, None, progress)?;
        solution.modes.diagnostics.extend(first.diagnostics);
        Ok(solution)
    }
}
