//! Rigs and ports: what is there, who they are, what they have counted.

use serde::{Deserialize, Serialize};

/// The USB serial ports of this computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceList {
    /// The ports.
    pub ports: Vec<Port>,
}

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Port {
    /// Its path.
    pub path: String,
    /// USB vendor ID; `null` where it is no USB device.
    pub vendor: Option<u16>,
    /// USB product ID; `null` where it is no USB device.
    pub product: Option<u16>,
    /// Manufacturer, product and serial number, as far as the device reports them.
    pub description: String,
}

/// Who a rig is and what it is doing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceIdentity {
    /// The port.
    pub port: String,
    /// Version of the protocol, `major.minor`.
    pub protocol: String,
    /// Version of the firmware.
    pub firmware: String,
    /// Commit that the firmware was built from.
    pub git_hash: String,
    /// Whether the working tree differed from that commit.
    pub git_dirty: bool,
    /// Name of the board.
    pub board: String,
    /// Scans per second.
    pub scan_rate_hz: f64,
    /// Number of channels, with the hammer.
    pub channels: u8,
    /// Resolution of the converter.
    pub adc_bits: u8,
    /// Voltage at the end of the converter's range.
    pub adc_reference_v: f64,
    /// Time from one channel of a scan to the next.
    pub channel_delay_s: f64,
    /// Scans in a record.
    pub record_scans: u16,
    /// Scans in a record before the trigger.
    pub pre_trigger_scans: u16,
    /// Number of triaxial sensors that the rig has inputs for.
    pub max_sensors: u8,
    /// Number of hit DOFs that the rig has memory for.
    pub max_hits: u8,
    /// Whether the link carries the stream of all scans.
    pub streams: bool,
    /// Why the rig started.
    pub boot_reason: String,
    /// Message of the panic that caused the last restart; empty when there was none.
    pub last_panic: String,
    /// What the rig is doing.
    pub phase: String,
    /// Hash of the layout on the rig, eight hexadecimal digits.
    pub layout_hash: Option<String>,
    /// Number of the result of the last campaign, where there is one.
    pub result: Option<u32>,
}

/// Charge of the battery of a rig.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BatteryCharge {
    /// Voltage of the cell.
    pub millivolts: u16,
    /// Charge in percent of a full one.
    pub percent: u8,
}

/// What a rig has counted since power-on, and what of it needs attention.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceStats {
    /// Version of the firmware.
    pub firmware: String,
    /// Why the rig started.
    pub boot_reason: String,
    /// Message of the panic that caused the last restart; empty when there was none.
    pub last_panic: String,
    /// What its clocks are derived from: `crystal`, `internal` or `unknown`.
    pub clock: String,
    /// Supply below which its chip resets itself; `null` when the board has no such level to set.
    pub brown_out_mv: Option<u16>,
    /// Whether its supply is too low to write flash.
    pub supply_is_low: bool,
    /// Charge of its battery, by its gauge; `null` when there is none.
    pub battery: Option<BatteryCharge>,
    /// Time since power-on.
    pub uptime_ms: u64,
    /// Scans taken.
    pub scans: u64,
    /// Triggers.
    pub triggers: u32,
    /// Scans lost because the sampler overran.
    pub scans_lost: u64,
    /// How often the sampler overran.
    pub overruns: u32,
    /// Hits aborted because scans of their record were lost.
    pub hits_aborted: u32,
    /// Longest time that the rig computed without serving scans, link and panel.
    pub longest_step_us: u32,
    /// How often it computed for longer than it may.
    pub deadlines_missed: u32,
    /// Frames received intact.
    pub frames_in: u32,
    /// Frames sent.
    pub frames_out: u32,
    /// Broken frames received and dropped.
    pub frames_broken: u32,
    /// Frames given up because nobody read them.
    pub frames_unsent: u32,
    /// Bytes received and dropped as noise or broken frames.
    pub bytes_dropped: u32,
    /// Requests refused.
    pub requests_refused: u32,
    /// Requests that had been executed before and were only answered again.
    pub requests_repeated: u32,
    /// Events dropped because the link was behind.
    pub events_dropped: u32,
    /// Scans of the stream dropped because the link was behind.
    pub stream_scans_dropped: u32,
    /// How often the link was lost and restored.
    pub reconnects: u32,
    /// Pages of flash erased.
    pub flash_erases: u32,
    /// Bytes of flash written.
    pub flash_bytes_written: u32,
    /// Records written to flash that read back differently.
    pub read_back_failures: u32,
    /// Flash writes that failed verification.
    pub store_failures: u32,
    /// Largest stack use so far, bytes; `null` where the board does not measure it.
    pub stack_high_water: Option<u32>,
    /// Size of the stack, bytes; `null` where the board does not measure its use.
    pub stack_size: Option<u32>,
    /// What of the stack was never used, bytes; `null` where the board does not measure it.
    pub stack_free: Option<u32>,
    /// The counters that need attention.
    pub findings: Vec<CounterFinding>,
}

/// A counter that needs attention.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CounterFinding {
    /// Its key.
    pub counter: String,
    /// What its value means, and what to do.
    pub text: String,
}

/// The end of a campaign on a rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceAbort {
    /// Whether there was a campaign.
    pub aborted: bool,
    /// Number of its accepted hits, which are discarded.
    pub discarded_hits: u32,
}

/// What a rig in safe mode has erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceErase {
    /// Whether its results, layouts and calibration are erased.
    pub erased: bool,
}

/// What is plugged in, what may be opened, and what is missing on this computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Doctor {
    /// What was looked at.
    pub findings: Vec<DoctorFinding>,
}

/// Something that was looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DoctorFinding {
    /// What it is.
    pub subject: String,
    /// `good`; `absent`, which only some commands need; or `bad`.
    pub state: String,
    /// What was found.
    pub found: String,
    /// What to do, where something is to be done.
    pub advice: Option<String>,
}

/// The level at which a rig's chip resets itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceBrownOut {
    /// Supply below which it does, from the next time that it is switched on.
    pub brown_out_mv: u16,
}

/// What a rig reads at rest, and the faults of wiring and parts that this shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviceCheck {
    /// The channels, the hammer first.
    pub channels: Vec<ChannelCheck>,
    /// The faults, those that explain others first; empty when nothing is wrong.
    pub findings: Vec<massline_result::Finding>,
}

/// What a channel reads at rest. Amplitudes are those of a sine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelCheck {
    /// Name of the channel, as in `sensor 2 x`.
    pub channel: String,
    /// Mean.
    pub level_v: f64,
    /// Standard deviation without the tones below.
    pub noise_v: f64,
    /// The same, by the nominal sensitivity of a sensor; `null` for the hammer.
    pub noise_g: Option<f64>,
    /// Amplitude at 50 Hz, or at 100 Hz where it is larger.
    pub hum_50_hz_v: f64,
    /// Amplitude at 60 Hz, or at 120 Hz where it is larger.
    pub hum_60_hz_v: f64,
    /// Amplitude at the refresh rate of the screen.
    pub screen_v: f64,
}
