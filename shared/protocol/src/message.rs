//! Requests of the host and answers of the rig.

use heapless::{String, Vec};
use num_enum::{IntoPrimitive, TryFromPrimitive};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use massline_shared::EstimatedValue;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::{RIG_HITS, RigLayout};
use massline_shared::measurement::StartError;
use massline_shared::measurement::campaign::{Command, CommandError, Start};
use massline_shared::signal::{AdcProperties, CHANNELS, RestStatistics};

/// Connects a request with its kind and its answer. The kind of the answer is that of the request with
/// [`ANSWER`] set.
pub trait Endpoint {
    /// Kind of the request.
    const KIND: u16;
    /// True when the request changes the rig. Such a request is executed at most once, however often it
    /// arrives.
    const CHANGES: bool = false;
    /// Type of the request.
    type Request: Serialize + DeserializeOwned;
    /// Type of the answer.
    type Response: Serialize + DeserializeOwned;
}

/// Set in the kind of every answer.
pub const ANSWER: u16 = 0x8000;
/// Kind of the answer to a refused request; its body is a [`Refusal`].
pub const REFUSED: u16 = 0xFFFF;

macro_rules! endpoints {
    ($($(#[$doc:meta])* $name:ident = $kind:literal $(, $changes:ident)?: $request:ty => $response:ty;)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug)]
            pub struct $name;
            impl Endpoint for $name {
                const KIND: u16 = $kind;
                $(const CHANGES: bool = { let $changes = true; $changes };)?
                type Request = $request;
                type Response = $response;
            }
        )*
        /// Kind and name of every endpoint, and whether it changes the rig.
        pub const ENDPOINTS: &[(u16, &str, bool)] =
            &[$(($kind, stringify!($name), <$name as Endpoint>::CHANGES)),*];

        /// True when a request of this kind changes the rig.
        pub fn changes(kind: u16) -> bool {
            match kind {
                $($kind => <$name as Endpoint>::CHANGES,)*
                _ => false,
            }
        }
    };
}

endpoints! {
    /// Asks who the rig is. Frozen for ever.
    GetIdentity = 1: () => Identity;
    /// Asks what the rig is doing.
    GetStatus = 2: () => Status;
    /// Asks for the counters since power-on.
    GetStats = 3: () => Stats;
    /// Stores a layout.
    PutLayout = 4, changes: RigLayout => LayoutAnswer;
    /// Asks for the layout in use.
    GetLayout = 5: () => RigLayout;
    /// Stores a calibration.
    PutCalibration = 6, changes: CalibrationRecord => ();
    /// Asks for the stored calibration.
    GetCalibration = 7: () => CalibrationRecord;
    /// Starts a campaign.
    StartCampaign = 8, changes: StartRequest => Status;
    /// Passes a command of the operator to the campaign in progress.
    SteerCampaign = 22, changes: Command => Status;
    /// Asks for length and checksum of an object.
    GetObjectInfo = 9: crate::object::ObjectId => crate::object::ObjectInfo;
    /// Asks for a piece of an object.
    ReadObject = 10: crate::object::ChunkRequest => crate::object::Chunk;
    /// Asks for the list of stored results.
    ListResults = 11: ListRequest => ResultPage;
    /// Deletes a result.
    DeleteResult = 12, changes: u32 => ();
    /// Starts or stops the stream of scans.
    SetStream = 13, changes: bool => ();
    /// Records the channels without a hit; the record starts again when scans are lost.
    TakeReading = 14, changes: () => ();
    /// Asks for the statistics of that record. Refused with [`Reason::Busy`] while the record is being taken,
    /// with [`Reason::SamplerStopped`] when sampling failed, and with [`Reason::NotFound`] when there is no
    /// record or something else has been recorded since.
    GetRestStatistics = 15: () => RestStatistics;
    /// Asks for the mass lines of a DOF of the current campaign or of the last one, by its index in the layout.
    /// Refused with [`Reason::NotFound`] before the DOF is closed.
    GetMassLines = 16: u8 => crate::object::DofResult;
    /// Asks for the level of every channel while the rig waits for a hit, the hammer first.
    GetLevels = 17: () => Levels;
    /// Erases all that a rig in safe mode stores; [`Reason::UnknownMessage`] in any other mode.
    EraseStore = 18, changes: () => ();
    /// Asks for the state of clock, supply and converter.
    GetHardware = 19: () => Hardware;
    /// Sets [`Hardware::brown_out_mv`] to the chip's highest level that is below its supply. It is in force after the
    /// next power-on at the latest. Refused with [`Reason::SupplyLow`] while the supply is too low to write flash, and
    /// with [`Reason::UnknownMessage`] by a board whose chip has no such level.
    SetBrownOut = 20, changes: () => ();
    /// Asks for the charge of the battery; `None` when there is no gauge, or none that answers.
    GetBattery = 21: () => Option<Battery>;
}

/// Largest framed answer to a request that changes the rig, bytes.
pub const MAX_CHANGE_ANSWER: usize = 272;

/// Identity of the rig. Frozen: never edited in any version.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// [`super::PROTOCOL_MAJOR`] of the rig.
    pub protocol_major: u8,
    /// [`super::PROTOCOL_MINOR`] of the rig.
    pub protocol_minor: u8,
    /// Version of the firmware, `major.minor.patch`.
    pub firmware: String<16>,
    /// Commit that the firmware was built from.
    pub git_hash: String<16>,
    /// True when the working tree differed from that commit.
    pub git_dirty: bool,
    /// Name of the board, the folder under `boards/`.
    pub board: String<24>,
    /// Properties of the converter.
    pub adc: AdcProperties,
    /// Scans in a record.
    pub record_scans: u16,
    /// Scans in a record before the trigger.
    pub pre_trigger_scans: u16,
    /// Number of triaxial sensors that the rig has inputs for.
    pub max_sensors: u8,
    /// Number of hit DOFs that the rig has memory for.
    pub max_hits: u8,
    /// True when the link carries the stream of all scans.
    pub streams: bool,
    /// Why the rig started: raw [`BootReason`](crate::BootReason).
    pub boot_reason: u8,
    /// Message of the panic that caused the last restart; empty when there was none.
    pub last_panic: String<96>,
}

/// State of the rig.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Raw [`Phase`](massline_shared::measurement::campaign::Phase).
    pub phase: u8,
    /// Index of the current DOF.
    pub dof: u8,
    /// Number of times the trigger was armed since power-on: a new number means that the next hit is wanted.
    pub armings: u32,
    /// Accepted hits of each DOF of the layout.
    pub accepted: Vec<u8, RIG_HITS>,
    /// Accepted hits wanted at each DOF.
    pub hits_per_dof: u8,
    /// Hits rejected in this campaign.
    pub rejected: u16,
    /// Number of the last hit, as in [`crate::event::HitEvent::number`].
    pub last_hit: u32,
    /// Hash of the stored layout, 0 when there is none.
    pub layout_hash: u32,
    /// Number of the last campaign's result, 0 when there is none.
    pub result: u32,
    /// Time at which the campaign was started, as in [`crate::object::ResultHead::started_unix_s`].
    pub started_unix_s: u32,
    /// Diagnostics of the campaign.
    #[serde(with = "crate::diagnostic")]
    pub diagnostics: Diagnostics,
}

/// Level of every channel over the last tenth of a second: the number of bits of the range of its codes, 0 when the
/// code did not change.
pub type Levels = [u8; CHANNELS];

/// Counters of the rig since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stats {
    /// Time since power-on, ms.
    pub uptime_ms: u64,
    /// Scans taken.
    pub scans: u64,
    /// Scans lost because the sampler overran.
    pub scans_lost: u64,
    /// Number of times the rig computed for longer than [`STEP_LIMIT_MS`] without serving scans, link and
    /// panel.
    pub deadlines_missed: u32,
    /// Triggers.
    pub triggers: u32,
    /// Frames received intact.
    pub frames_in: u32,
    /// Broken frames received and dropped.
    pub frames_broken: u32,
    /// Requests refused.
    pub requests_refused: u32,
    /// Repeated requests: they had been executed before and were only answered again.
    pub requests_repeated: u32,
    /// Frames sent.
    pub frames_out: u32,
    /// Frames given up because the host did not read.
    pub frames_unsent: u32,
    /// Events dropped because the link was behind.
    pub events_dropped: u32,
    /// Flash writes that failed verification.
    pub store_failures: u32,
    /// Largest stack use so far, bytes; 0 when the board does not measure it.
    pub stack_high_water: u32,
    /// Number of times the sampler overran; [`Self::scans_lost`] counts the scans.
    pub overruns: u32,
    /// Hits aborted because scans of their record were lost.
    pub hits_aborted: u32,
    /// Longest time that the rig computed without serving scans, link and panel, µs. A time above
    /// [`STEP_LIMIT_MS`] counts in [`Self::deadlines_missed`].
    pub longest_step_us: u32,
    /// Scans of the stream that were dropped because the link was behind.
    pub stream_scans_dropped: u32,
    /// Bytes received and dropped as noise or broken frames.
    pub bytes_dropped: u32,
    /// Number of times the link was lost and restored.
    pub reconnects: u32,
    /// Pages of flash erased.
    pub flash_erases: u32,
    /// Bytes of flash written.
    pub flash_bytes_written: u32,
    /// Records written to flash that read back differently.
    pub read_back_failures: u32,
    /// Size of the stack, bytes; 0 when the board does not report it.
    pub stack_size: u32,
}

/// State of clock, supply and converter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hardware {
    /// What the clocks are derived from: raw [`Clock`](crate::Clock).
    pub clock: u8,
    /// Supply voltage below which the chip holds itself in reset, mV; `None` when the chip has no such level to set.
    pub brown_out_mv: Option<u16>,
    /// True while the supply is too low to write flash.
    pub supply_is_low: bool,
    /// What is wrong with an external converter: raw [`ConverterFault`](crate::ConverterFault).
    pub converter: u8,
    /// With [`ConverterFault::WrongTag`](crate::ConverterFault::WrongTag) the channel in the first wrong frame.
    pub wrong_tag: u8,
}

/// Charge of the battery, by its gauge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Battery {
    /// Voltage of the cell, mV.
    pub millivolts: u16,
    /// Charge in percent of a full one.
    pub percent: u8,
}

impl Battery {
    /// Below this voltage of the cell, mV, little charge is left, and a linear regulator passes on the ripple of the
    /// cell.
    pub const LOW_MV: u16 = 3500;

    /// True when it should be charged.
    pub fn is_low(&self) -> bool {
        self.millivolts < Self::LOW_MV
    }
}

/// Longest time that a rig may compute without serving scans, link and panel, ms: every board buffers the
/// scans of this time.
pub const STEP_LIMIT_MS: u64 = 40;

/// Answer to [`PutLayout`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayoutAnswer {
    /// Hash of the layout as stored.
    pub hash: u32,
    /// Findings about the layout. When one is an error, the layout is stored, but a campaign needs
    /// [`StartRequest::force`].
    #[serde(with = "crate::diagnostic")]
    pub diagnostics: Diagnostics,
}

/// Request that starts a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartRequest {
    /// The options of the campaign. A block's mass that is not a positive number is refused with [`Reason::Malformed`].
    pub start: Start,
    /// Start even if the layout has an error.
    pub force: bool,
}

/// Asks for the results after a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListRequest {
    /// Only results with a larger number are listed.
    pub after: u32,
}

/// A mass in kg; it has no standard deviation when it comes from single hits.
pub type EstimatedMass = EstimatedValue<f32, Option<f32>>;

/// One entry of the list of results.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultEntry {
    /// Number of the result.
    pub number: u32,
    /// Hash of the layout that it was measured with.
    pub layout_hash: u32,
    /// Mass from the best estimate, kg; `None` when the result has no estimate.
    pub mass: Option<EstimatedMass>,
    /// Length of the result, bytes.
    pub length: u32,
}

/// Part of the list of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultPage {
    /// Results in order of their numbers.
    pub entries: Vec<ResultEntry, 16>,
    /// True when more results follow.
    pub more: bool,
}

/// Why a request was not executed, raw in [`Refusal::reason`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u16)]
pub enum Reason {
    /// The rig does not know this kind of message.
    UnknownMessage = 1,
    /// The body cannot be decoded as this message.
    Malformed = 2,
    /// There is no such object or result.
    NotFound = 3,
    /// The request is not possible in this phase of the campaign.
    WrongPhase = 4,
    /// No layout is stored.
    NoLayout = 5,
    /// The layout cannot determine the ten properties.
    LayoutRefused = 6,
    /// The store is full.
    StoreFull = 7,
    /// The flash did not read back what was written.
    StoreFailed = 8,
    /// The requested part lies outside the object.
    OutOfRange = 9,
    /// The object is being written; ask again.
    Busy = 10,
    /// The converter does not respond.
    SamplerStopped = 11,
    /// No hit has been accepted since power-on, the start of the campaign, the last undo, or a DOF that was skipped
    /// or is measured again.
    NothingToUndo = 12,
    /// A later hit has overwritten the record of the last accepted one, so it cannot be undone.
    HitOverwritten = 13,
    /// A block of known mass is weighed by mass lines, and the layout has the suspension profile.
    BlockNeedsMassLines = 14,
    /// The rig is in safe mode, where it answers [`GetIdentity`] and [`EraseStore`] only.
    SafeMode = 15,
    /// The supply is too low to write flash.
    SupplyLow = 16,
}

impl From<StartError> for Reason {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Busy => Self::Busy,
            StartError::NoLayout => Self::NoLayout,
            StartError::LayoutRefused => Self::LayoutRefused,
            StartError::BlockNeedsMassLines => Self::BlockNeedsMassLines,
            StartError::NoRoom => Self::StoreFull,
            StartError::WrongPhase => Self::WrongPhase,
        }
    }
}

impl From<CommandError> for Reason {
    fn from(error: CommandError) -> Self {
        match error {
            CommandError::WrongPhase => Self::WrongPhase,
            CommandError::NoDofs => Self::NoLayout,
            CommandError::NothingToUndo => Self::NothingToUndo,
            CommandError::HitOverwritten => Self::HitOverwritten,
        }
    }
}

/// Answer to a request that was not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// Raw [`Reason`].
    pub reason: u16,
    /// With [`Reason::StoreFull`] for a start: how many results must be deleted, the oldest first; zero when even
    /// without results there is too little room, and for any other request.
    pub results_to_delete: u8,
}

impl From<Reason> for Refusal {
    fn from(reason: Reason) -> Self {
        Self { reason: reason.into(), results_to_delete: 0 }
    }
}
