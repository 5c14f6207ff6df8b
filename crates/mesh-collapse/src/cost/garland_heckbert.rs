//! Quadric error metrics (Garland and Heckbert 1997).

use glam::DVec3;
use mesh_core::{Handle, Remap, RemapOf, TriMesh, VertexId};

use super::{Cost, Reach};
use crate::geometry::edge_patch::{Collapse, EdgePatch};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy, Scratch};

/// The quadrics of the original planes, accumulated at the vertices. Each face adds a third of its area times the
/// squared distance to its plane to each of its corners.
///
/// The cost is the sum of the quadrics of the two ends at the new position. In the *marginal* variant, the values of
/// the quadrics at the current ends are subtracted: the cost is then the error of this collapse only, without errors
/// made before.
#[derive(Clone, Debug, Default)]
pub struct GarlandHeckbert {
    /// Whether errors already made are subtracted.
    pub marginal: bool,
    quadrics: AccumulatedQuadrics,
}

impl GarlandHeckbert {
    /// The cost as published.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The cost without the errors already made.
    #[must_use]
    pub fn marginal() -> Self {
        Self { marginal: true, ..Self::default() }
    }

    #[inline]
    fn value(&self, patch: &EdgePatch<'_>, quadric: Option<&Quadric>, x: DVec3) -> f64 {
        let value = quadric.map_or(0.0, |q| q.value(x));
        let made = if self.marginal { self.quadrics.made(patch) } else { 0.0 };
        (value - made).max(0.0) + length_tie(patch)
    }
}

impl Policy for GarlandHeckbert {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.quadrics = AccumulatedQuadrics::new(mesh);
    }

    fn collapsed(&mut self, _: &TriMesh, collapse: &Collapse) {
        self.quadrics.merge(collapse);
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.quadrics.compact(remap);
    }
}

impl Cost for GarlandHeckbert {
    #[inline]
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        Some(self.quadrics.of_edge(patch) + *patch.border())
    }

    #[inline]
    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        _: &mut Scratch,
    ) -> f64 {
        self.value(patch, quadric, x)
    }

    #[inline]
    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        let quadric = self.quadric(patch)?;
        let x = quadric.minimizer(None)?;
        Some(self.value(patch, Some(&quadric), x))
    }

    fn needs(&self) -> Needs {
        Needs::Ends
    }

    fn reach(&self) -> Reach {
        Reach::OneRingSum
    }
}

/// A term so small that it decides only between edges whose cost is rounding error; short edges come first.
#[inline]
pub(super) fn length_tie(patch: &EdgePatch<'_>) -> f64 {
    1e-12 * patch.squared_length() * patch.squared_length()
}

/// One quadric per vertex, about the position of the vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct AccumulatedQuadrics(Vec<Quadric>);

impl AccumulatedQuadrics {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let mut quadrics = vec![Quadric::default(); topology.vertex_capacity()];
        for face in topology.faces() {
            let cross = mesh.face_cross(face);
            let double_area = cross.length();
            if double_area > 0.0 {
                // The plane contains all three corners, so the offset is zero.
                let plane = Quadric::plane(cross, 0.0, 1.0 / (6.0 * double_area));
                for vertex in topology.face_vertices(face) {
                    quadrics[vertex.index()] += plane;
                }
            }
        }
        Self(quadrics)
    }

    pub(crate) fn from_vec(quadrics: Vec<Quadric>) -> Self {
        Self(quadrics)
    }

    pub(crate) fn into_vec(self) -> Vec<Quadric> {
        self.0
    }

    /// The quadrics, by vertex.
    pub(crate) fn as_slice(&self) -> &[Quadric] {
        &self.0
    }

    /// The sum of the quadrics of both ends, about the midpoint of the edge.
    #[inline]
    pub(crate) fn of_edge(&self, patch: &EdgePatch<'_>) -> Quadric {
        let [_, half] = patch.ends();
        self.0[patch.removed().index()].joined(&self.0[patch.kept().index()], half)
    }

    /// The sum of the values of the quadrics of both ends at these ends.
    #[inline]
    pub(crate) fn made(&self, patch: &EdgePatch<'_>) -> f64 {
        self.0[patch.removed().index()].constant + self.0[patch.kept().index()].constant
    }

    /// Moves the quadrics to the handles of the mesh without gaps.
    pub(crate) fn compact(&mut self, remap: &Remap) {
        let mut index = 0;
        self.0.retain(|_| {
            let vertex = VertexId::from_index(index);
            index += 1;
            remap.new_handle(vertex).is_some()
        });
    }

    pub(crate) fn merge(&mut self, collapse: &Collapse) {
        let Collapse { removed, kept, removed_from, kept_from, position } = *collapse;
        self.0[kept.index()] = self.0[kept.index()].moved_by(position - kept_from)
            + self.0[removed.index()].moved_by(position - removed_from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::{Irregular, Sphere};

    fn sphere() -> TriMesh {
        let soup =
            Sphere { radius: 1.0 }.irregular_icosphere(1, Irregular { jitter: 0.2, seed: 3 });
        TriMesh::from_soup(&soup.unwrap()).unwrap()
    }

    #[test]
    fn errors_made_before_count_unless_the_cost_is_marginal() {
        let mesh = sphere();
        let edge = mesh.topology().edges().next().unwrap();
        let patch = EdgePatch::without_faces(&mesh, edge.half_edge());
        // The value at the midpoint of the edge is 4.
        let quadric = Quadric::plane(DVec3::Z, 2.0, 1.0);
        for (mut cost, expected) in
            [(GarlandHeckbert::new(), 4.0), (GarlandHeckbert::marginal(), 3.25)]
        {
            cost.prepare(&mesh);
            cost.quadrics.0[patch.removed().index()].constant = 0.25;
            cost.quadrics.0[patch.kept().index()].constant = 0.5;
            let found = cost.cost(&patch, Some(&quadric), DVec3::ZERO, &mut Scratch::default());
            assert!((found - length_tie(&patch) - expected).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn the_early_bound_is_the_least_cost_of_any_place() {
        let mesh = sphere();
        let mut cost = GarlandHeckbert::new();
        cost.prepare(&mesh);
        for edge in mesh.topology().edges() {
            let patch = EdgePatch::without_faces(&mesh, edge.half_edge());
            let quadric = cost.quadric(&patch);
            let bound = cost.early_bound(&patch).unwrap();
            let at = |x: DVec3| cost.cost(&patch, quadric.as_ref(), x, &mut Scratch::default());
            let best = quadric.unwrap().minimizer(None).unwrap();
            assert_eq!(bound, at(best));
            for way in [DVec3::X, DVec3::Y, DVec3::Z].map(|way| 0.01 * way) {
                assert!(at(best + way) > bound && at(best - way) > bound, "{edge:?}");
            }
        }
    }
}
