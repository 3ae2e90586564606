//! The output of `layout new` and `layout schema`.

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;

use super::raw::RawLayout;

/// A commented layout file to start from; it is valid and can be used for a measurement.
pub const TEMPLATE: &str = include_str!("template.toml");

/// The JSON schema (draft 2020-12) of the layout file.
pub fn schema() -> Schema {
    let settings = SchemaSettings::draft2020_12().with_transform(RecursiveTransform(plain));
    settings.into_generator().into_root_schema_for::<RawLayout>()
}

/// Removes what does not apply to TOML: the formats of Rust's numbers, and null as the default of an optional
/// key.
fn plain(schema: &mut Schema) {
    schema.remove("format");
    if schema.get("default").is_some_and(serde_json::Value::is_null) {
        schema.remove("default");
    }
}
