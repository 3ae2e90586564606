//! Which version of the program this is.

/// The version of the package, and the commit that it was built from.
pub(crate) const VERSION: &str =
    concat!(env!("CARGO_PKG_VERSION"), " (commit ", env!("MASSLINE_GIT_HASH"), ")");
