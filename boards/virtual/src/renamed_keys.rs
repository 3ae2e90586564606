//! TOML keys that have been renamed.
//!
//! Every reader of layout, calibration, bench and sidecar files looks here when it cannot read a file, so that a
//! file with an old key is refused with the new name of that key, not with a list of all keys.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Old and new name of each renamed key.
const RENAMED: [(&str, &str); 5] = [
    ("gravity_m_s2", "gravity_m_per_s2"),
    ("rc_corner_hz", "rc_cutoff_hz"),
    ("weakest_hit_n", "min_peak_force_n"),
    ("leaning_rate", "sustained_contact_rate"),
    ("astray_rate", "misplaced_rate"),
];

/// A key that a text uses under its old name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenamedKey {
    /// Byte range of the old name in the text.
    pub span: Range<usize>,
    /// The old name.
    pub old: &'static str,
    /// The new name.
    pub new: &'static str,
}

impl RenamedKey {
    /// The first renamed key in a TOML text; `None` when there is none or the text is not TOML.
    pub fn first_in(text: &str) -> Option<Self> {
        let root = DeTable::parse(text).ok()?;
        let mut found = Vec::new();
        search_table(root.get_ref(), &mut found);
        found.into_iter().min_by_key(|key| key.span.start)
    }

    /// The message for the owner of the file.
    pub fn message(&self) -> String {
        format!("`{}` is called `{}` now", self.old, self.new)
    }
}

/// The message of the TOML reader in words for the owner of the file.
pub fn plain(message: &str) -> &str {
    match message {
        "duplicate key" => "this key is in the file twice; delete one",
        other => other,
    }
}

fn search_table(table: &DeTable, found: &mut Vec<RenamedKey>) {
    for (key, value) in table {
        let renamed = RENAMED.into_iter().find(|(old, _)| old == key.get_ref());
        found.extend(renamed.map(|(old, new)| RenamedKey { span: key.span(), old, new }));
        search_value(value, found);
    }
}

fn search_value(value: &Spanned<DeValue>, found: &mut Vec<RenamedKey>) {
    match value.get_ref() {
        DeValue::Table(table) => search_table(table, found),
        DeValue::Array(entries) => entries.iter().for_each(|entry| search_value(entry, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_renamed_key_of_a_text_is_found_wherever_it_stands() {
        let text = "a = [{ rc_corner_hz = 1 }]\n[test]\nweakest_hit_n = 2\n";
        let key = RenamedKey::first_in(text).unwrap();
        assert_eq!(&text[key.span.clone()], "rc_corner_hz");
        assert_eq!(key.message(), "`rc_corner_hz` is called `rc_cutoff_hz` now");
        let key = RenamedKey::first_in("[test]\nweakest_hit_n = 2\n").unwrap();
        assert_eq!((key.span.start, key.new), (7, "min_peak_force_n"));
    }

    #[test]
    fn new_keys_values_and_comments_are_no_old_keys() {
        let text =
            "title = \"weakest_hit_n\" # rc_corner_hz\nrc_cutoff_hz = 1\nmin_peak_force_n = 1\n";
        assert_eq!(RenamedKey::first_in(text), None);
        assert_eq!(RenamedKey::first_in("weakest_hit_n 8"), None);
    }
}
