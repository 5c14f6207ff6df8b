//! Samples of the boundary and of the feature lines of the original, which attract edges of the mesh.

use std::sync::Arc;

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh, parallel};
use mesh_metric::Surface;

use crate::curve::Curve;
use crate::fit::constraints::FitConstraints;
use crate::fit::element::USUAL_SAMPLES;
use crate::fit::spread::area;
use crate::fit::system::System;

/// Points of the lines of the original, and the edges of the mesh that represent these lines.
///
/// Pairs of surface samples do not notice a boundary that moves within the surface; these points do.
pub(super) struct Lines(Vec<Line>);

struct Line {
    points: Vec<DVec3>,
    edges: Vec<EdgeId>,
}

impl Lines {
    /// The lines are sampled as densely as the surface at the usual density, but have no more points than the surface
    /// except one for each edge: the boundary of a comb is much longer than its surface is wide.
    pub(super) fn new(mesh: &TriMesh, original: &Surface, constraints: &FitConstraints) -> Self {
        if constraints.boundary_curve.is_none() && constraints.feature_curve.is_none() {
            return Self(Vec::new());
        }
        let topology = mesh.topology();
        let samples = (USUAL_SAMPLES * topology.face_count()).max(1) as f64;
        let all = parallel::sum(original.triangle_count(), |t| area(&original.triangle(t)));
        let spacing = (all / samples).sqrt();
        let line = |curve: &Option<Arc<Curve>>, is_line: &dyn Fn(EdgeId) -> bool| {
            let curve = curve.as_ref()?;
            let points = curve.points(spacing.max(curve.length() / samples));
            Some(Line { points, edges: topology.edges().filter(|&e| is_line(e)).collect() })
        };
        let boundary = line(&constraints.boundary_curve, &|e| topology.is_boundary_edge(e));
        let features = line(&constraints.feature_curve, &|e| constraints.is_feature(e));
        Self([boundary, features].into_iter().flatten().collect())
    }

    pub(super) fn add_to(&self, system: &mut System, mesh: &TriMesh) {
        for Line { points, edges } in &self.0 {
            // The mesh may have no edges of this line left.
            let Some(curve) = Curve::new(mesh, edges) else { continue };
            for (point, (edge, along)) in points.iter().zip(curve.closest_edges(points)) {
                system.add_to_edge(mesh, edges[edge], along, *point);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A star with this many spikes, as a fan.
    fn star(spikes: usize) -> TriMesh {
        let corner = |k: usize| {
            let angle = core::f64::consts::PI * k as f64 / spikes as f64;
            let radius = if k.is_multiple_of(2) { 1.0 } else { 0.5 };
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let around = 2 * spikes;
        let points: Vec<_> = (0..around).map(corner).chain([[0.0; 3]]).collect();
        let faces: Vec<_> = (0..around).map(|k| [around, k, (k + 1) % around]).collect();
        TriMesh::from_triangles(&points, &faces).unwrap()
    }

    #[test]
    fn a_long_boundary_has_no_more_points_than_the_surface() {
        let fine = star(2_000);
        let original = Surface::new(&fine).unwrap();
        let boundary_curve = Curve::boundary(&fine).map(Arc::new);
        let constraints = FitConstraints { boundary_curve, ..FitConstraints::default() };
        for spikes in [4, 40, 400] {
            let mesh = star(spikes);
            let lines = Lines::new(&mesh, &original, &constraints);
            let [Line { points, .. }] = &lines.0[..] else { panic!("one line") };
            let samples = USUAL_SAMPLES * mesh.topology().face_count();
            assert!(points.len() <= samples + 4_000, "{} of {samples}", points.len());
        }
    }
}
