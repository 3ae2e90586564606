//! Spectra averaged over the hits of one DOF.
