//! From responses to the motions of the reference point.

use nalgebra::{Complex, Vector6};

use super::{LineGrid, RigLayout, SolverMemory, Stage, SuspensionSolver, Wanted};
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::{RIG_HITS, is_finite};
use crate::modes::{CompactMotions, ForceMixing, MOST_LINES, OrderSearch, reduce};
use crate::{Progress, Real};

/// Lines that one step reduces.
const LINES_OF_A_STEP: usize = 10;

/// What has to hold before a response is asked for.
pub(super) fn check<R: Real>(
    layout: &RigLayout<R>,
    grid: &LineGrid<R>,
    dofs: &[usize],
) -> Result<(), Diagnostics> {
    let LineGrid { resolution_hz, band_hz, decay, correlation } = *grid;
    let numbers = [resolution_hz, band_hz[0], band_hz[1], decay, correlation];
    if !is_finite(layout) || !numbers.iter().all(|v| v.finite()) {
        return Err(fatal(Code::LayoutNotFinite, R::zero()));
    }
    let exists = |dof: &usize| *dof < layout.hits.len();
    let known = !dofs.is_empty() && dofs.len() <= layout.hits.len() && dofs.iter().all(exists);
    if !known || resolution_hz <= R::zero() || grid.count() == 0 {
        return Err(fatal(Code::FrfMissing, R::zero()));
    }
    let nothing = |_channel: usize, _force: usize| Complex::new(R::zero(), R::zero());
    let sigma =
        reduce(layout, grid.s(0), &layout.sensor_centroid(), nothing, &mut [Vector6::zeros()]);
    if sigma.is_none() {
        return Err(fatal(Code::ResponseRankDeficient, R::zero()));
    }
    Ok(())
}

impl<R: Real> SuspensionSolver<R> {
    /// Takes the response that is wanted: the accelerances of all lines, from zero on, (m/s²)/N. Missing lines count as
    /// numbers that are not finite.
    pub fn take(
        &mut self,
        layout: &RigLayout<R>,
        lines: &[Complex<R>],
        memory: &mut SolverMemory<'_, R>,
    ) {
        let Stage::Wanting(wanted) = self.stage else { return };
        let nan = R::zero() / R::zero();
        let readings = memory.readings.chunks_exact_mut(MOST_LINES).nth(wanted.channel);
        for (line, to) in readings.into_iter().flatten().enumerate().take(self.grid.count()) {
            let of_line = lines.get(self.grid.first() + line);
            *to = of_line.copied().unwrap_or(Complex::new(nan, nan));
        }
        let channel = wanted.channel + 1;
        self.stage = if channel < 3 * layout.sensors.len() {
            Stage::Wanting(Wanted { channel, ..wanted })
        } else {
            Stage::Reducing(Wanted { channel: 0, ..wanted }, 0)
        };
    }

    /// Wants this response, or the first of a later hit when this one has no share in the force. False when no hit is left.
    pub(super) fn want(&mut self, from: Wanted, mixing: &ForceMixing<R, RIG_HITS>) -> bool {
        let shares = |hit: &usize| mixing.share(from.force, *hit) != R::zero();
        let Some(hit) = (from.hit..self.dofs.len()).find(shares) else { return false };
        self.stage = Stage::Wanting(Wanted { hit, ..from });
        true
    }

    /// Reduces the readings of a hit at some lines, and adds their share in the force.
    #[inline(never)]
    pub(super) fn step_reducing(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let Stage::Reducing(wanted, start) = self.stage else { return Progress::Going };
        let count = self.grid.count();
        let mixing = self.mixing(layout);
        let share = |hit: usize| mixing.share(wanted.force, hit);
        let is_first = (0..wanted.hit).all(|hit| share(hit) == R::zero());
        if is_first && start == 0 {
            memory.scratch.fill(R::zero());
        }
        let share = share(wanted.hit);
        let end = (start + LINES_OF_A_STEP).min(count);
        for line in start..end {
            let s = self.grid.s(line);
            let reading =
                |channel: usize, _force: usize| memory.readings[channel * MOST_LINES + line];
            let mut motion = [Vector6::zeros()];
            let Some(sigma) = reduce(layout, s, &self.reference, reading, &mut motion) else {
                return self.fail(fatal(Code::ResponseRankDeficient, R::zero()));
            };
            memory.lines[line] = s;
            memory.weights[6 * line..][..6].copy_from_slice(&sigma);
            for (component, value) in motion[0].iter().enumerate() {
                let at = place(component, line);
                memory.scratch[at] += value.re * share;
                memory.scratch[at + 1] += value.im * share;
            }
        }
        if end < count {
            self.stage = Stage::Reducing(wanted, end);
            return Progress::Going;
        }
        if self.want(Wanted { hit: wanted.hit + 1, ..wanted }, &mixing) {
            return Progress::Going;
        }
        if !self.store_force(wanted.force, memory) {
            return self.fail(fatal(Code::DataNotFinite, R::zero()));
        }
        let next = Wanted { force: wanted.force + 1, ..Wanted::default() };
        if next.force == usize::from(self.forces) || !self.want(next, &mixing) {
            self.stage = Stage::Orders(OrderSearch::default());
        }
        Progress::Going
    }

    /// Stores the motions under a force; false when one is not finite.
    fn store_force(&mut self, force: usize, memory: &mut SolverMemory<'_, R>) -> bool {
        let (count, scratch) = (self.grid.count(), &*memory.scratch);
        (0..6).all(|component| {
            let values = (0..count).map(|line| {
                let at = place(component, line);
                Complex::new(scratch[at], scratch[at + 1])
            });
            CompactMotions::<R>::store(memory.codes, &mut self.units[0], (force, component), values)
        })
    }
}

/// Where the real part of a component at a line is.
fn place(component: usize, line: usize) -> usize {
    2 * (component * MOST_LINES + line)
}
