//! What `layout new` and `layout schema` print.

/// A commented layout file to start from: it is valid and can be measured.
pub const TEMPLATE: &str = include_str!("template.toml");

/// The JSON schema (draft 2020-12) of the layout file.
pub const SCHEMA: &str = include_str!("schema.json");
