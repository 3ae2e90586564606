//! The modal fit of a test, and the answers of the methods to it.

use heapless::Vec;
use nalgebra::{Complex, Vector3};

use super::Answer;
use super::answers::{MethodInput, answer, found_again, lines_about, noise_in_draw};
use super::points::suspect_points;
use super::selection::{Selection, select};
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, fatal};
use crate::frequency_responses::FrequencyResponses;
use crate::identify::{Method, Perturbation};
use crate::layout::Layout;
use crate::modes::{
    ForceMixing, Lines, LinesPerSide, MOST_LINES, MOST_PAIRS, Modes, Orders, Poles, Reduction,
    relocate_once,
};
use crate::real::Real;

/// The modal fit of a test under its layout.
#[derive(Clone, Debug)]
pub struct SuspensionFit<'a, R: Real, C: Capacity> {
    layout: &'a Layout<R, C>,
    readings: &'a FrequencyResponses<'a, R>,
    reference: Vector3<R>,
    mixing: ForceMixing<R, C>,
    s: Vec<Complex<R>, MOST_LINES>,
    orders: Orders<R>,
    /// Poles of all modes that were fitted, and the places of the suspension modes among them.
    poles: Poles<R>,
    kept: Vec<usize, MOST_PAIRS>,
    one_more: Option<Diagnostic>,
    modes: Modes<R>,
    lines: Lines,
    noise: R,
}

impl<'a, R: Real, C: Capacity> SuspensionFit<'a, R, C> {
    /// Fits the modes. `readings` contains the lines of the suspension band, at most [`MOST_LINES`], in ascending
    /// order.
    ///
    /// # Errors
    /// `layout_not_finite`, `data_not_finite`, `frf_missing` when channels or hits are not those of the layout,
    /// `response_rank_deficient`, and `suspension_modes_missing` when no mode shows.
    pub fn new(
        layout: &'a Layout<R, C>,
        readings: &'a FrequencyResponses<'a, R>,
        memory: &mut Reduction<R>,
    ) -> Result<Self, Diagnostics> {
        readings.check(layout)?;
        let reference = layout.sensor_centroid();
        let mixing = ForceMixing::of(layout, &reference);
        let s: Vec<_, MOST_LINES> = (0..readings.frequencies().len().min(MOST_LINES))
            .map(|line| readings.s(line))
            .collect();
        let reading = |line, channel, hit| readings.at(line, channel, hit);
        memory
            .fill(layout, &reference, &mixing, &s, reading)
            .ok_or_else(|| fatal(Code::ResponseRankDeficient, R::zero()))?;
        let responses = memory.responses();
        let orders = Orders::up_to(&responses, MOST_PAIRS);
        let missing = || fatal(Code::SuspensionModesMissing, R::zero());
        let order = orders.sufficient().ok_or_else(missing)?;
        let noise = order.noise_variance().sqrt();
        let poles = order.poles.clone();
        let (candidates, places) = Modes::of_poles(&responses, &poles).ok_or_else(missing)?;
        let Selection { kept, one_more } = select(&candidates, &s, responses.length);
        if places.len() < poles.len() || kept.is_empty() {
            let lines = lines_about(&poles, &s, LinesPerSide::Width);
            let suspect = suspect_points(layout, readings, &reference, &lines);
            if !suspect.is_empty() {
                return Err(suspect);
            }
        }
        if kept.is_empty() {
            return Err(missing());
        }
        let modes = candidates.only(&kept);
        let kept = kept.iter().map(|kept| places[*kept]).collect();
        let lines = lines_about(&modes.poles, &s, LinesPerSide::Width);
        Ok(Self {
            layout,
            readings,
            reference,
            mixing,
            s,
            orders,
            poles,
            kept,
            one_more,
            modes,
            lines,
            noise,
        })
    }

    /// The fits of every order.
    pub fn orders(&self) -> &Orders<R> {
        &self.orders
    }

    /// The suspension modes, about [`Self::reference`].
    pub fn modes(&self) -> &Modes<R> {
        &self.modes
    }

    /// The point that shapes and motions refer to, in the body frame, m.
    pub fn reference(&self) -> Vector3<R> {
        self.reference
    }

    /// Standard deviation of the noise of a reading, (m/s²)/N, of a complex number.
    pub fn noise(&self) -> R {
        self.noise
    }

    /// Factor on standard deviations because the window of the records correlates neighbouring lines.
    pub fn correlation(&self) -> R {
        self.readings.correlation
    }

    /// A finding about a mode more than a rigid body on a suspension has; an error where the answers would be far off.
    pub fn one_more(&self) -> Option<Diagnostic> {
        self.one_more
    }

    /// The lines about the poles within the band that are no suspension modes: of hum, or of an elastic mode.
    pub fn disturbed_lines(&self) -> Vec<usize, MOST_LINES> {
        let Self { s, poles, kept, .. } = self;
        let others = poles.iter().enumerate().filter(|(place, _)| !kept.contains(place));
        let others: Vec<Complex<R>, MOST_PAIRS> = others.map(|(_, pole)| *pole).collect();
        let spacing = |line: usize| {
            let next = s.get(line + 1).or(s.get(line)).map_or(R::zero(), |s| s.im);
            next - s[line.saturating_sub(1)].im
        };
        let near = |line: &usize| {
            let reach = |pole: &Complex<R>| spacing(*line) - pole.re;
            others.iter().any(|pole| (s[*line].im - pole.im).abs() < reach(pole))
        };
        (0..s.len()).filter(near).collect()
    }

    /// The lines about the modes.
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// The same with other lines for the direct methods.
    pub fn with_lines(self, per_side: LinesPerSide) -> Self {
        let lines = lines_about(&self.modes.poles, &self.s, per_side);
        Self { lines, ..self }
    }

    /// The noise of a reading in a draw, (m/s²)/N.
    pub fn noise_of(&self, draw: u32, line: usize, channel: usize, hit: usize) -> Complex<R> {
        let Self { readings, noise, .. } = self;
        let place = (line * readings.channels() + channel) * readings.hits() + hit;
        noise_in_draw(*noise * readings.correlation, draw, place)
    }

    /// The motions and modes of changed data: noise moves the poles, which are found again by one step from where they
    /// are; as does an error of the layout. `None` when one of the modes is not found again.
    pub fn changed(
        &self,
        changed: &Perturbation<'_, R, C>,
        memory: &mut Reduction<R>,
    ) -> Option<Modes<R>> {
        let Self { readings, reference, mixing, s, poles, .. } = self;
        let reading = |line: usize, channel: usize, hit: usize| {
            let value = readings.at(line, channel, hit);
            changed.draw.map_or(value, |draw| value + self.noise_of(draw, line, channel, hit))
        };
        memory.fill(changed.layout, reference, mixing, s, reading)?;
        let responses = memory.responses();
        let (candidates, _) = Modes::of_poles(&responses, &relocate_once(&responses, poles)?)?;
        let places = found_again(&candidates.poles, poles, self.kept.iter().copied())?;
        Some(candidates.only(&places))
    }

    /// The answer of a method to these motions and modes, as a body in the body frame without the attached ones.
    ///
    /// # Errors
    /// Why the method has no answer.
    pub fn answer(
        &self,
        method: Method,
        layout: &Layout<R, C>,
        memory: &Reduction<R>,
        modes: &Modes<R>,
    ) -> Result<Answer<R>, Diagnostics> {
        let responses = memory.responses();
        let Self { lines, noise, .. } = self;
        let observed = MethodInput { responses: &responses, modes, lines, noise: *noise };
        answer(method, layout, &self.reference, &observed)
    }

    /// The layout of the test.
    pub fn layout(&self) -> &'a Layout<R, C> {
        self.layout
    }
}
