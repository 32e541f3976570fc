//! End-to-end tests of fibar.
