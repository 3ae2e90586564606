//! Checks of single values; the errors name the place in the file.

use std::ops::Range;

use toml::Spanned;

use super::error::{Fault, LayoutFileError, Place};

/// The text of the file, to which spans refer.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    pub(super) fn fault(&self, span: Range<usize>, key: &str, fault: Fault) -> LayoutFileError {
        let place = Place::of(self.file, self.text, Some(span), key);
        LayoutFileError::Fault { place, fault }
    }

    pub(super) fn finite(
        &self,
        span: Range<usize>,
        key: &str,
        values: &[f64],
    ) -> Result<(), LayoutFileError> {
        match values.iter().find(|v| !v.is_finite()) {
            Some(&value) => Err(self.fault(span, key, Fault::NotFinite { value })),
            None => Ok(()),
        }
    }

    pub(super) fn within(
        &self,
        value: &Spanned<f64>,
        key: &str,
        good: impl Fn(f64) -> bool,
        wanted: &'static str,
    ) -> Result<f64, LayoutFileError> {
        let v = *value.get_ref();
        self.finite(value.span(), key, &[v])?;
        if good(v) {
            Ok(v)
        } else {
            Err(self.fault(value.span(), key, Fault::OutOfRange { value: v, wanted }))
        }
    }
}
