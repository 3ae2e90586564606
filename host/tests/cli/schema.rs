//! `massline schema`.

use massline::document::Described;
use serde_json::Value;

use crate::program::{run, success};

#[test]
fn a_schema_is_printed_by_its_name_and_all_are_listed() {
    let listed = success(&["schema"]);
    let names: Vec<&str> = listed["documents"]
        .as_array()
        .unwrap()
        .iter()
        .map(|of| of["document"].as_str().unwrap())
        .collect();
    assert_eq!(names, Described::ALL.map(|of| of.name));
    for name in names {
        let schema: Value = serde_json::from_str(&run(&["schema", name]).stdout).unwrap();
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
        assert!(schema["properties"]["schema_version"].is_object(), "{schema}");
    }
    assert_eq!(run(&["schema", "nothing"]).exit, 2);
}
