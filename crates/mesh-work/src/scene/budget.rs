//! Divides a number of faces among meshes, so that the largest errors are equal.

/// The error of a mesh at several numbers of faces.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// The number of times that the mesh is drawn.
    pub(super) times: usize,
    /// Numbers of faces, falling, each with the error there. The first is the whole mesh.
    pub(super) points: Vec<(usize, f64)>,
    /// The mesh keeps at least this many faces.
    pub(super) least: usize,
}

impl Curve {
    /// The number of faces with this error: between two points by linear interpolation. An error that falls where
    /// faces are fewer counts as the one before.
    fn faces(&self, error: f64) -> f64 {
        let mut last: Option<(f64, f64)> = None;
        for &(faces, own) in &self.points {
            let faces = faces as f64;
            let (before, highest) = last.unwrap_or((faces, own));
            let own = own.max(highest);
            if own > error {
                let share = (error - highest) / (own - highest);
                return (before + share * (faces - before)).max(self.least as f64);
            }
            last = Some((faces, own));
        }
        last.map_or(0.0, |(faces, _)| faces).max(self.least as f64)
    }
}

/// Halvings of the error: more than the digits of a number.
const HALVINGS: usize = 100;

/// The numbers of faces of meshes that are drawn with at most `budget` faces, with an equal error as far as the curves
/// allow it. If even the largest error needs more faces, each mesh gets its least.
pub(super) fn split(curves: &[Curve], budget: usize) -> Vec<usize> {
    let shares =
        |error: f64| -> Vec<f64> { curves.iter().map(|curve| curve.faces(error)).collect() };
    let fits = |error: f64| {
        let drawn = shares(error).into_iter().zip(curves).map(|(n, curve)| n * curve.times as f64);
        drawn.sum::<f64>() <= budget as f64
    };
    let errors = curves.iter().flat_map(|curve| &curve.points).map(|&(_, error)| error);
    let (mut low, mut high) = (0.0, errors.fold(0.0, f64::max));
    if fits(low) {
        high = low;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if fits(middle) { high = middle } else { low = middle }
    }
    whole(&shares(high), curves, budget)
}

/// Rounds the numbers of faces down, and then up where the largest parts were cut off, as long as there is room.
fn whole(shares: &[f64], curves: &[Curve], budget: usize) -> Vec<usize> {
    let mut faces: Vec<usize> = shares.iter().map(|&share| share as usize).collect();
    let drawn: usize = faces.iter().zip(curves).map(|(faces, curve)| faces * curve.times).sum();
    let mut left = budget.saturating_sub(drawn);
    let mut order: Vec<usize> = (0..faces.len()).collect();
    order.sort_by(|&i, &j| shares[j].fract().total_cmp(&shares[i].fract()));
    for i in order.into_iter().filter(|&i| shares[i].fract() > 0.0) {
        if curves[i].times <= left {
            left -= curves[i].times;
            faces[i] += 1;
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error of a smooth surface: in inverse proportion to the number of faces.
    fn smooth(times: usize, size: f64, faces: usize) -> Curve {
        let counts = (0..12).map(|step| faces >> step);
        let points = counts.map(|n| (n, size * (1.0 / n as f64 - 1.0 / faces as f64))).collect();
        Curve { times, points, least: 4 }
    }

    #[test]
    fn the_largest_errors_are_equal_and_the_faces_fit() {
        let curves = [smooth(1, 10.0, 100_000), smooth(3, 1.0, 100_000), smooth(1, 1e-3, 100_000)];
        for budget in [100, 1_000, 10_000, 150_000] {
            let faces = split(&curves, budget);
            let drawn: usize = faces.iter().zip(&curves).map(|(n, curve)| n * curve.times).sum();
            assert!(drawn <= budget && drawn + 5 > budget, "{drawn} of {budget}");
            let error = |i: usize, n: usize| {
                let size = [10.0, 1.0, 1e-3][i];
                size * (1.0 / n as f64 - 1e-5)
            };
            // Linear interpolation between points a factor of two apart is off by up to an eighth.
            let errors: Vec<f64> = (0..2).map(|i| error(i, faces[i])).collect();
            assert!((errors[0] / errors[1] - 1.0).abs() < 0.3, "{errors:?} {faces:?}");
            assert!(faces[2] >= 4);
        }
    }

    #[test]
    fn nothing_changes_where_all_faces_fit_and_each_mesh_keeps_its_least() {
        let curves = [smooth(1, 1.0, 1000), smooth(2, 1.0, 500)];
        assert_eq!(split(&curves, 2000), [1000, 500]);
        let flat = Curve { times: 1, points: vec![(1000, 0.0), (10, 0.0)], least: 4 };
        assert_eq!(split(&[flat.clone(), smooth(1, 1.0, 500)], 510), [10, 500]);
        let kept = Curve { least: 300, ..flat };
        assert_eq!(split(&[kept, smooth(1, 1.0, 512)], 20)[0], 300);
    }

    #[test]
    fn an_error_that_falls_counts_as_the_one_before() {
        let points = vec![(100, 0.0), (50, 2.0), (25, 1.0), (10, 4.0)];
        let curve = Curve { times: 1, points, least: 1 };
        assert_eq!(curve.faces(2.0), 25.0);
        assert_eq!(curve.faces(3.0), 17.5);
        assert_eq!(curve.faces(9.0), 10.0);
    }
}
