//! Colours of the full screen. They only repeat what is also said in words, because not every terminal has them and not
//! every eye tells them apart.

use ratatui::style::{Color, Modifier, Style};

/// The styles of a terminal with or without colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Theme {
    /// Whether there are colours.
    pub color: bool,
}

impl Theme {
    fn colored(self, color: Color) -> Style {
        if self.color { Style::new().fg(color) } else { Style::new() }
    }

    /// The name of the DOF, its arrow, and what is to be done now.
    pub fn accent(self) -> Style {
        self.colored(Color::Cyan).add_modifier(Modifier::BOLD)
    }

    /// A good hit.
    pub fn good(self) -> Style {
        self.colored(Color::Green).add_modifier(Modifier::BOLD)
    }

    /// A rejected hit, a warning.
    pub fn bad(self) -> Style {
        self.colored(Color::Yellow).add_modifier(Modifier::BOLD)
    }

    /// Frames, axes and what is said beside.
    pub fn faint(self) -> Style {
        self.colored(Color::DarkGray)
    }

    /// Headings.
    pub fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// The first and the last line.
    pub fn bar(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    /// The color of a curve by its place.
    pub fn curve(self, place: usize) -> Style {
        const COLORS: [Color; 3] = [Color::Cyan, Color::Yellow, Color::Magenta];
        self.colored(COLORS[place % COLORS.len()])
    }
}
