//! What a document says about the measurement: its mass lines, its suspension modes, and the details of the fit.

use massline_shared::calibration::CalibrationSigma;
use massline_shared::layout::HostLayout;
use serde::Deserialize;
use serde_json::Value;

use super::{ResultFile, ShownModes};
use crate::document::{ErrorBudget, HitDetails, SensorDetails};
use crate::error::{Error, Result};
use crate::identification::with_gains;

/// The mass lines of a hit DOF.
#[derive(Clone, Debug, Deserialize)]
pub struct ShownMassLine {
    /// The DOF.
    pub dof: String,
    /// Number of averaged hits, where it is known.
    pub hits: Option<u8>,
    /// Their band, Hz, where every DOF has its own.
    pub band_hz: Option<[f64; 2]>,
    /// Mean coherence of every response, where it is known.
    pub coherence: Option<Vec<f64>>,
    /// Standard deviation of the accelerance of every response.
    #[serde(rename = "noise_m_per_s2_per_n")]
    pub noise: Vec<Option<f64>>,
}

/// A DOF that was measured.
#[derive(Clone, Debug, Deserialize)]
pub struct ShownDof {
    /// The DOF.
    pub dof: String,
    /// Number of averaged hits, where it is known.
    pub hits: Option<u16>,
    /// The band, Hz, where every DOF has its own.
    pub band_hz: Option<[f64; 2]>,
    /// Mean coherence of every response, where it is known.
    pub coherence: Option<Vec<f64>>,
}

/// What pictures show of the details of a fit.
pub struct ShownDetails {
    /// The sensors.
    pub sensors: Vec<SensorDetails>,
    /// The hits.
    pub hits: Vec<HitDetails>,
    /// The error budget as stated and as learned.
    pub error_budget: Option<ErrorBudget>,
}

impl ResultFile {
    /// The mass lines of the DOFs that are in the answers; none where these have no mass lines.
    ///
    /// # Errors
    /// Exit 2 when they are malformed.
    pub fn mass_lines(&self) -> Result<Vec<ShownMassLine>> {
        match self.document["mass_lines"].is_array() {
            true => self.part(&self.document, "document", "mass_lines"),
            false => Ok(Vec::new()),
        }
    }

    /// The DOFs that are in the answers, with mass lines or with lines about the suspension modes.
    ///
    /// # Errors
    /// Exit 2 when they are malformed.
    pub fn measured_dofs(&self) -> Result<Vec<ShownDof>> {
        let mut dofs: Vec<ShownDof> = match self.document["mass_lines"].is_array() {
            true => self.part(&self.document, "document", "mass_lines")?,
            false => Vec::new(),
        };
        if self.document["lines"].is_array() {
            dofs.extend(self.part::<Vec<ShownDof>>(&self.document, "document", "lines")?);
        }
        Ok(dofs)
    }

    /// The standard deviations that the calibration has contributed to the error budget, as old as it was during the test;
    /// `None` where it has contributed none.
    pub fn gains(&self) -> Option<CalibrationSigma> {
        match &self.archive {
            Some(archive) => archive.result.head.gains,
            None => CalibrationSigma::deserialize(&self.document["calibration_sigma"]).ok(),
        }
    }

    /// The layout as the answers were found with: its budget has what the calibration has contributed.
    pub fn layout_in_force(&self) -> Option<HostLayout> {
        self.layout().map(|layout| with_gains(layout, self.gains()))
    }

    /// The suspension modes, where the result has them.
    ///
    /// # Errors
    /// Exit 2 when they are malformed.
    pub fn modes(&self) -> Result<Option<ShownModes>> {
        let modes = match &self.document["suspension"] {
            Value::Object(_) => &self.document["suspension"],
            // The output of `massline modes` is nothing else.
            _ if self.document["modes"].is_array() => &self.document,
            _ => return Ok(None),
        };
        let part = "suspension modes";
        let shown = ShownModes {
            band_hz: self.part(modes, part, "band_hz")?,
            modes: self.part(modes, part, "modes")?,
            missing: self.part(modes, part, "modes_missing")?,
            hit_for_missing: self.part(modes, part, "hit_for_missing")?,
            modal_assurance: self.part(modes, part, "modal_assurance")?,
            orders: self.part(modes, part, "orders")?,
            noise: self.part(modes, part, "noise_m_per_s2_per_n")?,
        };
        shown.check().map_err(|what| {
            let text = format!("{}: {part}: {what}", self.name);
            Error::input("result_malformed", text)
        })?;
        Ok(Some(shown))
    }

    /// What the fit has found about sensors and hits, where the result has it: of the host, else of its document.
    ///
    /// # Errors
    /// Exit 2 when it is malformed.
    pub fn details(&self) -> Result<Option<ShownDetails>> {
        let of_host = self.document.get("host").and_then(|host| host.get("details"));
        let details = [of_host, self.document.get("details")];
        let Some(details) = details.into_iter().flatten().find(|of| of.is_object()) else {
            return Ok(None);
        };
        let part = "details";
        Ok(Some(ShownDetails {
            sensors: self.part(details, part, "sensors")?,
            hits: self.part(details, part, "hits")?,
            error_budget: self.part(details, part, "error_budget")?,
        }))
    }
}
