//! The window itself, on a virtual display, driven by real events: orbit, switch shadows, play, drag the
//! head, undo, save, reopen.
//!
//! Every wait is for a state that the window reports (`--report-state`), with a limit; none is for a time.
//! Skipped where Xvfb, xdotool or ImageMagick's import are absent. Screenshots stay in the folder that the
//! test prints.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use lorelei_core::document;
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::look::Shadowing;
use lorelei_core::mesh::TriMesh;
use lorelei_core::strands::Strands;
use serde_json::Value;

/// A software driver on a busy machine compiles shaders and draws its first frame within this.
const LIMIT: Duration = Duration::from_mins(5);

#[test]
fn a_session_with_real_events_keeps_what_was_saved() {
    let missing: Vec<&str> =
        ["Xvfb", "xdotool", "import"].into_iter().filter(|program| !is_installed(program)).collect();
    if !missing.is_empty() || !cfg!(target_os = "linux") {
        println!("skipped: {} not installed (apt-get install xvfb xdotool imagemagick)", missing.join(", "));
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("window");
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).unwrap();
    println!("screenshots: {}", folder.display());
    let file = folder.join("small.lorelei");
    let groom = small_groom();
    document::save(&groom, &file).unwrap();
    let display = Display::start();

    let mut studio = Studio::open(&display, &folder, &file, "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    assert_eq!(opened["unsaved"], false);
    assert_eq!(opened["look"]["shadowing"], "deep-opacity");
    let first = studio.screenshot("1_opened");

    // Orbit with the middle button.
    let [left, top, right, bottom] = numbers(&opened["viewport"]);
    let (x, y) = (left + 0.3 * (right - left), 0.5 * (top + bottom));
    studio.drag(2, (x, y), (x + 120.0, y + 20.0));
    let before = numbers::<3>(&opened["camera"]);
    let orbited = studio.wait("an orbit", |state| {
        state["still"] == true && (numbers::<3>(&state["camera"])[0] - before[0]).abs() > 10.0
    });
    assert_eq!(numbers::<3>(&orbited["camera"])[2], before[2], "an orbit keeps the distance");
    let second = studio.screenshot("2_orbited");
    assert!(difference(&first, &second, [left, top, right, bottom]) > 0.002, "the picture turned");

    // Switch shadows off through the palette.
    studio.key("F3");
    studio.wait("the palette", |state| state["palette"] == true && state["typing"] == true);
    studio.type_text("switch shadows");
    studio.key("Return");
    let dark = studio.wait("shadows off", |state| state["look"]["shadowing"] == "off" && state["still"] == true);
    assert_eq!(dark["unsaved"], true);
    assert_eq!(dark["n_done"], 1);
    studio.screenshot("3_without_shadows");

    // Play, and drag the head by its handle: the hair follows in time.
    studio.key("space");
    studio.wait("movement", |state| state["playing"] == true && state["sim_secs"].as_f64() > Some(0.1));
    let [hx, hy] = numbers(&studio.state()["head_handle"]);
    studio.drag(1, (hx, hy), (hx + 60.0, hy - 10.0));
    studio.wait("a dragged head", |state| numbers::<5>(&state["head"])[..3].iter().any(|cm| cm.abs() > 0.3));
    studio.screenshot("4_dragged");
    studio.key("space");
    studio.wait("rest", |state| state["playing"] == false && state["still"] == true);

    // Undo: as it was opened, and so nothing to save. Redo, save.
    studio.key("ctrl+z");
    let undone = studio.wait("undo", |state| state["look"]["shadowing"] == "deep-opacity" && state["still"] == true);
    assert_eq!((&undone["unsaved"], &undone["n_done"]), (&Value::from(false), &Value::from(0)));
    studio.key("ctrl+shift+z");
    studio.wait("redo", |state| state["look"]["shadowing"] == "off");
    studio.key("ctrl+s");
    let saved = studio.wait("the save", |state| state["unsaved"] == false && state["jobs"] == 0);
    assert_eq!(saved["notices"], Value::Array(Vec::new()));
    let mut expected = groom;
    expected.look.shadowing = Shadowing::Off;
    assert!(document::open(&file).unwrap() == expected, "the file holds the groom, with the one change");
    studio.screenshot("5_saved");

    // Save as, with the studio's own dialog.
    studio.key("ctrl+shift+s");
    studio.wait("the dialog", |state| state["dialog"] == true && state["typing"] == true);
    studio.key("ctrl+a");
    studio.type_text("other");
    studio.key("Return");
    let renamed =
        studio.wait("save as", |state| state["path"].as_str().is_some_and(|path| path.ends_with("other.lorelei")));
    assert_eq!(renamed["unsaved"], false);
    assert!(document::open(&folder.join("other.lorelei")).unwrap() == expected);

    // Unsaved changes are asked about before the window closes.
    studio.key("shift+l");
    studio.wait("a change", |state| state["unsaved"] == true);
    studio.key("ctrl+q");
    studio.wait("the question", |state| state["question"] == "unsaved");
    studio.screenshot("6_question");
    studio.key("Escape");
    studio.wait("no question", |state| state["question"].is_null());
    studio.key("ctrl+z");
    studio.wait("nothing to save", |state| state["unsaved"] == false);
    studio.quit();

    let mut studio = Studio::open(&display, &folder, &file, "second");
    let reopened = studio.wait("the file again", |state| state["still"] == true);
    assert_eq!(reopened["look"]["shadowing"], "off");
    assert_eq!(reopened["layers"], opened["layers"]);
    studio.screenshot("7_reopened");
    studio.quit();
}

/// A ball with a tuft of 400 strands that stand out and hang over.
fn small_groom() -> Groom {
    let mut strands = Strands::default();
    for i in 0..400 {
        // Fibonacci directions over the upper half.
        let t = i as f32 / 400.0;
        let (height, turn) = (1.0 - 0.75 * t, i as f32 * 2.399_963);
        let ring = (1.0 - height * height).sqrt();
        let out = Vec3::new(ring * turn.cos(), height, ring * turn.sin());
        let points: Vec<Vec3> = (0..10).map(|k| (9.0 + k as f32) * out - 0.12 * (k * k) as f32 * Vec3::Y).collect();
        strands.push(&points);
    }
    let mut layer = Layer::from_strands("tuft", strands);
    layer.radius_um = 300.0;
    let guides = Layer { source: Source::Guides(strands_of(&layer)), n_strands: 2000, ..layer };
    Groom {
        name: "small".to_owned(),
        head: Some(Head::new("ball", ball(9.0))),
        layers: vec![guides],
        ..Groom::default()
    }
}

fn strands_of(layer: &Layer) -> Arc<Strands> {
    match &layer.source {
        Source::Strands(strands) | Source::Guides(strands) => Arc::clone(strands),
        Source::HairMesh(_) => unreachable!("made of strands above"),
    }
}

fn ball(radius: f32) -> TriMesh {
    let (n_around, n_up) = (32_u32, 16_u32);
    let mut mesh = TriMesh::default();
    for j in 0..=n_up {
        for i in 0..n_around {
            let (phi, theta) =
                (i as f32 / n_around as f32 * std::f32::consts::TAU, j as f32 / n_up as f32 * std::f32::consts::PI);
            mesh.positions.push(radius * Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()));
        }
    }
    for j in 0..n_up {
        for i in 0..n_around {
            let at = |i: u32, j: u32| j * n_around + i % n_around;
            mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh.compute_normals();
    mesh
}

fn is_installed(program: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).stdout(Stdio::null()).status();
    found.is_ok_and(|status| status.success())
}

/// A virtual screen of its own.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn start() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        // The number is written once the server answers.
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
        Self { name: format!(":{}", line.trim()), server }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

/// A studio that runs on the display.
struct Studio<'a> {
    display: &'a Display,
    folder: PathBuf,
    report: PathBuf,
    process: Child,
    window: String,
}

impl<'a> Studio<'a> {
    fn open(display: &'a Display, folder: &Path, file: &Path, run: &str) -> Self {
        use std::os::unix::fs::PermissionsExt;
        let runtime = folder.join("runtime");
        std::fs::create_dir_all(&runtime).unwrap();
        std::fs::set_permissions(&runtime, std::fs::Permissions::from_mode(0o700)).unwrap();
        let report = folder.join(format!("state_{run}.jsonl"));
        let log = std::fs::File::create(folder.join(format!("log_{run}.txt"))).unwrap();
        let process = Command::new(env!("CARGO_BIN_EXE_lorelei"))
            .arg(file)
            .arg("--report-state")
            .arg(&report)
            .arg("--data-folder")
            .arg(folder.join("data"))
            .env("DISPLAY", &display.name)
            .env("XDG_RUNTIME_DIR", &runtime)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("DBUS_SESSION_BUS_ADDRESS")
            .current_dir(folder)
            .stderr(log)
            .spawn()
            .unwrap();
        let mut studio = Self { display, folder: folder.to_owned(), report, process, window: String::new() };
        studio.wait("the window", |_| true);
        studio.window = studio.xdotool(&["search", "--sync", "--onlyvisible", "--name", "Lorelei"]);
        studio.window = studio.window.lines().next().unwrap_or_default().to_owned();
        // There is no window manager: events go where the focus was put, once the window is ready for it.
        studio.wait("a picture to focus on", |state| state["still"] == true);
        studio.focus();
        studio
    }

    fn focus(&mut self) {
        let start = Instant::now();
        while self.state()["focused"] != true {
            self.xdotool(&["windowfocus", &self.window.clone()]);
            assert!(start.elapsed() < LIMIT, "the window takes no focus");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool").env("DISPLAY", &self.display.name).args(arguments).output().unwrap();
        assert!(output.status.success(), "xdotool {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn key(&self, key: &str) {
        self.xdotool(&["key", "--clearmodifiers", key]);
    }

    fn type_text(&self, text: &str) {
        self.xdotool(&["type", "--delay", "30", text]);
    }

    /// Press, move in steps as a hand does, release; each once the studio has seen the one before.
    fn drag(&mut self, button: u32, from: (f64, f64), to: (f64, f64)) {
        let button = button.to_string();
        self.move_to(from);
        self.xdotool(&["mousedown", &button]);
        self.wait("the press", |state| state["pointer_down"] == true);
        for step in 1..=4 {
            let share = f64::from(step) / 4.0;
            self.move_to((from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1)));
        }
        self.xdotool(&["mouseup", &button]);
        self.wait("the release", |state| state["pointer_down"] == false);
    }

    fn move_to(&mut self, (x, y): (f64, f64)) {
        let (x, y) = (x.round(), y.round());
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
        self.wait("the pointer", |state| {
            state["pointer"].is_array() && {
                let [px, py] = numbers(&state["pointer"]);
                (px - x).abs() < 1.5 && (py - y).abs() < 1.5
            }
        });
    }

    /// The state that was reported last; null before the first.
    fn state(&self) -> Value {
        let text = std::fs::read_to_string(&self.report).unwrap_or_default();
        let complete = text.rfind('\n').map_or("", |end| &text[..end]);
        complete.lines().last().map_or(Value::Null, |line| serde_json::from_str(line).unwrap())
    }

    fn wait(&mut self, what: &str, is_there: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let state = self.state();
            if !state.is_null() && is_there(&state) {
                return state;
            }
            if let Some(status) = self.process.try_wait().unwrap() {
                panic!("the studio ended ({status}) while the test waited for {what}; see {}", self.folder.display());
            }
            assert!(start.elapsed() < LIMIT, "waited too long for {what}; the state is {state:#}");
            std::thread::sleep(Duration::from_millis(40));
        }
    }

    fn screenshot(&self, name: &str) -> image::RgbImage {
        let path = self.folder.join(format!("{name}.png"));
        let status = Command::new("import")
            .env("DISPLAY", &self.display.name)
            .args(["-window", "root"])
            .arg(&path)
            .status()
            .unwrap();
        assert!(status.success());
        image::open(&path).unwrap().to_rgb8()
    }

    /// Ctrl+Q, and the process ends well.
    fn quit(mut self) {
        self.key("ctrl+q");
        let start = Instant::now();
        loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                assert!(status.success(), "the studio ended with {status}");
                return;
            }
            assert!(start.elapsed() < LIMIT, "the studio did not close: {:#}", self.state());
            std::thread::sleep(Duration::from_millis(40));
        }
    }
}

impl Drop for Studio<'_> {
    fn drop(&mut self) {
        self.process.kill().ok();
        self.process.wait().ok();
    }
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = value.as_array().expect("numbers").iter().map(|v| v.as_f64().unwrap()).collect();
    numbers.try_into().expect("as many numbers")
}

/// Mean absolute difference of two screenshots within a rectangle, 0-1.
fn difference(a: &image::RgbImage, b: &image::RgbImage, [left, top, right, bottom]: [f64; 4]) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for y in top as u32..(bottom as u32).min(a.height()) {
        for x in left as u32..(right as u32).min(a.width()) {
            for (p, q) in a.get_pixel(x, y).0.iter().zip(b.get_pixel(x, y).0) {
                sum += (f64::from(*p) - f64::from(q)).abs() / 255.0;
                n += 1.0;
            }
        }
    }
    sum / n
}
