//! The sidecar of a tape, in TOML.

use std::path::Path;

use massline_shared::layout::Dof;
use massline_shared::signal::{AdcProperties, CHANNELS};
use massline_shared::units::{Hertz, Seconds, Volts};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Segment, Sidecar};
use crate::calibration_file::CalibrationTable;
use crate::single::number;
use crate::toml_file;
use massline_result::{Error, Result};

/// Error code of this module.
const MALFORMED: &str = "sidecar_malformed";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SidecarTable {
    scan_rate_hz: ScanRate,
    channels: ChannelCount,
    adc_bits: Bits,
    adc_reference_v: Reference,
    channel_delay_s: Delay,
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
    #[serde(serialize_with = "written", deserialize_with = "parsed")]
    dof: Dof,
}

number!(
    /// Scans per second.
    ScanRate,
    |value| value > 0.0,
    "a positive number"
);
number!(
    /// Reference of the converter, V.
    Reference,
    |value| value > 0.0,
    "a positive voltage"
);
number!(
    /// Time from channel to channel of a scan, s.
    Delay,
    |value| value >= 0.0,
    "zero to a tenth of the time of a scan"
);

/// Bits of the converter.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(try_from = "u8")]
struct Bits(u8);

impl TryFrom<u8> for Bits {
    type Error = String;

    fn try_from(bits: u8) -> std::result::Result<Self, String> {
        let is_good = (1..=16).contains(&bits);
        is_good.then_some(Self(bits)).ok_or_else(|| format!("{bits} is not valid; use 1 to 16"))
    }
}

/// Number of channels of a scan.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(try_from = "u8")]
struct ChannelCount(u8);

impl TryFrom<u8> for ChannelCount {
    type Error = String;

    fn try_from(count: u8) -> std::result::Result<Self, String> {
        let wanted = "use 4, 7 or 10: the hammer and three channels a sensor";
        let is_good = matches!(count, 4 | 7 | 10);
        is_good.then_some(Self(count)).ok_or_else(|| format!("{count} is not valid; {wanted}"))
    }
}

fn written<S: Serializer>(dof: &Dof, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_str(dof)
}

fn parsed<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Dof, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map_err(|e| D::Error::custom(format!("\"{text}\": {e}")))
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
        let segment = |s: &Segment| SegmentTable { start: s.start, dof: s.dof };
        let table = SidecarTable {
            scan_rate_hz: ScanRate(self.adc.rate.0),
            channels: ChannelCount(self.adc.channels),
            adc_bits: Bits(self.adc.bits),
            adc_reference_v: Reference(self.adc.reference.0),
            channel_delay_s: Delay(self.adc.channel_delay.0),
            pre_trigger_scans: self.pre_trigger_scans,
            layout_hash: self.layout_hash,
            calibration: CalibrationTable::of(&self.calibration),
            segment: self.segments.iter().map(segment).collect(),
        };
        // Numbers and tables only, so this cannot fail.
        toml::to_string(&table).unwrap_or_default()
    }
}

impl SidecarTable {
    fn resolve(self) -> Result<Sidecar> {
        let (rate, delay) = (self.scan_rate_hz.0, self.channel_delay_s.0);
        if delay * CHANNELS as f32 > 1.0 / rate {
            let text = format!(
                "channel_delay_s = {delay} is not valid at scan_rate_hz = {rate}; use zero to a tenth of the time of a \
                 scan"
            );
            return Err(Error::input(MALFORMED, text));
        }
        let segment = |segment: SegmentTable| Segment { start: segment.start, dof: segment.dof };
        Ok(Sidecar {
            adc: AdcProperties {
                rate: Hertz(rate),
                channels: self.channels.0,
                bits: self.adc_bits.0,
                reference: Volts(self.adc_reference_v.0),
                channel_delay: Seconds(delay),
            },
            calibration: self.calibration.record().calibration,
            pre_trigger_scans: self.pre_trigger_scans,
            layout_hash: self.layout_hash,
            segments: self.segment.into_iter().map(segment).collect(),
        })
    }
}
