//! The output of `layout new` and `layout schema`.

use massline_shared::layout::{
    HitPolicy, TestProfile, UncertaintyKey, UncertaintyUnit, uncertainty_keys,
};
use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;

use super::raw::RawLayout;

/// The template without the keys that massline-shared lists.
const FRAME: &str = include_str!("template.toml");
/// The last line of the frame before the keys of `[policy]`, and before those of `[uncertainty]`.
const POLICY: &str = "\n[policy]\n";
const BUDGET: &str = "\nlearn = true                      # correct this budget from the data; false uses it as it is\n";
/// Where comments begin.
const COLUMN: usize = 34;

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

/// A commented layout file of this profile to start from; it is valid and can be used for a measurement.
pub fn template(profile: TestProfile) -> String {
    let policy: String = HitPolicy::CODES
        .map(|code| {
            format!("{} = \"{}\"\n", code.name(), HitPolicy::default_treatment(code).name())
        })
        .concat();
    let budget: String = uncertainty_keys().map(budget_line).collect();
    let text = FRAME.replacen(POLICY, &format!("{POLICY}{policy}"), 1).replacen(
        BUDGET,
        &format!("{BUDGET}{budget}"),
        1,
    );
    match profile {
        TestProfile::MassLine => text,
        TestProfile::Suspension => {
            let changed = |text: String, (from, to): (&str, &str)| text.replacen(from, to, 1);
            OF_SUSPENSION.into_iter().fold(text, changed)
        }
    }
}

/// The line of a key of `[uncertainty]` with its default.
fn budget_line(key: &UncertaintyKey) -> String {
    let unit = match key.unit {
        UncertaintyUnit::Relative => ", relative",
        // The key has it.
        UncertaintyUnit::Meters | UncertaintyUnit::Radians => "",
    };
    let only = if key.only_modes { "; for the suspension modes only" } else { "" };
    let stated = format!("{} = {}", key.name, key.default);
    format!("{stated:COLUMN$}# {}{unit}{only}\n", key.meaning)
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
