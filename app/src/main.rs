//! Lorelei, a hair studio: the window and the command line.

mod cli;
mod lettering;
mod lod_strip;
mod movement;
mod open;
mod script;
mod sheet;
mod stage;
mod turntable;
mod window;

fn main() -> std::process::ExitCode {
    cli::run()
}
