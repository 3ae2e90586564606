//! The nets of a rig, from the facts: `boards/parts.toml` and a board's wiring.

use std::collections::{BTreeMap, BTreeSet};

use massline_boards::Wiring;

use crate::source::{DrawnBoard, Netlist, Parts};

/// Name of each net, with its pins as `part.pin`.
pub type Nets = BTreeMap<String, BTreeSet<String>>;

/// All nets of a rig with this board.
pub fn nets(parts: &Parts, board: &DrawnBoard) -> Nets {
    let mut connections = pins(parts, board);
    connections.extend(board_pins(&board.wiring));
    let mut nets = Nets::new();
    for (pin, net) in connections {
        nets.entry(net).or_default().insert(pin);
    }
    nets
}

/// The nets that lead nowhere, because they have one pin.
pub fn unconnected(nets: &Nets) -> Vec<&str> {
    nets.iter().filter(|(_, pins)| pins.len() < 2).map(|(net, _)| net.as_str()).collect()
}

/// What the placeholders of a sensor stand for.
pub fn of_sensor(text: &str, number: usize) -> String {
    let first = 3 * number - 2;
    let values = [
        ("{n}", number),
        ("{j}", number + 1),
        ("{x}", first),
        ("{y}", first + 1),
        ("{z}", first + 2),
    ];
    values
        .iter()
        .fold(text.to_owned(), |text, (name, value)| text.replace(name, &value.to_string()))
}

/// The net that the board's regulator gets.
pub fn raw(wiring: &Wiring) -> &str {
    wiring.power.raw.as_deref().unwrap_or("VSYS")
}

fn pins(parts: &Parts, board: &DrawnBoard) -> Vec<(String, String)> {
    let wiring = &board.wiring;
    let rail = |net: &str| {
        net.replace("{supply}", &wiring.supply)
            .replace("{sensors}", wiring.sensor_rail())
            .replace("{raw}", raw(wiring))
    };
    let mut connections = Vec::new();
    let mut add = |netlist: &Netlist, name: &dyn Fn(&str) -> String| {
        for (part, pins) in netlist {
            for (pin, net) in pins {
                connections.push((format!("{}.{pin}", name(part)), rail(&name(net))));
            }
        }
    };
    add(&parts.netlist, &str::to_owned);
    for number in 1..=parts.sensor.count {
        add(&parts.sensor.netlist, &|text| of_sensor(text, number));
    }
    connections
}

/// The pins of the board and of its converter.
fn board_pins(wiring: &Wiring) -> Vec<(String, String)> {
    let mut connections = Vec::new();
    let mut pin = |part: &str, pin: &str, net: &str| {
        connections.push((format!("{part}.{pin}"), net.to_owned()))
    };
    let inputs = if wiring.adc.is_some() { "U8" } else { "M1" };
    for (number, name) in wiring.channels.iter().enumerate() {
        pin(inputs, name, &format!("CH{number}"));
    }
    let (screen, buttons) = (&wiring.screen, &wiring.buttons);
    for (name, net) in [
        (&wiring.supply, wiring.supply.as_str()),
        (&"GND".to_owned(), "GND"),
        (&screen.scl, "SCL"),
        (&screen.sda, "SDA"),
        (&buttons.ok, "OK"),
        (&buttons.back, "BACK"),
        (&buttons.next, "NEXT"),
        (&wiring.buzzer, "TONE"),
        (&wiring.power.battery, "VSYS"),
    ] {
        pin("M1", name, net);
    }
    if let Some(name) = &wiring.power.raw {
        pin("M1", name, raw(wiring));
    }
    for name in &wiring.grounded {
        pin("M1", name, "GND");
    }
    for (row, name) in wiring.pulled_down.iter().enumerate() {
        let (resistor, net) = (pull_down(row), format!("{name} pulled down"));
        pin("M1", name, &net);
        pin(&resistor, "1", &net);
        pin(&resistor, "2", "GND");
    }
    let Some(adc) = &wiring.adc else { return connections };
    let (supply, reference) = (wiring.supply.as_str(), wiring.sensor_rail());
    for [name, other] in &adc.wires {
        pin("U8", name, name);
        pin("M1", other, name);
    }
    for (name, net) in [(&adc.supply, supply), (&adc.reference, reference), (&adc.ground, "GND")] {
        pin("U8", name, net);
    }
    for name in &adc.joined {
        pin("U8", name, "joined");
    }
    for (name, net) in [("IN", supply), ("OUT", reference), ("GND", "GND")] {
        pin("U9", name, net);
    }
    for [name, place] in &adc.capacitors {
        pin(name, "1", if adc.reference.contains(place) { reference } else { supply });
        pin(name, "2", "GND");
    }
    connections
}

/// The resistor at a pin that is pulled down.
pub fn pull_down(row: usize) -> String {
    format!("R{}", 6 + row)
}
