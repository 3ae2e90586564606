//! Holds the drawings of a board against the nets of the facts, and looks for texts that cannot be read.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, bail, ensure};

use crate::circuit::{Nets, nets, of_sensor, unconnected};
use crate::pen::Sheet;
use crate::source::{DrawnBoard, Parts};
use crate::trace::{Point, Trace};

/// Checks facts and drawings of a board.
///
/// # Errors
/// The first net, pin, part or text that is wrong.
pub fn check(parts: &Parts, board: &DrawnBoard, sheets: &[Sheet]) -> anyhow::Result<()> {
    let wanted = nets(parts, board);
    facts(parts, board, &wanted)?;
    drawing(board, sheets, &wanted)?;
    sheets.iter().try_for_each(legible)
}

/// Checks that every net leads somewhere, every part has a line in the bill of materials, every contact of a cable is
/// at the same net at both ends, and no pin of the board has two uses.
fn facts(parts: &Parts, board: &DrawnBoard, wanted: &Nets) -> anyhow::Result<()> {
    if let [net, ..] = unconnected(wanted)[..] {
        bail!("the net {net} leads nowhere: {:?}", wanted[net]);
    }
    let mut net_of = BTreeMap::new();
    for (net, pins) in wanted {
        for pin in pins {
            if let Some(other) = net_of.insert(pin.as_str(), net) {
                bail!("{pin} is in the nets {net} and {other}");
            }
        }
    }
    let mut bill = BTreeSet::new();
    for name in parts.bill(board).flat_map(|part| part.designators(parts.sensor.count)) {
        ensure!(bill.insert(name.clone()), "{name} is twice in the bill of materials");
    }
    let connected = |name: &&str| !name.starts_with('P');
    let used: BTreeSet<_> =
        net_of.keys().filter_map(|pin| pin.split('.').next()).filter(connected).collect();
    let bill: BTreeSet<_> = bill.iter().map(String::as_str).collect();
    let missing: Vec<_> = used.symmetric_difference(&bill).collect();
    ensure!(missing.is_empty(), "in the netlist or in the bill of materials only: {missing:?}");
    let mut labels = BTreeSet::new();
    for (pin, label) in &board.wiring.connector {
        ensure!(labels.insert(label), "{label}, of {pin}, is twice on the header");
    }
    cables(parts, &net_of)
}

/// Checks that the wires of each cable join the same net at both ends, and that each contact has one wire.
fn cables(parts: &Parts, net_of: &BTreeMap<&str, &String>) -> anyhow::Result<()> {
    for cable in &parts.cable {
        let sensors = if cable.name.contains("{j}") { parts.sensor.count } else { 1 };
        for sensor in 1..=sensors {
            let name = |text: &str| of_sensor(text, sensor);
            let net = |end: usize, contact: &str| {
                let pin = format!("{}.{contact}", name(&cable.ends[end]));
                net_of.get(pin.as_str()).copied().with_context(|| format!("{pin} has no net"))
            };
            let mut contacts = BTreeSet::new();
            for wire in &cable.wires {
                let (contact, here) = (&wire[0], net(0, &wire[0])?);
                if cable.ends.len() > 1 {
                    let other = net(1, wire.get(2).unwrap_or(contact))?;
                    let name = name(&cable.name);
                    ensure!(here == other, "{name}: {contact} joins {here} and {other}");
                }
                ensure!(contacts.insert(contact), "{}: {contact} twice", name(&cable.name));
            }
            let end = format!("{}.", name(&cable.ends[0]));
            let pin_count = net_of.keys().filter(|pin| pin.starts_with(&end)).count();
            ensure!(pin_count == contacts.len(), "{}: a contact without a wire", name(&cable.name));
        }
    }
    Ok(())
}

/// Checks that both sheets together draw exactly the nets of the facts, and the pins that belong to the board alone.
pub fn drawing(board: &DrawnBoard, sheets: &[Sheet], wanted: &Nets) -> anyhow::Result<()> {
    let traces: Vec<&Trace> = sheets.iter().map(|sheet| &sheet.trace).collect();
    let drawn: BTreeSet<_> =
        Trace::nets(&traces).map_err(anyhow::Error::msg)?.into_values().collect();
    for (net, pins) in wanted {
        if !drawn.contains(pins) {
            let touching: Vec<_> = drawn.iter().filter(|other| !other.is_disjoint(pins)).collect();
            bail!("{net}: {pins:?} are drawn as {touching:?}");
        }
    }
    let plugs = board.wiring.plug.iter().flat_map(|plug| &plug.pins);
    let own = plugs.chain([&board.wiring.light]).map(|pin| BTreeSet::from([format!("M1.{pin}")]));
    let wanted: BTreeSet<_> = wanted.values().cloned().chain(own).collect();
    let more: Vec<_> = drawn.difference(&wanted).collect();
    ensure!(more.is_empty(), "drawn, but not in the facts: {more:?}");
    Ok(())
}

/// Checks that no text lies on another one or on a wire, and that all are within the sheet.
///
/// # Errors
/// All texts that are not.
pub fn legible(sheet: &Sheet) -> anyhow::Result<()> {
    let covers = |text| format!("a box covers \"{text}\"");
    let mut wrong: Vec<_> = sheet.covered.iter().map(covers).collect();
    for (number, text) in sheet.texts.iter().enumerate() {
        let overlaps = |from: Point, to: Point| {
            text.from.0 < to.0 && from.0 < text.to.0 && text.from.1 < to.1 && from.1 < text.to.1
        };
        let others =
            sheet.texts[number + 1..].iter().filter(|other| overlaps(other.from, other.to));
        wrong.extend(others.map(|other| format!("\"{}\" lies on \"{}\"", text.text, other.text)));
        let crossed = |line: &&[Point; 2]| crosses(**line, text.from, text.to);
        let line = sheet.lines.iter().find(crossed);
        wrong.extend(line.map(|line| format!("the line {line:?} crosses \"{}\"", text.text)));
        if text.from.0 < 0
            || text.from.1 < 0
            || text.to.0 > sheet.size.0
            || text.to.1 > sheet.size.1
        {
            wrong.push(format!("\"{}\" leaves the sheet", text.text));
        }
    }
    ensure!(wrong.is_empty(), "{}", wrong.join("; "));
    Ok(())
}

/// Whether a line enters the inside of a rectangle: what is left of it after each side has cut off what is beyond.
fn crosses([a, b]: [Point; 2], from: Point, to: Point) -> bool {
    let (dx, dy) = (f64::from(b.0 - a.0), f64::from(b.1 - a.1));
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (slope, room) in [
        (-dx, f64::from(a.0 - from.0)),
        (dx, f64::from(to.0 - a.0)),
        (-dy, f64::from(a.1 - from.1)),
        (dy, f64::from(to.1 - a.1)),
    ] {
        if slope == 0.0 {
            if room <= 0.0 {
                return false;
            }
        } else if slope < 0.0 {
            enter = enter.max(room / slope);
        } else {
            leave = leave.min(room / slope);
        }
    }
    enter < leave
}
