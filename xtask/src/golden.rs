//! `cargo xtask golden`: the golden images of `tests/golden/`, written anew or compared with this machine.

use std::process::Command;

use crate::machine::{self, Needs, binary, cargo, root, status_of};

/// `args`: `write` or `compare`, then a folder instead of `tests/golden` and, to compare, one for what differs.
pub fn golden(args: &[String]) -> Result<(), String> {
    let (command, folders) = match args {
        [command, folders @ ..] if command == "write" || command == "compare" => (command, folders),
        _ => return Err("say `write` or `compare`, as in `cargo xtask golden compare`".to_owned()),
    };
    machine::prepare(Needs::Pictures)?;
    // The features of `cargo xtask test`, so that nothing is built twice.
    let mut build = cargo();
    build.current_dir(root()).args(["build", "--workspace", "--features", "xtask/bake", "--bin", "golden"]);
    status_of(build)?;
    let mut golden = Command::new(binary("debug", "golden"));
    golden.arg(command);
    if folders.is_empty() {
        golden.arg(root().join("tests").join("golden"));
    }
    golden.args(folders);
    status_of(golden)
}
