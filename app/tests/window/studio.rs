//! Drives a studio on a virtual display with the events of a real mouse and keyboard.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;

/// A software driver on a busy machine compiles shaders and draws its first frame within this.
const LIMIT: Duration = Duration::from_mins(5);

static ALONE: Mutex<()> = Mutex::new(());

/// An empty folder for a story's files, and the right to be the only one that runs: two studios on a software driver
/// would make each other wait. `None`, with a line that says so, where the machine lacks what a story needs.
pub fn begin(story: &str) -> Option<(MutexGuard<'static, ()>, PathBuf)> {
    let missing: Vec<&str> =
        ["Xvfb", "xdotool", "import"].into_iter().filter(|program| !is_installed(program)).collect();
    if !missing.is_empty() || !cfg!(target_os = "linux") {
        println!("skipped: {} not installed (apt-get install xvfb xdotool imagemagick)", missing.join(", "));
        return None;
    }
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("window").join(story);
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).unwrap();
    println!("screenshots: {}", folder.display());
    Some((alone, folder))
}

fn is_installed(program: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).stdout(Stdio::null()).status();
    found.is_ok_and(|status| status.success())
}

/// A virtual screen of its own.
pub struct Display {
    server: Child,
    name: String,
}

impl Display {
    pub fn start() -> Self {
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
pub struct Studio<'a> {
    display: &'a Display,
    folder: PathBuf,
    report: PathBuf,
    process: Child,
    window: String,
}

impl<'a> Studio<'a> {
    /// Open the studio with arguments of its own; waits until there is a picture to focus on.
    pub fn open(display: &'a Display, folder: &Path, arguments: &[&str], run: &str) -> Self {
        use std::os::unix::fs::PermissionsExt;
        let runtime = folder.join("runtime");
        std::fs::create_dir_all(&runtime).unwrap();
        std::fs::set_permissions(&runtime, std::fs::Permissions::from_mode(0o700)).unwrap();
        let report = folder.join(format!("state_{run}.jsonl"));
        let log = std::fs::File::create(folder.join(format!("log_{run}.txt"))).unwrap();
        let process = Command::new(env!("CARGO_BIN_EXE_lorelei"))
            .args(arguments)
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

    /// The process's death, as a crash would be: nothing is written any more.
    pub fn kill(mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }

    /// The middle of a control that the window has named.
    pub fn place_of(&mut self, mark: &str) -> (f64, f64) {
        let state = self.wait(mark, |state| state["marks"][mark].is_array());
        let [left, top, right, bottom] = numbers(&state["marks"][mark]);
        (f64::midpoint(left, right), f64::midpoint(top, bottom))
    }

    /// Until no control has moved for a moment: what scrolls has stopped. (Other things go on while hair moves.)
    pub fn rest(&mut self) {
        let start = Instant::now();
        let mut before = self.state()["marks"].clone();
        loop {
            std::thread::sleep(Duration::from_millis(400));
            let now = self.state()["marks"].clone();
            if now == before {
                return;
            }
            assert!(start.elapsed() < LIMIT, "the controls do not come to rest");
            before = now;
        }
    }

    /// Put the pointer on a control, once it has stopped moving.
    pub fn hover(&mut self, mark: &str) -> (f64, f64) {
        let mut before = self.place_of(mark);
        loop {
            self.move_to(before);
            let now = self.place_of(mark);
            if now == before {
                return now;
            }
            before = now;
        }
    }

    pub fn click(&mut self, mark: &str) {
        self.hover(mark);
        self.xdotool(&["click", "1"]);
    }

    /// Turn the wheel over the panel of a control that is seen until another one lies between two heights, as a
    /// person would who looks for it.
    pub fn scroll_to(&mut self, seen: &str, wanted: &str, [top, bottom]: [f64; 2]) {
        let (x, _) = self.place_of(seen);
        for _ in 0..60 {
            let at = self.state()["marks"][wanted].clone();
            let y = at.is_array().then(|| numbers::<4>(&at)).map(|[_, top, _, bottom]| f64::midpoint(top, bottom));
            if y.is_some_and(|y| (top..bottom).contains(&y)) {
                return;
            }
            let is_above = y.is_some_and(|y| y < top);
            // Half of the way at a time: how far a click goes is the window's own.
            let way = y.map_or(0.0, |y| (y - f64::midpoint(top, bottom)).abs());
            let n_clicks = (way / 160.0).clamp(1.0, 20.0) as u32;
            self.move_to((x, f64::midpoint(top, bottom)));
            let button = if is_above { "4" } else { "5" };
            self.xdotool(&["click", "--repeat", &n_clicks.to_string(), "--delay", "20", button]);
            self.rest();
        }
        panic!("the panel does not scroll to {wanted}");
    }

    /// Run a command by its name, from the palette.
    pub fn command(&mut self, name: &str) {
        self.key("F3");
        self.wait("the palette", |state| state["palette"] == true && state["typing"] == true);
        self.type_text(name);
        self.key("Return");
        self.wait("no palette", |state| state["palette"] == false);
    }

    /// Answer the studio's own file dialog with a path.
    pub fn choose(&mut self, path: &str) {
        self.wait("the dialog", |state| state["dialog"] == true);
        self.click("dialog path");
        self.wait("the path field", |state| state["typing"] == true);
        self.key("ctrl+a");
        self.type_text(path);
        self.key("Return");
        self.wait("the path taken", |state| state["typing"] == false);
        self.click("dialog accept");
        self.wait("no dialog", |state| state["dialog"] == false);
    }

    pub fn focus(&mut self) {
        let start = Instant::now();
        while self.state()["focused"] != true {
            self.xdotool(&["windowfocus", &self.window.clone()]);
            assert!(start.elapsed() < LIMIT, "the window takes no focus");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    pub fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool").env("DISPLAY", &self.display.name).args(arguments).output().unwrap();
        assert!(output.status.success(), "xdotool {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    pub fn key(&self, key: &str) {
        self.xdotool(&["key", "--clearmodifiers", key]);
    }

    pub fn type_text(&self, text: &str) {
        self.xdotool(&["type", "--delay", "30", "--", text]);
    }

    /// Press, move in steps as a hand does, release; each once the studio has seen the one before.
    pub fn drag(&mut self, button: u32, from: (f64, f64), to: (f64, f64)) {
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

    pub fn move_to(&mut self, (x, y): (f64, f64)) {
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
    pub fn state(&self) -> Value {
        let text = std::fs::read_to_string(&self.report).unwrap_or_default();
        let complete = text.rfind('\n').map_or("", |end| &text[..end]);
        complete.lines().last().map_or(Value::Null, |line| serde_json::from_str(line).unwrap())
    }

    /// Every state that was reported, in order.
    pub fn states(&self) -> Vec<Value> {
        let text = std::fs::read_to_string(&self.report).unwrap_or_default();
        let complete = text.rfind('\n').map_or("", |end| &text[..end]);
        complete.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    pub fn wait(&mut self, what: &str, is_there: impl Fn(&Value) -> bool) -> Value {
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

    /// What is on the screen, once two looks at it in a row are the same: a state is told before it is painted. Hair
    /// that moves is taken as it is after a few looks.
    pub fn screenshot(&self, name: &str) -> image::RgbImage {
        let path = self.folder.join(format!("{name}.png"));
        let look = || {
            let status = Command::new("import")
                .env("DISPLAY", &self.display.name)
                .args(["-window", "root"])
                .arg(&path)
                .status()
                .unwrap();
            assert!(status.success());
            image::open(&path).unwrap().to_rgb8()
        };
        let mut before = look();
        for _ in 0..6 {
            std::thread::sleep(Duration::from_millis(250));
            let now = look();
            if now == before {
                break;
            }
            before = now;
        }
        before
    }

    /// Ctrl+Q, and the process ends well.
    pub fn quit(mut self) {
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

pub fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = value.as_array().expect("numbers").iter().map(|v| v.as_f64().unwrap()).collect();
    numbers.try_into().expect("as many numbers")
}

/// Mean absolute difference of two screenshots within a rectangle, 0-1.
pub fn difference(a: &image::RgbImage, b: &image::RgbImage, [left, top, right, bottom]: [f64; 4]) -> f64 {
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
