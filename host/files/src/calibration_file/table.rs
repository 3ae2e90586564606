//! The tables of a calibration file; what stands in them is checked as it is read.

use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::signal::{Calibration, ChannelCalibration, CrossAxis};
use massline_shared::units::{Hertz, Volts};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::day::Day;
use crate::limited::at_most;
use crate::single::number;

/// Largest number of sensors of a file.
const MOST_SENSORS: usize = 4096;

/// The TOML representation of a calibration, also used in a tape's sidecar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [calibration]")]
pub struct CalibrationTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    method: Option<Method>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    date: Option<Day>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    temperature_c: Option<Temperature>,
    sensor_range_m_per_s2: Option<SensorRange>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "usable_sigma")]
    sigma: Option<CalibrationSigma>,
    hammer: HammerTable,
    #[serde(default, deserialize_with = "at_most::<MOST_SENSORS, _, _>")]
    pub(super) sensor: Vec<SensorTable>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [hammer]")]
struct HammerTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<Id>,
    zero_v: Zero,
    sensitivity_v_per_n: Sensitivity,
    #[serde(default = "nominal_cutoff")]
    rc_cutoff_hz: Cutoff,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[sensor]]")]
pub(super) struct SensorTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<Id>,
    zero_v: [Zero; 3],
    sensitivity_v_per_m_per_s2: [Sensitivity; 3],
    #[serde(default = "nominal_cutoffs")]
    rc_cutoff_hz: [Cutoff; 3],
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "usable_cross_axis"
    )]
    cross_axis: Option<CrossAxis>,
}

number!(
    /// The output at rest, V.
    Zero,
    f64::is_finite,
    "the output at rest in volts"
);
number!(
    /// Volts per unit of what is measured.
    Sensitivity,
    |value| value != 0.0,
    "a number that is not zero"
);
number!(
    /// Cutoff of a low-pass, Hz; 0 without one.
    Cutoff,
    |value| value >= 0.0,
    "the cutoff of the low-pass in Hz, or 0 without one"
);
number!(
    /// Range of the sensors, m/s².
    SensorRange,
    |value| value > f64::from(Calibration::SMALLEST_RANGE),
    "more than 2 g, that is 19.6133"
);
number!(
    /// Temperature of the calibration, °C.
    Temperature,
    f64::is_finite,
    "degrees Celsius, or leave it out"
);

/// The method of a calibration, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
struct Method(CalibrationMethod);

impl TryFrom<String> for Method {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let named = CalibrationMethod::ALL.into_iter().find(|method| method.name() == name);
        let known = || CalibrationMethod::ALL.map(CalibrationMethod::name).join(", ");
        named.map(Self).ok_or_else(|| format!("\"{name}\" is not valid; use one of {}", known()))
    }
}

impl From<Method> for &'static str {
    fn from(method: Method) -> Self {
        method.0.name()
    }
}

/// A name or serial number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
struct Id(heapless::String<12>);

impl TryFrom<String> for Id {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        short(&text).map(Self)
    }
}

impl From<Id> for String {
    fn from(id: Id) -> Self {
        id.0.as_str().to_owned()
    }
}

impl Id {
    /// An id, unless it is empty.
    fn of(text: &heapless::String<12>) -> Option<Self> {
        (!text.is_empty()).then(|| Self(text.clone()))
    }

    fn as_str(&self) -> &str {
        &self.0
    }
}

/// A name or serial number as a calibration stores it.
///
/// # Errors
/// A sentence, when it is too long.
pub fn short(text: &str) -> Result<heapless::String<12>, String> {
    text.try_into().map_err(|_| format!("\"{text}\" is not valid; use at most 12 letters"))
}

fn usable_sigma<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<CalibrationSigma>, D::Error> {
    let sigma = CalibrationSigma::deserialize(deserializer)?;
    let wanted = "a standard deviation here is not valid; use numbers that are not negative";
    sigma.is_usable().then_some(Some(sigma)).ok_or_else(|| D::Error::custom(wanted))
}

fn usable_cross_axis<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<CrossAxis>, D::Error> {
    let cross_axis = CrossAxis::deserialize(deserializer)?;
    let wanted = || {
        format!("a number here is not valid; use numbers between -{0} and {0}", CrossAxis::LARGEST)
    };
    cross_axis.is_usable().then_some(Some(cross_axis)).ok_or_else(|| D::Error::custom(wanted()))
}

fn nominal_cutoff() -> Cutoff {
    Cutoff(Calibration::RC_CUTOFF.0 as f32)
}

fn nominal_cutoffs() -> [Cutoff; 3] {
    [nominal_cutoff(); 3]
}

impl CalibrationTable {
    /// The calibration with its origin.
    pub fn of_record(record: &CalibrationRecord) -> Self {
        let mut table = Self::of(&record.calibration);
        table.method = Some(Method(record.method));
        // A rig may hold a text that is not a date; a file with it could not be read back.
        table.date = record.date.parse().ok();
        table.temperature_c = record.temperature.map(Temperature);
        table.sigma = Some(record.sigma);
        table.hammer.id = Id::of(&record.hammer);
        for (sensor, id) in table.sensor.iter_mut().zip(&record.sensors) {
            sensor.id = Id::of(id);
        }
        table
    }

    /// The calibration without its origin.
    pub fn of(calibration: &Calibration) -> Self {
        let [hammer, sensors @ ..] = &calibration.channels;
        let sensor = sensors
            .chunks_exact(3)
            .zip(&calibration.cross_axis)
            .map(|(axes, cross_axis)| SensorTable {
                id: None,
                zero_v: [0, 1, 2].map(|k| Zero(axes[k].zero.0)),
                sensitivity_v_per_m_per_s2: [0, 1, 2].map(|k| Sensitivity(axes[k].sensitivity)),
                rc_cutoff_hz: [0, 1, 2].map(|k| Cutoff(axes[k].cutoff.0)),
                cross_axis: (*cross_axis != CrossAxis::default()).then_some(*cross_axis),
            })
            .collect();
        Self {
            method: None,
            date: None,
            temperature_c: None,
            sensor_range_m_per_s2: Some(SensorRange(calibration.sensor_range)),
            sigma: None,
            hammer: HammerTable {
                id: None,
                zero_v: Zero(hammer.zero.0),
                sensitivity_v_per_n: Sensitivity(hammer.sensitivity),
                rc_cutoff_hz: Cutoff(hammer.cutoff.0),
            },
            sensor,
        }
    }

    /// The calibration with its origin.
    pub fn record(&self) -> CalibrationRecord {
        let mut record = CalibrationRecord::from(Calibration::default());
        if let Some(range) = self.sensor_range_m_per_s2 {
            record.calibration.sensor_range = range.0;
        }
        if let Some(method) = self.method {
            record.method = method.0;
        }
        if let Some(sigma) = self.sigma {
            record.sigma = sigma;
        }
        if let Some(date) = self.date {
            record.date = date.text();
        }
        record.temperature = self.temperature_c.map(f32::from);
        let hammer = &self.hammer;
        record.hammer = hammer.id.clone().map_or_else(Default::default, |id| id.0);
        record.calibration.channels[0] = ChannelCalibration {
            zero: Volts(hammer.zero_v.0),
            sensitivity: hammer.sensitivity_v_per_n.0,
            cutoff: Hertz(hammer.rc_cutoff_hz.0),
        };
        for (k, sensor) in self.sensor.iter().enumerate() {
            sensor.write(k, &mut record);
        }
        record
    }
}

impl SensorTable {
    /// Its name or serial number.
    pub(super) fn id(&self) -> Option<&str> {
        self.id.as_ref().map(Id::as_str)
    }

    /// Writes this sensor to position `k`; does nothing when the rig has no such position.
    pub(super) fn write(&self, k: usize, record: &mut CalibrationRecord) {
        let (Some(cross_axis), Some(id)) =
            (record.calibration.cross_axis.get_mut(k), record.sensors.get_mut(k))
        else {
            return;
        };
        *cross_axis = self.cross_axis.unwrap_or_default();
        *id = self.id.clone().map_or_else(Default::default, |id| id.0);
        let channels = record.calibration.channels.iter_mut().skip(1 + 3 * k);
        for (axis, channel) in channels.take(3).enumerate() {
            *channel = ChannelCalibration {
                zero: Volts(self.zero_v[axis].0),
                sensitivity: self.sensitivity_v_per_m_per_s2[axis].0,
                cutoff: Hertz(self.rc_cutoff_hz[axis].0),
            };
        }
    }
}
