//! Large objects, read in chunks so that an interrupted download can resume.

use heapless::Vec;
use num_enum::{IntoPrimitive, TryFromPrimitive};
use serde::{Deserialize, Serialize};

use crate::lines_head::LinesHead;
use massline_shared::body::RigidBody;
use massline_shared::calibration::CalibrationSigma;
use massline_shared::capacity::Rig;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::maximum_likelihood::LearnedBudget;
use massline_shared::identify::{
    Consistency, DofMassLines, Estimate, ForceTrend, METHODS, MassLines, Method, lower_triangle,
    symmetric,
};
use massline_shared::layout::{Dof, FrfEstimator, RIG_HITS, RIG_SENSORS, TestProfile};
use massline_shared::mass_line::Terms;
use massline_shared::measurement::MeasuredDof;
use massline_shared::responses::Responses;
use massline_shared::signal::RESPONSES;
use nalgebra::SVector;

/// Largest chunk, bytes.
pub const MAX_CHUNK: usize = 1024;

/// Kinds of objects, raw in [`ObjectId::kind`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub enum ObjectKind {
    /// A stored [`MeasurementResult`], postcard; `number` is the result's.
    Result = 1,
    /// The record of the last hit: scans of ten little-endian u16 codes; `number` is the hit's, or [`READING`].
    Record = 2,
    /// Averaged spectra of the current DOF or of the last one finished; `number` is the DOF's index. It
    /// consists of little-endian words of four bytes: DOF, hits, responses (u8 each) and a zero; number of
    /// bins (u16) and a zero; bin spacing in Hz (f32); σ of the exponential window in 1/s (f32); then as
    /// f32: G_FF by bin, G_XF of each response by bin (re, im), G_XX of each response by bin. There is
    /// space for [`RESPONSES`] responses; the header gives the number in use. Force and responses of each hit
    /// are divided by the root of the force's energy in the band, so the spectra count hits of any force the
    /// same: G_FF has no unit, G_XF is in (m/s²)/N.
    Spectra = 3,
    /// A finished DOF with its lines, of a stored result or of the current campaign; `number` is that of a
    /// [`LinesId`](crate::lines::LinesId). It consists of the head, postcard, which says what was measured besides the
    /// lines, and of the lines of each response as in
    /// [`CompactLines`](massline_shared::signal::CompactLines). A campaign by mass lines stores none.
    Lines = 4,
    /// A stored layout as it was sent, the `RigLayout` in postcard; `number` is its hash.
    Layout = 5,
}

/// Number of the record of a reading without a hit, as long as no hit has followed; hits count from 1.
pub const READING: u32 = 0;

/// Identifies an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ObjectId {
    /// Raw [`ObjectKind`].
    pub kind: u8,
    /// Number of the object within its kind.
    pub number: u32,
}

/// Length and checksum of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ObjectInfo {
    /// Length, bytes.
    pub length: u32,
    /// CRC-32 (ISO-HDLC) of all bytes.
    pub crc: u32,
}

/// Asks for a piece of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChunkRequest {
    /// The object.
    pub object: ObjectId,
    /// Offset of the first byte.
    pub offset: u32,
    /// Number of bytes wanted, at most [`MAX_CHUNK`].
    pub length: u16,
}

/// A piece of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chunk {
    /// The object.
    pub object: ObjectId,
    /// Offset of the first byte in the object.
    pub offset: u32,
    /// The bytes.
    pub bytes: Vec<u8, MAX_CHUNK>,
}

/// A [`Chunk`] to be sent without copying its bytes; the encoding is the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChunkRef<'a> {
    /// The object.
    pub object: ObjectId,
    /// Offset of the first byte in the object.
    pub offset: u32,
    /// The bytes, at most [`MAX_CHUNK`].
    pub bytes: &'a [u8],
}

/// Elements of the lower triangle of a symmetric matrix of the responses.
pub const SCATTER: usize = RESPONSES * (RESPONSES + 1) / 2;
/// Elements of the lower triangle of a 10 × 10 matrix.
pub const COVARIANCE: usize = 55;

/// Measured mass lines of one DOF.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DofResult {
    /// The DOF.
    pub dof: Dof,
    /// Its index in the layout.
    pub index: u8,
    /// Number of hits averaged.
    pub hits: u8,
    /// Lower and upper end of the band of its mass lines, Hz.
    pub band_hz: [f32; 2],
    /// Mass line accelerance of each response from the averaged spectra, (m/s²)/N.
    pub accelerance: [f32; RESPONSES],
    /// Standard deviation of each accelerance from the scatter of the bins about the model,
    /// corrected for the window, (m/s²)/N.
    pub noise: [f32; RESPONSES],
    /// Sample covariance of the single hits' mass lines, lower triangle row by row, ((m/s²)/N)²; empty when
    /// it is unknown.
    pub scatter: Vec<f32, SCATTER>,
    /// Mean coherence over the band for each response; `None` for a single hit, whose coherence carries no
    /// information.
    pub coherence: Option<[f32; RESPONSES]>,
    /// How the single hits' accelerances change with their force.
    pub trend: StoredTrend,
    /// Change of each accelerance when the ends of the band are left out, (m/s²)/N.
    pub band_shift: [f32; RESPONSES],
}

/// Stored [`ForceTrend`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredTrend {
    /// Mean squared force, N².
    pub mean: f32,
    /// Sum of the squared deviations of the squared force, N⁴; zero when unknown.
    pub squares: f32,
    /// Sum of the products of both deviations for each response, (m/s²) N.
    pub products: [f32; RESPONSES],
}

impl DofResult {
    /// Converts a measured DOF for storage.
    pub fn of(details: &MeasuredDof<f32>, (index, lines): &DofMassLines<f32, Rig>) -> Self {
        let array = |responses: &Responses<f32, Rig>| core::array::from_fn(|k| responses[k]);
        let mut scatter = Vec::new();
        if !lines.scatter.is_zero() {
            scatter.extend(lower_triangle(&lines.scatter, RESPONSES));
        }
        Self {
            dof: details.dof,
            index: *index as u8,
            hits: lines.hits as u8,
            band_hz: details.band_hz,
            accelerance: array(&lines.accelerance),
            noise: array(&lines.noise),
            scatter,
            coherence: details.coherence,
            trend: StoredTrend {
                mean: lines.trend.mean,
                squares: lines.trend.squares,
                products: array(&lines.trend.products),
            },
            band_shift: array(&lines.band_shift),
        }
    }

    /// Decodes the DOF at the front of these bytes, and returns what follows; `None` when they begin with none.
    pub fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
        postcard::take_from_bytes(bytes).ok()
    }

    /// Converts back to the measured DOF; `None` when the numbers are inconsistent.
    pub fn measured(&self) -> Option<(MeasuredDof<f32>, DofMassLines<f32, Rig>)> {
        let Self { dof, band_hz, coherence, .. } = *self;
        Some((MeasuredDof { dof, band_hz, coherence }, self.mass_lines()?))
    }

    /// Mass lines of the DOF with the index of the hit in the layout; `None` when the numbers are
    /// inconsistent.
    pub fn mass_lines(&self) -> Option<DofMassLines<f32, Rig>> {
        let hits = u16::from(self.hits);
        let mut lines = MassLines::from_parts(&self.accelerance, &self.noise, &self.scatter, hits)?;
        let StoredTrend { mean, squares, products } = self.trend;
        let responses = |stored: [f32; RESPONSES]| Responses::from_fn(RIG_SENSORS, |k| stored[k]);
        lines.trend = ForceTrend { mean, squares, products: responses(products) };
        lines.band_shift = responses(self.band_shift);
        Some((usize::from(self.index), lines))
    }
}

/// Stored estimate of one method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredEstimate {
    /// [`Method::number`].
    pub method: u8,
    /// [m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz]; kg, m, kg m²; inertia about the centre of
    /// mass, body axes, tensor elements.
    pub properties: [f32; 10],
    /// Covariance of the properties, lower triangle row by row; empty when it cannot be determined.
    pub covariance: Vec<f32, COVARIANCE>,
    /// Condition of the balanced regression matrix.
    pub condition: f32,
    /// Whether the data agree with their error budget; only for methods that use one.
    pub consistency: Option<Consistency<f32>>,
    /// What the data have taught about the error budget; only for a method that learns it.
    pub learned: Option<LearnedBudget<f32>>,
    /// Diagnostics of the estimate.
    #[serde(with = "crate::diagnostic")]
    pub diagnostics: Diagnostics,
}

impl From<&Estimate<f32>> for StoredEstimate {
    fn from(estimate: &Estimate<f32>) -> Self {
        let covariance = estimate.covariance.as_ref();
        Self {
            method: estimate.method.number(),
            properties: estimate.theta().into(),
            covariance: covariance.map_or(Vec::new(), |c| lower_triangle(c, 10).collect()),
            condition: estimate.condition,
            consistency: estimate.consistency,
            learned: estimate.learned,
            diagnostics: estimate.diagnostics.clone(),
        }
    }
}

impl StoredEstimate {
    /// Converts to an [`Estimate`]; `None` when this program does not know the method.
    pub fn estimate(&self) -> Option<Estimate<f32>> {
        Some(Estimate {
            method: Method::from_number(self.method)?,
            body: RigidBody::from_theta(&SVector::from(self.properties)),
            covariance: symmetric(&self.covariance),
            condition: self.condition,
            consistency: self.consistency,
            learned: self.learned,
            diagnostics: self.diagnostics.clone(),
        })
    }
}

/// Head of a stored result: its origin and how it was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultHead {
    /// Number of the result on this rig.
    pub number: u32,
    /// Hash of the layout.
    pub layout_hash: u32,
    /// Title of the layout.
    pub title: heapless::String<48>,
    /// Time at which the campaign was started, seconds since 1970-01-01 00:00 UTC; zero when the rig was not told.
    pub started_unix_s: u32,
    /// Checksum of the calibration in use.
    pub calibration: u32,
    /// Standard deviations that this calibration has contributed to the error budget, with its age; `None`
    /// without a calibration of one's own.
    pub gains: Option<CalibrationSigma>,
    /// Version of the firmware that computed the result, `major.minor.patch`.
    pub firmware: heapless::String<16>,
    /// Estimator of the frequency responses.
    pub frf_estimator: FrfEstimator,
    /// Terms of the mass lines.
    pub terms: Terms,
    /// True when the bands were found from the data.
    pub band_automatic: bool,
}

/// A stored result: what one campaign measured and identified. A rig writes and reads it in pieces: the head,
/// the number of DOFs (postcard's `u32`) and each DOF, the same of those with lines and of estimates, the diagnostics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasurementResult {
    /// Origin of the result and how it was measured.
    pub head: ResultHead,
    /// Mass lines of each DOF.
    pub dofs: Vec<DofResult, RIG_HITS>,
    /// Or, in the suspension profile, what is known of each DOF besides its lines, which are objects of their own.
    pub lines: Vec<LinesHead, RIG_HITS>,
    /// Estimates, one per method, best first; empty when there are none, as in the suspension profile, which the
    /// program solves.
    pub estimates: Vec<StoredEstimate, METHODS>,
    /// Diagnostics of the campaign.
    #[serde(with = "crate::diagnostic")]
    pub diagnostics: Diagnostics,
}

impl MeasurementResult {
    /// What was measured; mass lines when every DOF was skipped.
    pub fn profile(&self) -> TestProfile {
        if self.lines.is_empty() { TestProfile::MassLine } else { TestProfile::Suspension }
    }

    /// The DOFs of either profile, each with its index in the layout and the number of its hits.
    pub fn measured(&self) -> impl Iterator<Item = (Dof, u8, u16)> {
        let lines = self.lines.iter().map(|head| (head.dof, head.index, head.hits));
        self.dofs.iter().map(|stored| (stored.dof, stored.index, stored.hits.into())).chain(lines)
    }

    /// The estimates, best first, and the numbers of the methods that this program does not know.
    pub fn estimates(&self) -> (Vec<Estimate<f32>, METHODS>, Vec<u8, METHODS>) {
        let known = self.estimates.iter().filter_map(StoredEstimate::estimate).collect();
        let unknown = self.estimates.iter().map(|stored| stored.method);
        (known, unknown.filter(|&number| Method::from_number(number).is_none()).collect())
    }
}
