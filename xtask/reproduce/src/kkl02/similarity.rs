//! Whether two norms give similar results.

use super::super::item::Item;
use super::super::outcome::Outcome;

/// Results whose mean errors are within this factor are similar; within the other, roughly.
const SIMILAR: f64 = 1.25;
const ROUGHLY: f64 = 2.5;

/// Whether the results of two norms are similar, from the mean errors by L2 over those by L1.
pub(super) fn add_similarity_claim(item: &mut Item, name: &str, ratios: [f64; 3]) {
    let how =
        format!("the mean error by L2 over that by L1 at the three levels is {}", list(ratios));
    item.claim(name, similar(ratios), how);
}

fn similar(ratios: [f64; 3]) -> Outcome {
    let within = |factor: f64| ratios.iter().all(|r| (1.0 / factor..factor).contains(r));
    match (within(SIMILAR), within(ROUGHLY)) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    }
}

pub(super) fn list(ratios: [f64; 3]) -> String {
    ratios.map(|ratio| format!("{ratio:.2}")).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_that_differ_turn_the_verdict() {
        assert_eq!(similar([1.0, 1.1, 0.9]), Outcome::Holds);
        assert_eq!(similar([1.0, 1.1, 0.5]), Outcome::InPart);
        assert_eq!(similar([1.0, 1.1, 4.0]), Outcome::Fails);
    }
}
