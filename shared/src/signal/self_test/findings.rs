//! Faults of wiring and parts, by what the channels read at rest.

use super::{ChannelAtRest, SelfTest};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::real::Real;
use crate::signal::{Calibration, HAMMER};
use crate::units::STANDARD_GRAVITY;

/// Levels of an ADXL326 at rest, V at a supply of 3 V: its zero by the data sheet, and 1 g.
const AT_REST: [f32; 2] = [1.14, 1.86];
/// Below this nothing drives an input, V: 100 kΩ to ground, and a leakage of 1 µA at most.
const SILENT: f32 = 0.11;
/// Above this an input is at the supply, V; an ADXL326 goes up to 2.8 V at 16 g.
const AT_SUPPLY: f32 = 2.85;
/// Below this is no acceleration within the range, V.
const NO_ACCELERATION: f32 = 0.5;
/// Noise that is too much, V: five times that of an ADXL326.
const NOISY: f32 = 0.0024;
/// Tones that are named, V: 5 mg.
const TONE: f32 = 285e-6;
/// Slow motion that is named, V: 20 mg.
const MOTION: f32 = 0.00114;
/// Level of the hammer's input with nothing plugged in, V: 82 kΩ to ground and 1 MΩ to a supply of 3.0 to 3.4 V, which
/// makes 0.227 to 0.258 V, and 2 % of each resistor.
const HAMMER_OPEN: [f32; 2] = [0.218, 0.268];
/// Below this the hammer's input is shorted, V; a conditioner at 0 V gives 0.11 V.
const HAMMER_SHORTED: f32 = 0.03;
/// Level of PA4 to which the pull-up of a flash chip, 4.7 to 20 kΩ, brings it against 100 kΩ to ground, V.
const FLASH_SELECT: [f32; 2] = [2.3, 2.95];
/// Level of x when the cable is the wrong way round and feeds the sensor through it, V: the supply less a diode.
const FED: [f32; 2] = [2.0, 2.85];
/// How far above half of that the mean of y and z may be then, V: their zeros.
const FED_ZERO: f32 = 0.1;
/// Channels with the same finding that may have one cause: a bridge, or what is wrong with one sensor, concerns fewer.
const MANY: usize = 4;
/// How far from 1 g a calibrated sensor may read.
const GRAVITY_ERROR: f32 = 0.08;
/// Sensitivity of an ADXL326, V/g.
const VOLT_PER_G: f32 = Calibration::ADXL326_VOLT_PER_G as f32;
/// 1 g, m/s².
const GRAVITY: f32 = STANDARD_GRAVITY as f32;
/// A cutoff below this, Hz, does not come from the rig's own filter: the tolerance of the 32 kΩ leaves 432 Hz.
pub const LEAST_CUTOFF_HZ: f32 = 300.0;

/// What is special about the inputs of a board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Circuit {
    /// The channel on which some of these boards have the select pin of a flash chip.
    pub flash_select: Option<u8>,
}

/// Sensors whose sensitivity and zero are known absolutely, from a tumble test.
#[derive(Clone, Copy, Debug)]
pub struct KnownSensors<'a>(pub &'a Calibration);

impl<R: Real> SelfTest<R> {
    /// The faults, those that explain others first. A channel that has been named is not named again. `known` is `None`
    /// without a tumble test.
    pub fn findings(&self, circuit: Circuit, known: Option<KnownSensors<'_>>) -> Diagnostics {
        let mut faults = FaultList { diagnostics: Diagnostics::new(), judged: 0 };
        self.hammer(&mut faults);
        for sensor in 0..self.count().saturating_sub(1) / 3 {
            self.sensor(sensor, circuit, known, &mut faults);
        }
        let mains = faults.judged;
        // The hammer's input does not depend on the supply as the sensors do.
        let sensors = mains.saturating_sub(1);
        faults.join(Code::PickUp50Hz, mains, Code::MainsInAllChannels);
        faults.join(Code::PickUp60Hz, mains, Code::MainsInAllChannels);
        faults.join(Code::ScreenRipple, sensors, Code::ScreenInAllSensors);
        faults.join(Code::ChannelsAlike, 0, Code::SupplyUnsteady);
        faults.leave_out_what_an_unsteady_supply_does();
        faults.diagnostics
    }

    fn hammer(&self, faults: &mut FaultList) {
        let Some(hammer) = self.channels().get(HAMMER) else { return };
        let level = hammer.level.to_f32();
        let code = match level {
            _ if level < HAMMER_SHORTED => Code::HammerAtGround,
            _ if level > AT_SUPPLY => Code::HammerAtSupply,
            _ if (HAMMER_OPEN[0]..=HAMMER_OPEN[1]).contains(&level) => Code::HammerAbsent,
            _ => return tones_and_noise(HAMMER, hammer, faults),
        };
        faults.add(code, Subject::Whole, level);
    }

    fn sensor(
        &self,
        sensor: usize,
        circuit: Circuit,
        known: Option<KnownSensors<'_>>,
        faults: &mut FaultList,
    ) {
        let first = 1 + 3 * sensor;
        let Some(axes) = self.channels().get(first..first + 3) else { return };
        let levels = [0, 1, 2].map(|axis| axes[axis].level.to_f32());
        let [least, most] = [
            levels.iter().fold(f32::MAX, |a, b| a.min(*b)),
            levels.iter().fold(0.0, |a: f32, b| a.max(*b)),
        ];
        let whole = match () {
            () if most < SILENT => Some((Code::SensorSilent, most)),
            () if least > AT_SUPPLY => Some((Code::SensorGroundOpen, least)),
            () if most < NO_ACCELERATION => Some((Code::SensorReversed, most)),
            () if is_fed_through_x(levels) => Some((Code::CableReversed, levels[0])),
            () => None,
        };
        if let Some((code, level)) = whole {
            return faults.add(code, Subject::sensor(sensor), level);
        }
        let mut all_rest = true;
        for (axis, at_rest) in axes.iter().enumerate() {
            let channel = first + axis;
            all_rest &= axis_is_at_rest(channel, at_rest, circuit, faults);
        }
        if axes.iter().any(ChannelAtRest::moves) && !axes.iter().any(ChannelAtRest::hums) {
            let moved = axes.iter().map(|axis| axis.slow_range.to_f32()).fold(0.0, f32::max);
            let acceleration = moved / VOLT_PER_G * GRAVITY;
            faults.add(Code::NotAtRest, Subject::sensor(sensor), acceleration);
        } else if let Some(KnownSensors(calibration)) = known
            && all_rest
        {
            one_gravity(sensor, levels, calibration, faults);
        }
    }
}

/// The channels whose cutoff, by a block test, is that of a breakout's own capacitor.
pub fn left_capacitors(calibration: &Calibration) -> impl Iterator<Item = Diagnostic> {
    calibration.channels.iter().enumerate().skip(1).filter_map(|(channel, channel_calibration)| {
        let cutoff = channel_calibration.cutoff.0;
        let is_low = cutoff > 0.0 && cutoff < LEAST_CUTOFF_HZ;
        let subject = Subject::channel(channel);
        is_low.then(|| Diagnostic::about(Code::CapacitorLeft, Severity::Error, subject, cutoff))
    })
}

/// True when x is at a supply of which y and z have half: contact 5 of a cable that is the wrong way round feeds the
/// output of x.
fn is_fed_through_x([x, y, z]: [f32; 3]) -> bool {
    (FED[0]..FED[1]).contains(&x)
        && (y + z) / 2.0 < x / 2.0 + FED_ZERO
        && y.min(z) > NO_ACCELERATION
}

/// True when an axis has the level of a sensor at rest; else it is named. Its tones and noise are named in any case.
fn axis_is_at_rest<R: Real>(
    channel: usize,
    at_rest: &ChannelAtRest<R>,
    circuit: Circuit,
    faults: &mut FaultList,
) -> bool {
    let level = at_rest.level.to_f32();
    let code = match level {
        _ if (AT_REST[0]..=AT_REST[1]).contains(&level) => {
            tones_and_noise(channel, at_rest, faults);
            return true;
        }
        _ if level < SILENT => Code::AxisSilent,
        _ if circuit.flash_select.is_some_and(|select| usize::from(select) == channel)
            && (FLASH_SELECT[0]..FLASH_SELECT[1]).contains(&level) =>
        {
            faults.add(Code::FlashOnInputs, Subject::Whole, level);
            return false;
        }
        _ if level > AT_SUPPLY => Code::AxisAtSupply,
        _ => Code::RestLevelOutOfRange,
    };
    faults.add(code, Subject::channel(channel), level);
    false
}

/// Names the worst of a channel's tones and noise.
fn tones_and_noise<R: Real>(channel: usize, at_rest: &ChannelAtRest<R>, faults: &mut FaultList) {
    let [mains_50, mains_60, screen] =
        [at_rest.hum_50_hz, at_rest.hum_60_hz, at_rest.screen].map(|tone| tone.to_f32());
    let noise = at_rest.noise.to_f32();
    faults.judged += 1;
    let (code, value) = match () {
        () if at_rest.is_stuck && channel != HAMMER => (Code::ChannelStuck, 0.0),
        () if at_rest.hums() => match at_rest.largest_tone() {
            largest if largest == mains_50 => (Code::PickUp50Hz, mains_50),
            largest if largest == mains_60 => (Code::PickUp60Hz, mains_60),
            _ => (Code::ScreenRipple, screen),
        },
        () if at_rest.moves() => return,
        () if at_rest.is_alike && channel != HAMMER => (Code::ChannelsAlike, 0.0),
        () if noise > NOISY => (Code::ChannelNoisy, noise),
        () => return,
    };
    faults.add(code, Subject::channel(channel), value);
}

/// Names a calibrated sensor that does not read 1 g.
fn one_gravity(sensor: usize, levels: [f32; 3], calibration: &Calibration, faults: &mut FaultList) {
    let squares =
        levels.iter().zip(&calibration.channels[1 + 3 * sensor..]).map(|(level, channel)| {
            let g = (level - channel.zero.0) / channel.sensitivity / GRAVITY;
            g * g
        });
    let read = libm::sqrtf(squares.sum());
    if (read - 1.0).abs() > GRAVITY_ERROR {
        faults.add(Code::NotOneGravity, Subject::sensor(sensor), read);
    }
}

impl<R: Real> ChannelAtRest<R> {
    /// True when a tone stands out of the noise. A tone of noise alone is a 26th of it, rms.
    fn hums(&self) -> bool {
        self.largest_tone() > TONE && self.largest_tone() > self.noise.to_f32() / 4.0
    }

    /// True when the channel shows a slow motion. Of white noise the means of blocks have a third of its standard
    /// deviation as their range, of a swing of a few hertz nearly three times.
    fn moves(&self) -> bool {
        self.slow_range.to_f32() > MOTION && self.slow_range > self.noise
    }

    fn largest_tone(&self) -> f32 {
        self.hum_50_hz.max(self.hum_60_hz).max(self.screen).to_f32()
    }
}

/// Faults so far.
struct FaultList {
    diagnostics: Diagnostics,
    /// Number of channels whose tones and noise were judged.
    judged: usize,
}

impl FaultList {
    fn add(&mut self, code: Code, subject: Subject, value: f32) {
        // A list that is full names enough.
        let _ = self.diagnostics.push(Diagnostic::about(code, Severity::Error, subject, value));
    }

    /// Joins findings of one code when there are this many, and [`MANY`]: they have one cause then, which explains
    /// others.
    fn join(&mut self, code: Code, least: usize, whole: Code) {
        let of_code = self.diagnostics.iter().filter(|diagnostic| diagnostic.code == code);
        if of_code.clone().count() < least.max(MANY) {
            return;
        }
        let largest = of_code.map(|diagnostic| diagnostic.value).fold(0.0, f32::max);
        self.diagnostics.retain(|diagnostic| diagnostic.code != code);
        // There is room again.
        let _ = self.diagnostics.insert(0, Diagnostic::whole(whole, Severity::Error, largest));
    }

    /// With an unsteady supply noise and tones of single channels say nothing.
    fn leave_out_what_an_unsteady_supply_does(&mut self) {
        use Code::{ChannelNoisy, PickUp50Hz, PickUp60Hz, ScreenRipple, SupplyUnsteady};
        if self.diagnostics.iter().any(|diagnostic| diagnostic.code == SupplyUnsteady) {
            let of_channels = [ChannelNoisy, PickUp50Hz, PickUp60Hz, ScreenRipple];
            self.diagnostics.retain(|diagnostic| !of_channels.contains(&diagnostic.code));
        }
    }
}
