//! Follows a campaign from its start to its result.
