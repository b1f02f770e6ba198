//! The container: round trips, fixed bytes, damage, atomic writing, freshness.

#[path = "../common/mod.rs"]
mod common;

mod golden;
mod hostile;
mod images;
mod kill;
mod refuse;
mod round_trip;
mod spec;
mod stale;
mod twin;
