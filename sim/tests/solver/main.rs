//! The laws that both solvers keep, and that they agree.

mod contacts;
mod grooms;
mod laws;
mod rods;
mod twins;
mod wind;
