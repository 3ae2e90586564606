//! Is this hit good enough to be averaged?
