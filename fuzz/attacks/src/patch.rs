//! Curvature of faces, patches and covers.

use arbitrary::{Result, Unstructured};
use curvpatch::{CoverOptions, CurvatureEstimator, FitTest, Params, Shape, cover};
use dcurv::{CurvatureOptions, Curvatures, VertexArea};
use mesh_core::TriMesh;

use crate::shape::mesh;

/// Curvature at vertices and faces, one patch, and a cover: all returned values must be finite, and within the
/// tolerance.
pub fn attack(data: &[u8]) {
    // Too few bytes are not an error.
    let _ = run(&mut Unstructured::new(data));
}

fn run(u: &mut Unstructured<'_>) -> Result<()> {
    let mesh = mesh(u)?;
    of_vertices(&mesh, *u.choose(&[VertexArea::Voronoi, VertexArea::Barycentric])?);
    let params = if u.arbitrary()? { Params::paper() } else { Params::robust() };
    let radius = f64::from(u.int_in_range(1..=100)?) / 20.0;
    let shape = *u.choose(&[Shape::Circle, Shape::Ellipse, Shape::EqualSagitta])?;
    let tolerance = f64::from(u.int_in_range(1..=60)?) / 30.0;
    let Ok(estimator) = CurvatureEstimator::new(&mesh, params) else { return Ok(()) };
    if let Ok(discs) = estimator.all_faces(radius) {
        for disc in discs.as_slice().iter().flatten() {
            assert!(disc.mean().is_finite() && disc.gaussian().is_finite(), "{disc:?}");
            assert!((disc.normal().length() - 1.0).abs() < 1e-9, "{disc:?}");
        }
    }
    let mut probe = FitTest::new(&mesh);
    if let Some(face) = mesh.topology().faces().next()
        && let Ok(fit) = estimator.patch(face, radius, shape)
    {
        let errors = probe.full_error(&fit, tolerance, true);
        assert!(!errors.max().is_nan(), "{errors:?}");
        assert!(fit.patch.center().is_finite(), "{fit:?}");
    }
    if u.ratio(1, 2)? {
        let options = CoverOptions { shapes: vec![shape], ..CoverOptions::new(tolerance) };
        if let Ok(cover) = cover(&estimator, &options) {
            assert!(cover.max_error() <= tolerance, "{} > {tolerance}", cover.max_error());
            assert!(cover.covered_faces() <= mesh.topology().face_count());
        }
    }
    Ok(())
}

fn of_vertices(mesh: &TriMesh, area: VertexArea) {
    let options = CurvatureOptions { area };
    let curvatures = Curvatures::of(mesh, &options);
    let totals = curvatures.totals();
    let topology = mesh.topology();
    let all = [totals.f1, totals.f2(), totals.f3, totals.gaussian.value()];
    assert!(all.iter().all(|x| !x.is_nan()), "{totals:?}");
    let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)).count() as f64;
    let euler = used - topology.edge_count() as f64 + topology.face_count() as f64;
    let has_area = topology.faces().all(|face| !has_zero_area(mesh.triangle(face)));
    // Gauss-Bonnet theorem; the angles of a face without area do not add up to half a turn.
    let expected = 2.0 * core::f64::consts::PI * euler;
    let found = totals.gaussian.value();
    assert!(!has_area || (found - expected).abs() < 1e-9 * (1.0 + used), "{found}, not {expected}");
}

fn has_zero_area([a, b, c]: [glam::DVec3; 3]) -> bool {
    (b - a).cross(c - a) == glam::DVec3::ZERO
}
