//! The program with a virtual rig at a TCP address.

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::program::{answer, layout_with_hits, run_json};
use crate::virtual_process::VirtualProcess;

/// A fast virtual rig at a free port of this computer.
fn rig() -> VirtualProcess {
    VirtualProcess::start(&["--fast", "--tcp", "127.0.0.1:0"])
}

fn code(answer: &Value) -> &str {
    answer["error"]["code"].as_str().unwrap_or_default()
}

#[test]
fn a_campaign_over_tcp_gives_what_a_campaign_over_a_pty_gives() {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 3);
    let measure = |rig: &VirtualProcess| {
        let (exit, measured) = answer(&["measure", &layout, "--port", &rig.port]);
        assert_eq!(exit, 0, "{measured}");
        measured["results"].clone()
    };
    let rig = rig();
    assert!(rig.port.starts_with("tcp://127.0.0.1:"), "{}", rig.port);
    let over_tcp = measure(&rig);
    // The ideal bench has no errors of placement: 1.23 kg within the scatter of three hits.
    let mass = over_tcp[0]["mass_kg"]["value"].as_f64().unwrap();
    assert!((mass / 1.23 - 1.0).abs() < 0.01, "{mass}");
    assert_eq!(over_tcp, measure(&VirtualProcess::start(&["--fast"])));
    // The next client has the same rig.
    let (exit, list) = answer(&["results", "list", "--port", &rig.port]);
    assert_eq!((exit, list["results"].as_array().unwrap().len()), (0, 1));
}

#[test]
fn the_json_of_a_rig_has_its_address() {
    let rig = VirtualProcess::start(&["--tcp", "localhost:0", "--json"]);
    let started: Value = serde_json::from_str(&rig.port).unwrap();
    let port = started["port"].as_str().unwrap();
    assert_eq!(answer(&["device", "identify", "--port", port]).0, 0);
}

#[test]
fn a_second_client_waits_until_the_first_has_left_and_then_gives_up() {
    let rig = rig();
    let first = std::net::TcpStream::connect(rig.port.strip_prefix("tcp://").unwrap()).unwrap();
    let (refused, error) = run_json(&["device", "identify", "--port", &rig.port]);
    assert_eq!((refused.exit, code(&error)), (4, "port_busy"), "{error}");
    assert!(refused.says("is in use by another program; waiting"), "{}", refused.stderr);

    let leaves = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(1));
        drop(first);
    });
    assert_eq!(answer(&["device", "identify", "--port", &rig.port]).0, 0);
    leaves.join().unwrap();
}

#[test]
fn a_rig_that_ends_is_a_lost_link() {
    let folder = tempfile::tempdir().unwrap();
    let layout = layout_with_hits(folder.path(), 3);
    let mut rig = VirtualProcess::start(&["--tcp", "127.0.0.1:0"]);
    let port = rig.port.clone();
    let measure = std::thread::spawn(move || answer(&["measure", &layout, "--port", &port]));
    // In real time nine hits take longer than this.
    std::thread::sleep(Duration::from_secs(2));
    rig.process.kill().unwrap();
    let (exit, lost) = measure.join().unwrap();
    assert_eq!((exit, code(&lost)), (4, "link_lost"), "{lost}");
}

#[test]
fn an_address_where_nobody_answers_is_an_error_within_seconds() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let free = format!("tcp:{}", listener.local_addr().unwrap());
    drop(listener);
    // 192.0.2.0/24 is reserved for documentation: no host has such an address.
    for port in [free.as_str(), "tcp://192.0.2.1:4000", "tcp://no-such-host.invalid:4000"] {
        let started = Instant::now();
        let (exit, error) = answer(&["device", "identify", "--port", port]);
        assert_eq!((exit, code(&error)), (4, "unreachable"), "{error}");
        assert!(started.elapsed() < Duration::from_secs(20), "{port}: {:?}", started.elapsed());
    }
}

#[test]
fn an_address_that_others_can_reach_is_warned_of() {
    let mut process = Command::new(env!("CARGO_BIN_EXE_massline"))
        .args(["virtual", "--bench", "ideal", "--tcp", "0.0.0.0:0"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(process.stderr.take().unwrap()).lines();
    // The port is named last.
    let printed: Vec<_> =
        lines.map_while(Result::ok).take_while(|line| !line.contains("--port")).collect();
    process.kill().unwrap();
    process.wait().unwrap();
    let warning = "this rig answers anybody who can reach tcp://0.0.0.0:";
    assert!(printed.iter().any(|line| line.contains(warning)), "{printed:?}");
}

#[test]
fn a_malformed_address_is_named() {
    for port in ["tcp:", "tcp://127.0.0.1", "tcp://:4000", "tcp://127.0.0.1:99999"] {
        let (exit, error) = answer(&["device", "identify", "--port", port]);
        assert_eq!((exit, code(&error)), (2, "bad_address"), "{error}");
        assert!(error["error"]["message"].as_str().unwrap().contains("tcp://HOST:PORT"), "{error}");
    }
    for address in ["4000", "127.0.0.1:99999", "192.0.2.1:0"] {
        let (exit, error) = answer(&["virtual", "--tcp", address]);
        assert_eq!((exit, code(&error)), (2, "cannot_listen"), "{error}");
    }
}
