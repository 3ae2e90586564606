//! The drawings against the facts, the facts against the firmware and the guides, and that the checks can fail.

use std::collections::BTreeSet;

use massline_boards::wiring::Adc;

use super::*;
use crate::figures::figures;
use crate::trace::Trace;

fn boards() -> Vec<DrawnBoard> {
    let boards = source::boards(&root()).unwrap();
    // The three boards that have a guide.
    assert!(boards.len() >= 3, "{boards:?}");
    boards
}

fn parts() -> Parts {
    source::parts(&root()).unwrap()
}

fn file(board: &DrawnBoard, name: &str) -> String {
    fs::read_to_string(folder(board).join(name)).unwrap()
}

/// What the check says of these facts, drawn.
fn verdict(parts: &Parts, board: &DrawnBoard) -> String {
    let checked = check::check(parts, board, &sheets(parts, board));
    checked.map_or_else(|error| error.to_string(), |()| "right".to_owned())
}

#[test]
fn the_committed_drawings_and_lists_are_those_of_their_sources() {
    let remedy = "run cargo run -p massline-gate --bin massline-schematics, and look at";
    let (parts, boards) = (parts(), boards());
    for board in &boards {
        for (name, sheet) in SHEETS.into_iter().zip(sheets(&parts, board)) {
            assert!(sheet.svg == file(board, name), "{}: {remedy} {name}", board.name);
        }
    }
    for (name, drawing) in guide::FILES.iter().zip(guide::drawings()) {
        let committed = fs::read_to_string(root().join("boards/bring-up").join(name)).unwrap();
        assert!(drawing.svg == committed, "{remedy} boards/bring-up/{name}");
    }
    let page = fs::read_to_string(root().join("boards/PARTS.md")).unwrap();
    assert!(page == bill::page(&parts, &boards).unwrap(), "{remedy} PARTS.md");
}

#[test]
fn the_drawings_connect_what_the_facts_connect_and_can_be_read() {
    for board in &boards() {
        assert_eq!(verdict(&parts(), board), "right", "{}", board.name);
    }
}

/// Every wire of a drawing is needed, but for those from the board to its own sockets and light, and for one of the two
/// grounds of each cable, which has five pieces.
#[test]
fn a_drawing_that_lacks_any_wire_is_found() {
    let (parts, boards) = (parts(), boards());
    let board = boards.iter().find(|board| board.wiring.adc.is_some()).unwrap();
    let own = board.wiring.plug.iter().map(|plug| plug.pins.len()).sum::<usize>() + 1;
    let (wanted, mut unnoticed) = (circuit::nets(&parts, board), 0);
    for sheet in 0..SHEETS.len() {
        let mut sheets = sheets(&parts, board);
        let wires = sheets[sheet].trace.wires.clone();
        for missing in 0..wires.len() {
            sheets[sheet].trace.wires = wires.clone();
            sheets[sheet].trace.wires.remove(missing);
            unnoticed += usize::from(check::drawing(board, &sheets, &wanted).is_ok());
        }
    }
    assert_eq!(unnoticed, own + 2 * 5 * parts.sensor.count);
}

#[test]
fn a_pin_without_a_dot_or_drawn_twice_is_found() {
    let (parts, boards) = (parts(), boards());
    let message_after = |change: &dyn Fn(&mut Trace)| {
        let mut sheets = sheets(&parts, &boards[0]);
        change(&mut sheets[0].trace);
        check::check(&parts, &boards[0], &sheets).unwrap_err().to_string()
    };
    let twice = message_after(&|trace| trace.pin((5, 5), "J2.4".to_owned()));
    assert!(twice.contains("J2.4 is drawn twice"), "{twice}");
    let short = message_after(&|trace| {
        trace.name((7, 7), "SCL");
        trace.name((7, 7), "SDA");
    });
    assert!(short.contains("M1.PB6") && short.contains("M1.PB7"), "{short}");
}

#[test]
fn a_net_that_leads_nowhere_is_named() {
    for (part, pin) in [("J6", "1"), ("U7", "SDA"), ("S4", "2"), ("DS1", "VCC"), ("U6", "VIN")] {
        let mut parts = parts();
        let net = parts.netlist.get_mut(part).unwrap().get_mut(pin).unwrap();
        *net = "elsewhere".to_owned();
        let verdict = verdict(&parts, &boards()[0]);
        assert!(verdict.contains("the net elsewhere leads nowhere"), "{part}.{pin}: {verdict}");
    }
}

#[test]
fn a_pin_of_the_board_with_two_uses_is_named() {
    let mut boards = boards();
    let wiring = &mut boards[0].wiring;
    wiring.buzzer = wiring.buttons.ok.clone();
    let verdict = verdict(&parts(), &boards[0]);
    assert!(verdict.contains("M1.PB12 is in the nets TONE and OK"), "{verdict}");
    let board = boards.iter_mut().find(|board| !board.wiring.connector.is_empty()).unwrap();
    board.wiring.connector.insert("PB6".to_owned(), "D5".to_owned());
    let message = self::verdict(&parts(), board);
    assert!(message.contains("D5, of PB6, is twice on the header"), "{message}");
}

#[test]
fn a_cable_with_crossed_wires_and_a_contact_named_twice_are_found() {
    let mut crossed = parts();
    let socket = crossed.sensor.netlist.get_mut("J{j}").unwrap();
    socket.insert("2".to_owned(), "CH{y}".to_owned());
    socket.insert("3".to_owned(), "CH{x}".to_owned());
    let message = verdict(&crossed, &boards()[0]);
    assert!(message.contains("W2: 2 joins CH2 and CH1"), "{message}");
    let mut twice = parts();
    twice.cable[3].wires[3] = twice.cable[3].wires[2].clone();
    let message = verdict(&twice, &boards()[0]);
    assert!(message.contains("DS1: SCL twice"), "{message}");
    let mut short = parts();
    short.cable[1].wires.pop();
    let message = verdict(&short, &boards()[0]);
    assert!(message.contains("W2: a contact without a wire"), "{message}");
}

#[test]
fn a_part_without_a_line_in_the_bill_of_materials_is_named() {
    let mut parts = parts();
    parts.part.retain(|part| part.refs != ["U7"]);
    let verdict = verdict(&parts, &boards()[0]);
    assert!(verdict.contains("[\"U7\"]"), "{verdict}");
}

/// The limits that the circuit was made for. 1 mg is an eighth of the noise of a sensor, 300 µg/√Hz up to 497 Hz.
#[test]
fn the_values_keep_their_limits() {
    let parts = parts();
    for board in &boards() {
        let figures = figures(&parts, board).unwrap();
        assert!(figures.mains < 1e-3 && figures.mains_at_sensor < 1e-3 && figures.ripple < 1e-3);
        // What the circuit before this one had.
        assert!(figures.mains_before > 0.03 && figures.ripple_before > 1e-3);
        // What an MCP6004 has left at the largest load for which its data sheet states one.
        assert!(figures.phase_margin > 45.0, "{}", figures.phase_margin);
        // `massline calibrate` warns of this memory of the channel before.
        assert!(figures.kept < 0.002);
        // The weakest pins, those of an RP2350 after a reset, drive 4 mA.
        assert!(figures.buzzer < 4e-3);
        assert!(figures.hours > 8.0, "{}: {} h", board.name, figures.hours);
        let limit = if board.name == "blackpill-f411" { 75.0 } else { 100.0 };
        assert!(figures.euro <= limit, "{}: {} €", board.name, figures.euro);
    }
}

#[test]
fn the_guides_state_the_prices_of_the_bill_of_materials() {
    let common = fs::read_to_string(root().join("boards/README.md")).unwrap();
    for board in &boards() {
        let euro = format!("{:.0} €", figures(&parts(), board).unwrap().euro.ceil());
        assert!(file(board, "README.md").contains(&euro), "{}: {euro}", board.name);
        assert!(common.contains(&euro), "{}: {euro}", board.name);
    }
}

#[test]
fn the_guides_state_the_figures() {
    let (parts, boards) = (parts(), boards());
    let read = |name: &str| fs::read_to_string(root().join("boards").join(name)).unwrap();
    let (circuit, power) = (read("README.md"), read("POWER.md"));
    for board in &boards {
        let figures = figures(&parts, board).unwrap();
        for text in [
            format!("**{:.2} mg**", figures.mains * 1e3),
            format!("**{:.0} mg**", figures.mains_before * 1e3),
            format!(" {:.2} mg. Keep", figures.mains_at_sensor * 1e3),
            format!("phase margin {:.0}°", figures.phase_margin),
            format!("{:.2} % of the difference", figures.kept * 1e2),
            format!("takes {:.1} mA at each edge", figures.buzzer * 1e3),
        ] {
            assert!(circuit.contains(&text), "README.md: {text}");
        }
        for text in [
            format!("**{:.2} mg**", figures.ripple * 1e3),
            format!("**{:.1} mg**", figures.ripple_before * 1e3),
            format!(" {:.0} h", figures.hours),
        ] {
            assert!(power.contains(&text), "POWER.md: {text}");
        }
    }
}

#[test]
fn the_wiring_is_that_of_the_firmware() {
    for board in &boards() {
        let (DrawnBoard { name: board, wiring, .. }, code) = (board, file(board, "src/chip.rs"));
        let used: BTreeSet<_> = pins(&code).collect();
        let wired: BTreeSet<_> = wiring.firmware_pins().map(str::to_owned).collect();
        assert_eq!(used, wired, "{board}");
        let order = |from: &str, to: char| {
            let (_, list) = code.split_once(from).unwrap();
            pins(list.split_once(to).unwrap().0).collect::<Vec<_>>()
        };
        let (buttons, screen) = (&wiring.buttons, &wiring.screen);
        match &wiring.adc {
            None => assert_eq!(order("channels: (", ')'), wiring.channels, "{board}"),
            Some(Adc { wires, .. }) => {
                // The firmware's names of the converter's pins.
                let names = [
                    ("SDO", "data_out: "),
                    ("SDI", "data_in: "),
                    ("SCLK", "clock: "),
                    ("CS", "select: "),
                ];
                for ([pin, other], (name, field)) in wires.iter().zip(names) {
                    assert_eq!((pin.as_str(), order(field, ',')), (name, vec![other.clone()]));
                }
            }
        }
        assert_eq!(order("buttons: [", ']'), [&*buttons.ok, &*buttons.back, &*buttons.next]);
        assert_eq!(order("bus: ", '\n'), [&*screen.scl, &*screen.sda]);
        assert_eq!(order("tone: ", ')'), [&*wiring.buzzer]);
        assert_eq!(order("light: ", ','), [&*wiring.light]);
    }
}

#[test]
fn the_guides_name_every_pin() {
    for board in &boards() {
        let guide = file(board, "README.md");
        let power = &board.wiring.power;
        let more = board.wiring.pulled_down.iter().chain([&power.battery]).chain(&power.raw);
        for pin in board.wiring.firmware_pins().chain(more.map(String::as_str)) {
            assert!(guide.contains(pin), "{}: {pin}", board.name);
        }
    }
}

/// The chip's pins that the firmware uses: `p.PA0`, or `p.PIN_16`, which the board labels GP16.
fn pins(code: &str) -> impl Iterator<Item = String> {
    let words = code.split(|c: char| !c.is_ascii_alphanumeric() && c != '.' && c != '_');
    let number = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit());
    words.filter_map(|word| word.strip_prefix("p.P")).filter_map(move |pin| {
        match pin.strip_prefix("IN_") {
            Some(pin) => number(pin).then(|| format!("GP{pin}")),
            None => pin.get(1..).is_some_and(number).then(|| format!("P{pin}")),
        }
    })
}
