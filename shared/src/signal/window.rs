//! Windows on force and response.
