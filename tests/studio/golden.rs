//! This machine renders every choice of every slot as the golden images show it.

use lorelei_shaders::Gpu;
use lorelei_tests::golden::compare::{Difference, MOST_RMSE};
use lorelei_tests::golden::{Outcome, cases, compare, folder};
use lorelei_tests::root;

const HOW: &str = "look at out/golden/; where the change is meant, `cargo xtask golden write` makes the pictures anew";

#[test]
fn every_choice_of_every_slot_looks_as_its_golden_image() {
    let gpu = Gpu::headless().unwrap();
    let outcomes = compare(&gpu, &folder(), &root().join("out").join("golden")).unwrap();
    let lines: Vec<String> = outcomes.iter().map(Outcome::to_string).collect();
    println!("{}", lines.join("\n"));
    assert!(outcomes.iter().all(Outcome::is_within), "{HOW}:\n{}", lines.join("\n"));
}

#[test]
fn golden_images_are_those_of_the_slots_and_tell_the_choices_apart() {
    let cases = cases::all();
    let picture = |case: &cases::Case| {
        let path = case.path(&folder());
        image::open(&path).unwrap_or_else(|why| panic!("{}: {why}; {HOW}", path.display())).to_rgba8()
    };
    let default = picture(&cases[0]);
    for case in cases[1..].iter().filter(|case| !case.is_another_way()) {
        let apart = Difference::between(&default, &picture(case)).unwrap();
        let least = if case.is_subtle() { 0.2 * MOST_RMSE } else { MOST_RMSE };
        assert!(apart.rmse > least, "{} is within the tolerance of the default: {apart}", case.name);
    }
    let n_files = std::fs::read_dir(folder()).unwrap().count();
    assert_eq!(n_files, cases.len(), "there are pictures of choices that are gone in {}", folder().display());
}
