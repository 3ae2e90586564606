//! Which controller the screen has.

use serde::{Deserialize, Serialize};

/// What the operator says of the controller of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ScreenSetting {
    /// Nothing: the rig tells it by its answer.
    #[default]
    Automatic,
    /// An SSD1306: 128 columns.
    Ssd1306,
    /// An SH1106: 132 columns, of which two at each side are not on the glass.
    Sh1106,
}

impl ScreenSetting {
    /// The next one, round and round.
    pub fn next(self) -> Self {
        match self {
            Self::Automatic => Self::Ssd1306,
            Self::Ssd1306 => Self::Sh1106,
            Self::Sh1106 => Self::Automatic,
        }
    }

    /// Its name on the panel.
    pub fn name(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::Ssd1306 => "SSD1306",
            Self::Sh1106 => "SH1106",
        }
    }
}
