//! `cargo xtask bake`: what is embedded in the studio, made anew by the project's own code.

pub fn bake(args: &[String]) -> Result<(), String> {
    Err(format!("nothing is baked yet ({args:?})"))
}
