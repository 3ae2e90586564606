//! The drawings of `boards/BRING-UP.md`: where to put the probes, how to turn a sensor, how to reach the boot loader.

use crate::figures::VOLT_PER_G;
use crate::pen::{Align, Pen, Sheet};
use crate::trace::Point;

/// Files of the drawings, in `boards/bring-up`.
pub const FILES: [&str; 4] = ["power.svg", "channel.svg", "tilt.svg", "uart.svg"];

/// Supply of the sensors, V: of most boards, and of the one with a reference.
const SUPPLIES: [f64; 2] = [3.3, 3.0];

/// The drawings, in the order of the files.
pub fn drawings() -> [Sheet; 4] {
    [power(), channel(), tilt(), uart()]
}

/// A numbered place for the red probe, above its point, with what the meter shows.
fn probe(pen: &mut Pen, (x, y): Point, number: u32, reading: &str) {
    pen.add(format_args!(
        "<g stroke=\"#b3261e\"><path d=\"M{x},{y} l-5,-18 l10,0 z\" fill=\"#b3261e\"/><path d=\"M{x},{0} l0,-14\"/></g>",
        y - 18
    ));
    pen.circle((x, y - 42), 10, "#ffffff");
    pen.text((x, y - 38), 12, Align::Middle, &number.to_string());
    pen.text((x, y - 58), 12, Align::Middle, reading);
}

/// A box with lines of text in its middle.
fn block(pen: &mut Pen, (x, y): Point, (width, height): (i32, i32), lines: &[&str]) {
    pen.part((x, y), (width, height));
    let first = y + height / 2 + 4 - 8 * (lines.len() as i32 - 1);
    for (line, text) in (0..).zip(lines) {
        pen.text((x + width / 2, first + 16 * line), 12, Align::Middle, text);
    }
}

/// The black probe, on ground.
fn black(pen: &mut Pen, (x, y): Point, text: &str) {
    pen.line(&[(x, y - 12), (x, y)]);
    for (down, half) in [(0, 9), (4, 6), (8, 3)] {
        pen.line(&[(x - half, y + down), (x + half, y + down)]);
    }
    pen.text((x + 20, y + 6), 12, Align::Left, text);
}

fn power() -> Sheet {
    let mut pen = Pen::new(1000, 230);
    let y = 130;
    let boxes: [(i32, i32, &[&str]); 6] = [
        (30, 90, &["BT1", "cell"]),
        (200, 100, &["M2", "charger"]),
        (380, 70, &["S4", "switch"]),
        (500, 70, &["U5"]),
        (650, 110, &["board:", "5V, E5V", "or VSYS"]),
        (850, 120, &["sensors,", "followers"]),
    ];
    for (x, width, lines) in boxes {
        block(&mut pen, (x, y - 30), (width, 60), lines);
    }
    for pair in boxes.windows(2) {
        pen.line(&[(pair[0].0 + pair[0].1, y), (pair[1].0, y)]);
    }
    for (x, number, reading) in [
        (160, 1, "3.5 to 4.2 V"),
        (340, 2, "as 1"),
        (610, 3, "20 mV below 2"),
        (805, 4, "3.2 to 3.4 V"),
    ] {
        probe(&mut pen, (x, y), number, reading);
    }
    pen.line(&[(610, y), (610, 195), (650, 195)]);
    block(&mut pen, (650, 175), (60, 40), &["U6"]);
    pen.line(&[(710, 195), (850, 195)]);
    block(&mut pen, (850, 175), (120, 40), &["DS1 screen"]);
    pen.text((780, 212), 12, Align::Middle, "5: 3.2 to 3.4 V");
    black(&mut pen, (245, 195), "black probe: a GND pin of the board, all the time");
    pen.finish()
}

fn channel() -> Sheet {
    let mut pen = Pen::new(1000, 210);
    let y = 120;
    let boxes: [(i32, i32, &[&str]); 5] = [
        (30, 110, &["A1", "ADXL326"]),
        (250, 90, &["U1A", "follower"]),
        (430, 70, &["R11", "100 Ω"]),
        (570, 110, &["P1 to J2", "contact 2"]),
        (800, 150, &["input", "of the board"]),
    ];
    for (x, width, lines) in boxes {
        block(&mut pen, (x, y - 28), (width, 56), lines);
    }
    for pair in boxes.windows(2) {
        pen.line(&[(pair[0].0 + pair[0].1, y), (pair[1].0, y)]);
    }
    let rest = format!("{:.2} V", SUPPLIES[0] / 2.0);
    for (x, number, reading) in [(195, 6, "do not probe"), (385, 7, &*rest), (740, 8, &*rest)] {
        probe(&mut pen, (x, y), number, reading);
    }
    pen.text((195, y + 18), 11, Align::Middle, "C11");
    pen.text((740, y + 18), 11, Align::Middle, "C41");
    let tolerance = format!(
        "{:.2} V at {} V, {:.2} V at {} V; level axes: x, y ±0.17 V, z ±0.33 V by the data sheet",
        SUPPLIES[0] / 2.0,
        SUPPLIES[0],
        SUPPLIES[1] / 2.0,
        SUPPLIES[1]
    );
    pen.text((30, 190), 12, Align::Left, &tolerance);
    pen.finish()
}

fn tilt() -> Sheet {
    let mut pen = Pen::new(1000, 220);
    for (number, (name, turn, sign)) in (0..).zip([
        ("axis up", (0, -1), "+"),
        ("axis level", (1, 0), ""),
        ("axis down", (0, 1), "−"),
    ]) {
        let (x, y) = (150 + 330 * number, 90);
        pen.part((x - 34, y - 24), (68, 48));
        let (dx, dy): (i32, i32) = turn;
        let tip = (x + 62 * dx, y + 52 * dy);
        pen.line(&[(x, y), tip]);
        pen.line(&[(tip.0 - 7 * (dx + dy), tip.1 - 7 * (dx + dy)), tip]);
        pen.line(&[(tip.0 - 7 * (dx - dy), tip.1 - 7 * (dy - dx)), tip]);
        pen.text((x + 46, y - 30), 12, Align::Left, name);
        let reading = |supply: f64| {
            let volt = VOLT_PER_G / 3.0 * supply * 1e3;
            match sign {
                "" => format!("{:.2} V", supply / 2.0),
                sign => format!("{:.2} V {sign} {volt:.0} mV", supply / 2.0),
            }
        };
        pen.text((x, 176), 12, Align::Middle, &reading(SUPPLIES[0]));
        let other = format!("{} (Pico 2)", reading(SUPPLIES[1]));
        pen.text((x, 196), 12, Align::Middle, &other);
    }
    pen.finish()
}

fn uart() -> Sheet {
    let mut pen = Pen::new(1000, 210);
    block(&mut pen, (60, 40), (220, 140), &["USB-to-serial adapter", "3.3 V levels"]);
    block(&mut pen, (620, 40), (220, 140), &["Black Pill", "BOOT0 held at the reset"]);
    for (y, from, to) in [(65, "RXD", "PA9 (TX)"), (110, "TXD", "PA10 (RX)"), (155, "GND", "GND")] {
        pen.line(&[(280, y), (620, y)]);
        pen.text((290, y - 6), 12, Align::Left, from);
        pen.text((610, y - 6), 12, Align::Right, to);
    }
    pen.text(
        (450, 198),
        12,
        Align::Middle,
        "the Black Pill on its battery or a power bank, not on a computer: USB comes first",
    );
    pen.finish()
}
