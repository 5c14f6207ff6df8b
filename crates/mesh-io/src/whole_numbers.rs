//! Labels that a file has as floating-point numbers.

use crate::model::Model;
use crate::scalars::{ScalarValues, Scalars};

/// The largest number of different labels.
const MOST: usize = 256;

/// Beyond 2^53, all numbers are whole.
const LARGEST: f64 = 9_007_199_254_740_992.0;

/// Marks numbers without fractions as labels, if there are at least two and at most 256 different ones: class numbers of
/// programs that store all numbers in one type, and labels that are too large for the whole numbers of glTF.
pub(crate) fn mark_labels(model: &mut Model) {
    for Scalars { values, is_label, .. } in
        model.vertex_scalars.iter_mut().chain(&mut model.face_scalars)
    {
        *is_label |= match values {
            ScalarValues::F32(values) => are_labels(values.iter().map(|&value| f64::from(value))),
            ScalarValues::F64(values) => are_labels(values.iter().copied()),
            _ => false,
        };
    }
}

/// Unknown numbers do not count.
fn are_labels(values: impl Iterator<Item = f64>) -> bool {
    let mut labels: Vec<f64> = Vec::new();
    for value in values.filter(|value| !value.is_nan()) {
        // Both zeros are one label.
        let value = value + 0.0;
        if value.fract() != 0.0 || value.abs() > LARGEST {
            return false;
        }
        if let Err(place) = labels.binary_search_by(|label| label.total_cmp(&value)) {
            if labels.len() == MOST {
                return false;
            }
            labels.insert(place, value);
        }
    }
    labels.len() > 1
}

#[cfg(test)]
mod tests {
    use super::are_labels;

    #[test]
    fn few_whole_numbers_are_labels() {
        let are = |values: &[f64]| are_labels(values.iter().copied());
        assert!(!are(&[0.0, -0.0]) && !are(&[1e60, 1e70]));
        assert!(are(&[2.0, 6.0, 2.0]) && are(&[-7.0, 70_000.0, f64::NAN]));
        assert!(
            !are(&[0.0, 0.5, 1.0]) && !are(&[3.0, 3.0]) && !are(&[]) && !are(&[1.0, f64::INFINITY])
        );
        let up_to = |count: u32| are_labels((0..count).map(f64::from));
        assert!(up_to(256) && !up_to(257));
    }
}
