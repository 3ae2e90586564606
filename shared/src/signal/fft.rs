//! Fourier transform of a real record.
