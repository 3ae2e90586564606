//! What a sensor reads of the body's motion, and what a hit does to it.
