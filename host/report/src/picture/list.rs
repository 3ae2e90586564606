//! The list of pictures.

use clap::ValueEnum;
use massline_shared::layout::Dof;

use super::{
    Assurance, Budget, Drawing, DrivingPoints, Estimates, HitsOfDof, ImageFormat, Indicators,
    LayoutInSpace, Pulls, Responses, Stabilisation, render,
};
use crate::result_file::ResultFile;
use massline_result::Result;

/// A picture that can be made of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Picture {
    /// The ten properties with their intervals: all methods of a result, or the best answers of several results.
    Estimates,
    /// Sensors, hits, centre of mass, principal axes and the ellipsoid of the same inertia.
    Layout,
    /// Magnitude, phase and coherence of the frequency responses, with the mass lines where there are some, a picture
    /// for each hit DOF.
    Frf,
    /// All hits overlaid: force, its spectrum and responses, a picture for each hit DOF.
    Hits,
    /// Whether every point that is hit moves with its force.
    DrivingPoints,
    /// How far the fit pulls sensors and hits, and what it leaves of the readings of the hits.
    Pulls,
    /// The error budget as stated and as learned.
    Budget,
    /// How much of each suspension mode each hit shows.
    NormIndicator,
    /// The modal assurance criterion of the suspension modes.
    Mac,
    /// The poles of the suspension modes over the order of the fit.
    Stabilisation,
}

/// The file of a picture.
pub struct DrawnFile {
    /// Which picture it is.
    pub picture: Picture,
    /// The hit DOF, where there is a picture for each.
    pub dof: Option<Dof>,
    /// Its contents.
    pub bytes: Vec<u8>,
}

impl DrawnFile {
    /// Its name without the extension; it has no colon, which Windows does not allow in names of files.
    pub fn stem(&self) -> String {
        let name = self.picture.name();
        self.dof.map_or_else(|| name.clone(), |dof| format!("{name}-{dof}").replace(':', ""))
    }

    /// What it shows, as a caption under it.
    pub fn caption(&self) -> String {
        let caption = self.picture.caption();
        self.dof.map_or_else(|| caption.into(), |dof| format!("{caption}, hits at {dof}"))
    }
}

impl Picture {
    /// Every picture.
    pub fn all() -> &'static [Self] {
        Self::value_variants()
    }

    /// Its name on the command line and in the names of files.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// What it shows, as a caption under it.
    fn caption(self) -> &'static str {
        match self {
            Self::Estimates => "The ten properties",
            Self::Layout => "The test in space",
            Self::Frf => "Frequency responses",
            Self::Hits => "All hits overlaid",
            Self::DrivingPoints => "Driving points: does every point move with its force?",
            Self::Pulls => "Pulls of sensors and hits: what contradicts the error budget",
            Self::Budget => "The error budget as stated and as learned",
            Self::NormIndicator => "How much of each suspension mode each hit shows",
            Self::Mac => "Modal assurance criterion of the suspension modes",
            Self::Stabilisation => "Poles of the suspension modes over the order of the fit",
        }
    }

    /// What a result must have for it, to complete the sentence "it needs …".
    pub fn needs(self) -> &'static str {
        match self {
            Self::Estimates => "an answer",
            Self::Layout => "an archive, or the layout file of the test (--layout)",
            Self::Frf => {
                "an archive with the spectra of the test, or the universal file that the result was solved from \
                 (--responses)"
            }
            Self::Hits => {
                "an archive with the records of the hits: measure --output FILE.massline --records"
            }
            Self::DrivingPoints => {
                "an archive with mass lines or the universal file of the responses (--responses), and sensors that see \
                 all motions of the body"
            }
            Self::Pulls => "an answer by maximum likelihood with the details of its fit",
            Self::Budget => "an answer that has learned about its error budget",
            Self::NormIndicator | Self::Mac | Self::Stabilisation => {
                "suspension modes: the output of solve or modes with --json, from responses in the suspension band"
            }
        }
    }

    /// The files of the picture; none when the results have nothing to show in it. Only the estimates show several
    /// results.
    ///
    /// # Errors
    /// When a result is malformed.
    pub fn of(self, sources: &[ResultFile], format: ImageFormat) -> Result<Vec<DrawnFile>> {
        let [first, ..] = sources else { return Ok(Vec::new()) };
        let result = first.result();
        let (modes, details) = (result.suspension.as_ref(), result.details.as_ref());
        match self {
            Self::Estimates => self.one(Estimates::of(sources)?, format),
            Self::Layout => self.one(LayoutInSpace::of(first)?, format),
            Self::Frf => {
                let each = Responses::of(first)?;
                each.iter()
                    .map(|responses| self.file(Some(responses.dof), responses, format))
                    .collect()
            }
            Self::Hits => {
                let each = HitsOfDof::of(first)?;
                each.iter().map(|hits| self.file(Some(hits.dof), hits, format)).collect()
            }
            Self::DrivingPoints => self.one(DrivingPoints::of(first)?, format),
            Self::Pulls => self.one(details.and_then(|details| Pulls::of(first, details)), format),
            Self::Budget => {
                self.one(details.and_then(|details| Budget::of(first, details)), format)
            }
            Self::NormIndicator => {
                self.one(modes.map(|modes| Indicators::of(first, modes)), format)
            }
            Self::Mac => self.one(modes.map(|modes| Assurance::of(first, modes)), format),
            Self::Stabilisation => {
                self.one(modes.map(|modes| Stabilisation::of(first, modes)), format)
            }
        }
    }

    fn one(self, drawing: Option<impl Drawing>, format: ImageFormat) -> Result<Vec<DrawnFile>> {
        drawing.into_iter().map(|drawing| self.file(None, &drawing, format)).collect()
    }

    fn file(
        self,
        dof: Option<Dof>,
        drawing: &impl Drawing,
        format: ImageFormat,
    ) -> Result<DrawnFile> {
        Ok(DrawnFile { picture: self, dof, bytes: render(drawing, format)? })
    }
}
