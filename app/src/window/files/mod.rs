//! Files from the window: choosing them, and the work on them off the window's thread.

pub mod choose;
mod choosing;
pub mod dialog;
pub mod jobs;
pub mod listing;
