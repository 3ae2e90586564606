//! The sidecar of a tape, in TOML.

use std::path::Path;

use massline_shared::layout::Dof;
use massline_shared::signal::{AdcProperties, CHANNELS};
use massline_shared::units::{Hertz, Seconds, Volts};
use serde::{Deserialize, Serialize};

use super::{Segment, Sidecar};
use crate::calibration_file::CalibrationTable;
use crate::toml_file;
use massline_result::{Error, Result};

/// Error code of this module.
const MALFORMED: &str = "sidecar_malformed";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SidecarTable {
    scan_rate_hz: f32,
    channels: u8,
    adc_bits: u8,
    adc_reference_v: f32,
    channel_delay_s: f32,
    pre_trigger_scans: u32,
    layout_hash: u32,
    calibration: CalibrationTable,
    #[serde(default)]
    segment: Vec<SegmentTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[segment]]")]
struct SegmentTable {
    start: u64,
    dof: String,
}

impl Sidecar {
    /// Reads a sidecar.
    ///
    /// # Errors
    /// Exit 2 when it cannot be read or is not a sidecar.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&toml_file::read(path, "sidecar_not_readable")?, &path.display().to_string())
    }

    /// Reads the text of a sidecar; `file` is its name in errors.
    ///
    /// # Errors
    /// Exit 2 when it is not a sidecar.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        let table: SidecarTable = toml_file::parse(text, file, MALFORMED)?;
        table.resolve().map_err(|error| error.within(file))
    }

    /// The TOML text of this sidecar.
    pub fn to_toml(&self) -> String {
        let segment = self
            .segments
            .iter()
            .map(|s| SegmentTable { start: s.start, dof: s.dof.to_string() })
            .collect();
        let table = SidecarTable {
            scan_rate_hz: self.adc.rate.0,
            channels: self.adc.channels,
            adc_bits: self.adc.bits,
            adc_reference_v: self.adc.reference.0,
            channel_delay_s: self.adc.channel_delay.0,
            pre_trigger_scans: self.pre_trigger_scans,
            layout_hash: self.layout_hash,
            calibration: CalibrationTable::of(&self.calibration),
            segment,
        };
        // Numbers and tables only, so this cannot fail.
        toml::to_string(&table).unwrap_or_default()
    }
}

impl SidecarTable {
    fn resolve(self) -> Result<Sidecar> {
        let bad = |key: &str, value: &dyn std::fmt::Display, wanted: &str| {
            Error::input(MALFORMED, format!("{key} = {value} is not valid; use {wanted}"))
        };
        let positive = |v: f32| v.is_finite() && v > 0.0;
        if !positive(self.scan_rate_hz) {
            return Err(bad("scan_rate_hz", &self.scan_rate_hz, "a positive number"));
        }
        if !positive(self.adc_reference_v) {
            return Err(bad("adc_reference_v", &self.adc_reference_v, "a positive voltage"));
        }
        if !(1..=16).contains(&self.adc_bits) {
            return Err(bad("adc_bits", &self.adc_bits, "1 to 16"));
        }
        if !matches!(self.channels, 4 | 7 | 10) {
            let wanted = "4, 7 or 10: the hammer and three channels a sensor";
            return Err(bad("channels", &self.channels, wanted));
        }
        let delay = self.channel_delay_s;
        if !(delay.is_finite()
            && delay >= 0.0
            && delay * CHANNELS as f32 <= 1.0 / self.scan_rate_hz)
        {
            return Err(bad("channel_delay_s", &delay, "zero to a tenth of the time of a scan"));
        }
        let calibration = self.calibration.calibration()?;
        let mut segments = Vec::new();
        for segment in self.segment {
            let dof: Dof = segment.dof.parse().map_err(|e| {
                Error::input(MALFORMED, format!("segment.dof = \"{}\": {e}", segment.dof))
            })?;
            segments.push(Segment { start: segment.start, dof });
        }
        Ok(Sidecar {
            adc: AdcProperties {
                rate: Hertz(self.scan_rate_hz),
                channels: self.channels,
                bits: self.adc_bits,
                reference: Volts(self.adc_reference_v),
                channel_delay: Seconds(delay),
            },
            calibration,
            pre_trigger_scans: self.pre_trigger_scans,
            layout_hash: self.layout_hash,
            segments,
        })
    }
}
