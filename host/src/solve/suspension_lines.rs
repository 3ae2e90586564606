//! The lines of the suspension band.

use massline_shared::modes::MOST_LINES;

use super::frfs::LinesOfBand;

/// Fewest lines that can show five modes: two unknowns and their complex residues each, twice over.
pub(super) const FEWEST_LINES: usize = 24;
/// Lines further apart than this many times their neighbours leave a gap.
const GAP: f64 = 3.0;

impl LinesOfBand {
    /// Number of lines.
    pub(super) fn len(&self) -> usize {
        self.frequencies.len()
    }

    /// Length of the records, s, if the lines are as close as it permits.
    pub(super) fn record_s(&self) -> f64 {
        let distances = self.frequencies.windows(2).map(|f| f[1] - f[0]);
        distances.fold(f64::INFINITY, f64::min).recip()
    }

    /// Evenly picked lines, as many as the modal fit has room for.
    pub(super) fn thinned(&self) -> Self {
        let count = self.len();
        if count <= MOST_LINES {
            return self.clone();
        }
        let last = (count - 1) as f64 / (MOST_LINES - 1) as f64;
        self.picked((0..MOST_LINES).map(|k| (k as f64 * last).round() as usize))
    }

    /// The lines that say most about these modes, given by frequency in Hz and damping ratio: three quarters are those
    /// nearest to a mode in bandwidths, and the rest is spread over the band.
    pub(super) fn about(&self, modes: &[(f64, f64)]) -> Self {
        let count = self.len();
        if count <= MOST_LINES {
            return self.clone();
        }
        let distance = |line: usize| {
            let bandwidths = |(frequency, damping): &(f64, f64)| {
                (self.frequencies[line] - frequency).abs() / (2.0 * damping * frequency)
            };
            modes.iter().map(bandwidths).fold(f64::INFINITY, f64::min)
        };
        let mut nearest: Vec<usize> = (0..count).collect();
        nearest.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let mut picked: Vec<usize> = nearest[..MOST_LINES * 3 / 4].to_vec();
        let rest: Vec<usize> = (0..count).filter(|line| !picked.contains(line)).collect();
        let wanted = MOST_LINES - picked.len();
        let step = rest.len() as f64 / wanted as f64;
        picked.extend((0..wanted).filter_map(|k| rest.get((k as f64 * step) as usize)));
        picked.sort_unstable();
        picked.dedup();
        self.picked(picked.into_iter())
    }

    /// The frequency at which a gap in the lines begins, Hz, when there is one.
    pub(super) fn gap(&self) -> Option<f64> {
        let distances: Vec<f64> = self.frequencies.windows(2).map(|f| f[1] - f[0]).collect();
        // Lines may become wider apart with frequency, as on a logarithmic scale.
        let neighbours = |place: usize| {
            let before = place.checked_sub(1).and_then(|before| distances.get(before));
            let both = [before, distances.get(place + 1)];
            both.into_iter().flatten().copied().fold(0.0, f64::max)
        };
        let is_gap = |place: &usize| distances[*place] > GAP * neighbours(*place);
        let place = (0..distances.len()).filter(|_| distances.len() > 1).find(is_gap)?;
        self.frequencies.get(place).copied()
    }

    fn picked(&self, lines: impl Iterator<Item = usize>) -> Self {
        let width = self.channels * self.hits;
        let mut picked = Self { frequencies: Vec::new(), accelerance: Vec::new(), ..self.clone() };
        for line in lines {
            picked.frequencies.push(self.frequencies[line]);
            picked.accelerance.extend(&self.accelerance[line * width..(line + 1) * width]);
        }
        picked
    }
}
