//! The laws that both solvers keep, and that they agree.

mod contacts;
mod laws;
mod moved;
mod pins;
mod pulls;
mod rods;
mod strands;
mod twins;
mod volume;
mod wind;
