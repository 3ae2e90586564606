//! The lines of a rig's result in the suspension profile.

use massline_protocol::lines::LinesId;
use massline_protocol::object::MeasurementResult;
use massline_shared::layout::{HostLayout, TestProfile};
use massline_shared::signal::{AdcProperties, ringing_s};
use nalgebra::Complex;

use massline_analysis::suspension::{DofLines, TestLines};
use massline_client::{Client, ClientError, StoredDof};
use massline_files::archive::{Archive, ArchivedLines};

/// The lines of the DOFs of a result; none in the mass-line profile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigLines {
    /// The converter that they were measured with.
    adc: Option<AdcProperties>,
    dofs: Vec<ArchivedLines>,
}

/// A result as a rig has stored it, with the lines of its DOFs.
#[derive(Clone, Copy, Debug)]
pub struct StoredTest<'a> {
    /// The result.
    pub result: &'a MeasurementResult,
    /// Its lines.
    pub lines: &'a RigLines,
}

impl RigLines {
    /// Reads the lines of a result from the rig with this converter. DOFs that the rig does not have any more are left
    /// out.
    ///
    /// # Errors
    /// As [`Client::lines`].
    pub fn read(
        client: &mut Client,
        adc: AdcProperties,
        result: &MeasurementResult,
    ) -> Result<Self, ClientError> {
        let mut dofs = Vec::new();
        for head in &result.lines {
            let id = LinesId { result: result.head.number, dof: head.index };
            dofs.extend(client.lines(id)?.as_ref().map(archived));
        }
        Ok(Self { adc: Some(adc), dofs })
    }

    /// The lines in an archive.
    pub fn of_archive(archive: &Archive) -> Self {
        Self { adc: Some(archive.rig.sampler.adc), dofs: archive.lines.clone() }
    }

    /// The lines, DOF by DOF.
    pub fn into_dofs(self) -> Vec<ArchivedLines> {
        self.dofs
    }
}

/// The lines that a rig has sent, as an archive has them.
fn archived(stored: &StoredDof) -> ArchivedLines {
    let parts =
        |response: &Vec<Complex<f32>>| response.iter().map(|value| [value.re, value.im]).collect();
    ArchivedLines {
        dof: stored.head.dof.to_string(),
        responses: stored.responses.iter().map(parts).collect(),
    }
}

/// The lines of a DOF that a rig has stored, in double precision.
pub fn lines_of(stored: &StoredDof) -> DofLines {
    let lines = stored.responses.iter().flatten();
    let lines = lines.map(|value| Complex::new(f64::from(value.re), f64::from(value.im)));
    DofLines { dof: stored.head.index.into(), lines: lines.collect() }
}

impl StoredTest<'_> {
    /// What was measured.
    pub fn profile(&self) -> TestProfile {
        self.result.profile()
    }

    /// The DOFs of the result whose lines are missing.
    pub fn missing(&self) -> Vec<String> {
        let names = self.result.lines.iter().map(|head| head.dof.to_string());
        names.filter(|name| self.lines.dofs.iter().all(|lines| lines.dof != *name)).collect()
    }

    /// The lines with the layout of the test, and how long the object has rung in each record, s; `None` without lines.
    pub fn measured_lines(&self, layout: &HostLayout) -> Option<(TestLines, f64)> {
        let adc = self.lines.adc.filter(|_| !self.lines.dofs.is_empty())?;
        let dof_lines = |lines: &ArchivedLines| {
            let head = self.result.lines.iter().find(|head| head.dof.to_string() == lines.dof)?;
            let accelerance = lines.accelerance().flatten().collect();
            Some(DofLines { dof: usize::from(head.index), lines: accelerance })
        };
        let dofs: Vec<_> = self.lines.dofs.iter().filter_map(dof_lines).collect();
        Some((TestLines::new(layout, &adc, &dofs), ringing_s(&adc)))
    }
}
