//! `massline schema`, and the published schemas.

use std::path::{Path, PathBuf};

use massline_files::layout_file;
use massline_report::document::{DocumentKind, schemas};
use serde_json::Value;

use crate::program::{run, success};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas")
}

fn published(name: &str) -> String {
    std::fs::read_to_string(folder().join(format!("{name}.schema.json"))).unwrap()
}

#[test]
fn a_schema_is_printed_by_its_name_and_all_are_listed() {
    let listed = success(&["schema"]);
    let names: Vec<&str> = listed["documents"]
        .as_array()
        .unwrap()
        .iter()
        .map(|document| document["document"].as_str().unwrap())
        .collect();
    assert_eq!(names, DocumentKind::ALL.map(|kind| kind.name));
    for name in names {
        let printed = run(&["schema", name]).stdout;
        assert_eq!(printed, published(name));
        let schema: Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
        assert!(schema["properties"]["schema_version"].is_object(), "{schema}");
    }
    assert_eq!(run(&["schema", "nothing"]).exit, 2);
    assert_eq!(run(&["layout", "schema"]).stdout, published("layout-file"));
}

#[test]
fn the_published_schemas_are_those_of_the_types() {
    let folder = folder();
    let documents = schemas();
    assert_eq!(
        documents.each_ref().map(|(name, _)| *name),
        DocumentKind::ALL.map(|kind| kind.name)
    );
    let generated = documents.into_iter().chain([("layout-file", layout_file::schema())]);
    let mut paths = Vec::new();
    for (name, schema) in generated {
        let path = folder.join(format!("{name}.schema.json"));
        let text = format!("{schema:#}\n");
        if std::env::var_os("MASSLINE_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert_eq!(kept, text, "{}: MASSLINE_BLESS=1 renews it", path.display());
        paths.push(path);
    }
    let files = std::fs::read_dir(&folder).unwrap().count();
    assert_eq!(files, paths.len(), "a schema without a type");
}
