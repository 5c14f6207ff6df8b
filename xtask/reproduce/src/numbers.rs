//! How the numbers of a row are written.

use super::row::{Content, Row};
use xtask_common::decimals::{decimals_of, plain, with_decimals};

/// The printed number and ours, with as many decimals as the paper has but at least enough to tell
/// them apart.
pub(super) fn pair(row: &Row) -> [String; 2] {
    match &row.content {
        Content::Number { printed, ours, .. } => {
            let decimals = printed.map(decimals_of);
            let ours = ours.map(|x| decimals.map_or_else(|| plain(x), |d| with_decimals(x, d)));
            [printed.map(|p| with_decimals(p, decimals_of(p))), ours].map(Option::unwrap_or_default)
        }
        Content::Claim { .. } => Default::default(),
    }
}

/// What an independent program gave, and how far ours is from it.
pub(super) fn reference(row: &Row) -> String {
    let Content::Number { reference: Some(reference), ours, .. } = row.content else {
        return String::new();
    };
    let share = ours.map(|ours| 100.0 * (ours / reference - 1.0)).filter(|share| share.is_finite());
    match share {
        Some(share) if share.abs() >= 0.05 => format!("{reference} ({share:+.1} %)"),
        _ => reference.to_string(),
    }
}

/// Ours less the printed one.
pub(super) fn difference(row: &Row) -> String {
    match row.difference() {
        Some(0.0) => "0".into(),
        Some(d) if d.fract() == 0.0 => format!("{d:+}"),
        Some(d) => format!("{d:+.1e}"),
        None => String::new(),
    }
}
