//! `golden`: write the golden images, or compare this machine's GPU with those of another.
//!
//! One file without data beside it, so that it can be carried to a machine that has a GPU and no cargo.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lorelei_shaders::Gpu;
use lorelei_tests::golden;

const USAGE: &str = "\
Usage: golden write FOLDER          render one picture for each choice of each slot
       golden compare FOLDER [OUT]  render them again and compare; what differs goes to OUT (`out/golden`)

WGPU_ADAPTER_NAME (part of a name) chooses the GPU. Exit codes: 0 done, 1 different or failed, 2 wrong usage.
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words.as_slice() {
        ["write", folder] => write(Path::new(folder)),
        ["compare", folder] => compare(Path::new(folder), &PathBuf::from("out").join("golden")),
        ["compare", folder, out] => compare(Path::new(folder), Path::new(out)),
        _ => {
            eprint!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("golden: {why}");
            ExitCode::FAILURE
        }
    }
}

fn gpu() -> Result<Gpu, String> {
    let gpu = Gpu::headless().map_err(|why| why.to_string())?;
    let info = &gpu.adapter_info;
    println!("{} ({} {})", info.name, info.driver, info.driver_info);
    Ok(gpu)
}

fn write(folder: &Path) -> Result<(), String> {
    let n = golden::write(&gpu()?, folder)?;
    println!("{n} pictures in {}: look at what changed before it is committed", folder.display());
    Ok(())
}

fn compare(folder: &Path, out: &Path) -> Result<(), String> {
    let outcomes = golden::compare(&gpu()?, folder, out)?;
    for outcome in &outcomes {
        println!("{outcome}");
    }
    let n_different = outcomes.iter().filter(|outcome| !outcome.is_within()).count();
    if n_different == 0 {
        return Ok(());
    }
    Err(format!("{n_different} of {} are different: see {}", outcomes.len(), out.display()))
}
