//! The result of a block test: what it determines about the hammer and the sensors.

use massline_protocol::object::MeasurementResult;
use massline_shared::calibration::block::{
    BlockError, BlockHit, BlockMass, ForceRatio, SensorRatio, force_ratio, sensor_ratios,
};
use massline_shared::calibration::opposite_hits::{Setup, opposite_hits};
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::capacity::Rig;
use massline_shared::diagnosis::{Diagnostic, Severity};
use massline_shared::identify::MassLines;
use massline_shared::layout::RigLayout;
use massline_shared::signal::HAMMER;
use nalgebra::Vector3;

use super::cutoffs::{self, RcCutoff};
use super::electronics::{ConversionOrder, Electronics};
use massline_result::{Error, Result};

/// The hits of a block test.
pub type Hits = Vec<BlockHit<f64, Rig>>;

/// The result of a block test, relative to the calibration in force during it.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Gain and cross-axis ratios of each sensor against the hammer.
    pub sensors: Vec<SensorRatio<f64>>,
    /// The hammer against the sensors; only when a tumble test has calibrated the sensors.
    pub hammer: Option<ForceRatio<f64>>,
    /// The low-pass of each sensor axis against the hammer's.
    pub cutoffs: Vec<RcCutoff>,
    /// What hits from both sides show of multiplexer and converter.
    pub electronics: Electronics,
    /// Warnings of the rig about the hits: mains hum, which it has taken out, and others.
    pub warnings: Vec<Diagnostic>,
}

/// What is known when a block is hit.
#[derive(Clone, Copy, Debug)]
pub struct Conditions<'a> {
    /// The layout in use.
    pub layout: &'a RigLayout,
    /// The calibration in force.
    pub record: &'a CalibrationRecord,
    /// The block.
    pub mass: BlockMass<f64>,
    /// What the rig converts when.
    pub order: &'a ConversionOrder,
}

fn undetermined(error: BlockError) -> Error {
    Error::undetermined("block_test", error.to_string())
}

/// The hits of a result, with the directions of the layout in use during the test.
///
/// # Errors
/// Exit 3 when a DOF is not in the layout or has no mass lines.
pub fn hits_of(result: &MeasurementResult, layout: &RigLayout) -> Result<Hits> {
    let mut hits = Hits::new();
    for dof in &result.dofs {
        let of_layout = layout.hits.get(usize::from(dof.index));
        let hit = of_layout.filter(|hit| hit.dof == dof.dof).ok_or_else(|| {
            Error::undetermined(
                "another_layout",
                format!("DOF {} of the result is not one of the layout", dof.dof),
            )
        })?;
        let accelerance = dof.accelerance.map(f64::from);
        let scatter: Vec<f64> = dof.scatter.iter().map(|&v| f64::from(v)).collect();
        let count = if scatter.is_empty() { 1 } else { u16::from(dof.hits) };
        let noise = dof.noise.map(f64::from);
        let lines =
            MassLines::from_parts(&accelerance, &noise, &scatter, count).ok_or_else(|| {
                Error::undetermined("no_mass_lines", format!("DOF {} has no mass lines", dof.dof))
            })?;
        hits.push(BlockHit { direction: Vector3::from(hit.direction.map(f64::from)), lines });
    }
    Ok(hits)
}

impl Block {
    /// Evaluates the hits of a result and the `cutoffs` found from their spectra.
    ///
    /// # Errors
    /// Exit 3 when the hits do not determine a calibration.
    pub fn of(
        result: &MeasurementResult,
        Conditions { layout, record, mass: block, order }: Conditions<'_>,
        cutoffs: Vec<RcCutoff>,
    ) -> Result<Self> {
        let hits = &hits_of(result, layout)?;
        let count = layout.sensors.len();
        let sensors = layout.sensors.iter().enumerate().map(|(k, sensor)| {
            let axes = sensor.axes.map(|axis| axis.map(f64::from));
            sensor_ratios(hits, k, &axes, block).map_err(undetermined)
        });
        let sensors = sensors.collect::<Result<Vec<_>>>()?;
        let lines = hits.iter().map(|hit| &hit.lines);
        let known = record.method.knows_sensors();
        let hammer =
            known.then(|| force_ratio(lines, count, block)).transpose().map_err(undetermined)?;
        let exact = layout.cast::<f64, Rig>();
        let setup = exact.as_ref().map(|exact| Setup {
            sensors: &exact.sensors,
            mass: block.mass,
            calibration: &record.calibration,
            after_hammer: order.after(HAMMER),
        });
        let opposite = setup.and_then(|setup| opposite_hits(hits, &setup));
        let grave = result.diagnostics.iter().filter(|d| d.severity > Severity::Note);
        Ok(Self {
            sensors,
            hammer,
            cutoffs,
            electronics: Electronics::of(opposite.as_ref(), order),
            warnings: grave.copied().collect(),
        })
    }

    /// Updates the calibration that was in force. If the sensors have been calibrated already they stay, and
    /// the hammer is updated; otherwise the sensors are updated against the hammer, which stays.
    pub fn write(&self, record: &mut CalibrationRecord) {
        cutoffs::write(&self.cutoffs, &mut record.calibration);
        if let Some(hammer) = &self.hammer {
            record.take_block(hammer);
            return;
        }
        let calibration = &mut record.calibration;
        for (k, sensor) in self.sensors.iter().enumerate() {
            let sensitivity = calibration.sensor_sensitivity(k) * sensor.ratio;
            calibration.set_sensor_sensitivity(k, &sensitivity);
        }
        record.method = CalibrationMethod::Block;
        record.sigma = self.sensor_sigma();
    }

    /// The uncertainty of the sensors as calibrated against the hammer.
    fn sensor_sigma(&self) -> CalibrationSigma {
        let (mut gain, mut cross_axis) = (0.0_f64, 0.0_f64);
        for SensorRatio { ratio, sigma } in &self.sensors {
            for row in 0..3 {
                for column in 0..3 {
                    let relative = (sigma[(row, column)] / ratio[(row, row)]).abs();
                    let largest = if row == column { &mut gain } else { &mut cross_axis };
                    *largest = largest.max(relative);
                }
            }
        }
        CalibrationSigma { gain: gain as f32, cross_axis: cross_axis as f32, hammer_gain: 0.0 }
    }
}
