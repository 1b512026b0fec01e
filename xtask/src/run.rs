//! `cargo xtask run`: from a bare machine to the open studio.

use std::process::Command;

use crate::machine::{self, Needs, binary, cargo, has_display, root, status_of};

pub fn run(args: &[String]) -> Result<(), String> {
    let window = has_display();
    machine::prepare(if window { Needs::Window } else { Needs::Pictures })?;
    build_release()?;
    let mut lorelei = Command::new(binary("release", "lorelei"));
    if window || !args.is_empty() {
        lorelei.args(args);
        return status_of(lorelei);
    }
    let picture = root().join("out").join("lorelei.png");
    std::fs::create_dir_all(root().join("out")).map_err(|why| format!("cannot create the folder `out`: {why}"))?;
    lorelei.args(["render", "--size", "1280x720", "--out"]).arg(&picture);
    machine::without_display(&mut lorelei);
    status_of(lorelei)?;
    println!("There is no display here, so the default groom was rendered to {}", picture.display());
    println!("To open the studio's window: run `cargo xtask run` in a desktop session, or set DISPLAY to an X server");
    println!(
        "(for a virtual one: install `xvfb` and `xauth`, then `xvfb-run -s \"-screen 0 1600x1000x24\" cargo xtask run`)."
    );
    Ok(())
}

/// Build `lorelei` in release.
pub fn build_release() -> Result<(), String> {
    let mut build = cargo();
    build.current_dir(root()).args(["build", "--release", "--package", "lorelei"]);
    status_of(build)
}
