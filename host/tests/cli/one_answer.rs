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
    let mut matching_rows = rows.filter(|words| words.first() == Some(&symbol));
    matching_rows.next().unwrap_or_else(|| panic!("{symbol}: {table}"))
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
        let printed = row(&brief.stdout, symbol);
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
        assert_eq!(
            (numbers[0].as_str(), numbers[1].as_str()),
            (printed[1], printed[2]),
            "{symbol}"
        );

        let value = json["value"][k].as_f64().unwrap();
        let of_csv = csv.lines().find(|line| line.starts_with(&format!("{symbol},"))).unwrap();
        let of_csv: Vec<f64> =
            of_csv.split(',').skip(1).take(4).map(|n| n.parse().unwrap()).collect();
        let [low, high] = [&json["low95"], &json["high95"]].map(|ends| ends[k].as_f64().unwrap());
        assert_eq!((of_csv[0], of_csv[2], of_csv[3]), (value, low, high), "{symbol}");
        assert_eq!(answer["interval95"][symbol], serde_json::json!([low, high]), "{symbol}");
        // The text rounds to its last digit, in mm and g m².
        let factor = if k == 0 { 1.0 } else { 1e3 };
        for (shown, exact) in [(printed[1], value), (printed[2], (high - low) / 2.0)] {
            let decimals = shown.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let rounded = format!("{:.decimals$}", exact * factor);
            assert_eq!(shown, rounded, "{symbol}");
        }
    }
}

/// The scatter between hits alone covers the truth in 64 of 100 tests.
#[test]
fn nothing_gives_an_interval_that_covers_the_scatter_alone() {
    let folder = tempfile::tempdir().unwrap();
    let archive = text(&data("archive/version-1.massline"));
    let method = ["--method", "irm"];
    let solved = success(&[&["solve", &archive], &method[..]].concat());
    let answer = &solved["results"][0];
    assert_eq!(answer["method"], "inertia-restraint");
    assert!(answer["mass_kg"]["sigma"].is_number(), "{answer}");
    assert_eq!(
        (&answer["interval95"], &solved["verdict"]),
        (&Value::Null, &"use_with_care".into())
    );
    let brief = run(&[&["solve", &archive], &method[..]].concat()).stdout;
    for symbol in SYMBOLS {
        assert_eq!(row(&brief, symbol)[2], "-", "{brief}");
    }
    let principal = brief.lines().find(|line| line.starts_with("principal moments")).unwrap();
    assert!(!principal.contains('±'), "{principal}");

    let document = text(&folder.path().join("answer.json"));
    fs::write(&document, solved.to_string()).unwrap();
    for format in ["csv", "json", "yaml"] {
        let exported = run(&["export", &document, "--format", format]).stdout;
        let has_none = match format {
            "csv" => exported.lines().filter(|line| line.starts_with("m,")).all(|line| {
                let cells: Vec<&str> = line.split(',').collect();
                cells[3..5] == ["", ""]
            }),
            "json" => exported.contains("\"low95\": null") && exported.contains("\"high95\": null"),
            _ => exported.contains("low95: null") && exported.contains("high95: null"),
        };
        assert!(has_none, "{format}: {exported}");
    }
    let page = text(&folder.path().join("page.html"));
    success(&["report", &document, "-o", &page]);
    let page = fs::read_to_string(&page).unwrap();
    let table = page.split("<h2 id=\"result-1-properties\">").nth(1).unwrap();
    let table = cells(table.split("</table>").next().unwrap());
    let numbers: Vec<&String> = table.iter().filter(|cell| cell.parse::<f64>().is_ok()).collect();
    // Each property has its value, that of the text, and no other number.
    assert_eq!(numbers, SYMBOLS.map(|symbol| row(&brief, symbol)[1]), "{table:?}");
}
