//! The inertia restraint method.
