//! How a person who turns the sensors is asked for the next position of a tumble test.

use std::io;
use std::time::Duration;

use crossterm::event::KeyCode;
use indicatif::ProgressBar;
use massline_protocol::message::Identity;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::{Position, TumbleLimits};
use massline_shared::signal::{HAMMER, RestStatistics};

use crate::output::Output;
use crate::screen::positions::{Positions, SensorOrientation, in_words};
use crate::screen::{Screen, View};
use crate::support::keyboard::{Keyboard, no_terminal};
use crate::{Error, Result};
use massline_analysis::calibration::orientation;
use massline_client::Client;
use massline_client::interrupt::Interrupt;
use massline_files::file;

/// Longest line that a person types, bytes.
const MOST_LINE_BYTES: usize = 4096;
/// How long a key is waited for between two looks at the sensors.
const PATIENCE: Duration = Duration::from_millis(20);

/// Asks for positions, and tells how it went.
pub trait Helper {
    /// Returns when the sensors lie in this position.
    ///
    /// # Errors
    /// When there is nobody to turn the sensors, or the person leaves.
    fn ask(&mut self, position: Position, client: &mut Client, identity: &Identity) -> Result<()>;

    /// The sensors moved while they were read, or lie otherwise; they are read again.
    fn again(&mut self, why: &Error);

    /// A position has been read.
    fn done(&mut self, position: Position);
}

/// Asks in lines, and reads Enter from standard input.
pub struct Lines<'o> {
    output: &'o mut Output,
    bar: ProgressBar,
}

impl<'o> Lines<'o> {
    /// A helper with a bar that counts positions.
    pub fn new(output: &'o mut Output) -> Self {
        let bar = output.bar(Position::ALL.len() as u64, "positions");
        Self { output, bar }
    }
}

impl Drop for Lines<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Helper for Lines<'_> {
    fn ask(&mut self, position: Position, _: &mut Client, _: &Identity) -> Result<()> {
        self.output.note(in_words(position));
        match file::line(&mut io::stdin().lock(), MOST_LINE_BYTES) {
            Ok(Some(_)) => Ok(()),
            Err(error) => Err(Error::input("no_keyboard", format!("standard input: {error}"))),
            Ok(None) => Err(Error::input(
                "no_keyboard",
                "a person must say when the sensors lie in their position, and stdin has ended: run this in a \
                 terminal; what has been read is kept",
            )),
        }
    }

    fn again(&mut self, why: &Error) {
        self.output.warn(why.to_string());
    }

    fn done(&mut self, position: Position) {
        self.output.note(format!("{position}  read"));
        self.bar.inc(1);
    }
}

/// Shows on a full screen how the sensors lie until Enter is pressed.
pub struct ScreenHelper {
    screen: Screen<Positions>,
    keyboard: Keyboard,
    interrupt: Interrupt,
    /// The calibration that the rig has now, for what is shown.
    record: CalibrationRecord,
    /// Largest standard deviation of a sensor that does not move, m/s².
    unrest: f64,
}

impl ScreenHelper {
    /// Takes the terminal.
    ///
    /// # Errors
    /// When the terminal cannot be taken or the rig cannot be reached.
    pub fn open(client: &mut Client, wanted: &[Position], output: &Output) -> Result<Self> {
        let record = client.calibration()?;
        let view = Positions::new(wanted, orientation::is_known(&record));
        let keyboard = Keyboard::take(output)?;
        let screen = Screen::open(view, keyboard.raw_mode(), output).map_err(no_terminal)?;
        let interrupt = output.interrupt().clone();
        let unrest = TumbleLimits::default().unrest;
        Ok(Self { screen, keyboard, interrupt, record, unrest })
    }

    /// An error once the person has left.
    ///
    /// # Errors
    /// [`ErrorKind::Interrupted`](massline_result::ErrorKind::Interrupted).
    pub fn unless_interrupted(&self) -> Result<()> {
        match self.interrupt.pressed() {
            true => Err(Error::interrupted("the tumble test is interrupted")),
            false => Ok(()),
        }
    }

    /// What each sensor reads.
    fn lies(&self, statistics: &RestStatistics, identity: &Identity) -> Vec<SensorOrientation> {
        let per_code = identity.adc.volts_per_code();
        let volts = statistics.mean.map(|mean| f64::from(mean * per_code));
        let scale = |channel: usize| self.record.calibration.per_code(&identity.adc, channel);
        let moves = |channel: usize| {
            f64::from(scale(channel) * statistics.deviation[channel]).abs() > self.unrest
        };
        let sensors = orientation::readings(&volts, &self.record, identity).into_iter().enumerate();
        let lying = |(sensor, reads)| {
            let first = HAMMER + 1 + 3 * sensor;
            SensorOrientation { reads, moves: (first..first + 3).any(moves) }
        };
        sensors.map(lying).collect()
    }
}

impl Helper for ScreenHelper {
    fn ask(&mut self, position: Position, client: &mut Client, identity: &Identity) -> Result<()> {
        self.screen.update(|view| view.ask(position));
        loop {
            self.screen.draw();
            self.unless_interrupted()?;
            if self.keyboard.next_key(PATIENCE) == Some(KeyCode::Enter) {
                break;
            }
            let statistics = client.rest_statistics()?;
            let lies = self.lies(&statistics, identity);
            self.screen.update(|view| view.lies(lies));
        }
        self.screen.update(Positions::read);
        self.screen.draw();
        Ok(())
    }

    fn again(&mut self, why: &Error) {
        self.screen.update(|view| view.note(&why.to_string()));
    }

    fn done(&mut self, position: Position) {
        self.screen.update(|view| view.done(position));
        self.screen.draw();
    }
}
