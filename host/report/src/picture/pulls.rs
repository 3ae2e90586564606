//! The pulls of sensors and hits: how far the fit had to move each of them, in standard deviations of the error budget,
//! and what it leaves of the readings of a hit, over their noise.

use massline_result::Details;
use massline_shared::identify::maximum_likelihood::SUSPICIOUS_PULL;
use massline_shared::layout::{HOST_HITS, HOST_SENSORS};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, number, tick, write};
use super::legend::{Key, Sign, legend};
use super::scale::step_of;
use super::theme::{COLORS, FAINT, INK, LABEL, PAPER, SMALL};
use crate::result_file::{ResultFile, shorten_for_picture};

/// Room for the names at the left, and for numbers and name of the axis, pixels.
const LEFT: i32 = 260;
const BELOW: i32 = 84;
/// Room for the values at the right, pixels.
const RIGHT: i32 = 300;
/// Highest row, pixels.
const HIGHEST: i32 = 130;
/// A larger pull is drawn as this.
const LARGEST_DRAWN: f64 = 1e6;

/// A sensor or a hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Pull {
    /// What it is called.
    pub name: String,
    /// Its pull.
    pub pull: f64,
    /// What is left of its readings, over their noise; hits have it.
    pub residual: Option<f64>,
}

/// The pulls of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulls {
    /// What was measured.
    pub title: String,
    /// Sensors, then hits.
    pub rows: Vec<Pull>,
    /// Which errors have a factor of their budget that the data have taught, and the factor.
    pub scale: Option<(&'static str, f64)>,
}

impl Pulls {
    /// The pulls of a result; `None` when it has none.
    pub fn of(source: &ResultFile, details: &Details) -> Option<Self> {
        let sensors = details.sensors.iter().take(HOST_SENSORS).map(|sensor| Pull {
            name: format!("sensor at node {}", sensor.node),
            pull: sensor.pull.unwrap_or_default(),
            residual: None,
        });
        let hits = details.hits.iter().take(HOST_HITS).map(|hit| Pull {
            name: format!("hits at {}", shorten_for_picture(&hit.dof)),
            pull: hit.pull.unwrap_or_default(),
            residual: hit.normalized_residual,
        });
        let rows: Vec<Pull> = sensors.chain(hits).collect();
        let scale = details
            .error_budget
            .map(|budget| (budget.learned_from.constant(), budget.constant_scale.learned));
        let title = source.title.clone();
        (!rows.is_empty()).then_some(Self { title, rows, scale })
    }

    /// The right end of the axis.
    fn end(&self) -> f64 {
        let values = self.rows.iter().flat_map(|row| [Some(row.pull), row.residual]).flatten();
        let largest = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
        (1.12 * largest).clamp(1.25 * SUSPICIOUS_PULL, LARGEST_DRAWN)
    }

    /// What is drawn how.
    fn keys(&self) -> Vec<Key> {
        let budget = match self.scale {
            Some((errors, scale)) => {
                format!("pull, with the learned budget ({errors}: {scale:.2} × as stated)")
            }
            None => "pull, with the stated budget".to_owned(),
        };
        let suspect = format!("above {SUSPICIOUS_PULL}: suspect");
        let mut keys =
            vec![Key::of(budget, Sign::Patch, COLORS[0]), Key::of(suspect, Sign::Patch, COLORS[1])];
        if self.rows.iter().any(|row| row.residual.is_some()) {
            keys.push(Key::of("residual of hits, over noise", Sign::Ring, INK));
        }
        keys
    }
}

impl Drawing for Pulls {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "how far the fit pulls sensors and hits".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let used = legend(area, &self.keys())? + 10;
        let (_, area) = area.split_vertically(used);
        let (width, height) = area.dim_in_pixel();
        let row = ((height as i32 - BELOW) / self.rows.len().max(1) as i32).clamp(1, HIGHEST);
        let bottom = row * self.rows.len() as i32;
        let end = self.end();
        let room = f64::from(width as i32 - LEFT - RIGHT);
        let x = |value: f64| {
            let share = if value.is_finite() { (value / end).clamp(0.0, 1.0) } else { 1.0 };
            LEFT + (share * room).round() as i32
        };
        let upright = |value: f64, ink: ShapeStyle| {
            area.draw(&PathElement::new([(x(value), 0), (x(value), bottom)], ink))
        };
        let step = step_of(end, 10.0);
        for k in 0..=(end / step).floor() as i32 {
            let value = f64::from(k) * step;
            upright(value, FAINT.stroke_width(1))?;
            write(
                &area,
                &tick(value),
                (x(value), bottom + 20),
                (HPos::Center, VPos::Center),
                SMALL,
            )?;
        }
        let axis = "standard deviations of the budget; 1 is what it expects";
        let middle = LEFT + (room / 2.0) as i32;
        write(&area, axis, (middle, bottom + 58), (HPos::Center, VPos::Center), LABEL)?;
        for (place, pull) in self.rows.iter().enumerate() {
            let center = place as i32 * row + row / 2;
            let size = if row >= 30 { LABEL } else { 0.8 * SMALL };
            write(&area, &pull.name, (LEFT - 16, center), (HPos::Right, VPos::Center), size)?;
            let color = if pull.pull > SUSPICIOUS_PULL { COLORS[1] } else { COLORS[0] };
            let half = (row * 3 / 10).clamp(1, 24);
            let bar = [(LEFT, center - half), (x(pull.pull), center + half)];
            area.draw(&Rectangle::new(bar, color.filled()))?;
            if let Some(residual) = pull.residual {
                let at = (x(residual), center);
                area.draw(&Circle::new(at, 8, PAPER.filled()))?;
                area.draw(&Circle::new(at, 8, INK.stroke_width(3)))?;
            }
            let mut values = format!("pull {}", number(pull.pull, 2));
            if let Some(residual) = pull.residual {
                values += &format!(", residual {}", number(residual, 2));
            }
            let at = (width as i32 - RIGHT + 16, center);
            write(&area, &values, at, (HPos::Left, VPos::Center), size.min(SMALL))?;
        }
        upright(0.0, INK.stroke_width(2))?;
        upright(1.0, INK.stroke_width(2))?;
        upright(SUSPICIOUS_PULL, COLORS[1].stroke_width(3))
    }
}

#[cfg(test)]
mod tests {
    use super::{Pull, Pulls};

    #[test]
    fn the_axis_shows_the_largest_pull_and_the_suspicious_one() {
        let pull_of = |pull| Pull { name: "a".into(), pull, residual: None };
        let end = |pulls: &[f64]| {
            let rows = pulls.iter().map(|&pull| pull_of(pull)).collect();
            Pulls { title: String::new(), rows, scale: None }.end()
        };
        assert_eq!(end(&[0.3]), 2.5);
        assert!(end(&[0.3, 7.0]) > 7.0);
        assert_eq!(end(&[f64::INFINITY]), 2.5);
        assert_eq!(end(&[1e300]), 1e6);
    }
}
