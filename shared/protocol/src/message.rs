//! Requests of the host and answers of the rig.

use heapless::{String, Vec};
use num_enum::{IntoPrimitive, TryFromPrimitive};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use massline_shared::Estimated;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::{RIG_HITS, RigLayout};
use massline_shared::measurement::StartError;
use massline_shared::measurement::campaign::{Command as Steering, CommandError};
use massline_shared::signal::{AdcProperties, RestStatistics};

/// Binds a request, its kind and its answer. The answer's kind is the request's with
/// [`ANSWER`] set.
pub trait Endpoint {
    /// Kind of the request.
    const KIND: u16;
    /// True when the request changes the rig: it is then executed at most once however often it
    /// arrives.
    const CHANGES: bool = false;
    /// What the host sends.
    type Request: Serialize + DeserializeOwned;
    /// What the rig answers.
    type Response: Serialize + DeserializeOwned;
}

/// Set in the kind of every answer.
pub const ANSWER: u16 = 0x8000;
/// Kind of the answer to a request that is refused; its body is a [`Refusal`].
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
    };
}

endpoints! {
    /// Who is there? Frozen for ever.
    GetIdentity = 1: () => Identity;
    /// What is the rig doing?
    GetStatus = 2: () => Status;
    /// What has been counted since power-on?
    GetStats = 3: () => Stats;
    /// Take this layout and keep it.
    PutLayout = 4, changes: RigLayout => LayoutAnswer;
    /// Which layout is kept?
    GetLayout = 5: () => RigLayout;
    /// Take this calibration and keep it.
    PutCalibration = 6, changes: CalibrationRecord => ();
    /// Which calibration is kept?
    GetCalibration = 7: () => CalibrationRecord;
    /// Steer the campaign.
    Command = 8, changes: CommandRequest => Status;
    /// How long is an object, and what is its checksum?
    GetObjectInfo = 9: crate::object::ObjectId => crate::object::ObjectInfo;
    /// A piece of an object.
    ReadObject = 10: crate::object::ChunkRequest => crate::object::Chunk;
    /// Which results are kept?
    ListResults = 11: ListRequest => ResultPage;
    /// Delete a result.
    DeleteResult = 12, changes: u32 => ();
    /// Start or stop the stream of scans.
    SetStream = 13, changes: bool => ();
    /// Take a record of what the channels read now, without a hit; begun anew when scans are lost.
    TakeReading = 14, changes: () => ();
    /// What did they read? Refused with [`Reason::Busy`] while the record is taken, with
    /// [`Reason::SamplerStopped`] when it could not be, and with [`Reason::NotFound`] when there is
    /// none or something else has been recorded since.
    GetRestStatistics = 15: () => RestStatistics;
}

/// The most bytes of the framed answer to a request that changes the rig.
pub const MAX_CHANGE_ANSWER: usize = 272;

/// True when a request of this kind changes the rig.
pub fn changes(kind: u16) -> bool {
    ENDPOINTS.iter().any(|&(of, _, changes)| of == kind && changes)
}

/// Who the rig is. Frozen: never edited, in no version.
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
    /// True when that commit had been changed before the build.
    pub git_dirty: bool,
    /// Name of the board, the folder under `boards/`.
    pub board: String<24>,
    /// Sampling.
    pub adc: AdcProperties,
    /// Scans of a record.
    pub record_scans: u16,
    /// Scans of a record before the trigger.
    pub pre_trigger_scans: u16,
    /// Triaxial sensors that the rig has inputs for.
    pub max_sensors: u8,
    /// Hit DOFs that the rig has memory for.
    pub max_hits: u8,
    /// True when the link carries the stream of all scans.
    pub streams: bool,
    /// Why it started: raw [`BootReason`](crate::BootReason).
    pub boot_reason: u8,
    /// The last words of a panic before this start, empty when there was none.
    pub last_panic: String<96>,
}

/// What the rig is doing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Raw [`Phase`](massline_shared::measurement::campaign::Phase).
    pub phase: u8,
    /// Index of the DOF in hand.
    pub dof: u8,
    /// Counts every arming since power-on: a new number means the next hit is wanted.
    pub armings: u32,
    /// Accepted hits of each DOF of the layout.
    pub accepted: Vec<u8, RIG_HITS>,
    /// Accepted hits wanted at each DOF.
    pub hits_per_dof: u8,
    /// Hits rejected in this campaign.
    pub rejected: u16,
    /// Number of the last hit, as in [`crate::event::HitEvent::number`].
    pub last_hit: u32,
    /// Hash of the layout that is kept, 0 when there is none.
    pub layout_hash: u32,
    /// Number of the result of the campaign that ended last, 0 when there is none.
    pub result: u32,
    /// What is to be said about the campaign.
    #[serde(with = "crate::diagnostic")]
    pub diagnostics: Diagnostics,
}

/// What the rig has counted since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stats {
    /// Time since power-on, ms.
    pub uptime_ms: u64,
    /// Scans taken.
    pub scans: u64,
    /// Scans lost: the sampler overran.
    pub scans_lost: u64,
    /// Times that the rig computed for longer than its deadline allows before it looked after
    /// scans, link and panel again.
    pub deadlines_missed: u32,
    /// Triggers.
    pub triggers: u32,
    /// Frames received whole.
    pub frames_in: u32,
    /// Frames received and dropped: broken.
    pub frames_broken: u32,
    /// Requests refused.
    pub requests_refused: u32,
    /// Requests that had been executed already and were only answered again.
    pub requests_repeated: u32,
    /// Frames sent.
    pub frames_out: u32,
    /// Frames given up because nobody read.
    pub frames_unsent: u32,
    /// Events dropped because the link was behind.
    pub events_dropped: u32,
    /// Flash writes that failed verification.
    pub store_failures: u32,
    /// Most stack ever used, bytes, 0 when the board does not measure it.
    pub stack_high_water: u32,
    /// Times that the sampler overran; how many scans each cost is in [`Self::scans_lost`].
    pub overruns: u32,
    /// Hits aborted because scans of their record were lost.
    pub hits_aborted: u32,
    /// The longest that the rig computed before it looked after scans, link and panel again, µs: at
    /// most [`STEP_LIMIT_MS`], or it counts among [`Self::deadlines_missed`].
    pub longest_step_us: u32,
    /// Scans of a stream that were not sent because the link was behind.
    pub stream_scans_dropped: u32,
    /// Bytes received and dropped: noise and broken frames.
    pub bytes_dropped: u32,
    /// Times that the link was lost and came back.
    pub reconnects: u32,
    /// Pages of flash erased.
    pub flash_erases: u32,
    /// Bytes of flash written.
    pub flash_bytes_written: u32,
    /// Records written to the flash that did not read back as they were written.
    pub read_back_failures: u32,
    /// Stack that there is, bytes, 0 when the board does not say.
    pub stack_size: u32,
}

/// The longest that a rig may compute before it looks after scans, link and panel again, ms: every
/// board buffers as many scans.
pub const STEP_LIMIT_MS: u64 = 40;

/// The answer to a layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayoutAnswer {
    /// Hash of the layout as kept.
    pub hash: u32,
    /// What is to be said about it. With an error among them the layout is kept but a campaign
    /// needs [`CommandRequest::force`].
    #[serde(with = "crate::diagnostic")]
    pub diagnostics: Diagnostics,
}

/// What the host wants of the campaign, raw in [`CommandRequest::command`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub enum CampaignCommand {
    /// Start from the first DOF, forgetting a paused campaign.
    Start = 1,
    /// Accept the hit that waits for confirmation.
    Accept = 2,
    /// Reject the hit that waits for confirmation.
    Reject = 3,
    /// Forget all hits of the DOF in hand and measure it again.
    Redo = 4,
    /// Leave the DOF in hand out.
    Skip = 5,
    /// Go on with the hits that this DOF has.
    Finish = 6,
    /// Interrupt: stop sampling, keep everything accepted.
    Pause = 7,
    /// Go on after an interruption.
    Resume = 8,
    /// End the campaign without a result.
    Abort = 9,
}

impl CampaignCommand {
    /// What it asks of a campaign that is there already; `None` of a start.
    pub fn steering(self) -> Option<Steering> {
        Some(match self {
            Self::Start => return None,
            Self::Accept => Steering::Accept,
            Self::Reject => Steering::Reject,
            Self::Redo => Steering::Redo,
            Self::Skip => Steering::Skip,
            Self::Finish => Steering::Finish,
            Self::Pause => Steering::Pause,
            Self::Resume => Steering::Resume,
            Self::Abort => Steering::Abort,
        })
    }
}

/// Steers the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandRequest {
    /// Raw [`CampaignCommand`].
    pub command: u8,
    /// With `Start`: every hit waits for `Accept` or `Reject`, with its record readable.
    pub confirm: bool,
    /// With `Start`: begin although the layout has an error.
    pub force: bool,
    /// With `Start`: the object is a block of this mass, kg. The layout need not determine ten
    /// properties, none are looked for, and the result is marked by
    /// [`Code::BlockTest`](massline_shared::diagnosis::Code::BlockTest).
    pub block_mass: Option<f32>,
}

/// Results after a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListRequest {
    /// Only results with a larger number.
    pub after: u32,
}

/// A mass in kg; without a standard deviation when it comes from single hits.
pub type EstimatedMass = Estimated<f32, Option<f32>>;

/// One line of the list of results.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultEntry {
    /// Number of the result.
    pub number: u32,
    /// Hash of the layout that it was measured with.
    pub layout_hash: u32,
    /// Mass by the best of its answers, kg; `None` when the result has none.
    pub mass: Option<EstimatedMass>,
    /// Bytes of the result.
    pub length: u32,
}

/// Part of the list of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultPage {
    /// In order of their numbers.
    pub entries: Vec<ResultEntry, 16>,
    /// True when there are more.
    pub more: bool,
}

/// Why a request was not executed, raw in [`Refusal::reason`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u16)]
pub enum Reason {
    /// The rig does not know this message.
    UnknownMessage = 1,
    /// The body is not what this message needs.
    Malformed = 2,
    /// There is no such object or result.
    NotFound = 3,
    /// Not in this phase of the campaign.
    WrongPhase = 4,
    /// No layout is kept.
    NoLayout = 5,
    /// The layout cannot determine the ten properties.
    LayoutRefused = 6,
    /// The store is full.
    StoreFull = 7,
    /// The flash did not keep what was written.
    StoreFailed = 8,
    /// The part that is asked for lies outside the object.
    OutOfRange = 9,
    /// The object is being written; ask again.
    Busy = 10,
    /// The converter does not answer.
    SamplerStopped = 11,
}

impl From<StartError> for Reason {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Busy => Self::Busy,
            StartError::NoLayout => Self::NoLayout,
            StartError::LayoutRefused => Self::LayoutRefused,
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
        }
    }
}

/// The answer to a request that was not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// Raw [`Reason`].
    pub reason: u16,
}

impl From<Reason> for Refusal {
    fn from(reason: Reason) -> Self {
        Self { reason: reason.into() }
    }
}
