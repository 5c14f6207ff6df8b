//! Tables in pages, between marker comments, written from a record.
//!
//! A block starts with `<!-- peers: KIND -->` or `<!-- peers: KIND, ratios to TOOL -->` and ends with
//! `<!-- peers: end -->`. The kinds are `full`, `short`, `distances`, `validity`, `compare`, `worst`, `wins` and `tools`.
//! For `worst` the tool is the one whose worst cells are listed.

use super::record::Record;
use super::table;
use xtask_common::Failure;

/// The page with all its blocks written anew, and the number of blocks.
pub(super) fn rewrite(page: &str, rows: &[Record]) -> Result<(String, usize), Failure> {
    crate::marked_page::rewrite(page, "peers", |marker| block(marker, rows))
}

fn block(marker: &str, rows: &[Record]) -> Result<String, Failure> {
    let (kind, base) = match marker.split_once(", ratios to ") {
        Some((kind, base)) => (kind, Some(base)),
        None => (marker, table::usual_base(rows)),
    };
    let base = base.unwrap_or_default();
    if !rows.iter().any(|row| row.name == base) {
        return Err(Failure::Usage(format!("table `{marker}`: the record has no `{base}`")));
    }
    match kind {
        "full" => Ok(table::full(rows, base)),
        "short" => Ok(table::short(rows, base)),
        "distances" => Ok(table::distances(rows, base)),
        "validity" => Ok(table::validity(rows)),
        "compare" => Ok(table::compare(rows, base)),
        "worst" => Ok(table::worst(rows, base)),
        "wins" => Ok(table::wins(rows)),
        "tools" => Ok(table::tools(rows)),
        _ => Err(Failure::Usage(format!(
            "there is no table `{kind}`; there are full, short, distances, validity, compare, worst, wins and tools"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::record::tests::record;

    #[test]
    fn blocks_are_replaced_and_the_rest_is_kept() {
        let rows = [record("fast", 100, 1.0, 3.0), record("meshlab", 100, 4.0, 2.0)];
        let page = "a\n<!-- peers: short, ratios to fast -->\nold\n<!-- peers: end -->\nb\n";
        let (new, blocks) = rewrite(page, &rows).unwrap();
        assert_eq!(blocks, 1);
        assert!(new.starts_with("a\n") && new.ends_with("\n<!-- peers: end -->\nb\n"), "{new}");
        assert!(!new.contains("old") && new.contains("| MeshLab | 4.00 |"), "{new}");
        assert_eq!(rewrite(&new, &rows).unwrap(), (new, 1));
    }

    #[test]
    fn wrong_markers_are_refused() {
        let rows = [record("fast", 100, 1.0, 3.0)];
        for page in [
            "<!-- peers: short -->\n",
            "<!-- peers: long -->\n<!-- peers: end -->\n",
            "<!-- peers: short, ratios to cgal-lt -->\n<!-- peers: end -->\n",
        ] {
            assert!(rewrite(page, &rows).is_err(), "{page}");
        }
    }
}
