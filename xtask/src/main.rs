//! `cargo xtask`: set up this machine, then run, test, measure or bake the studio.
//!
//! One program instead of shell scripts, so that the same words work on Linux, macOS and Windows.

mod bench;
mod filmstrips;
mod fuzz;
mod golden;
mod machine;
mod numbers;
mod run;
mod test;

#[cfg(feature = "bake")]
mod bake;

use std::process::ExitCode;

const USAGE: &str = "\
Usage: cargo xtask COMMAND [-- ARGUMENTS]

  run [-- ARGS]    install what the system lacks, build in release, open the studio; ARGS go to `lorelei`.
                   Without a display: render the default groom to a picture and say where it is.
  test [FILTER]    the same care, then every test of the workspace; FILTER as for `cargo test`
  lint             format check and clippy, warnings denied
  fuzz [SECONDS] [TARGET]...
                   libFuzzer over the file readers, SECONDS for each (60)
  filmstrips [STYLE]...
                   every motion on every embedded style as eight frames side by side, in out/filmstrips, and their
                   numbers on the page of docs/; a named style anew; --debug with the program as built for developing
  bench            measure speed on this machine and print tables
  bake [NAME]...   make the embedded head and hairstyles anew, or only the styles that are named; after `check`,
                   compare them with those that are there
  golden COMMAND   `compare`: render the golden images here and compare; `write`: make them anew
  setup            only install what the system lacks
";

fn main() -> ExitCode {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    if args.is_empty() {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    }
    let command = args.remove(0);
    if args.first().is_some_and(|arg| arg == "--") {
        args.remove(0);
    }
    let outcome = match command.as_str() {
        "run" => run::run(&args),
        "test" => test::test(&args),
        "lint" => test::lint(),
        "filmstrips" => filmstrips::filmstrips(&args),
        "bench" => bench::bench(&args),
        "bake" => bake_command(&args),
        "fuzz" => fuzz::fuzz(&args),
        "golden" => golden::golden(&args),
        "setup" => machine::prepare(machine::Needs::Tests),
        "help" | "--help" | "-h" => {
            print!("{USAGE}");
            Ok(())
        }
        unknown => {
            eprintln!("cargo xtask: there is no command `{unknown}`\n");
            eprint!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("cargo xtask {command}: {message}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(feature = "bake")]
fn bake_command(args: &[String]) -> Result<(), String> {
    bake::bake(args)
}

/// The lean build does not bake: ask cargo for the one that does.
#[cfg(not(feature = "bake"))]
fn bake_command(args: &[String]) -> Result<(), String> {
    let mut cargo = machine::cargo();
    cargo.args(["run", "--release", "--package", "xtask", "--features", "bake", "--", "bake"]).args(args);
    machine::status_of(cargo)
}
