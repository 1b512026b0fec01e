//! What the studio needs from the system, and installing it where it is missing.
//!
//! Debian and Ubuntu are set up with apt; everywhere else the message says what to install. Nothing is
//! installed without being named first, and nothing is downloaded by any other way.

use std::path::Path;
use std::process::{Command, Stdio};

/// What the next step will use.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Pictures without a window.
    Pictures,
    /// A window on this display.
    Window,
    /// Pictures, a virtual display and real input events.
    Tests,
    /// A C++ compiler, for libFuzzer.
    Fuzz,
}

/// Something the system must have: how to see it, and the Debian package that brings it.
struct Part {
    package: &'static str,
    what: &'static str,
    present: fn() -> bool,
}

fn library(name: &str) -> bool {
    let folders =
        ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib", "/usr/local/lib"];
    folders.iter().any(|folder| Path::new(folder).join(name).exists())
}

fn program(name: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(name).is_file()))
}

/// A Vulkan driver registers itself with a JSON file: the system's, or one named by the environment.
fn vulkan_driver() -> bool {
    if std::env::var_os("VK_DRIVER_FILES").is_some() || std::env::var_os("VK_ICD_FILENAMES").is_some() {
        return true;
    }
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    folders.iter().any(|folder| std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()))
}

#[rustfmt::skip]
fn parts(needs: Needs) -> Vec<Part> {
    if needs == Needs::Fuzz {
        return vec![Part { package: "g++", what: "a C++ compiler for libFuzzer", present: || program("c++") }];
    }
    let mut parts = vec![
        Part { package: "libvulkan1", what: "the Vulkan loader", present: || library("libvulkan.so.1") },
        Part { package: "mesa-vulkan-drivers", what: "a Vulkan driver (Mesa; renders on the CPU where there is no GPU)", present: vulkan_driver },
    ];
    if needs != Needs::Pictures {
        parts.extend([
            Part { package: "libxkbcommon-x11-0", what: "the keyboard library of the window", present: || library("libxkbcommon-x11.so.0") },
            Part { package: "libx11-xcb1", what: "the X11 library of the window", present: || library("libX11-xcb.so.1") },
            Part { package: "libxcursor1", what: "the cursor library of the window", present: || library("libXcursor.so.1") },
            Part { package: "libxi6", what: "the input library of the window", present: || library("libXi.so.6") },
            Part { package: "libxrandr2", what: "the monitor library of the window", present: || library("libXrandr.so.2") },
        ]);
    }
    if needs == Needs::Tests {
        parts.extend([
            Part { package: "xvfb", what: "a virtual display for the window tests", present: || program("Xvfb") },
            Part { package: "xdotool", what: "real mouse and key events for the window tests", present: || program("xdotool") },
            Part { package: "imagemagick", what: "screenshots for the window tests", present: || program("import") },
        ]);
    }
    parts
}

/// Install what is missing for `needs`; says what, and fails with the command to run where it cannot.
pub fn prepare(needs: Needs) -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let missing: Vec<Part> = parts(needs).into_iter().filter(|part| !(part.present)()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    eprintln!("This machine lacks:");
    for part in &missing {
        eprintln!("  {:<22} {}", part.package, part.what);
    }
    let packages: Vec<&str> = missing.iter().map(|part| part.package).collect();
    let by_hand = format!("apt-get install --no-install-recommends {}", packages.join(" "));
    if !program("apt-get") {
        return Err(format!(
            "install the equivalents of these Debian packages with this system's package manager, then run again: {}",
            packages.join(" ")
        ));
    }
    let root = run_quiet("id", &["-u"]).is_some_and(|uid| uid.trim() == "0");
    if !root && !program("sudo") {
        return Err(format!("not root and no sudo here; as root run: {by_hand}"));
    }
    eprintln!("Installing them with apt-get{} ...", if root { "" } else { " through sudo" });
    apt(root, &["update", "-qq"])
        .map_err(|why| format!("apt-get update failed ({why}); as root run: apt-get update && {by_hand}"))?;
    let mut install = vec!["install", "-y", "-qq", "--no-install-recommends"];
    install.extend(&packages);
    apt(root, &install).map_err(|why| format!("apt-get install failed ({why}); as root run: {by_hand}"))?;
    let still: Vec<&str> = parts(needs).into_iter().filter(|part| !(part.present)()).map(|part| part.package).collect();
    if still.is_empty() {
        Ok(())
    } else {
        Err(format!("apt-get succeeded, yet these cannot be found: {}", still.join(" ")))
    }
}

fn apt(root: bool, args: &[&str]) -> Result<(), String> {
    let mut command = if root { Command::new("apt-get") } else { Command::new("sudo") };
    if !root {
        command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]);
    }
    command.env("DEBIAN_FRONTEND", "noninteractive").args(args).stdout(Stdio::null());
    status_of(command)
}

fn run_quiet(name: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(name).args(args).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The cargo that started this program.
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Run to the end; an unsuccessful end is an error that names the command.
pub fn status_of(mut command: Command) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().map_err(|why| format!("{name} could not be started: {why}"))?;
    if status.success() { Ok(()) } else { Err(format!("{name} ended with {status}")) }
}

/// Whether a window can be opened.
pub fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(target_os = "linux") || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// Mesa's layer that picks a device asks the display which one it uses, and prints an error where there is none.
pub fn without_display(command: &mut Command) {
    command.env("NODEVICE_SELECT", "1");
}

/// The workspace's root folder.
pub fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask is in the workspace").to_path_buf()
}

/// Where cargo put a program; `profile` is the folder's name, `debug` or `release`.
pub fn binary(profile: &str, name: &str) -> std::path::PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), Into::into);
    target.join(profile).join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}
