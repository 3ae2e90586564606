//! What `layout new` and `layout schema` print.

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;

use super::raw::RawLayout;

/// A commented layout file to start from: it is valid and can be measured.
pub const TEMPLATE: &str = include_str!("template.toml");

/// The JSON schema (draft 2020-12) of the layout file.
pub fn schema() -> Schema {
    let settings = SchemaSettings::draft2020_12().with_transform(RecursiveTransform(plain));
    settings.into_generator().into_root_schema_for::<RawLayout>()
}

/// Takes out what says nothing of TOML: the formats of Rust's numbers, and null as the default of a key that
/// may be left out.
fn plain(schema: &mut Schema) {
    schema.remove("format");
    if schema.get("default").is_some_and(serde_json::Value::is_null) {
        schema.remove("default");
    }
}
