//! Fig. 7: a half cylinder with vertices on its two rims only.

use curvpatch::{CurvatureEstimator, FitTest, Params, PatchFit, Shape};
use dcurv::Pointwise;
use glam::DVec3;
use mesh_core::{FaceId, TriMesh, VertexMap};
use mesh_shapes::{Cylinder, RowPhase};

use super::super::item::{Figure, Item};
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::drawing::{BLUE, Drawing, ORANGE};
use super::patches::{PRESETS, STYLE, axes_of_paper, estimator, patch};
use super::statistics::median;
use mesh_render::Style;
use xtask_common::Failure;

const SPARSE: Cylinder = Cylinder { radius: 1.0, height: 6.0 };
const DENSE: Cylinder = Cylinder { radius: 1.0, height: 4.0 };
const RADIUS: f64 = 0.4;
/// A face in the middle of the sparse mesh, and one of the dense mesh that cuts the same facet.
const FACES: [FaceId; 2] = [FaceId::new(22), FaceId::new(1536)];
const TOWARD: DVec3 = DVec3::new(0.3, 1.0, 0.3);
const TALL: Style = Style { size: [380, 780], ..STYLE };

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Half of a 48-sided cylinder as strips of long triangles. All vertices are on the boundary, \
         so curvature at vertices says nothing about the middle; sections through a face do not \
         care, and give to rounding what they give on a dense mesh of the same facets. Both shapes \
         of patch are drawn for r_g = 0.4, lifted a little to be seen.",
    );
    item.how(
        &["curvpatch::CurvatureEstimator::patch", "mesh_shapes::Cylinder::half_with_bare_sides"],
        &["curvmesh patch IN -o OUT.glb --face 22 --radius 0.4 --shape ellipse --preset paper"],
    );
    let sparse = mesh_of(&SPARSE.half_with_bare_sides(24).map_err(Failure::mesh)?)?;
    let dense = mesh_of(&DENSE.mesh(32, 48, RowPhase::Aligned).map_err(Failure::mesh)?)?;
    let topology = sparse.topology();
    let inner = topology.vertices().filter(|&v| !topology.is_boundary_vertex(v)).count();
    item.number("vertices inside the mesh", inner as f64);
    let mut worst = 0.0_f64;
    for (name, params) in PRESETS {
        let [few, many] = [(&sparse, FACES[0]), (&dense, FACES[1])]
            .map(|(mesh, face)| estimator(mesh, params)?.at(face, RADIUS).map_err(Failure::mesh));
        let (few, many) = (few?, many?);
        let axes = axes_of_paper(few.curvatures);
        let [k1, k2] = axes.map(|axis| few.curvatures[axis]);
        item.number(format!("{name} preset, kappa 1 (exact: 1)"), k1);
        item.number_within(
            format!("{name} preset, |kappa 2| below 0.01"),
            below(k2.abs(), 0.01),
            0.0,
        );
        let off = few.frame[axes[0]].z.abs().asin().to_degrees();
        item.number_within(
            format!("{name} preset, T1 off by less than 1e-6 degrees"),
            below(off, 1e-6),
            0.0,
        );
        let apart = (0..2).map(|i| (few.curvatures[i] - many.curvatures[i]).abs());
        if name == "paper" {
            worst = apart.fold(worst, f64::max);
        }
    }
    item.number_within("sparse and dense mesh agree to 1e-10", below(worst, 1e-10), 0.0);
    let at_faces = 100.0 * (face_curvature(&estimator(&sparse, Params::paper())?)? - 1.0).abs();
    let angles = [&sparse, &dense].map(|mesh| median_at_vertices(mesh, &by_angles(mesh)));
    let fit = [&sparse, &dense].map(|mesh| median_at_vertices(mesh, &by_fit(mesh)));
    for (name, [on_sparse, on_dense]) in [("angles", angles), ("fitted quadratics", fit)] {
        item.number(format!("{name} at vertices, sparse mesh, error of kappa 1 (%)"), on_sparse);
        item.number(format!("{name} at vertices, dense mesh, error of kappa 1 (%)"), on_dense);
    }
    item.claim(
        "curvature without vertices",
        only_by_faces(inner, worst, angles[0].min(fit[0]), at_faces),
        format!(
            "{inner} vertices inside; both meshes give the same curvatures by sections to {worst:.0e}, \
             {at_faces:.1} % off. At vertices (dcurv), kappa 1 is {:.1} % off by angles and dihedral angles and \
             {:.1} % by fitted quadratics on the sparse mesh, where all vertices are on the boundary; {:.1} % \
             and {:.1} % inside the dense one (medians). Holds if there are no vertices inside, sections do not notice, \
             and both estimates at vertices are ten times as wrong as sections; in part if the latter fails",
            angles[0], fit[0], angles[1], fit[1]
        ),
    );
    let figures = figures(run, item, &sparse)?;
    item.side_by_side(figures);
    Ok(())
}

/// The larger principal curvature at each vertex by angles and dihedral angles.
fn by_angles(mesh: &TriMesh) -> VertexMap<Option<[f64; 2]>> {
    let curvatures = dcurv::Curvatures::of(mesh, &dcurv::CurvatureOptions::default());
    curvatures.map(|c| Some(c.principal().map(Pointwise::value)))
}

/// The same by a quadratic surface fitted to the neighbours.
fn by_fit(mesh: &TriMesh) -> VertexMap<Option<[f64; 2]>> {
    let frames = dcurv::principal_frames(mesh);
    frames.map(|frame| frame.map(|f| [f.k_max, f.k_min].map(Pointwise::value)))
}

/// The median error of the larger principal curvature at the vertices inside, or at all where there are
/// none, in percent. A vertex without an estimate is 100 % off.
fn median_at_vertices(mesh: &TriMesh, principal: &VertexMap<Option<[f64; 2]>>) -> f64 {
    let topology = mesh.topology();
    let inside: Vec<_> = topology.vertices().filter(|&v| !topology.is_boundary_vertex(v)).collect();
    let all = if inside.is_empty() { topology.vertices().collect() } else { inside };
    let error = |v| {
        let larger = principal[v].map_or(0.0, |[k1, k2]| k1.abs().max(k2.abs()));
        100.0 * (larger - 1.0).abs()
    };
    median(all.into_iter().map(error).collect())
}

/// The larger principal curvature by sections through the face.
fn face_curvature(estimator: &CurvatureEstimator<'_>) -> Result<f64, Failure> {
    let [k1, k2] = estimator.at(FACES[0], RADIUS).map_err(Failure::mesh)?.curvatures;
    Ok(k1.abs().max(k2.abs()))
}

/// Whether sections give the curvature where vertices do not: `apart` is how far both meshes are apart,
/// and the errors are in percent.
fn only_by_faces(inner: usize, apart: f64, at_vertices: f64, at_faces: f64) -> Outcome {
    match (inner == 0 && apart < 1e-10, at_vertices > 10.0 * at_faces) {
        (true, true) => Outcome::Holds,
        (false, false) => Outcome::Fails,
        _ => Outcome::InPart,
    }
}

/// 1 when a number that is rounding only is below a limit.
fn below(value: f64, limit: f64) -> f64 {
    f64::from(u8::from(value < limit))
}

fn figures(run: &Run<'_>, item: &mut Item, mesh: &TriMesh) -> Result<Vec<Figure>, Failure> {
    let estimator = estimator(mesh, Params::paper())?;
    let view = view_of(mesh, TOWARD, DVec3::Z)?;
    let shapes = [(Shape::Circle, "circle", BLUE), (Shape::Ellipse, "ellipse", ORANGE)];
    let draw = |(shape, name, color): (Shape, &str, [u8; 3])| {
        let fit = patch(&estimator, FACES[0], RADIUS, shape)?;
        add_numbers(item, mesh, &fit, name);
        let mut drawing = Drawing::of(mesh, &[FACES[0]], [150, 150, 148]);
        drawing.patch(&fit.patch, color, 0.02, 3.0)?;
        let caption = format!("Fig. 7: {name} of r_g = {RADIUS} on the bare half cylinder");
        drawing.draw(run, &view, &TALL, &format!("sn10-half-cylinder-{name}"), &caption)
    };
    shapes.into_iter().map(draw).collect()
}

fn add_numbers(item: &mut Item, mesh: &TriMesh, fit: &PatchFit, name: &str) {
    let axes = axes_of_paper(fit.patch.curvatures());
    let [l1, l2] = axes.map(|axis| fit.patch.arcs()[axis]);
    item.number(format!("{name}, length of the second arc / r_g"), l2 / l1);
    let errors = FitTest::new(mesh).quarter_errors(fit);
    let largest = errors.into_iter().fold(0.0, f64::max);
    item.number(
        format!("{name}, largest error at four boundary points (% of r_g)"),
        100.0 * largest / RADIUS,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_that_do_turn_the_verdict() {
        assert_eq!(only_by_faces(0, 1e-13, 99.0, 1.7), Outcome::Holds);
        assert_eq!(only_by_faces(0, 1e-13, 1.5, 1.7), Outcome::InPart);
        assert_eq!(only_by_faces(9, 1e-3, 1.5, 1.7), Outcome::Fails);
    }
}
