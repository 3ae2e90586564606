//! The list of pictures.

use super::{
    Assurance, Drawing, Estimates, ImageFormat, InSpace, Indicators, Responses, Source,
    Stabilisation, render,
};
use crate::error::Result;

/// A picture that can be made of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Picture {
    /// The ten properties with their intervals: all methods of a result, or the best answers of several results.
    Estimates,
    /// Sensors, hits, centre of mass, principal axes and the ellipsoid of the same inertia.
    Layout,
    /// Magnitude, phase and coherence of the frequency responses with the mass lines, a picture for each hit DOF.
    Frf,
    /// How much of each suspension mode each hit shows.
    NormIndicator,
    /// The modal assurance criterion of the suspension modes.
    Mac,
    /// The poles of the suspension modes over the order of the fit.
    Stabilisation,
}

/// The file of a picture.
pub struct DrawnFile {
    /// Its name without the extension: that of the picture, with the DOF where there is one for each.
    pub stem: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Every picture.
    pub const ALL: [Self; 6] = [
        Self::Estimates,
        Self::Layout,
        Self::Frf,
        Self::NormIndicator,
        Self::Mac,
        Self::Stabilisation,
    ];

    /// Its name on the command line and in the names of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Estimates => "estimates",
            Self::Layout => "layout",
            Self::Frf => "frf",
            Self::NormIndicator => "norm-indicator",
            Self::Mac => "mac",
            Self::Stabilisation => "stabilisation",
        }
    }

    /// What a result must have for it, to complete the sentence "it needs …".
    pub fn needs(self) -> &'static str {
        match self {
            Self::Estimates => "an answer",
            Self::Layout => "an archive, or the layout file of the test (--layout)",
            Self::Frf => "an archive with the spectra of the test",
            Self::NormIndicator | Self::Mac | Self::Stabilisation => {
                "suspension modes: the output of solve or modes with --json, from responses in the suspension band"
            }
        }
    }

    /// The files of the picture; none when the results have nothing to show in it. Only the estimates show several results.
    ///
    /// # Errors
    /// When a result is malformed, and without a layout for the estimates.
    pub fn of(self, sources: &[Source], format: ImageFormat) -> Result<Vec<DrawnFile>> {
        let [first, ..] = sources else { return Ok(Vec::new()) };
        let modes = || first.modes();
        match self {
            Self::Estimates => self.one(Estimates::of(sources)?, format),
            Self::Layout => self.one(InSpace::of(first)?, format),
            Self::Frf => Responses::of(first)?.iter().map(|of| self.of_dof(of, format)).collect(),
            Self::NormIndicator => self.one(modes()?.map(|of| Indicators::of(first, &of)), format),
            Self::Mac => self.one(modes()?.map(|of| Assurance::of(first, &of)), format),
            Self::Stabilisation => {
                self.one(modes()?.map(|of| Stabilisation::of(first, &of)), format)
            }
        }
    }

    fn one(self, drawing: Option<impl Drawing>, format: ImageFormat) -> Result<Vec<DrawnFile>> {
        let file =
            |drawing| Ok(DrawnFile { stem: self.name().into(), bytes: render(&drawing, format)? });
        drawing.into_iter().map(file).collect()
    }

    /// The name of a file must not have a colon on Windows.
    fn of_dof(self, drawing: &Responses, format: ImageFormat) -> Result<DrawnFile> {
        let stem = format!("{}-{}", self.name(), drawing.dof.replace(':', ""));
        Ok(DrawnFile { stem, bytes: render(drawing, format)? })
    }
}
