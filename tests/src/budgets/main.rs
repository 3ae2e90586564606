//! Measures what the firmware costs on the emulated board, prints it beside `tests/budgets.toml`, and
//! fails when a budget is exceeded.
//!
//! ```text
//! cargo run -p massline-tests --bin massline-budgets -- --stack-high-water 9000
//! ```
//! The stack's high-water mark is that of the rig after a whole campaign, from
//! `massline device stats`; the end-to-end test leaves it in a file for `--stack-high-water-file`.

mod counts;
mod image;

use std::path::Path;
use std::process::ExitCode;
use std::{env, fs};

use anyhow::{Context, bail};
use comfy_table::{CellAlignment, Table, presets};
use serde::Deserialize;

fn main() -> anyhow::Result<ExitCode> {
    let high_water = high_water(env::args().skip(1))?;
    let checkout = massline::qemu::checkout()?;
    let budgets = Budgets::read(&checkout.join("tests/budgets.toml"))?;
    let image = image::measure(&massline::qemu::build_firmware()?)?;
    let counts = counts::measure(checkout)?;
    let mut lines = vec![
        Line::new("flash, bytes", budgets.image.flash_bytes, image.flash),
        Line::new("static RAM, bytes", budgets.image.static_ram_bytes, image.static_ram),
    ];
    if let Some(bytes) = high_water {
        lines.push(Line::new("stack high water, bytes", budgets.stack.high_water_bytes, bytes));
    }
    for (name, budget) in &budgets.instructions {
        let measured = counts
            .get(&format!("{name}_instructions"))
            .with_context(|| format!("the program `counts` does not measure {name}"))?;
        lines.push(Line::new(&format!("{name}, instructions"), *budget, *measured));
    }
    println!("{}", table(&lines));
    if high_water.is_none() {
        println!("The stack was not measured: give --stack-high-water BYTES.");
    }
    let exceeded = lines.iter().any(Line::exceeded);
    Ok(if exceeded { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// The limits.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Budgets {
    image: ImageBudget,
    stack: StackBudget,
    instructions: std::collections::BTreeMap<String, u64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageBudget {
    flash_bytes: u64,
    static_ram_bytes: u64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StackBudget {
    high_water_bytes: u64,
}

impl Budgets {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        toml::from_str(&text).with_context(|| path.display().to_string())
    }
}

/// One budget and what was measured.
#[derive(Debug)]
struct Line {
    name: String,
    budget: u64,
    measured: u64,
}

impl Line {
    fn new(name: &str, budget: u64, measured: u64) -> Self {
        Self { name: name.to_owned(), budget, measured }
    }

    fn exceeded(&self) -> bool {
        self.measured > self.budget
    }
}

fn table(lines: &[Line]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["", "budget", "measured", "used"]);
    for line in lines {
        let percent = 100.0 * line.measured as f64 / line.budget as f64;
        let verdict = if line.exceeded() { " EXCEEDED" } else { "" };
        table.add_row([
            line.name.clone(),
            line.budget.to_string(),
            line.measured.to_string(),
            format!("{percent:.0} %{verdict}"),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn high_water(mut arguments: impl Iterator<Item = String>) -> anyhow::Result<Option<u64>> {
    let Some(flag) = arguments.next() else { return Ok(None) };
    let value = arguments.next().with_context(|| format!("{flag} needs a value"))?;
    let text = match flag.as_str() {
        "--stack-high-water" => value,
        "--stack-high-water-file" => fs::read_to_string(&value).with_context(|| value.clone())?,
        _ => bail!(
            "unknown argument {flag}; there are --stack-high-water BYTES and --stack-high-water-file FILE"
        ),
    };
    let bytes = text.trim().parse().with_context(|| format!("{text:?} is no number of bytes"))?;
    Ok(Some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments(words: &[&str]) -> anyhow::Result<Option<u64>> {
        high_water(words.iter().map(|&word| word.to_owned()))
    }

    #[test]
    fn the_high_water_mark_is_taken_from_the_arguments() {
        assert_eq!(arguments(&[]).unwrap(), None);
        assert_eq!(arguments(&["--stack-high-water", "9000"]).unwrap(), Some(9000));
        assert!(arguments(&["--stack-high-water"]).is_err());
        assert!(arguments(&["--stack-high-water", "much"]).is_err());
        assert!(arguments(&["--stack"]).is_err());
    }

    #[test]
    fn a_budget_is_exceeded_from_the_next_byte_on() {
        assert!(!Line::new("", 10, 10).exceeded());
        assert!(Line::new("", 10, 11).exceeded());
    }

    #[test]
    fn the_committed_budgets_are_read() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("budgets.toml");
        let budgets = Budgets::read(&path).unwrap();
        assert!(budgets.instructions.contains_key("hit_analysis"));
    }
}
