//! Measures the firmware's use of resources on each board, prints it beside the limits, and fails when one is exceeded.
//! How much flash and RAM an image may fill, and its stack, into which the deepest calls must fit, are in
//! `boards/<name>/board.toml`. How much of both must stay free for what comes next, and the limits of the measured
//! stack and of the instructions, both from the emulated board, are in `tests/budgets.toml`.
//!
//! ```text
//! cargo run -p massline-gate --bin massline-budgets
//! ```
//! Needs QEMU and the targets of the boards.

mod counts;
mod image;
mod stack;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use comfy_table::{CellAlignment, Table, presets};
use massline_boards::Board;
use serde::Deserialize;

use crate::image::Image;
use crate::stack::calls;
use crate::stack::high_water;

fn main() -> anyhow::Result<ExitCode> {
    let checkout = massline::qemu::checkout()?;
    let budgets = Budgets::read(&checkout.join("tests/budgets.toml"))?;
    let elf = massline::qemu::build_firmware()?;
    let high_water = high_water::measure(&elf, checkout)?;
    let counts = counts::measure(checkout)?;
    let (mut lines, mut refused) = (Vec::new(), Vec::new());
    for board in &massline_boards::boards(checkout)? {
        let elf = image::build(checkout, board, &elf)?;
        let path = calls::deepest(&elf);
        let calls = path.as_ref().map_or(0, |path| path.bytes);
        let stack = stack_line(board, high_water.most(), calls);
        match path {
            Ok(path) if stack.exceeded() => {
                println!("{}: the deepest path of calls\n{path}", board.name)
            }
            Ok(_) => {}
            Err(error) => refused.push(error),
        }
        lines.extend(image_lines(board, budgets.head_room, image::measure(&elf)?));
        lines.push(stack);
    }
    let stack = budgets.stack.high_water_bytes;
    for (profile, measured) in
        [("mass-line", high_water.mass_line), ("suspension", high_water.suspension)]
    {
        let name = format!("stack high water, {profile} profile, bytes");
        lines.push(BudgetLine::new(&name, stack, measured));
    }
    for (name, budget) in &budgets.instructions {
        let measured = counts
            .get(&format!("{name}_instructions"))
            .with_context(|| format!("the program `counts` does not measure {name}"))?;
        lines.push(BudgetLine::new(&format!("{name}, instructions"), *budget, *measured));
    }
    println!("{}", table(&lines));
    refused.iter().for_each(|error| eprintln!("{error:#}"));
    let exceeded = lines.iter().any(BudgetLine::exceeded) || !refused.is_empty();
    Ok(if exceeded { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Flash and RAM of an image, each with a limit that leaves the head room.
fn image_lines(board: &Board, head_room: HeadRoom, image: Image) -> [BudgetLine; 2] {
    let name = &board.name;
    let static_ram = image.static_ram;
    let ram = static_ram + u64::from(board.image.stack_bytes);
    let ram_limit = u64::from(board.image.ram_bytes).saturating_sub(head_room.ram_bytes);
    [
        BudgetLine::new(
            &format!("{name}: flash, bytes"),
            head_room.flash_limit(board),
            image.flash,
        ),
        BudgetLine::new(
            &format!("{name}: RAM, bytes, of which static {static_ram}"),
            ram_limit,
            ram,
        ),
    ]
}

/// The stack of a board, of which the emulated one has used `high_water`, and the calls of its own image take `calls`.
fn stack_line(board: &Board, high_water: u64, calls: u64) -> BudgetLine {
    let name = format!("{}: stack, bytes; deepest calls {calls}", board.name);
    BudgetLine::new(&name, board.image.stack_bytes.into(), needed_stack(high_water, calls))
}

/// The stack that is needed: what was measured and a quarter, for what the campaigns did not meet, or the deepest
/// calls, which begin with `main`, and 1 KiB for methods of `dyn` objects that they end with, such as those that format
/// the message of a panic. An interrupt of a chip takes up to 1 KiB, with the report of a panic and what the chip
/// itself saves; all have one priority, so only a fault or an NMI may interrupt it, with up to 0.8 KiB: 2 KiB together.
fn needed_stack(high_water: u64, calls: u64) -> u64 {
    (high_water + high_water.div_ceil(4)).max(calls + 1024) + 2048
}

/// The limits of `tests/budgets.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Budgets {
    head_room: HeadRoom,
    stack: StackBudget,
    instructions: BTreeMap<String, u64>,
}

/// What an image leaves free.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HeadRoom {
    /// Percent of the flash that the linker may fill beside the store.
    flash_percent: u64,
    /// Bytes of RAM beside the stack.
    ram_bytes: u64,
}

impl HeadRoom {
    /// Most bytes of flash that the image of a board may take.
    fn flash_limit(self, board: &Board) -> u64 {
        let hole = board.hole().map_or(0, |store| store.len() as u64);
        let beside_the_store = board.image_flash().len() as u64 - hole;
        let free = (beside_the_store * self.flash_percent).div_ceil(100);
        (board.code_flash().len() as u64).saturating_sub(free)
    }
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
struct BudgetLine {
    name: String,
    budget: u64,
    measured: u64,
}

impl BudgetLine {
    fn new(name: &str, budget: u64, measured: u64) -> Self {
        Self { name: name.to_owned(), budget, measured }
    }

    fn exceeded(&self) -> bool {
        self.measured > self.budget
    }
}

fn table(lines: &[BudgetLine]) -> Table {
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

#[cfg(test)]
mod tests {
    use super::*;
    use massline_protocol::message::STEP_LIMIT_MS;

    #[test]
    fn a_budget_is_exceeded_from_the_next_byte_on() {
        assert!(!BudgetLine::new("", 10, 10).exceeded());
        assert!(BudgetLine::new("", 10, 11).exceeded());
    }

    #[test]
    fn a_chip_needs_more_stack_than_the_emulated_board() {
        // 20 001 + 5001 + 2048
        assert_eq!(needed_stack(20_001, 10_000), 27_050);
        assert_eq!(needed_stack(10_000, 20_001), 23_073);
    }

    #[test]
    fn head_room_is_a_part_of_the_flash_beside_the_store() {
        let head_room = HeadRoom { flash_percent: 8, ram_bytes: 2048 };
        let checkout = massline::qemu::checkout().unwrap();
        let limit = |name: &str| {
            let boards = massline_boards::boards(checkout).unwrap();
            head_room.flash_limit(boards.iter().find(|board| board.name == name).unwrap())
        };
        // 448 KiB behind the store, less 8 % of 512 KiB without the store's 48.
        assert_eq!(limit("blackpill-f411"), 0x7_0000 - 38_011);
        // The store is at the end: 92 % of what is before it.
        assert_eq!(limit("nucleo-g474re"), 473_088 - 37_848);
    }

    fn committed() -> Budgets {
        Budgets::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../budgets.toml")).unwrap()
    }

    /// Checks each computation that the firmware does between two polls of scans, link and panel.
    #[test]
    fn no_step_of_the_rig_takes_longer_than_its_deadline() {
        const STEPS: [&str; 10] = [
            "hit_step",
            "hit_grading",
            "dof_closing",
            "irm_solve",
            "ml_learn_step_12",
            "further_hit_step_12",
            "layout_check",
            "record_checksum",
            "rest_statistics",
            "self_test_channel",
        ];
        // A slow board: 84 MHz and two cycles per instruction, including flash wait states.
        let milliseconds = |instructions: u64| 2 * instructions / 84_000;
        let budgets = committed().instructions;
        for step in STEPS {
            assert!(milliseconds(budgets[step]) < STEP_LIMIT_MS, "{step}");
        }
    }

    #[test]
    fn the_committed_budgets_are_read() {
        let budgets = committed();
        assert!(budgets.instructions.contains_key("hit_analysis"));
    }
}
