//! Errors of the communication with a rig.

use std::time::Duration;

use massline_protocol::message::Reason;
use massline_protocol::{PROTOCOL_MAJOR, PROTOCOL_MINOR};

use super::purpose::START;
use massline_files::dof_spectra::SpectraError;
use massline_result::Error;

/// Why a request to a rig failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClientError {
    /// The port cannot be opened.
    #[error(
        "{port} does not open as a serial port: {reason}; `massline device list` shows the ports"
    )]
    NotOpened {
        /// Path of the port.
        port: String,
        /// The system's message.
        reason: String,
    },
    /// The user may not open the port.
    #[error(
        "{port} may not be opened ({reason}): on Linux your user must be in the group `dialout`, or a udev rule must \
         allow it; `massline doctor` prints the rule"
    )]
    Denied {
        /// Path of the port.
        port: String,
        /// The system's message.
        reason: String,
    },
    /// The file is not a port.
    #[error("{port} is not a serial port; `massline device list` shows the ports")]
    NoPort {
        /// Path of the file.
        port: String,
    },
    /// There is no such port.
    #[error("{port} does not exist; `massline device list` shows the ports that do")]
    NoSuchPort {
        /// Path of the port.
        port: String,
    },
    /// Another program has the port.
    #[error("{port} is in use by another program; close it and try again ({reason})")]
    PortBusy {
        /// Path of the port.
        port: String,
        /// The system's message.
        reason: String,
    },
    /// Nothing answers at the TCP address.
    #[error(
        "{port} cannot be reached: {reason}; check host and port, and that `massline virtual --tcp` or whatever \
         shares the serial port runs there"
    )]
    Unreachable {
        /// The address.
        port: String,
        /// The system's message.
        reason: String,
    },
    /// The link was lost and did not come back.
    #[error(
        "{port} was lost ({reason}) and did not come back within {}; connect the rig \
         again and repeat the command: what the rig has accepted and stored is kept",
        seconds(*.waited)
    )]
    Lost {
        /// Path of the port.
        port: String,
        /// The system's message.
        reason: String,
        /// How long the client waited.
        waited: Duration,
    },
    /// The rig does not answer.
    #[error(
        "{port} does not answer when the rig is asked to {request} ({attempts} attempts in {}); is it a massline \
         rig, and does it run?",
        seconds(*.waited)
    )]
    NoAnswer {
        /// Path of the port.
        port: String,
        /// What the rig was asked to do, as in "asked to …".
        request: &'static str,
        /// How often the request was sent.
        attempts: u32,
        /// How long the client waited.
        waited: Duration,
    },
    /// Something else than a rig answers.
    #[error(
        "{port} answers, but not as a massline rig: {first}; `massline device list` shows the ports. If it is a rig, \
         the line garbles what the rig sends"
    )]
    NoRig {
        /// Path of the port.
        port: String,
        /// The first bytes that it sent, as text.
        first: String,
    },
    /// What is sent comes back.
    #[error(
        "{port} returns what is sent to it: this is an echo (a loopback plug, a terminal, or TX wired to RX), and not \
         a massline rig"
    )]
    Echo {
        /// Path of the port.
        port: String,
    },
    /// The other side closes each connection.
    #[error(
        "{port} closes the connection when it is asked ({attempts} times in {}), without an answer: a server runs \
         there, but not a massline rig",
        seconds(*.waited)
    )]
    Closing {
        /// Path of the port.
        port: String,
        /// How often it was asked.
        attempts: u32,
        /// How long that took.
        waited: Duration,
    },
    /// The user did not want to wait for the rig any longer.
    #[error("interrupted while {port} {state}")]
    Interrupted {
        /// Path of the port.
        port: String,
        /// Why the rig was waited for, as in "while the port …".
        state: String,
    },
    /// The rig uses an incompatible protocol version.
    #[error(
        "{port}: the rig (firmware {firmware}) speaks protocol {rig_major}.{rig_minor}, this \
         program {PROTOCOL_MAJOR}.{PROTOCOL_MINOR}; the first numbers must be equal: {advice}"
    )]
    OtherProtocol {
        /// Path of the port.
        port: String,
        /// Version of its firmware.
        firmware: String,
        /// Major version of its protocol.
        rig_major: u8,
        /// Minor version of its protocol.
        rig_minor: u8,
        /// Which side must be updated.
        advice: &'static str,
    },
    /// The rig refused the request.
    #[error("the rig refused to {request}: {}", explain(request, *.reason, *.results_to_delete))]
    Refused {
        /// What the rig was asked to do, as in "asked to …".
        request: &'static str,
        /// Raw [`Reason`].
        reason: u16,
        /// How many results must be deleted for a campaign, the oldest first; zero when that does not help or does not
        /// matter.
        results_to_delete: u8,
    },
    /// An object was received completely several times, but never with the announced checksum.
    #[error(
        "object {kind}/{number} does not have the checksum that the rig announced, after {attempts} attempts"
    )]
    Checksum {
        /// Raw kind of the object.
        kind: u8,
        /// Number of the object.
        number: u32,
        /// How often it was read.
        attempts: u32,
    },
    /// An object was received completely but does not decode as its kind.
    #[error(
        "object {kind}/{number} arrived intact but cannot be decoded; is the rig's firmware newer than \
         this program?"
    )]
    Unreadable {
        /// Raw kind of the object.
        kind: u8,
        /// Number of the object.
        number: u32,
    },
    /// Spectra were received completely but are invalid.
    #[error(
        "the spectra of DOF number {} arrived whole, but {reason}; is the rig's firmware newer?",
        .number + 1
    )]
    Spectra {
        /// Index of the DOF in the layout.
        number: u32,
        /// The fault of the spectra.
        reason: SpectraError,
    },
    /// A message does not fit in a frame.
    #[error("the request to {request} does not fit in a frame")]
    TooLong {
        /// What the rig was asked to do, as in "asked to …".
        request: &'static str,
    },
}

/// A duration for people, with the digits that it deserves.
pub(super) fn seconds(time: Duration) -> String {
    format!("{:.1} s", time.as_secs_f64())
}

impl ClientError {
    /// The code of a port that the user may not open.
    pub const DENIED: &'static str = "port_denied";

    /// The rig's reason when it refused.
    pub fn refusal(&self) -> Option<Reason> {
        match self {
            Self::Refused { reason, .. } => Reason::try_from(*reason).ok(),
            _ => None,
        }
    }

    /// The stable identifier.
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotOpened { .. } => "port_not_opened",
            Self::Denied { .. } => Self::DENIED,
            Self::NoPort { .. } => "no_port",
            Self::NoSuchPort { .. } => "port_not_found",
            Self::PortBusy { .. } => "port_busy",
            Self::Unreachable { .. } => "unreachable",
            Self::Lost { .. } => "link_lost",
            Self::NoAnswer { .. } => "no_answer",
            Self::NoRig { .. } => "not_a_rig",
            Self::Echo { .. } => "echo",
            Self::Closing { .. } => "connection_closed",
            Self::Interrupted { .. } => Error::INTERRUPTED,
            Self::OtherProtocol { .. } => "protocol_major_differs",
            Self::Refused { reason, .. } => refusal_code(*reason),
            Self::Checksum { .. } => "checksum_differs",
            Self::Unreadable { .. } | Self::Spectra { .. } => "unreadable_object",
            Self::TooLong { .. } => "message_too_long",
        }
    }
}

impl From<ClientError> for Error {
    fn from(error: ClientError) -> Self {
        let message = error.to_string();
        match (error.refusal(), &error) {
            (_, ClientError::Interrupted { .. }) => Self::interrupted(message),
            (_, ClientError::TooLong { .. }) => Self::internal(error.code(), message),
            (Some(Reason::LayoutRefused), _) => Self::undetermined(error.code(), message),
            (Some(Reason::NotFound | Reason::NoLayout), _) => Self::input(error.code(), message),
            _ => Self::device(error.code(), message),
        }
    }
}

fn refusal_code(raw: u16) -> &'static str {
    match Reason::try_from(raw).ok() {
        Some(Reason::UnknownMessage) => "rig_unknown_message",
        Some(Reason::Malformed) => "rig_malformed",
        Some(Reason::NotFound) => "not_found",
        Some(Reason::WrongPhase) => "wrong_phase",
        Some(Reason::NoLayout) => "no_layout",
        Some(Reason::LayoutRefused) => "layout_refused",
        Some(Reason::StoreFull) => "store_full",
        Some(Reason::StoreFailed) => "store_failed",
        Some(Reason::OutOfRange) => "out_of_range",
        Some(Reason::Busy) => "rig_busy",
        Some(Reason::SamplerStopped) => "sampler_stopped",
        Some(Reason::NothingToUndo) => "nothing_to_undo",
        Some(Reason::HitOverwritten) => "hit_overwritten",
        Some(Reason::BlockNeedsMassLines) => "block_needs_mass_lines",
        Some(Reason::SafeMode) => "safe_mode",
        Some(Reason::SupplyLow) => "supply_low",
        None => "refused",
    }
}

fn explain(request: &str, raw: u16, results_to_delete: u8) -> String {
    let text = match Reason::try_from(raw).ok() {
        Some(Reason::UnknownMessage) => "its firmware does not know this request; update it",
        Some(Reason::Malformed) => {
            "it could not read the request: the link garbles it, or its firmware is of another build; update it \
             (`massline flash`)"
        }
        Some(Reason::NotFound) => {
            "nothing is stored under that number; `massline results list` shows what is"
        }
        Some(Reason::WrongPhase) => {
            "a campaign is running or interrupted; `massline device identify` shows its phase, `massline measure` \
             goes on with it, `massline device abort` discards it"
        }
        Some(Reason::NoLayout) => "it has no layout; `massline measure LAYOUT` sends one",
        Some(Reason::LayoutRefused) => "its layout cannot determine the ten properties",
        Some(Reason::StoreFull) => {
            return match results_to_delete {
                0 if request == START => {
                    "its store cannot hold a test of so many hit points, even without any result: take fewer of them \
                     in `hits`, or a board with more flash"
                        .into()
                }
                0 => "its store is full; `massline results delete` makes room, and a layout with fewer hits needs \
                     less".into(),
                1 => "its store has too little room; delete the oldest result with `massline results delete`".into(),
                more => format!(
                    "its store has too little room; delete the {more} oldest results with `massline results delete`"
                ),
            };
        }
        Some(Reason::StoreFailed) => "its flash does not keep what is written",
        Some(Reason::OutOfRange) => "the requested part lies outside the object",
        Some(Reason::Busy) => "it is writing that object at the moment; try again",
        Some(Reason::SamplerStopped) => {
            "its converter does not answer; check its supply and wiring"
        }
        Some(Reason::NothingToUndo) => "there is no accepted hit to undo",
        Some(Reason::HitOverwritten) => {
            "a later hit has replaced the record of the last accepted one"
        }
        Some(Reason::BlockNeedsMassLines) => {
            "a block of known mass is weighed by mass lines, and its layout has the suspension profile; use a layout \
             with the profile mass-line"
        }
        Some(Reason::SafeMode) => {
            "it is in safe mode, because its last three starts have failed; `massline device identify` shows what went \
             wrong, reset lets it try again, and `massline device erase` erases what it stores, which may be the cause"
        }
        Some(Reason::SupplyLow) => {
            "its supply is too low to write its flash; charge its battery, or try another cable or USB port"
        }
        None => return format!("reason {raw}, which this program does not know"),
    };
    text.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exit(error: ClientError) -> u8 {
        Error::from(error).exit_code()
    }

    #[test]
    fn a_lost_link_is_a_device_failure() {
        let lost = ClientError::Lost {
            port: "p".into(),
            reason: "r".into(),
            waited: Duration::from_secs(10),
        };
        assert_eq!(exit(lost), 4);
    }

    #[test]
    fn a_result_that_is_not_there_is_a_wrong_argument() {
        let refused = ClientError::Refused {
            request: "find an object",
            reason: Reason::NotFound as u16,
            results_to_delete: 0,
        };
        assert_eq!(exit(refused), 2);
    }

    #[test]
    fn a_refused_layout_cannot_determine_the_answer() {
        let refused = ClientError::Refused {
            request: "do what was asked",
            reason: Reason::LayoutRefused as u16,
            results_to_delete: 0,
        };
        assert_eq!(exit(refused), 3);
    }

    #[test]
    fn an_unknown_reason_is_passed_on() {
        let refused = ClientError::Refused {
            request: "do what was asked",
            reason: 999,
            results_to_delete: 0,
        };
        assert!(refused.to_string().contains("999"));
        assert_eq!(exit(refused), 4);
    }

    #[test]
    fn a_full_store_says_how_many_results_to_delete() {
        let refused = |request, results_to_delete| {
            let reason = Reason::StoreFull as u16;
            ClientError::Refused { request, reason, results_to_delete }.to_string()
        };
        let full = |results_to_delete| refused(START, results_to_delete);
        assert!(
            full(0).contains("cannot hold a test of so many hit points, even without any result")
        );
        assert!(refused("store a layout", 0).contains("is full; `massline results delete`"));
        assert!(full(1).contains("delete the oldest result"));
        assert!(full(3).contains("delete the 3 oldest results"));
    }
}
