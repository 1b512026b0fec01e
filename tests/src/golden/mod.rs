//! Golden images: one picture for each choice of each slot, compared within a stated tolerance.
//!
//! Three uses of one list of cases: a test compares this machine with `tests/golden/`; `golden compare` compares any
//! two machines, with no cargo there; `golden write` makes the pictures anew.

pub mod cases;
pub mod compare;
pub mod groom;

use std::path::{Path, PathBuf};

use image::RgbaImage;
use lorelei_shaders::Gpu;

use cases::{Case, Studio};
use compare::Difference;

/// Where the pictures of the test lie.
pub fn folder() -> PathBuf {
    crate::root().join("tests").join("golden")
}

/// Write every case's picture; returns how many.
pub fn write(gpu: &Gpu, folder: &Path) -> Result<usize, String> {
    std::fs::create_dir_all(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut studio = Studio::new(gpu)?;
    let cases = cases::all();
    for case in &cases {
        let path = case.path(folder);
        studio.render(case)?.save(&path).map_err(|why| format!("{}: {why}", path.display()))?;
    }
    Ok(cases.len())
}

/// How one case came out.
#[derive(Debug)]
pub struct Outcome {
    pub case: Case,
    /// The difference, or why there is none: no picture on disk, another size.
    pub difference: Result<Difference, String>,
}

impl Outcome {
    pub fn is_within(&self) -> bool {
        let is_blended = self.case.is_blended();
        self.difference.as_ref().is_ok_and(|difference| difference.is_within(is_blended))
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mark = if self.is_within() { "ok" } else { "DIFFERENT" };
        match &self.difference {
            Ok(difference) => write!(f, "{:<32} {difference}  {mark}", self.case.name),
            Err(why) => write!(f, "{:<32} {why}  {mark}", self.case.name),
        }
    }
}

/// Render every case and compare it with its picture in `folder`. What is outside the tolerance is written to `out`:
/// `NAME.new.png`, and `NAME.difference.png`, ten times the absolute difference.
pub fn compare(gpu: &Gpu, folder: &Path, out: &Path) -> Result<Vec<Outcome>, String> {
    let mut studio = Studio::new(gpu)?;
    let mut outcomes = Vec::new();
    for case in cases::all() {
        let new = studio.render(&case)?;
        let path = case.path(folder);
        let golden = image::open(&path).map(|picture| picture.to_rgba8());
        let difference = match &golden {
            Ok(golden) => Difference::between(golden, &new),
            Err(why) => Err(format!("{}: {why}", path.display())),
        };
        let outcome = Outcome { case, difference };
        if !outcome.is_within() {
            keep(&outcome.case, golden.ok().as_ref(), &new, out)?;
        }
        outcomes.push(outcome);
    }
    Ok(outcomes)
}

fn keep(case: &Case, golden: Option<&RgbaImage>, new: &RgbaImage, out: &Path) -> Result<(), String> {
    let failed = |why: &dyn std::fmt::Display| format!("{}: {why}", out.display());
    std::fs::create_dir_all(out).map_err(|why| failed(&why))?;
    let stem = case.path(out).with_extension("");
    new.save(stem.with_extension("new.png")).map_err(|why| failed(&why))?;
    if let Some(golden) = golden.filter(|golden| golden.dimensions() == new.dimensions()) {
        let picture = compare::difference_picture(golden, new);
        picture.save(stem.with_extension("difference.png")).map_err(|why| failed(&why))?;
    }
    Ok(())
}
