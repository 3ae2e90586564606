//! The output of `layout new` and `layout schema`.

use massline_shared::layout::TestProfile;
use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;

use super::raw::RawLayout;

/// A commented layout file to start from; it is valid and can be used for a measurement.
pub const TEMPLATE: &str = include_str!("template.toml");

/// What differs in the template of the suspension profile: it has five hits, so that each of the six modes is moved by one,
/// and the defaults of its own.
const OF_SUSPENSION: [(&str, &str); 5] = [
    (
        "profile = \"mass-line\"             # or \"suspension\": other band and windows, as by `layout new --profile suspension`",
        "profile = \"suspension\"            # or \"mass-line\": other band and windows, as by `layout new`",
    ),
    (
        "band_hz = [10.0, 120.0]           # from 3 × the highest suspension mode to 0.4 × the first elastic;\n                                  \
         # \"auto\" finds it from the data",
        "band_hz = [0.5, 12.4]             # with all six suspension modes, 12.4 at most",
    ),
    ("exponential_decay_per_s = 10.0 ", "exponential_decay_per_s = 0.1  "),
    ("force_window_s = 0.012 ", "force_window_s = 0.05  "),
    (
        "hits = [\"1:+Y\", \"2:+Z\", \"4:+X\"]",
        "hits = [\"1:+Y\", \"2:+Z\", \"4:+X\", \"3:+Z\", \"4:-Y\"]",
    ),
];

/// A commented layout file of this profile to start from.
pub fn template(profile: TestProfile) -> String {
    match profile {
        TestProfile::MassLine => TEMPLATE.into(),
        TestProfile::Suspension => {
            let changed = |text: String, (from, to): (&str, &str)| text.replacen(from, to, 1);
            OF_SUSPENSION.into_iter().fold(TEMPLATE.into(), changed)
        }
    }
}

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
