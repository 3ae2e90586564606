//! Which DOF is hit next, and what a verdict leads to.
