//! What a diagnostic is about.

use super::Setting;

/// What a diagnostic is about. Indexes count from 0, in the order of the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// The whole layout, hit, data set or answer.
    Whole,
    /// A sensor.
    Sensor(u8),
    /// A hit DOF.
    Hit(u8),
    /// A channel of a record: 0 is the hammer, then three for each sensor.
    Channel(u8),
    /// One of the inertial parameters, in the order of `theta`.
    Property(u8),
    /// A setting of the `[test]` table.
    Setting(Setting),
    /// A suspension mode, in the order of the frequencies.
    Mode(u8),
    /// Two hit DOFs.
    Hits {
        /// One of them.
        first: u8,
        /// The other.
        second: u8,
    },
    /// A response due to a hit DOF.
    Response {
        /// The hit DOF.
        hit: u8,
        /// The response: three for each sensor.
        response: u8,
    },
}

impl Subject {
    /// The sensor with this index.
    pub fn sensor(index: usize) -> Self {
        Self::Sensor(narrow(index))
    }

    /// The hit DOF with this index.
    pub fn hit(index: usize) -> Self {
        Self::Hit(narrow(index))
    }

    /// The channel with this index.
    pub fn channel(index: usize) -> Self {
        Self::Channel(narrow(index))
    }

    /// The inertial parameter with this index in `theta`.
    pub fn property(index: usize) -> Self {
        Self::Property(narrow(index))
    }

    /// The hit DOFs with these indexes.
    pub fn hits(first: usize, second: usize) -> Self {
        Self::Hits { first: narrow(first), second: narrow(second) }
    }

    /// The suspension mode with this index.
    pub fn mode(index: usize) -> Self {
        Self::Mode(narrow(index))
    }

    /// The response with this index due to the hit DOF with this index.
    pub fn response(hit: usize, response: usize) -> Self {
        Self::Response { hit: narrow(hit), response: narrow(response) }
    }
}

/// No layout and no record has more than 256 of anything; a larger index is reported as 255.
fn narrow(index: usize) -> u8 {
    u8::try_from(index).unwrap_or(u8::MAX)
}

/// The kinds of subject that a code refers to. [`Subject::Whole`] is possible with every kind and then means
/// any or all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubjectKind {
    /// No subject: the code is about the whole.
    Whole,
    /// Sensors.
    Sensor,
    /// Hit DOFs.
    Hit,
    /// Sensors and hit DOFs.
    SensorOrHit,
    /// Channels of a record.
    Channel,
    /// Inertial parameters.
    Property,
    /// Settings.
    Setting,
    /// Suspension modes.
    Mode,
    /// Pairs of hit DOFs.
    HitPair,
    /// Responses due to a hit DOF.
    Response,
}

impl SubjectKind {
    /// True when a code of this kind may be about the subject.
    pub fn admits(self, subject: Subject) -> bool {
        match subject {
            Subject::Whole => true,
            Subject::Sensor(_) => matches!(self, Self::Sensor | Self::SensorOrHit),
            Subject::Hit(_) => matches!(self, Self::Hit | Self::SensorOrHit),
            Subject::Channel(_) => self == Self::Channel,
            Subject::Property(_) => self == Self::Property,
            Subject::Setting(_) => self == Self::Setting,
            Subject::Mode(_) => self == Self::Mode,
            Subject::Hits { .. } => self == Self::HitPair,
            Subject::Response { .. } => self == Self::Response,
        }
    }

    /// The subject of this kind with this index; for a response, the one due to the first hit. Used to list
    /// all possible texts.
    pub fn at(self, index: u8) -> Subject {
        match self {
            Self::Whole => Subject::Whole,
            Self::Sensor => Subject::Sensor(index),
            Self::Hit | Self::SensorOrHit => Subject::Hit(index),
            Self::Channel => Subject::Channel(index),
            Self::Property => Subject::Property(index),
            Self::Setting => {
                let setting = Setting::ALL.get(usize::from(index));
                setting.map_or(Subject::Whole, |&setting| Subject::Setting(setting))
            }
            Self::Mode => Subject::Mode(index),
            Self::HitPair => Subject::Hits { first: 0, second: index },
            Self::Response => Subject::Response { hit: 0, response: index },
        }
    }
}
