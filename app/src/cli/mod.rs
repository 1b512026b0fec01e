//! The command line: its words, its exit codes, and where each command is done.
//!
//! Exit codes: 0 done, 1 the work failed, 2 wrong usage. Results go to stdout, everything else to stderr.

mod apply;
mod convert;
mod info;
mod lod;
mod looks;
mod map;
mod measure;
mod pin;
mod read_as;
mod render;
mod scene;
pub mod set;
mod setup;
mod sheet;
mod simulate;
mod wind_source;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::window;

/// A hair studio: open hair and a head, light them, let them move, render and export.
///
/// Without a command the studio's window opens, with FILE where one is given and the default groom
/// otherwise. Everything else works without a display.
#[derive(Debug, Parser)]
#[command(name = "lorelei", version, args_conflicts_with_subcommands = true, after_help = AFTER_HELP)]
struct Arguments {
    /// A groom (.lorelei), hair of another program (.hair, .tfx, .data, .bin, .ply), or an embedded style: long, bob,
    /// curls, crop, ponytail, bun, braid, knot.
    file: Option<PathBuf>,
    /// The head that the hair belongs to: .obj, .glb, .gltf, .ply.
    #[arg(long, value_name = "MESH")]
    head: Option<PathBuf>,
    /// Append the window's state to a file as lines of JSON: for tests.
    #[arg(long, value_name = "FILE", hide = true)]
    report_state: Option<PathBuf>,
    /// Keep settings and recovery files here.
    #[arg(long, value_name = "FOLDER", hide = true)]
    data_folder: Option<PathBuf>,
    /// Draw on the window's device even where its driver is software: for tests.
    #[arg(long, hide = true)]
    share_gpu: bool,
    /// Go on with what a window that ended badly has kept.
    #[arg(long, value_name = "FILE", hide = true)]
    recovered: Option<PathBuf>,
    /// The file that it belongs to.
    #[arg(long, value_name = "FILE", hide = true)]
    recovered_path: Option<PathBuf>,
    /// Windows that ended badly, one after the other.
    #[arg(long, value_name = "N", hide = true, default_value_t = 0)]
    losses: u32,
    /// Seconds between two writes of unsaved changes.
    #[arg(long, value_name = "S", hide = true, default_value_t = 60)]
    autosave: u64,
    #[command(subcommand)]
    command: Option<Command>,
}

const AFTER_HELP: &str = "\
Examples:
  lorelei                                              open the studio with the default groom
  lorelei bob                                          open an embedded style: long, bob, curls, crop, ..
  lorelei my.lorelei                                   open a groom
  lorelei render --camera side --out side.png          render the default groom
  lorelei render hair.tfx --head head.obj --out a.png  render somebody's hair on somebody's head
  lorelei sheet --slot shadowing --out shadows.png     every choice of one slot in one picture
  lorelei simulate bob --motion shake --seconds 3 --filmstrip shake.png  hair that moves
  lorelei looks                                        what --set takes
  lorelei convert hair.data hair.usda --up z --unit m  for another program
  lorelei apply a.lorelei --edits e.ron --out b.lorelei  replay edits

Exit codes: 0 done, 1 the work failed, 2 wrong usage.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a picture, without a window.
    Render(render::RenderArguments),
    /// Every choice of one slot of the look in one labelled picture, with what each costs.
    Sheet(sheet::SheetArguments),
    /// Let hair move and say how well it keeps its laws; pictures of it, and a filmstrip.
    Simulate(simulate::SimulateArguments),
    /// List everything that `--set` takes, with ranges and units.
    Looks(looks::LooksArguments),
    /// Say what is in a file: strands, points, bounds, unit and axis.
    Info(info::InfoArguments),
    /// Measure what this machine needs for work on a groom.
    Measure(measure::MeasureArguments),
    /// Write hair in another program's format.
    Convert(convert::ConvertArguments),
    /// Replay a list of edits on a groom.
    Apply(apply::ApplyArguments),
    /// A painted map out of a groom as a picture, or a picture into it.
    Map(map::MapArguments),
    /// The levels of detail side by side with what each costs, or the level that meets a target.
    Lod(lod::LodArguments),
}

/// Why a command did not do its work.
#[derive(Debug)]
pub enum CliError {
    /// Exit code 1.
    Failed(String),
    /// Exit code 2.
    Usage(String),
}

impl std::fmt::Display for CliError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Self::Failed(why) | Self::Usage(why)) = self;
        f.write_str(why)
    }
}

impl CliError {
    /// The work failed for a reason that says itself what, where and what next.
    pub fn failed(why: impl std::fmt::Display) -> Self {
        Self::Failed(why.to_string())
    }
}

/// Parse the arguments and do what they say.
pub fn run() -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("warn,wgpu_core=error,wgpu_hal=off"))
        .format_timestamp(None)
        .init();
    let started = std::time::Instant::now();
    let arguments = Arguments::parse();
    let result = match arguments.command {
        Some(Command::Render(arguments)) => render::run(&arguments),
        Some(Command::Sheet(arguments)) => sheet::run(&arguments),
        Some(Command::Simulate(arguments)) => simulate::run(&arguments),
        Some(Command::Looks(arguments)) => looks::run(&arguments),
        Some(Command::Info(arguments)) => info::run(&arguments),
        Some(Command::Measure(arguments)) => measure::run(&arguments),
        Some(Command::Convert(arguments)) => convert::run(&arguments),
        Some(Command::Apply(arguments)) => apply::run(&arguments),
        Some(Command::Map(arguments)) => map::run(&arguments),
        Some(Command::Lod(arguments)) => lod::run(&arguments),
        None => window::open(&window::StartOptions {
            file: arguments.file,
            head: arguments.head,
            report_state: arguments.report_state,
            data_folder: arguments.data_folder,
            share_gpu: arguments.share_gpu,
            recovered: arguments.recovered,
            recovered_path: arguments.recovered_path,
            n_losses: arguments.losses,
            autosave: std::time::Duration::from_secs(arguments.autosave),
            started,
        })
        .map_err(CliError::failed),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(CliError::Failed(why)) => {
            eprintln!("error: {why}");
            ExitCode::from(1)
        }
        Err(CliError::Usage(why)) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

/// Refuse a picture's name, given by an option, that does not end in .png.
fn check_png(option: &str, out: &Path) -> Result<(), CliError> {
    let extension = out.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    if extension.as_deref() == Some("png") {
        return Ok(());
    }
    Err(CliError::Usage(format!("{option} {}: let the name end in .png", out.display())))
}

/// Make the folder that a file is to be written into, where there is none.
fn make_folder_of(out: &Path) -> Result<(), CliError> {
    let Some(folder) = out.parent().filter(|folder| !folder.as_os_str().is_empty()) else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|why| CliError::Failed(format!("{}: {why}", folder.display())))
}

/// Write a line of results to stdout. A reader that went away (`| head`) is no failure.
fn print_line(line: &str) -> Result<(), CliError> {
    use std::io::Write;
    match writeln!(std::io::stdout(), "{line}") {
        Err(why) if why.kind() != std::io::ErrorKind::BrokenPipe => Err(CliError::failed(why)),
        Ok(()) | Err(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_arguments_are_consistent_and_every_option_has_a_help_text() {
        Arguments::command().debug_assert();
        for command in Arguments::command().get_subcommands() {
            for argument in command.get_arguments() {
                assert!(argument.get_help().is_some(), "{} {}", command.get_name(), argument.get_id());
            }
        }
    }

    #[test]
    fn files_and_commands_are_told_apart() {
        let parse = |line: &str| Arguments::try_parse_from(line.split(' '));
        assert!(parse("lorelei bob.lorelei").unwrap().file.is_some());
        assert!(matches!(parse("lorelei looks --json").unwrap().command, Some(Command::Looks(_))));
        assert!(matches!(parse("lorelei render a.tfx --head b.obj").unwrap().command, Some(Command::Render(_))));
        assert_eq!(parse("lorelei render --size 10").unwrap_err().exit_code(), 2);
        assert_eq!(parse("lorelei render --nonsense").unwrap_err().exit_code(), 2);
    }
}
