//! Numbers out of the program's own JSON.

/// The number after `"key":` in the program's own flat JSON. A JSON library would be this program's only dependency.
pub fn number(json: &str, key: &str) -> Result<f64, String> {
    let missing = || format!("lorelei printed no `{key}`: {json}");
    let after = json.split_once(&format!("\"{key}\":")).ok_or_else(missing)?.1.trim_start();
    let end = after.find(|c: char| !(c.is_ascii_digit() || ".-+eE".contains(c))).unwrap_or(after.len());
    after[..end].parse().map_err(|_| missing())
}

/// The text after `"key":`, where there is one.
pub fn text(json: &str, key: &str) -> Option<String> {
    let after = json.split_once(&format!("\"{key}\":"))?.1.trim_start().strip_prefix('"')?;
    Some(after.split('"').next()?.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_texts_are_read_from_flat_json() {
        let json = r#"{"adapter": "llvmpipe (LLVM 15)", "frame_ms": 12.5e1, "out": "x.png"}"#;
        assert_eq!(number(json, "frame_ms"), Ok(125.0));
        assert_eq!(text(json, "adapter").as_deref(), Some("llvmpipe (LLVM 15)"));
        assert!(number(json, "missing").is_err());
    }
}
