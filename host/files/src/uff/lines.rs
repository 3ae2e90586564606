//! The lines of a universal file, with the place of each for errors.

use std::borrow::Cow;

use super::error::{UffError, UffFault};
use crate::encoding::label;

/// The line that begins and ends a dataset.
const DELIMITER: &[u8] = b"    -1";

/// True for the line that begins and ends a dataset.
pub(super) fn is_delimiter(line: &[u8]) -> bool {
    line.strip_suffix(&[END_OF_FILE]).unwrap_or(line).trim_ascii_end() == DELIMITER
}

/// The character that ends a text file under DOS.
const END_OF_FILE: u8 = 0x1a;
/// The bytes that mark a text as UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A cursor over the bytes of a file.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    /// Offset of the byte after the line read last.
    at: usize,
    /// Place of the line read last.
    line: usize,
    line_start: usize,
    /// Number of the current dataset.
    dataset: usize,
    dataset_line: usize,
    dataset_byte: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let zero = 0;
        Self {
            bytes,
            at: if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { zero },
            line: zero,
            line_start: zero,
            dataset: zero,
            dataset_line: zero,
            dataset_byte: zero,
        }
    }

    /// Number of the current dataset, from 1; 0 before the first.
    pub(super) fn dataset(&self) -> usize {
        self.dataset
    }

    /// Line and byte at which the current dataset begins.
    pub(super) fn dataset_place(&self) -> (usize, usize) {
        (self.dataset_line, self.dataset_byte)
    }

    /// Notes that the next line begins a dataset.
    pub(super) fn open_dataset(&mut self) {
        self.dataset += 1;
        self.dataset_line = self.line + 1;
        self.dataset_byte = self.at;
    }

    /// The next line without its line end; `None` at the end of the file.
    pub(super) fn peek(&self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let line = rest.get(..end)?;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// Reads the next line.
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let line = self.peek()?;
        self.line += 1;
        self.line_start = self.at;
        let rest = self.rest();
        let length = rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |end| end + 1);
        self.at += length;
        Some(line)
    }

    /// Reads the next line of a dataset's text.
    pub(super) fn record(&mut self, wanted: &'static str) -> Result<&'a [u8], UffError> {
        self.next().ok_or_else(|| self.error(UffFault::Truncated { wanted }))
    }

    /// Reads the next line of a dataset's text as text.
    pub(super) fn text(&mut self, wanted: &'static str) -> Result<Cow<'a, str>, UffError> {
        self.record(wanted).map(label)
    }

    /// Whether no dataset can follow: what is left are blanks, zeros and ends of file.
    pub(super) fn at_end(&self) -> bool {
        let fills = |b: &u8| b.is_ascii_whitespace() || [0, END_OF_FILE].contains(b);
        self.rest().iter().all(fills)
    }

    /// The unread bytes.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Takes `length` bytes of binary data.
    pub(super) fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let taken = self.rest().get(..length)?;
        self.line_start = self.at;
        self.at += length;
        Some(taken)
    }

    /// True when the dataset ends after `length` more bytes, with or without a line end before the delimiter.
    pub(super) fn ends_after(&self, length: usize) -> bool {
        let Some(rest) = self.rest().get(length..) else { return false };
        let rest = rest.strip_prefix(b"\r").unwrap_or(rest);
        let rest = rest.strip_prefix(b"\n").unwrap_or(rest);
        let end = rest.iter().take(82).position(|&b| b == b'\n').unwrap_or(rest.len().min(82));
        rest.get(..end).is_some_and(is_delimiter)
    }

    /// Skips to the end of the dataset.
    pub(super) fn skip_to_delimiter(&mut self) -> Result<(), UffError> {
        while let Some(line) = self.next() {
            if is_delimiter(line) {
                return Ok(());
            }
        }
        Err(self.error(UffFault::Truncated { wanted: "the end of the dataset, \"    -1\"," }))
    }

    /// Line and byte of the line read last.
    pub(super) fn place(&self) -> (usize, usize) {
        (self.line, self.line_start)
    }

    /// An error at the line or data read last.
    pub(super) fn error(&self, fault: UffFault) -> UffError {
        UffError { dataset: self.dataset, line: self.line, byte: self.line_start, fault }
    }
}
