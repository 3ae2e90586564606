//! The large memory of a measurement, borrowed from its driver.

use heapless::Vec;
use nalgebra::Complex;

use super::averaging::{DofSpectra, HitMemory};
use super::result::MeasuredDof;
use super::stored_lines::StoredLines;
use crate::capacity::Rig;
use crate::identify::{
    DofMassLines, Identification, MASS_LINE_METHODS, ScatterAccumulator, maximum_likelihood,
};
use crate::layout::RIG_HITS;
use crate::mass_line::BasisRow;
use crate::real::Real;
use crate::signal::{KnownScatter, RECORD_SCANS, RealFft, Record, SPECTRUM_BINS};

// The scratch memory is also the workspace of the methods.
const _: () = assert!(maximum_likelihood::RIG_WORKSPACE <= RECORD_SCANS);

/// The large memory of a measurement: about 75 KiB in single precision. Its initial value is all zeros, so a
/// static one takes no room in the image.
pub struct Memory<R: Real> {
    pub(super) record: Record,
    /// Averages of the hits at the current DOF.
    pub(super) spectra: DofSpectra<R>,
    /// Samples and transform of one channel; after the last hit, the workspace of the identification.
    pub(super) scratch: [R; RECORD_SCANS],
    pub(super) force: [Complex<R>; SPECTRUM_BINS],
    pub(super) basis: [BasisRow<R>; SPECTRUM_BINS],
    /// Mass lines of the single hits at the current DOF.
    pub(super) single_hits: Option<ScatterAccumulator<R, Rig>>,
    /// Data measured in this campaign, DOF by DOF.
    pub(super) dofs: Vec<MeasuredDof<R>, RIG_HITS>,
    /// The mass lines of these DOFs, in the same order.
    pub(super) mass_lines: Vec<DofMassLines<R, Rig>, RIG_HITS>,
    /// Or, in the suspension profile, what is known of their stored lines.
    pub(super) lines: Vec<StoredLines<R>, RIG_HITS>,
    /// The methods that run, or their answers.
    pub(super) answers: Identification<R, MASS_LINE_METHODS>,
}

macro_rules! memory {
    ($($real:ty),*) => {$(
        impl Memory<$real> {
            /// Empty memory.
            pub const fn new() -> Self {
                Self {
                    record: Record::new(),
                    spectra: DofSpectra::<$real>::new(),
                    scratch: [0.0; RECORD_SCANS],
                    force: [Complex { re: 0.0, im: 0.0 }; SPECTRUM_BINS],
                    basis: [BasisRow::<$real>::EMPTY; SPECTRUM_BINS],
                    single_hits: None,
                    dofs: Vec::new(),
                    mass_lines: Vec::new(),
                    lines: Vec::new(),
                    answers: Identification::idle(),
                }
            }
        }

        impl Default for Memory<$real> {
            fn default() -> Self {
                Self::new()
            }
        }
    )*};
}

memory!(f32, f64);

impl<R: Real> Memory<R> {
    /// The parts needed to process a hit.
    pub(super) fn of_hit(&mut self) -> (&Record, &mut DofSpectra<R>, HitMemory<'_, R>) {
        let Self { record, spectra, scratch, force, basis, .. } = self;
        (record, spectra, HitMemory { scratch, force, basis })
    }

    /// Discards the data of a campaign.
    pub(super) fn discard_campaign(&mut self) {
        self.single_hits = None;
        self.dofs.clear();
        self.mass_lines.clear();
        self.lines.clear();
        self.answers.begin([]);
    }

    /// Stores the data of a DOF and replaces previous data of it.
    pub(super) fn store_dof(&mut self, details: MeasuredDof<R>, mass_lines: DofMassLines<R, Rig>) {
        self.discard_dof(mass_lines.0);
        // There is room for every DOF of a layout.
        let _ = self.mass_lines.push(mass_lines);
        let _ = self.dofs.push(details);
    }

    /// Stores what is said about a DOF besides its lines, and replaces previous data of it.
    pub(super) fn keep_lines(&mut self, details: MeasuredDof<R>, lines: StoredLines<R>) {
        self.discard_dof(lines.dof.into());
        // There is room for every DOF of a layout.
        let _ = self.lines.push(lines);
        let _ = self.dofs.push(details);
    }

    /// Discards the data of a DOF.
    pub(super) fn discard_dof(&mut self, dof: usize) {
        if let Some(place) = self.mass_lines.iter().position(|(index, _)| *index == dof) {
            self.mass_lines.remove(place);
            self.dofs.remove(place);
        }
        if let Some(place) = self.lines.iter().position(|lines| usize::from(lines.dof) == dof) {
            self.lines.remove(place);
            self.dofs.remove(place);
        }
    }
}

impl<R: RealFft> Memory<R> {
    /// Scatter of the repeat hits at the DOFs whose lines are stored.
    pub(super) fn known_line_scatter(&self) -> KnownScatter<R> {
        let mut known = KnownScatter::none();
        for lines in &self.lines {
            let scatter = &lines.scatter;
            known.add(lines.hits.into(), scatter.mean_squared, scatter.scatter_squared);
        }
        known
    }
}
