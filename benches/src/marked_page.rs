//! Pages with tables between marker comments, which are written from a record.
//!
//! A block starts with `<!-- NAME: TABLE -->` and ends with `<!-- NAME: end -->`.

use xtask_common::Failure;

/// The page with all blocks of a name written anew, and the number of blocks. `table` makes the text of a table.
pub(crate) fn rewrite(
    page: &str,
    name: &str,
    table: impl Fn(&str) -> Result<String, Failure>,
) -> Result<(String, usize), Failure> {
    let (start, end) = (format!("<!-- {name}: "), format!("<!-- {name}: end -->"));
    let mut text = String::new();
    let mut blocks = 0;
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        text.push_str(line);
        text.push('\n');
        let marker = line.strip_prefix(&start).and_then(|rest| rest.strip_suffix(" -->"));
        let Some(marker) = marker else { continue };
        text.push_str(&format!("\n{}\n{end}\n", table(marker)?));
        blocks += 1;
        if !lines.by_ref().any(|line| line == end) {
            return Err(Failure::Usage(format!("after `{line}` there is no `{end}`")));
        }
    }
    Ok((text, blocks))
}
