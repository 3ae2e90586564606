//! The global fit among the other methods.

use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::Perturbation;
use massline_shared::identify::global_fit::{
    GlobalFitSettings, GlobalFitSolution, Sensitivities, gains, nuisances,
    solve_with_sensitivities, workspace,
};
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout};
use nalgebra::{Complex, SVector};

use super::HostFit;

/// The answer of the global fit, and how it depends on data and layout.
#[derive(Clone, Debug)]
pub struct GlobalAnswer {
    /// The answer.
    pub solution: GlobalFitSolution<f64>,
    /// The lines that were used, as places in the readings of the test.
    pub(super) lines: Vec<usize>,
    gain: Vec<SVector<Complex<f64>, 10>>,
    nuisances: Vec<SVector<f64, 10>>,
}

impl GlobalAnswer {
    /// Fits the readings from this start.
    ///
    /// # Errors
    /// Those of [`solve_with_sensitivities`].
    pub fn of(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        start: &RigidBody<f64>,
        settings: &GlobalFitSettings,
    ) -> Result<Self, Diagnostics> {
        let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
        let mut memory = vec![0.0; workspace(sensors, hits)];
        let readings_count = gains(readings.frequencies().len(), sensors, hits);
        let mut gain = vec![SVector::zeros(); readings_count];
        let mut of_nuisances =
            vec![SVector::zeros(); nuisances(sensors, hits, layout.attached.len())];
        let mut sensitivities = Sensitivities { gain: &mut gain, nuisances: &mut of_nuisances };
        let solution = solve_with_sensitivities(
            layout,
            readings,
            start,
            settings,
            &mut memory,
            &mut sensitivities,
        )?;
        let lines = (0..readings.frequencies().len()).collect();
        Ok(Self { solution, lines, gain, nuisances: of_nuisances })
    }

    /// The answer to perturbed data, to first order.
    pub(super) fn perturbed(
        &self,
        fit: &HostFit<'_>,
        perturbation: &Perturbation<'_, f64, HOST_SENSORS, HOST_HITS>,
    ) -> SVector<f64, 10> {
        let mut theta = self.solution.estimate.theta();
        if let Some(draw) = perturbation.draw {
            let layout = fit.layout();
            let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
            for (place, gain) in self.gain.iter().enumerate() {
                let (rest, hit) = (place / hits, place % hits);
                let line = self.lines.get(rest / channels).copied().unwrap_or_default();
                let noise = fit.noise_of(draw, line, rest % channels, hit);
                for (to, gain) in theta.iter_mut().zip(gain) {
                    *to += gain.re * noise.re + gain.im * noise.im;
                }
            }
        }
        if let Some(quantity) = perturbation.quantity {
            theta += match self.nuisances.get(quantity) {
                Some(shift) => *shift,
                // The priors come last.
                None => self.shift_of_prior(fit.layout(), quantity - self.nuisances.len()),
            };
        }
        theta
    }

    /// What a prior that is higher by one standard deviation does to the answer: the covariance with the property over
    /// that standard deviation.
    fn shift_of_prior(&self, layout: &HostLayout, place: usize) -> SVector<f64, 10> {
        let covariance = self.solution.estimate.covariance;
        let shift = layout.priors.get(place).zip(covariance).map(|(prior, covariance)| {
            covariance.column(usize::from(prior.property)) / prior.sigma
        });
        shift.unwrap_or_default()
    }
}
