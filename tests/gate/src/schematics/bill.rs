//! Writes `boards/PARTS.md`: parts with prices, what the values give, currents, contacts of the cables.

use std::fmt::Write;

use massline_boards::Part;

use crate::circuit::of_sensor;
use crate::figures::{Figures, figures};
use crate::source::{Cable, DrawnBoard, Parts};

const HEAD: &str = "\
# Parts, figures, contacts

Made from [`parts.toml`](parts.toml) and each board's `board.toml` by
`cargo run -p massline-gate --bin massline-schematics`; a test compares. **Nobody has built a rig yet:** figures are
computed from values and data sheets ([`figures.rs`](../tests/gate/src/schematics/figures.rs)).

";

const PRICES: &str = "\
## Bill of materials

A whole rig with battery and screen; without hammer, USB cables and solder. **Prices are assumptions** for single pieces,
with VAT, without shipping: no shop was asked. Numbers are those of the makers, or an example of the kind.

### Every rig

";

/// The page.
///
/// # Errors
/// When a value has no unit.
pub fn page(parts: &Parts, boards: &[DrawnBoard]) -> anyhow::Result<String> {
    let figures =
        boards.iter().map(|board| figures(parts, board)).collect::<Result<Vec<_>, _>>()?;
    let mut page = HEAD.to_owned();
    let revision = &parts.revision;
    writeln!(page, "Revision {} of {}, {}.\n", revision.name, revision.date, revision.state)?;
    prices(&mut page, parts, boards, &figures)?;
    values(&mut page, boards, &figures)?;
    currents(&mut page, parts, boards)?;
    contacts(&mut page, parts, boards)?;
    Ok(page)
}

fn prices(
    page: &mut String,
    parts: &Parts,
    boards: &[DrawnBoard],
    figures: &[Figures],
) -> std::fmt::Result {
    *page += PRICES;
    let common = table(page, parts, &parts.part)?;
    for (board, figures) in boards.iter().zip(figures) {
        writeln!(page, "### {}\n", board.title)?;
        let own = table(page, parts, &board.wiring.part)?;
        writeln!(
            page,
            "With the parts of every rig **{:.2} €**: {common:.2} € + {own:.2} €.\n",
            figures.euro
        )?;
    }
    Ok(())
}

/// Returns the sum, euro.
fn table(page: &mut String, parts: &Parts, lines: &[Part]) -> Result<f64, std::fmt::Error> {
    *page += "| pieces | part | designators | number | each, € | € |\n| --- | --- | --- | --- | --- | --- |\n";
    let (sensors, mut sum) = (parts.sensor.count, 0.0);
    for part in lines {
        let (count, each) = (part.count(sensors), f64::from(part.cents) / 100.0);
        let maker = if part.maker == "any" { String::new() } else { format!("{} ", part.maker) };
        let refs = in_order(part.designators(sensors)).join(", ");
        let price = each * f64::from(count);
        let (description, number) = (&part.what, &part.number);
        writeln!(
            page,
            "| {count} | {description} | {refs} | {maker}{number} | {each:.2} | {price:.2} |"
        )?;
        sum += price;
    }
    writeln!(page, "| | **sum** | | | | **{sum:.2}** |\n")?;
    Ok(sum)
}

/// Designators by their numbers.
fn in_order(mut names: Vec<String>) -> Vec<String> {
    let number =
        |name: &String| name.trim_start_matches(|c: char| !c.is_ascii_digit()).parse::<u32>().ok();
    names.sort_by_key(number);
    names
}

fn values(page: &mut String, boards: &[DrawnBoard], figures: &[Figures]) -> std::fmt::Result {
    let Some(first) = figures.first() else { return Ok(()) };
    *page += "## What the values give\n\n| figure | value | limit |\n| --- | --- | --- |\n";
    let mg = |g: f64| format!("{:.2} mg rms", g * 1e3);
    let rows = [
        (
            "1 pF from mains (230 V, 50 Hz) to a wire of a sensor's cable, through 100 Ω",
            mg(first.mains),
            "1 mg",
        ),
        ("the same without a follower at the sensor, through 32 kΩ", mg(first.mains_before), ""),
        (
            "mains wire 0.1 m from the 10 mm between sensor and follower",
            mg(first.mains_at_sensor),
            "1 mg",
        ),
        (
            "ripple of the screen, on its own regulator (1 Ω at its input, 40 dB in the board's regulator)",
            mg(first.ripple),
            "1 mg",
        ),
        ("the same with the screen on the board's 3V3 (0.5 Ω)", mg(first.ripple_before), ""),
        (
            "phase margin of a follower with 100 Ω, 1 m of cable and 10 nF",
            format!("{:.0}°", first.phase_margin),
            "45°",
        ),
        (
            "delay of 100 Ω and 10 nF, in all channels alike",
            format!("{:.1} µs", first.delay * 1e6),
            "",
        ),
        (
            "what a channel keeps of the one before it, 15 pF to 10 nF",
            format!("{:.2} %", first.kept * 100.0),
            "0.2 %",
        ),
        ("largest current of the buzzer's pin", format!("{:.1} mA", first.buzzer * 1e3), "4 mA"),
    ];
    for (figure, value, limit) in rows {
        writeln!(page, "| {figure} | {value} | {limit} |")?;
    }
    *page += "\n| board | current from the cell | until 3.5 V |\n| --- | --- | --- |\n";
    for (board, figures) in boards.iter().zip(figures) {
        let (title, ma) = (&board.title, figures.current * 1e3);
        writeln!(page, "| {title} | {ma:.0} mA | {:.0} h |", figures.hours)?;
    }
    *page += "\n";
    Ok(())
}

fn currents(page: &mut String, parts: &Parts, boards: &[DrawnBoard]) -> anyhow::Result<()> {
    let cell = &parts.cell;
    writeln!(
        page,
        "Of the {} mAh of the cell {} % are counted on: an old one in the cold, down to 3.5 V, where the regulators of\n\
         3.3 V end. Mean currents, by data sheet or, for boards and screen, assumed on the high side:\n",
        cell.milliamp_hours, cell.usable_percent
    )?;
    *page += "| part | mA |\n| --- | --- |\n";
    let mut all_parts: Vec<&Part> = boards.iter().flat_map(|board| &board.wiring.part).collect();
    all_parts.extend(&parts.part);
    for part in all_parts.iter().filter(|part| part.microamps > 0) {
        let count = part.count(parts.sensor.count);
        let ma = f64::from(count * part.microamps) / 1e3;
        writeln!(page, "| {count} × {} | {ma} |", part.number)?;
    }
    for board in boards {
        if let Some(percent) = board.wiring.power.efficiency_percent {
            let title = &board.title;
            writeln!(
                page,
                "\nThe {title} converts with {percent} %; the others pass the current on."
            )?;
        }
    }
    *page += "\n";
    Ok(())
}

fn contacts(page: &mut String, parts: &Parts, boards: &[DrawnBoard]) -> std::fmt::Result {
    *page += "## Contacts\n\n";
    for cable in &parts.cable {
        let numbers = if cable.name.contains("{j}") { 1..=parts.sensor.count } else { 0..=0 };
        for number in numbers {
            contact(page, boards, cable, number)?;
        }
    }
    Ok(())
}

/// The contacts of a cable; `sensor` is 0 if it is that of no sensor.
fn contact(
    page: &mut String,
    boards: &[DrawnBoard],
    cable: &Cable,
    sensor: usize,
) -> std::fmt::Result {
    let name = |text: &str| if sensor > 0 { of_sensor(text, sensor) } else { text.to_owned() };
    let ends = cable.ends.iter().map(|end| name(end)).collect::<Vec<_>>().join(" to ");
    writeln!(page, "**{}**, {}: {ends}\n", name(&cable.name), name(&cable.what))?;
    let titles: Vec<_> = boards.iter().map(|board| board.title.as_str()).collect();
    let at_boards = sensor > 0;
    match at_boards {
        true => writeln!(
            page,
            "| contact | | {} |\n| --- | --- |{}",
            titles.join(" | "),
            " --- |".repeat(boards.len())
        )?,
        false => writeln!(page, "| contact | |\n| --- | --- |")?,
    }
    for wire in &cable.wires {
        write!(page, "| {} | {} |", wire[0], wire[1])?;
        for board in boards.iter().filter(|_| at_boards) {
            write!(page, " {} |", crate::power::goes_to(&board.wiring, &wire[0], sensor))?;
        }
        *page += "\n";
    }
    *page += "\n";
    Ok(())
}
