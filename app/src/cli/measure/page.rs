//! A measured table on its page of the documentation: it takes the place of the one before, and the rest stays.

use std::io::Write;
use std::path::Path;

use lorelei_core::io::write_atomically;

use super::super::CliError;

const BEGIN: &str = "<!-- measured: begin -->";
const END: &str = "<!-- measured: end -->";

/// Put a table between the marks of the page at `path`, or at `default` where no file was named.
pub(super) fn write(path: &Path, default: &str, table: &str) -> Result<(), CliError> {
    let path = if path.as_os_str().is_empty() { Path::new(default) } else { path };
    let failed = |why: String| CliError::Failed(format!("{}: {why}", path.display()));
    let page = std::fs::read_to_string(path).map_err(|why| failed(why.to_string()))?;
    let page =
        put_between(&page, table).ok_or_else(|| failed(format!("there are no lines {BEGIN} and {END} in it")))?;
    write_atomically(path, |file| file.write_all(page.as_bytes())).map_err(CliError::failed)
}

/// The page with what stands between the marks replaced.
fn put_between(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{}\n{END}{after}", table.trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_takes_the_place_of_the_old_one_and_the_page_stays() {
        let page = format!("# Title\n{BEGIN}\nold\n{END}\nwhat it means\n");
        let new = put_between(&page, "new\n").unwrap();
        assert_eq!(new, format!("# Title\n{BEGIN}\nnew\n{END}\nwhat it means\n"));
        assert_eq!(put_between("no marks", "new"), None);
    }
}
