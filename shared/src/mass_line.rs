//! The mass line: the constant part of an accelerance.
