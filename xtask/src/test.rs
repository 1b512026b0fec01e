//! `cargo xtask test`: set up, build, run every test, print the totals.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use crate::machine::{self, Needs, cargo, root, status_of};

/// Every test of the workspace, the baker's included. `args` go to `cargo test`.
pub fn test(args: &[String]) -> Result<(), String> {
    machine::prepare(Needs::Tests)?;
    let mut command = cargo();
    command.current_dir(root()).args(["test", "--workspace", "--features", "xtask/bake", "--no-fail-fast"]).args(args);
    if !args.iter().any(|arg| arg == "--") {
        // What a passed test printed is hidden by default, and with it that it skipped something.
        command.args(["--", "--show-output"]);
    }
    if !machine::has_display() {
        machine::without_display(&mut command);
    }
    let mut child =
        command.stdout(Stdio::piped()).spawn().map_err(|why| format!("cargo could not be started: {why}"))?;
    let stdout = child.stdout.take().expect("stdout is piped");
    let mut totals = Totals::default();
    for line in BufReader::new(stdout).lines() {
        let line = line.map_err(|why| format!("cargo's output broke off: {why}"))?;
        if totals.add(&line) {
            println!("{line}");
        }
    }
    let status = child.wait().map_err(|why| format!("cargo did not end: {why}"))?;
    println!(
        "total: {} passed; {} failed; {} ignored; {} skipped for want of something named above",
        totals.passed, totals.failed, totals.ignored, totals.skipped
    );
    if status.success() { Ok(()) } else { Err(format!("{} tests failed", totals.failed)) }
}

/// Format and clippy over everything, warnings denied.
pub fn lint() -> Result<(), String> {
    let mut fmt = cargo();
    fmt.current_dir(root()).args(["fmt", "--all", "--check"]);
    status_of(fmt)?;
    let mut clippy = cargo();
    clippy.current_dir(root()).args([
        "clippy",
        "--workspace",
        "--all-targets",
        "--features",
        "xtask/bake",
        "--",
        "-D",
        "warnings",
    ]);
    status_of(clippy)
}

#[derive(Default, Debug, PartialEq)]
struct Totals {
    passed: u32,
    failed: u32,
    ignored: u32,
    skipped: u32,
    /// Between `successes:` and what follows, where passed tests' output is.
    is_in_successes: bool,
}

impl Totals {
    /// True where the line is to be shown: of what passed tests printed, only what they skipped.
    fn add(&mut self, line: &str) -> bool {
        let is_skip = line.contains("skipped: ");
        self.skipped += u32::from(is_skip);
        match line {
            "successes:" => self.is_in_successes = true,
            "failures:" => self.is_in_successes = false,
            _ => self.is_in_successes &= !line.starts_with("test result: "),
        }
        self.count(line);
        is_skip || !self.is_in_successes
    }

    fn count(&mut self, line: &str) {
        let Some(result) = line.strip_prefix("test result: ") else { return };
        for part in result.split([';', '.']) {
            let mut words = part.split_whitespace();
            let (Some(number), Some(word)) = (words.next().and_then(|word| word.parse::<u32>().ok()), words.next())
            else {
                continue;
            };
            match word {
                "passed" => self.passed += number,
                "failed" => self.failed += number,
                "ignored" => self.ignored += number,
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_add_up_and_of_what_passed_only_skips_are_shown() {
        let output = "\
test a ... ok
successes:
---- a stdout ----
measured 12 ms
skipped: no ../shared here
successes:
    a
failures:
---- b stdout ----
it is 3
test result: FAILED. 12 passed; 2 failed; 1 ignored; 0 measured; 0 filtered out; finished in 1.00s
test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s";
        let mut totals = Totals::default();
        let shown: Vec<&str> = output.lines().filter(|line| totals.add(line)).collect();
        let expected = Totals { passed: 15, failed: 2, ignored: 1, skipped: 1, is_in_successes: false };
        assert_eq!(totals, expected);
        assert_eq!(shown.len(), 7, "{shown:?}");
        assert!(shown.contains(&"it is 3") && !shown.contains(&"measured 12 ms"));
    }
}
