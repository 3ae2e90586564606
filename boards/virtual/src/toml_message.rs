//! The messages of the TOML reader in words for the owner of the file.

/// What a message of the reader means to whoever wrote the file.
pub fn plain(message: &str) -> &str {
    match message {
        "duplicate key" => "this key is in the file twice; delete one",
        other => other,
    }
}
