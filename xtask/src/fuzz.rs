//! `cargo xtask fuzz`: libFuzzer over every reader, with the compiler that builds everything else.
//!
//! cargo-fuzz was rejected: it wants a nightly compiler, for the address sanitizer. The readers have no unsafe code,
//! and coverage, debug assertions and overflow checks are there in a stable compiler.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::machine::{self, Needs, cargo, root, status_of};

/// What cargo-fuzz gives to rustc, without its sanitizer.
const COVERAGE: &[&str] = &[
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "--cfg=fuzzing",
    "-Ccodegen-units=1",
    "-Cdebug-assertions",
    "-Coverflow-checks",
];
/// A minute for each target where nothing is said.
const SECONDS: u32 = 60;
/// Inputs are at most 64 KiB; with the fuzzer's own, this is room for a reader that keeps to what a file justifies.
const MOST_MEMORY_MIB: u32 = 512;

/// `args`: seconds for each target, then names of targets; both may be left out.
pub fn fuzz(args: &[String]) -> Result<(), String> {
    let (seconds, wanted) = match args.split_first() {
        Some((first, rest)) if first.parse::<u32>().is_ok() => (first.parse().unwrap_or(SECONDS), rest),
        _ => (SECONDS, args),
    };
    machine::prepare(Needs::Fuzz)?;
    let folder = root().join("fuzz");
    let targets = targets(&folder)?;
    if let Some(unknown) = wanted.iter().find(|name| !targets.contains(name)) {
        return Err(format!("there is no target `{unknown}`; there are: {}", targets.join(", ")));
    }
    let host = host()?;
    let mut build = cargo();
    // With a target named, build scripts are spared the flags.
    build.current_dir(&folder).args(["build", "--release", "--target", &host]);
    build.env("CARGO_ENCODED_RUSTFLAGS", COVERAGE.join("\u{1f}")).env("CARGO_TARGET_DIR", folder.join("target"));
    status_of(build)?;
    let mut failed = Vec::new();
    for target in targets.iter().filter(|target| wanted.is_empty() || wanted.contains(target)) {
        println!("{target}: {seconds} s");
        if run(&folder, &host, target, seconds).is_err() {
            failed.push(target.as_str());
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    Err(format!("{} failed; what they failed on lies in fuzz/artifacts/", failed.join(", ")))
}

fn run(folder: &Path, host: &str, target: &str, seconds: u32) -> Result<(), String> {
    let corpus = folder.join("corpus").join(target);
    let artifacts = folder.join("artifacts").join(target);
    for made in [&corpus, &artifacts] {
        std::fs::create_dir_all(made).map_err(|why| format!("{}: {why}", made.display()))?;
    }
    let mut fuzzer = Command::new(folder.join("target").join(host).join("release").join(target));
    fuzzer.arg(corpus).arg(folder.join("seeds").join(target));
    fuzzer.arg(format!("-artifact_prefix={}{}", artifacts.display(), std::path::MAIN_SEPARATOR));
    fuzzer.args([&format!("-max_total_time={seconds}"), &format!("-rss_limit_mb={MOST_MEMORY_MIB}")]);
    fuzzer.args(["-max_len=65536", "-timeout=10", "-verbosity=0", "-print_funcs=0", "-print_final_stats=1"]);
    status_of(fuzzer)
}

/// The names of `fuzz_targets/*.rs`.
fn targets(folder: &Path) -> Result<Vec<String>, String> {
    let folder = folder.join("fuzz_targets");
    let entries = std::fs::read_dir(&folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let stem = |path: PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let mut names: Vec<String> = entries.flatten().filter_map(|entry| stem(entry.path())).collect();
    names.sort();
    Ok(names)
}

/// The triple that rustc builds for when nothing is said.
fn host() -> Result<String, String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().map_err(|why| format!("rustc could not be started: {why}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| format!("rustc -vV names no host: {text}"))
}
