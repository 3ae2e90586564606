//! A test has one answer: what the commands say of it are the same numbers everywhere.

use std::fs;

use serde_json::Value;

use crate::program::{data, run, success, text};

const SYMBOLS: [&str; 10] =
    ["m", "c_x", "c_y", "c_z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz"];

/// The words of the row of a property in a table.
#[track_caller]
fn row<'t>(table: &'t str, symbol: &str) -> Vec<&'t str> {
    let rows = table.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut found = rows.filter(|words| words.first() == Some(&symbol));
    found.next().unwrap_or_else(|| panic!("{symbol}: {table}"))
}

/// Text without markup, a word for each cell, with the minus sign of a keyboard.
fn cells(page: &str) -> Vec<String> {
    let parts = page.split('<').filter_map(|part| Some(part.split_once('>')?.1.trim()));
    parts.filter(|cell| !cell.is_empty()).map(|cell| cell.replace('−', "-")).collect()
}

#[test]
fn text_page_and_exports_of_an_archive_state_equal_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("archive/version-1.massline"));
    let answer = success(&["solve", &archive])["results"][0].clone();
    let kept: Value = serde_json::from_str(&fs::read_to_string(&archive).unwrap()).unwrap();
    assert_eq!(kept["answers"]["results"][0], answer);
    let brief = run(&["solve", &archive]);
    assert_eq!(brief.exit, 0, "{}", brief.stderr);
    let page = text(&folder.path().join("page.html"));
    success(&["report", &archive, "-o", &page]);
    let page = cells(&fs::read_to_string(&page).unwrap());
    let csv = run(&["export", &archive, "--format", "csv"]).stdout;
    let json: Value =
        serde_json::from_str(&run(&["export", &archive, "--format", "json"]).stdout).unwrap();
    assert_eq!(json["method"], answer["method"]);
    assert_eq!(json["mass"], answer["mass_kg"]["value"]);
    assert_eq!(json["center_of_mass"], answer["center_of_mass_m"]["value"]);
    assert_eq!(json["inertia"], answer["inertia_kg_m2"]["value"]);
    for (k, symbol) in SYMBOLS.into_iter().enumerate() {
        let said = row(&brief.stdout, symbol);
        // The symbol stands in two cells of the page, c and x, before its name, its value and half its interval.
        let (letter, index) = symbol.split_once('_').unwrap_or((symbol, ""));
        let place = (0..page.len()).find(|&at| {
            let parts = [letter, index].into_iter().filter(|part| !part.is_empty());
            parts.enumerate().all(|(n, part)| page.get(at + n).is_some_and(|cell| cell == part))
                && page[at..]
                    .iter()
                    .take(4)
                    .any(|cell| cell.contains("mass") || cell.contains("inertia"))
        });
        let after = place.map(|at| &page[at..]).unwrap_or_else(|| panic!("{symbol}: {page:?}"));
        let numbers: Vec<_> = after.iter().filter(|cell| cell.parse::<f64>().is_ok()).collect();
        assert_eq!((numbers[0].as_str(), numbers[1].as_str()), (said[1], said[2]), "{symbol}");

        let value = json["value"][k].as_f64().unwrap();
        let of_csv = csv.lines().find(|line| line.starts_with(&format!("{symbol},"))).unwrap();
        let of_csv: Vec<f64> =
            of_csv.split(',').skip(1).take(4).map(|n| n.parse().unwrap()).collect();
        let [low, high] = [&json["low95"], &json["high95"]].map(|ends| ends[k].as_f64().unwrap());
        assert_eq!((of_csv[0], of_csv[2], of_csv[3]), (value, low, high), "{symbol}");
        assert_eq!(answer["interval95"][symbol], serde_json::json!([low, high]), "{symbol}");
        // The text rounds to its last digit, in mm and g m².
        let factor = if k == 0 { 1.0 } else { 1e3 };
        for (shown, exact) in [(said[1], value), (said[2], (high - low) / 2.0)] {
            let decimals = shown.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let rounded = format!("{:.decimals$}", exact * factor);
            assert_eq!(shown, rounded, "{symbol}");
        }
    }
}
