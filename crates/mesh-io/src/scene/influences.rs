//! Joints and weights of skins in bytes.

use super::replace::NewPrimitive;
use super::vertex_data::VertexData;
use crate::scalars::ScalarType;
use std::collections::HashMap;

/// Weights of a vertex have this sum.
const WHOLE: u8 = u8::MAX;

/// Why weights stay as they are.
pub(super) const NEGATIVE: &str = "some are negative, or no numbers";

/// The joints and weights of a set, four for each vertex.
pub(super) type Set = [VertexData; 2];

impl NewPrimitive {
    /// Rounds the weights of skins as [`Scene::quantized`](crate::Scene::quantized) does. Weights that are integers
    /// already stay as they are.
    pub fn round_weights(&mut self) {
        let attributes = self.attributes.iter().enumerate();
        let named: HashMap<&str, usize> =
            attributes.map(|(place, data)| (&*data.name, place)).collect();
        let place = |name: String| named.get(&*name).copied();
        let sets = (0..).map_while(|set: usize| {
            Some([place(format!("JOINTS_{set}"))?, place(format!("WEIGHTS_{set}"))?])
        });
        let places: Vec<[usize; 2]> = sets.collect();
        let data = |places: &[usize; 2]| places.map(|place| self.attributes.get(place).cloned());
        let sets = places.iter().map(data).map(|[joints, weights]| Some([joints?, weights?]));
        let Some(sets) = sets.collect::<Option<Vec<Set>>>() else { return };
        let Ok(Some(rounded)) = rounded(&sets) else { return };
        for (place, data) in places.as_flattened().iter().zip(rounded.into_iter().flatten()) {
            if let Some(slot) = self.attributes.get_mut(*place) {
                *slot = data;
            }
        }
    }
}

/// The weights of each vertex as bytes whose sum is 255, over all sets, and the joints as bytes if they fit. A joint
/// without weight is joint 0. `None` if there is nothing to round.
///
/// # Errors
/// The reason why the weights have no such form.
pub(super) fn rounded(sets: &[Set]) -> Result<Option<Vec<Set>>, &'static str> {
    let Some([_, first]) = sets.first() else { return Ok(None) };
    let count = first.count();
    let is_sound = |[joints, weights]: &Set| {
        let have_four = joints.width == 4 && weights.width == 4;
        let is_whole = joints.component.is_integer() && !joints.normalized;
        let fits = joints.count() == count && weights.count() == count;
        have_four && is_whole && fits && weights.component == ScalarType::F32
    };
    if !sets.iter().all(is_sound) {
        return Ok(None);
    }
    let of_vertex = |vertex: usize, part: usize| -> Vec<f64> {
        sets.iter().flat_map(|set| (0..4).map(move |k| set[part].get(vertex, k))).collect()
    };
    let mut all = Vec::with_capacity(count);
    for vertex in 0..count {
        let weights = of_vertex(vertex, 1);
        if weights.iter().any(|weight| !(*weight >= 0.0 && weight.is_finite())) {
            return Err(NEGATIVE);
        }
        let shares = shares(&weights);
        let joints = of_vertex(vertex, 0).into_iter().zip(&shares);
        let joints = joints.map(|(joint, &share)| if share == 0 { 0.0 } else { joint });
        all.push((joints.collect::<Vec<f64>>(), shares));
    }
    let most = all.iter().flat_map(|(joints, _)| joints).copied().fold(0.0, f64::max);
    let component = if most > f64::from(u8::MAX) { ScalarType::U16 } else { ScalarType::U8 };
    let new = |(set, [joints, weights]): (usize, &Set)| {
        let part = 4 * set..4 * set + 4;
        let mut joints = VertexData { component, ..joints.empty() };
        let mut weights =
            VertexData { component: ScalarType::U8, normalized: true, ..weights.empty() };
        let form = joints.empty();
        for (of_vertex, shares) in &all {
            let own = of_vertex.get(part.clone()).unwrap_or_default();
            own.iter().for_each(|&joint| form.encode(joint, &mut joints.bytes));
            weights.bytes.extend_from_slice(shares.get(part.clone()).unwrap_or_default());
        }
        [joints, weights]
    };
    Ok(Some(sets.iter().enumerate().map(new).collect()))
}

/// Shares of 255 in proportion to weights: rounded down, and then up where the remainders are largest.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "parts of 255, rounded down"
)]
fn shares(weights: &[f64]) -> Vec<u8> {
    let sum: f64 = weights.iter().sum();
    if sum <= 0.0 {
        return vec![0; weights.len()];
    }
    let exact: Vec<f64> = weights.iter().map(|weight| weight / sum * f64::from(WHOLE)).collect();
    let mut shares: Vec<u8> = exact.iter().map(|&part| part as u8).collect();
    let rest =
        usize::from(WHOLE).saturating_sub(shares.iter().map(|&part| usize::from(part)).sum());
    let mut order: Vec<(usize, f64)> = exact.iter().map(|part| part.fract()).enumerate().collect();
    order.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    for (place, _) in order.into_iter().take(rest) {
        if let Some(share) = shares.get_mut(place) {
            *share = share.saturating_add(1);
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::shares;

    #[test]
    fn shares_are_nearest_with_the_sum_of_all() {
        for weights in [
            vec![1.0],
            vec![0.5, 0.5, 0.0, 0.0],
            vec![0.1, 0.2, 0.3, 0.4, 1e-6, 0.0, 0.0, 0.0],
            vec![1.0 / 3.0; 3],
            vec![0.2, 0.2],
            (1..9).map(f64::from).collect(),
        ] {
            let sum: f64 = weights.iter().sum();
            let found = shares(&weights);
            assert_eq!(found.iter().map(|&share| u32::from(share)).sum::<u32>(), 255);
            for (&share, weight) in found.iter().zip(&weights) {
                assert!((f64::from(share) - 255.0 * weight / sum).abs() < 1.0, "{weights:?}");
            }
        }
        assert_eq!(shares(&[0.0; 4]), [0; 4]);
    }
}
