//! The global fit among the other methods.

use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::Perturbation;
use massline_shared::identify::global_fit::{
    Damping, GlobalFitSettings, GlobalFitSolution, Sensitivities, gains, nuisances,
    solve_with_sensitivities, workspace,
};
use massline_shared::layout::HostLayout;
use nalgebra::{Complex, SMatrix, SVector};

use super::HostFit;
use super::directions::direction_scale;
use super::modal_gains::ModalGains;
use super::noise::UnevenNoise;

/// Rounds of fitting with the noise of every line: the second one sees it without what the first has explained.
const ROUNDS: usize = 2;
/// Deviate of an extra term from which it stands in uneven noise. What follows the modes is alike in all lines about a
/// mode, and not only in neighbours: in 40 simulated campaigns of a rigid wheel the deviates were 1.4 ± 1.3, so that
/// chance exceeds this once in 300 tests.
const STANDING: f64 = 5.0;

/// The answer of the global fit, and how it depends on data and layout.
#[derive(Clone, Debug)]
pub struct GlobalAnswer {
    /// The answer.
    pub solution: GlobalFitSolution<f64>,
    /// The lines that were used, as places in the readings of the test.
    pub(super) lines: Vec<usize>,
    /// The noise of these lines, where they are not all alike.
    noise: Option<UnevenNoise>,
    /// The covariance of theta without gains of single modes.
    of_fit: Option<SMatrix<f64, 10, 10>>,
    /// Gains of single modes in single responses, where there are any.
    pub(super) gains: Option<ModalGains>,
    /// What is left of every reading of these lines.
    left: Vec<Complex<f64>>,
    gain: Vec<SVector<Complex<f64>, 10>>,
    /// Covariance of theta with every nuisance parameter.
    pub(super) nuisances: Vec<SVector<f64, 10>>,
    /// The nuisance parameters at the answer, and their covariance row by row.
    pub(super) pulls: Vec<f64>,
    pub(super) posterior: Vec<f64>,
}

impl GlobalAnswer {
    /// Fits the readings from this start, with the noise of every line and the scatter of directions that they show, and
    /// with the uncertainty that gains of single modes in single responses add.
    ///
    /// # Errors
    /// Those of [`solve_with_sensitivities`].
    pub fn of_real_converter(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        start: &RigidBody<f64>,
        settings: &GlobalFitSettings,
    ) -> Result<Self, Diagnostics> {
        let answer = Self::of_shown_directions(layout, readings, start, settings)?;
        Ok(answer.with_gains(layout, readings, settings.damping))
    }

    /// As [`Self::of_real_converter`], for readings with the same noise at all lines and with the directions of the
    /// layout: as good for what is left of the readings.
    ///
    /// # Errors
    /// Those of [`solve_with_sensitivities`].
    pub(super) fn of_even_noise(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        start: &RigidBody<f64>,
        settings: &GlobalFitSettings,
    ) -> Result<Self, Diagnostics> {
        let answer = Self::of(layout, readings, start, settings)?;
        Ok(answer.with_gains(layout, readings, settings.damping))
    }

    /// The same with gains of single modes in single responses, where there are any.
    fn with_gains(
        mut self,
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        damping: Damping,
    ) -> Self {
        if !self.leaves_noise() {
            return self;
        }
        let Self { solution, noise, left, gain, .. } = &mut self;
        let gains = ModalGains::of(layout, readings, solution, damping, left);
        if let Some((gains, covariance)) = gains.as_ref().zip(solution.estimate.covariance.as_mut())
        {
            let assumed = |line: usize| {
                let deviation = match &*noise {
                    Some(noise) => noise.correlation / noise.precision[line],
                    None => readings.correlation,
                };
                (solution.noise * deviation).powi(2)
            };
            *covariance += gains.covariance(layout, readings, gain, assumed);
        }
        self.gains = gains;
        self
    }

    /// As [`Self::of_uneven_noise`], where the layout permits to learn from the data: the mean loss of directions that
    /// scatter is then that of the directions that the readings show, and not of those that the layout states.
    ///
    /// # Errors
    /// Those of [`solve_with_sensitivities`].
    fn of_shown_directions(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        start: &RigidBody<f64>,
        settings: &GlobalFitSettings,
    ) -> Result<Self, Diagnostics> {
        let stated = Self::of_uneven_noise(layout, readings, start, settings)?;
        if !layout.learn_budget {
            return Ok(stated);
        }
        let scale = direction_scale(layout, &stated.pulls, &stated.posterior);
        let Some(direction_scale) = scale else { return Ok(stated) };
        let GlobalFitSolution { extra_terms, extra_terms_z, .. } = stated.solution;
        let settings =
            GlobalFitSettings { direction_scale, most_extra_terms: extra_terms, ..*settings };
        let body = stated.solution.estimate.body;
        let again = match &stated.noise {
            Some(noise) => {
                let weighted = readings.windowed(readings.decay, noise.correlation);
                Self::of(layout, &weighted.weighted(&noise.precision), &body, &settings)
            }
            None => Self::of(layout, readings, &body, &settings),
        };
        // The same minimum, but for the length of the forces, is there again.
        let Ok(again) = again else { return Ok(stated) };
        let solution = GlobalFitSolution { extra_terms_z, ..again.solution };
        Ok(Self { solution, noise: stated.noise, ..again })
    }

    /// As [`Self::of`], with the noise of every line as the readings show it. Whether a flexible mode is there is
    /// decided with that noise: in white noise, what follows the modes looks like one.
    ///
    /// # Errors
    /// Those of [`solve_with_sensitivities`].
    fn of_uneven_noise(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        start: &RigidBody<f64>,
        settings: &GlobalFitSettings,
    ) -> Result<Self, Diagnostics> {
        let rigid = GlobalFitSettings { most_extra_terms: 0, ..*settings };
        let mut answer = Self::of(layout, readings, start, &rigid);
        for _round in 0..ROUNDS {
            let noise = answer.as_ref().ok().and_then(|answer| answer.uneven(readings));
            let Some(noise) = noise else {
                return Self::of(layout, readings, start, settings);
            };
            let weighted = readings.windowed(readings.decay, noise.correlation);
            let weighted = weighted.weighted(&noise.precision);
            answer = Self::of(layout, &weighted, start, settings);
            if let Some(fewer) = answer.as_ref().ok().and_then(|answer| answer.fewer_extra_terms())
            {
                let settings = GlobalFitSettings { most_extra_terms: fewer, ..*settings };
                answer = Self::of(layout, &weighted, start, &settings);
            }
            answer = answer.map(|answer| Self { noise: Some(noise), ..answer });
        }
        answer
    }

    /// How many extra terms stand in uneven noise, where those of the fit do not.
    fn fewer_extra_terms(&self) -> Option<usize> {
        let deviates = self.solution.extra_terms_z.iter().take(self.solution.extra_terms);
        let standing = deviates.take_while(|z| z.is_some_and(|z| z > STANDING)).count();
        (standing < self.solution.extra_terms).then_some(standing)
    }

    /// The noise of the lines where they are not alike.
    fn uneven(&self, readings: &FrequencyResponses<'_, f64>) -> Option<UnevenNoise> {
        self.leaves_noise().then(|| UnevenNoise::of(&self.left, readings)).flatten()
    }

    /// False where hardly anything is left of the readings: that is rounding and no noise.
    fn leaves_noise(&self) -> bool {
        let sum: f64 = self.left.iter().map(Complex::norm_sqr).sum();
        sum > self.left.len() as f64 * self.solution.noise.powi(2)
    }

    /// Noise at one of the lines of the fit over that of the modes.
    fn noise_at(&self, place: usize, fit: &HostFit<'_>) -> f64 {
        let Some(noise) = &self.noise else { return 1.0 };
        let precision = noise.precision.get(place).copied().unwrap_or(1.0);
        let correlation = noise.correlation / fit.correlation();
        noise_over_modes(self.solution.noise, fit) * correlation / precision
    }

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
        let mut left = vec![Complex::ZERO; readings_count];
        let count = of_nuisances.len();
        let (mut pulls, mut posterior) = (vec![0.0; count], vec![0.0; count * count]);
        let mut sensitivities = Sensitivities {
            gain: &mut gain,
            nuisances: &mut of_nuisances,
            left: &mut left,
            pulls: &mut pulls,
            posterior: &mut posterior,
        };
        let solution = solve_with_sensitivities(
            layout,
            readings,
            start,
            settings,
            &mut memory,
            &mut sensitivities,
        )?;
        let lines = (0..readings.frequencies().len()).collect();
        let nuisances = of_nuisances;
        let of_fit = solution.estimate.covariance;
        Ok(Self {
            solution,
            lines,
            noise: None,
            gains: None,
            of_fit,
            left,
            gain,
            nuisances,
            pulls,
            posterior,
        })
    }

    /// The answer to perturbed data, to first order.
    pub(super) fn perturbed(
        &self,
        fit: &HostFit<'_>,
        perturbation: &Perturbation<'_, f64, Unbounded>,
    ) -> SVector<f64, 10> {
        let mut theta = self.solution.estimate.theta();
        if let Some(draw) = perturbation.draw {
            let layout = fit.layout();
            let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
            for (place, gain) in self.gain.iter().enumerate() {
                let (rest, hit) = (place / hits, place % hits);
                let line = self.lines.get(rest / channels).copied().unwrap_or_default();
                // The other methods are asked about the noise that the modes show.
                let more = self.noise_at(rest / channels, fit);
                let noise = fit.noise_of(draw, line, rest % channels, hit).scale(more);
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
        let shift = layout.priors.get(place).zip(self.of_fit).map(|(prior, covariance)| {
            covariance.column(usize::from(prior.property)) / prior.sigma
        });
        shift.unwrap_or_default()
    }
}

/// Noise of the real part of a reading, over that of the modes.
pub(super) fn noise_over_modes(noise: f64, fit: &HostFit<'_>) -> f64 {
    // That of the real part, and that of a complex number.
    noise * std::f64::consts::SQRT_2 / fit.noise()
}
