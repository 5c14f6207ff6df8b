//! Distances of very small and very large meshes, and of a mesh and itself.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::{SplitMix64, TriMesh};
use mesh_metric::{
    CertifyOptions, CompareOptions, SignRule, SignedDistance, Surface, compare, face_distances,
    hausdorff_bounds, normal_deviation, one_sided_bounds, sampled_hausdorff,
};
use mesh_shapes::Sphere;

fn sphere(level: u32, place: impl Fn(DVec3) -> DVec3) -> Surface {
    let soup = Sphere { radius: 1.0 }.icosphere(level).unwrap();
    let positions: Vec<DVec3> = soup.positions().iter().map(|&p| place(p)).collect();
    let triangles: Vec<[u32; 3]> = soup.faces().map(|f| f.try_into().unwrap()).collect();
    Surface::from_triangles(&positions, &triangles).unwrap()
}

const SAMPLES: CompareOptions =
    CompareOptions { samples: 2000, vertices: true, edges: true, seed: 1 };

/// Bounds and samples of scaled surfaces equal the scaled bounds and samples of the originals. Outside the range of
/// ordinary sizes, where surfaces are scaled to unit size, the bits are the same. The bounds hold everywhere.
#[test]
fn distances_scale_with_the_surfaces() {
    let options = |scale: f64| CertifyOptions { tolerance: 1e-4 * scale, ..Default::default() };
    let measure = |scale: f64| {
        let [a, b] = [2, 3].map(|level| sphere(level, |p| p * scale));
        let found = compare(&a, &b, &SAMPLES);
        let bounds = hausdorff_bounds(&a, &b, &options(scale));
        let one = one_sided_bounds(&b, &a, &options(scale));
        assert!(bounds.converged && one.converged, "{scale:e}");
        [found.mean(), found.rms(), found.hausdorff(), bounds.lower, bounds.upper, one.upper]
            .map(|length| length / scale)
    };
    let unit = measure(1.0);
    for exponent in [-990_i32, -700, -400, -300, -150, -10, 10, 150, 300, 400, 700, 990] {
        let scaled = measure(f64::from(exponent).exp2());
        for (unit, scaled) in unit.iter().zip(scaled) {
            assert!((scaled / unit - 1.0).abs() < 1e-9, "2^{exponent}: {scaled} {unit}");
        }
        if exponent.abs() > 200 {
            assert_eq!(scaled, measure(f64::from(exponent.signum() * 300).exp2()), "2^{exponent}");
        }
    }
}

/// Distances of points, the sampled maximum and the distances of faces, as bits.
#[test]
fn distances_of_points_and_faces_scale_with_the_surfaces() {
    let measure = |scale: f64| {
        let [a, b] = [2, 3].map(|level| sphere(level, |p| p * scale));
        let mut all = b.distances(a.positions());
        all.push(sampled_hausdorff(&a, &b, &SAMPLES));
        all.extend(face_distances(&a, &b, 4000));
        all.iter().map(|distance| (distance / scale).to_bits()).collect::<Vec<u64>>()
    };
    let far = measure(f64::from(300).exp2());
    assert!(far.iter().any(|&bits| f64::from_bits(bits) > 1e-3));
    for exponent in [-950, -700, -400, -300, 400, 700, 950] {
        assert_eq!(measure(f64::from(exponent).exp2()), far, "2^{exponent}");
    }
}

/// Means, maxima and closest points of scaled surfaces are those of the originals, bit for bit.
#[test]
fn samples_and_closest_points_scale_with_the_surfaces() {
    let measure = |scale: f64| {
        let [a, b] = [2, 3].map(|level| sphere(level, |p| p * scale));
        let found = compare(&a, &b, &SAMPLES);
        let mut all = vec![found.mean(), found.rms(), found.hausdorff()];
        let points: Vec<DVec3> =
            a.positions().iter().map(|&p| 1.1 * p + 0.3 * DVec3::X * scale).collect();
        let than: Vec<f64> = (0..points.len()).map(|i| 0.01 * scale * i as f64).collect();
        let closer = b.closer_points(&points, &than);
        let mut near: Vec<_> = b.closest_points(&points);
        near.extend(b.closest_to_neighbours(&points));
        near.extend(points.iter().map(|&p| b.closest(p)));
        near.extend(closer.iter().flatten());
        for closest in near {
            all.extend([closest.distance, f64::from(closest.triangle) * scale]);
            all.extend(closest.point.to_array().into_iter().chain(closest.offset.to_array()));
        }
        all.extend(points.iter().map(|&p| b.distance(p)));
        let decisions: Vec<bool> = (0..40)
            .map(|i| b.are_within(&points, 0.01 * scale * f64::from(i)))
            .chain(points.iter().zip(&than).map(|(&p, &d)| b.has_within(p, d, |_| true)))
            .collect();
        let angle = normal_deviation(&a, &b, 500, 1);
        (
            all.iter().map(|length| (length / scale).to_bits()).collect::<Vec<u64>>(),
            decisions,
            angle,
        )
    };
    let unit = measure(1.0);
    assert!(unit.1.contains(&true) && unit.1.contains(&false) && unit.2 > 0.01);
    // Offsets along the surface are as small as rounding errors, and must keep their digits.
    for exponent in [-800, -700, -400, -300, -190, 190, 300, 400, 700, 950] {
        assert!(measure(f64::from(exponent).exp2()) == unit, "2^{exponent}");
    }
}

/// Signs by winding numbers, and by pseudonormals of an open surface.
#[test]
fn signed_distances_scale_with_the_surfaces() {
    for rule in [SignRule::WindingNumber, SignRule::Pseudonormal] {
        let measure = |scale: f64| {
            let ball = sphere(2, |p| p * scale);
            let open = usize::from(rule == SignRule::Pseudonormal);
            let mesh =
                TriMesh::from_triangles(ball.positions(), &ball.triangles()[open..]).unwrap();
            let signed = SignedDistance::negative_inside(&mesh).unwrap();
            assert_eq!(signed.rule(), rule);
            let mut random = SplitMix64::new(3);
            let mut point =
                || DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
            let mut points: Vec<DVec3> = (0..300).map(|_| 1.3 * scale * point()).collect();
            points.extend(ball.positions().iter().map(|&p| 1.25 * p));
            let one = signed.distance(points[0]);
            let all = signed.distances(&points);
            assert_eq!(one, all[0]);
            all.iter().map(|length| length / scale).collect::<Vec<f64>>()
        };
        let unit = measure(1.0);
        assert!(unit.iter().filter(|&&length| length < 0.0).count() > 50);
        for exponent in [-950, -700, -400, -300, -190, 190, 300, 400, 700, 950] {
            assert_eq!(measure(f64::from(exponent).exp2()), unit, "2^{exponent} {rule:?}");
        }
    }
}

/// The lower bound of the distance of a surface to itself is 0, also with the farthest sample.
#[test]
fn a_surface_is_at_distance_zero_from_itself() {
    for (scale, shift) in [(1.0, 0.0), (1e-3, 1e3), (1e90, 0.0), (1e-90, 0.0), (0.3, 1e7)] {
        let a = sphere(3, |p| p * scale + DVec3::splat(shift));
        let found = compare(&a, &a, &SAMPLES);
        let options = CertifyOptions { tolerance: 1e-6 * scale, ..Default::default() };
        let bounds = hausdorff_bounds(&a, &a, &options);
        let raised = bounds.raised_by(&found.forward, &a, &a).raised_by(&found.backward, &a, &a);
        assert_eq!((bounds.lower, raised.lower), (0.0, 0.0), "{scale:e} {shift:e}");
        assert!(raised.upper <= 1e-5 * scale.max(1e-9 * shift), "{}", raised.upper);
    }
}

/// A sample raises the lower bound if the search stopped early.
#[test]
fn samples_raise_the_lower_bound() {
    let (a, b) = (sphere(2, |p| p), sphere(2, |p| 1.5 * p));
    let found = compare(&a, &b, &SAMPLES);
    let coarse = CertifyOptions { tolerance: 10.0, ..Default::default() };
    let bounds = hausdorff_bounds(&a, &b, &coarse);
    let raised = bounds.raised_by(&found.forward, &a, &b).raised_by(&found.backward, &b, &a);
    assert!(raised.lower >= bounds.lower && raised.lower <= raised.upper);
    assert!(raised.lower > found.hausdorff() * (1.0 - 1e-12) && raised.lower < found.hausdorff());
}

/// Far from the origin, where coordinates are coarser than the tolerance, the search ends at once.
#[test]
fn a_tolerance_below_the_rounding_ends_the_search() {
    let a = sphere(2, |p| p + DVec3::splat(1e15));
    let b = sphere(3, |p| p + DVec3::splat(1e15));
    let bounds = hausdorff_bounds(&a, &b, &CertifyOptions::default());
    assert!(bounds.converged && bounds.pieces < 100_000, "{} pieces", bounds.pieces);
    assert!(bounds.lower <= bounds.upper && bounds.upper < 20.0);
}

/// Far from the origin, the bounds and the samples are those of the shifted surfaces, bit for bit.
#[test]
fn a_shift_changes_no_bits() {
    for offset in [1e15, -3e12, 2e16] {
        let far = |level| sphere(level, |p| 100.0 * p + DVec3::new(offset, 0.5, -offset));
        let [a, b] = [2, 3].map(far);
        let corner = |s: &Surface| {
            let bounds = s.bounding_box();
            if offset > 0.0 { [bounds.min.x, bounds.max.z] } else { [bounds.max.x, bounds.min.z] }
        };
        let [[ax, az], [bx, bz]] = [corner(&a), corner(&b)];
        let nearer = |p: f64, q: f64| if p.abs() < q.abs() { p } else { q };
        let origin = DVec3::new(nearer(ax, bx), 0.0, nearer(az, bz));
        let shifted = |s: &Surface| {
            let positions: Vec<DVec3> = s.positions().iter().map(|&p| p - origin).collect();
            Surface::from_triangles(&positions, s.triangles()).unwrap()
        };
        let measure = |a: &Surface, b: &Surface| {
            let options = CertifyOptions { tolerance: 1e-3, ..Default::default() };
            let bounds = hausdorff_bounds(a, b, &options);
            let found = compare(a, b, &SAMPLES);
            assert!(bounds.converged);
            [bounds.lower, bounds.upper, found.mean(), found.rms(), found.hausdorff()]
        };
        let found = measure(&a, &b);
        assert_eq!(found, measure(&shifted(&a), &shifted(&b)), "{offset:e}");
        assert!(found[1] - found[0] <= 1.01e-3, "{found:?}");
    }
}
