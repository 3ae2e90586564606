//! Tables of answers: a row for each, a column for each of the ten properties.

use std::fmt;

use askama::Template;
use askama::filters::HtmlSafe;
use massline_result::{CombinedAnswer, Estimate};
use massline_shared::body::INERTIAL_PARAMETERS;

use super::answer::{number, symbol};

/// What is said of an answer whose interval is of another kind than those beside it.
pub(super) const SCATTER_ONLY: &str = "its intervals would cover the scatter between hits only";

/// Answers against each other.
#[derive(Template)]
#[template(path = "properties.html")]
pub(super) struct PropertyTable {
    pub caption: String,
    /// What a row is.
    pub row_kind: &'static str,
    pub header: Vec<Label>,
    pub groups: Vec<RowGroup>,
}

/// Rows under a heading.
pub(super) struct RowGroup {
    /// Empty where all rows are in one group.
    pub heading: String,
    pub rows: Vec<PropertyRow>,
}

/// An answer.
pub(super) struct PropertyRow {
    pub name: String,
    /// The number of its result in the page, to which it leads; `None` in the section of a result.
    pub result: Option<usize>,
    /// What has to be said of its intervals.
    pub remark: &'static str,
    pub cells: Vec<Cell>,
}

/// A property with half the width of its 95 % interval, in the unit of tables.
pub(super) struct Cell {
    value: String,
    /// Empty where it is not known.
    half_width: String,
}

/// What a property is called, and its unit.
pub(super) struct Label {
    pub symbol: (&'static str, &'static str),
    pub unit: &'static str,
}

impl Label {
    /// Those of all ten properties.
    pub fn all() -> Vec<Self> {
        let parameters = INERTIAL_PARAMETERS.iter();
        parameters
            .map(|parameter| Self { symbol: symbol(parameter), unit: parameter.table_unit })
            .collect()
    }
}

impl PropertyTable {
    /// The caption says what stands after ±, where that stands anywhere.
    pub fn new(caption: &str, row_kind: &'static str, groups: Vec<RowGroup>) -> Self {
        let cells = groups.iter().flat_map(|group| &group.rows).flat_map(|row| &row.cells);
        let intervals = intervals_in(cells);
        Self { caption: format!("{caption}{intervals}"), row_kind, header: Label::all(), groups }
    }
}

/// What a caption says of intervals; nothing where no cell has one.
pub(super) fn intervals_in<'c>(mut cells: impl Iterator<Item = &'c Cell>) -> &'static str {
    if cells.any(|cell| !cell.half_width.is_empty()) { ", ± 95\u{a0}%" } else { "" }
}

impl PropertyRow {
    /// An answer, by a name. An interval of another kind than those beside it does not stand there.
    pub fn of(name: String, answer: &Estimate) -> Self {
        let remark = if answer.covers_scatter_only() { SCATTER_ONLY } else { "" };
        Self { name, result: None, remark, cells: Cell::all(answer) }
    }

    /// What all methods say together.
    pub fn combined(combined: &CombinedAnswer) -> Self {
        let [theta, half] =
            [combined.value, combined.half_width95].map(|properties| properties.in_order());
        let cell = |k: usize| Cell::of(k, theta[k], Some(half[k]));
        let cells = (0..10).map(cell).collect();
        Self { name: "combined".into(), result: None, remark: "", cells }
    }
}

impl Cell {
    /// Those of an answer.
    pub fn all(answer: &Estimate) -> Vec<Self> {
        let (theta, half) = (answer.theta(), answer.half_widths());
        let cell = |k: usize| Self::of(k, theta[k], half.map(|half| half[k]));
        (0..10).map(cell).collect()
    }

    /// That of a result without an answer.
    pub fn none() -> Self {
        Self { value: "–".into(), half_width: String::new() }
    }

    fn of(k: usize, value: f64, half: Option<f64>) -> Self {
        let half_width = half.map_or(String::new(), |width| number(k, width, half));
        Self { value: number(k, value, half), half_width }
    }
}

/// Numbers only.
impl HtmlSafe for Cell {}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.value)?;
        match self.half_width.as_str() {
            "" => Ok(()),
            half => write!(f, "<span class=\"below\">± {half}</span>"),
        }
    }
}
