//! The frequency responses of a result: those of its archive, or those of the universal file that it was solved from.

use massline_shared::layout::{Dof, HostLayout, RIG_SENSORS};
use nalgebra::Complex;

use super::ResultFile;
use massline_analysis::identification::lines_of;
use massline_files::archive::{Archive, ArchivedSpectra};
use massline_files::uff::NodeDirection;
use massline_result::{Error, Result};

/// The responses to the hits at one DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct DofResponses {
    /// The DOF.
    pub dof: Dof,
    /// Its place in the layout.
    pub hit: usize,
    /// Number of averaged hits, where it is known.
    pub hits: Option<u8>,
    /// Frequencies of the bins, Hz; none when only the mass lines are known.
    pub frequency_hz: Vec<f64>,
    /// Accelerance of each response bin by bin, (m/s²)/N.
    pub accelerance: Vec<Vec<Complex<f64>>>,
    /// Coherence of each response bin by bin, where it is known.
    pub coherence: Vec<Vec<f64>>,
    /// Decay rate σ of the exponential window, 1/s.
    pub decay_per_s: f64,
    /// What the result was found from.
    pub band: Band,
}

/// The responses to all hits of a layout, at the same frequencies.
pub struct FileResponses {
    /// Frequencies of the bins, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Those of each hit.
    pub hits: Vec<HitResponses>,
}

/// The responses to one hit: sensor by sensor, axis by axis.
pub struct HitResponses {
    /// Accelerance bin by bin, (m/s²)/N.
    pub accelerance: Vec<Vec<Complex<f64>>>,
    /// Coherence bin by bin; empty unless the file has that of every response.
    pub coherence: Vec<Vec<f64>>,
}

/// What the answers were found from.
#[derive(Clone, Debug, PartialEq)]
pub enum Band {
    /// The mass lines in this band, Hz: rigid-body accelerance of each response, (m/s²)/N.
    MassLines([f64; 2], Vec<f64>),
    /// The suspension modes in this band, Hz.
    Suspension([f64; 2]),
}

impl Band {
    /// Its ends, Hz.
    pub fn ends_hz(&self) -> [f64; 2] {
        match self {
            Self::MassLines(ends, _) | Self::Suspension(ends) => *ends,
        }
    }

    /// The mass lines; `None` where the modes are used.
    pub fn mass_lines(&self) -> Option<&[f64]> {
        match self {
            Self::MassLines(_, lines) => Some(lines),
            Self::Suspension(_) => None,
        }
    }
}

impl ResultFile {
    /// The responses to every hit, in the order of the layout or the test; none where they are not known.
    pub fn responses(&self) -> Vec<DofResponses> {
        match &self.archive {
            Some(archive) => of_archive(archive),
            None => self.responses.clone(),
        }
    }

    /// Adds the frequency responses that this result was solved from; `responses_of` reads those of a layout.
    ///
    /// # Errors
    /// Exit 2 for an archive, which has its own, without a layout, and when the file lacks a response.
    pub fn add_responses(
        &mut self,
        responses_of: impl FnOnce(&HostLayout) -> Result<FileResponses>,
    ) -> Result<()> {
        let name = &self.name;
        if self.archive.is_some() {
            let text = format!(
                "{name}: this archive has frequency responses of its own; leave out --responses"
            );
            return Err(Error::input("usage", text));
        }
        let Some(layout) = self.layout() else {
            let text = format!(
                "{name}: the layout says which responses are those of the test; give it with --layout"
            );
            return Err(Error::input("layout_needed", text));
        };
        let measured = responses_of(layout)?;
        let bands = layout.hits.iter().map(|hit| self.band_of(hit.dof));
        let each = layout.hits.iter().zip(measured.hits).zip(bands).enumerate();
        let responses = each.map(|(place, ((hit, of_hit), band))| DofResponses {
            dof: hit.dof,
            hit: place,
            hits: None,
            frequency_hz: measured.frequency_hz.clone(),
            accelerance: of_hit.accelerance,
            coherence: of_hit.coherence,
            decay_per_s: 0.0,
            band,
        });
        self.responses = responses.collect();
        Ok(())
    }

    /// What the result says about the band of a DOF.
    fn band_of(&self, dof: Dof) -> Band {
        let lines = self.result.mass_lines.iter().find(|lines| lines.dof == dof.to_string());
        let is_band = |ends: &[f64; 2]| 0.0 <= ends[0] && ends[0] < ends[1] && ends[1] <= 1e6;
        if let Some((ends, lines)) = self.result.band_hz.filter(is_band).zip(lines) {
            return Band::MassLines(ends, lines.accelerance_m_per_s2_per_n.clone());
        }
        let expected = || self.layout().map_or([10.0, 120.0], |layout| layout.test.expected_band());
        Band::Suspension(
            self.result.suspension.as_ref().map_or_else(expected, |modes| modes.band_hz),
        )
    }
}

/// The responses of an archive. An edited one may have more sensors than its rig.
fn of_archive(archive: &Archive) -> Vec<DofResponses> {
    let (layout, frfs) = (&archive.layout.resolved, archive.frfs());
    let responses = 3 * layout.sensors.len().min(RIG_SENSORS);
    let of_dof = |hit: usize, hits: u8, band: Band| {
        let dof = layout.hits.get(hit)?.dof;
        let name = dof.to_string();
        let spectra = archive.spectra.iter().find(|spectra| spectra.dof == name);
        let reference = NodeDirection::from(dof);
        let frfs: Vec<_> =
            frfs.iter().filter(|frf| frf.reference == reference).take(responses).collect();
        let coherence =
            |spectra: &ArchivedSpectra| (0..responses).map(|k| spectra.coherence(k)).collect();
        Some(DofResponses {
            dof,
            hit,
            hits: Some(hits),
            frequency_hz: frfs.first().map_or(Vec::new(), |frf| frf.frequency_hz.clone()),
            accelerance: frfs.iter().map(|frf| frf.accelerance.clone()).collect(),
            coherence: spectra.map_or(Vec::new(), coherence),
            decay_per_s: archive.decay_per_s().unwrap_or_default(),
            band,
        })
    };
    let of_mass_lines =
        lines_of(&archive.result, layout).into_iter().filter_map(|(place, lines)| {
            let dof = archive.result.dofs.iter().find(|dof| usize::from(dof.index) == place)?;
            let accelerance = lines.accelerance.iter().copied().take(responses).collect();
            of_dof(place, dof.hits, Band::MassLines(dof.band_hz.map(f64::from), accelerance))
        });
    let of_lines = archive.result.lines.iter().filter_map(|line| {
        of_dof(line.index.into(), line.hits as u8, Band::Suspension(line.band_hz.map(f64::from)))
    });
    of_mass_lines.chain(of_lines).collect()
}
