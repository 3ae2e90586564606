//! Tables that fit the terminal without breaking a number.

use std::fmt;
use std::io::{self, IsTerminal};
use std::ops::{Deref, DerefMut};

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Width, presets};

use crate::wrap::{KEPT, WIDTH};

/// Blanks before a column of a tight table: one of its cells, and one between columns.
const BLANKS: usize = 2;

/// A table with rules at the top, under the header and at the bottom. Where the terminal is too narrow, columns move
/// together; where that is not enough, cells wrap between words, and at last every row becomes a list.
#[derive(Debug)]
pub struct Table {
    table: comfy_table::Table,
    columns: Option<usize>,
}

impl Table {
    /// An empty table for this many columns of a terminal; `None` for as many as it needs.
    pub fn within(columns: Option<usize>) -> Self {
        let mut table = comfy_table::Table::new();
        table.load_style(presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none()));
        Self { table, columns }
    }

    /// The cells of a column, its header first.
    fn cells(&self, column: usize) -> Vec<String> {
        let header = self.table.header().into_iter();
        let cell = |row: &comfy_table::Row| row.cell_iter().nth(column).map(|c| c.content());
        header.chain(self.table.row_iter()).filter_map(cell).collect()
    }

    /// The table in as few columns as it takes without wrapping.
    fn tight(&self) -> comfy_table::Table {
        let mut table = self.table.clone();
        table.column_iter_mut().for_each(|column| {
            column.set_padding((1, 0));
        });
        table
    }

    /// The table with cells that wrap between words; `None` when even that is too wide.
    fn wrapped(&self, columns: usize) -> Option<comfy_table::Table> {
        let mut table = self.tight();
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(u16::try_from(columns).ok()?);
        let mut least = 0;
        for k in 0..table.column_count() {
            let cells = self.cells(k);
            let words = cells.iter().flat_map(|cell| cell.split([' ', '\n']));
            let longest = words.map(textwrap::core::display_width).max().unwrap_or(0);
            least += longest + BLANKS;
            let width = Width::Fixed(u16::try_from(longest + 1).ok()?);
            table.column_mut(k)?.set_constraint(ColumnConstraint::LowerBoundary(width));
        }
        // Before the first column there is no other.
        (least <= columns + 1).then_some(table)
    }

    /// Every row as a list of its cells.
    fn as_list(&self) -> String {
        let content = |row: &comfy_table::Row| -> Vec<String> {
            row.cell_iter().map(|cell| cell.content().replace('\n', " ")).collect()
        };
        let header = self.table.header().map_or_else(Vec::new, content);
        let mut lines = Vec::new();
        for row in self.table.row_iter().map(content) {
            let mut cells =
                row.iter().zip(header.iter().map(String::as_str).chain([""].into_iter().cycle()));
            lines.extend(
                cells.next().map(|(first, name)| format!("{name} {first}").trim().to_owned()),
            );
            lines.extend(cells.map(|(cell, name)| format!("  {name}: {cell}")));
        }
        lines.join("\n")
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fits = |table: &str| self.columns.is_none_or(|columns| width(table) <= columns);
        let whole = [self.table.to_string(), self.tight().to_string()];
        let table = whole.into_iter().find(|table| fits(table)).unwrap_or_else(|| {
            let wrapped = self.wrapped(self.columns.unwrap_or(usize::MAX));
            wrapped.map_or_else(|| self.as_list(), |table| table.to_string())
        });
        f.write_str(&table.replace(KEPT, " "))
    }
}

/// Columns of the widest line.
fn width(text: &str) -> usize {
    text.lines().map(textwrap::core::display_width).max().unwrap_or(0)
}

impl Deref for Table {
    type Target = comfy_table::Table;

    fn deref(&self) -> &Self::Target {
        &self.table
    }
}

impl DerefMut for Table {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.table
    }
}

/// Width of the terminal at this moment, columns; `None` where it does not know it.
pub fn terminal_width() -> Option<usize> {
    let columns = crossterm::terminal::size().ok().map(|(columns, _)| usize::from(columns));
    // A terminal that does not know its size reports zero.
    columns.filter(|&columns| columns > 0)
}

/// An empty table in the style of this program, as wide as the terminal of standard output has room for.
pub fn table() -> Table {
    let width = || terminal_width().unwrap_or(WIDTH);
    Table::within(io::stdout().is_terminal().then(width))
}

/// Right-aligns columns of numbers.
pub fn align_right(table: &mut Table, columns: impl IntoIterator<Item = usize>) {
    for column in columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: usize) -> String {
        let mut table = Table::within(Some(columns));
        table.set_header(["", "value", "error, % of scale"]);
        table.add_row(["c_x", "168.7505", "+0.147"]);
        table.to_string()
    }

    #[test]
    fn a_narrow_terminal_breaks_no_number() {
        let whole = width(&table(200));
        assert_eq!(width(&table(whole)), whole);
        // Three columns that each lose the blank after them, on as many lines.
        let tight = table(whole - 1);
        assert_eq!(width(&tight), whole - 3);
        assert_eq!(tight.lines().count(), table(whole).lines().count());
        let wrapped = table(28);
        assert!(width(&wrapped) <= 28 && wrapped.contains("168.7505"), "{wrapped}");
        assert_eq!(table(15), "c_x\n  value: 168.7505\n  error, % of scale: +0.147");
    }
}
