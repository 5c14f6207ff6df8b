//! Divides a number of faces among meshes, so that the sum of their errors is least.

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

/// Faces of a mesh that can go, and by how much the error grows with each.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    mesh: usize,
    faces: f64,
    growth: f64,
}

impl Curve {
    /// The stretches of the lower convex hull, from the whole mesh on: their growth rises.
    fn stretches(&self, mesh: usize) -> Vec<Stretch> {
        let mut hull: Vec<(f64, f64)> = Vec::new();
        let growth = |(f, e): (f64, f64), (g, h): (f64, f64)| (h - e) / (f - g);
        for &(faces, error) in &self.points {
            let point = (faces as f64, error);
            while let [.., a, b] = hull[..]
                && growth(a, b) >= growth(b, point)
            {
                hull.pop();
            }
            hull.push(point);
        }
        let least = self.least as f64;
        let stretch = |&[a, b]: &[(f64, f64); 2]| {
            let faces = a.0 - b.0.max(least);
            (faces > 0.0).then(|| Stretch { mesh, faces, growth: growth(a, b) })
        };
        hull.array_windows::<2>().filter_map(stretch).collect()
    }
}

/// The numbers of faces of meshes that are drawn with at most `budget` faces. Faces go where the sum of the errors grows
/// least. If even the least faces of all meshes are more, each mesh gets its least.
pub(super) fn split(curves: &[Curve], budget: usize) -> Vec<usize> {
    let whole = curves.iter().map(|curve| curve.points.first().map_or(0, |point| point.0));
    let mut faces: Vec<f64> = whole.map(|faces| faces as f64).collect();
    let drawn = faces.iter().zip(curves).map(|(faces, curve)| faces * curve.times as f64);
    let mut excess = drawn.sum::<f64>() - budget as f64;
    let all = curves.iter().enumerate();
    let mut stretches: Vec<Stretch> = all.flat_map(|(mesh, curve)| curve.stretches(mesh)).collect();
    // The sort is stable, so the stretches of a mesh stay in order.
    stretches.sort_by(|a, b| a.growth.total_cmp(&b.growth));
    for Stretch { mesh, faces: there, .. } in stretches {
        let times = curves[mesh].times as f64;
        let removed = there.min((excess / times).max(0.0));
        faces[mesh] -= removed;
        excess -= removed * times;
    }
    rounded(&faces, curves, budget)
}

/// Rounds the numbers of faces down, and then up where the largest parts were cut off, as long as there is room.
fn rounded(shares: &[f64], curves: &[Curve], budget: usize) -> Vec<usize> {
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

    /// The squared error of a smooth surface, in inverse proportion to the square of the number of faces.
    fn smooth(times: usize, size: f64, faces: usize) -> Curve {
        let error = |n: usize| size * ((n as f64).powi(-2) - (faces as f64).powi(-2));
        let points = (0..12).map(|step| faces >> step).filter(|&n| n > 0).map(|n| (n, error(n)));
        Curve { times, points: points.collect(), least: 4 }
    }

    /// The error at a number of faces, linear between the points.
    fn error(curve: &Curve, faces: usize) -> f64 {
        let at =
            |[(f, e), (g, h)]: [(usize, f64); 2]| e + (h - e) * (f - faces) as f64 / (f - g) as f64;
        let between = |pair: &&[(usize, f64); 2]| pair[0].0 >= faces && faces >= pair[1].0;
        curve.points.array_windows::<2>().find(between).map_or(f64::INFINITY, |&pair| at(pair))
    }

    #[test]
    fn the_sum_of_errors_is_the_least_of_all_divisions() {
        for (sizes, times) in [([1.0, 1.0], [1, 1]), ([9.0, 1.0], [1, 2]), ([1e-3, 5.0], [3, 1])] {
            let curves = [0, 1].map(|i| smooth(times[i], sizes[i], 128));
            for budget in [40, 90, 200] {
                let found = split(&curves, budget);
                let drawn = |faces: &[usize]| faces[0] * times[0] + faces[1] * times[1];
                assert!(drawn(&found) <= budget, "{found:?} {budget}");
                let sum = |faces: &[usize]| {
                    (0..2).map(|i| times[i] as f64 * error(&curves[i], faces[i])).sum::<f64>()
                };
                let pairs = (4..=128_usize).flat_map(|a| (4..=128_usize).map(move |b| [a, b]));
                let best = pairs.filter(|pair| drawn(pair) <= budget).map(|pair| sum(&pair));
                let best = best.fold(f64::INFINITY, f64::min);
                // A rounded face of the other mesh may be worth a little.
                assert!(sum(&found) <= best * 1.1 + 1e-12, "{found:?} {} {best}", sum(&found));
            }
        }
    }

    #[test]
    fn nothing_changes_where_all_faces_fit_and_each_mesh_keeps_its_least() {
        let curves = [smooth(1, 1.0, 1000), smooth(2, 1.0, 500)];
        assert_eq!(split(&curves, 2000), [1000, 500]);
        let flat = Curve { times: 1, points: vec![(1000, 0.0), (10, 0.0)], least: 4 };
        assert_eq!(split(&[flat.clone(), smooth(1, 1.0, 500)], 510), [10, 500]);
        let kept = Curve { least: 300, ..flat };
        assert_eq!(split(&[kept, smooth(1, 1.0, 512)], 20), [300, 4]);
    }

    #[test]
    fn an_error_that_falls_with_fewer_faces_does_not_count() {
        let points = vec![(100, 0.0), (50, 2.0), (25, 1.0), (10, 4.0)];
        let curve = Curve { times: 1, points, least: 1 };
        let found: Vec<[f64; 2]> =
            curve.stretches(0).iter().map(|stretch| [stretch.faces, stretch.growth]).collect();
        assert_eq!(found, [[75.0, 1.0 / 75.0], [15.0, 0.2]]);
    }
}
