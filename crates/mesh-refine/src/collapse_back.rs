//! Collapses that bring a mesh back to its number of faces after splits.

use mesh_collapse::{
    Boundary, Memoryless, Optimal, Phase, Placement, Policies, Protect, Start, Target,
    cheapest_edges, collapse_edges_from,
};
use mesh_core::{EdgeId, Remap, RemapOf, TriMesh, VertexId, VertexMap};

use crate::fit::constraints::FitConstraints;
use crate::observer::Observer;

/// Options of a run of collapses after splits.
pub struct CollapseBack<'a> {
    /// Number of faces to stop at.
    pub faces: usize,
    /// Vertices that stay, in addition to the fixed ones.
    pub locked: &'a [VertexId],
    /// How the boundary is treated.
    pub boundary: Boundary,
    /// Whether faces must not intersect if they did not before.
    pub forbid_intersections: bool,
    /// Number of vertices that every component keeps; `None` for no limit.
    pub min_component_vertices: Option<usize>,
    /// Cheap edges to examine first; `None` if not known.
    pub first: Option<&'a [EdgeId]>,
}

impl CollapseBack<'_> {
    fn fixed(&self, mesh: &TriMesh, constraints: &FitConstraints) -> Protect {
        let mut locked = mesh.topology().vertex_map(false);
        let fixed = constraints.fixed.iter().flat_map(VertexMap::iter);
        fixed.filter(|(_, fixed)| **fixed).for_each(|(v, _)| locked[v] = true);
        self.locked.iter().for_each(|&v| locked[v] = true);
        Protect {
            boundary: self.boundary,
            locked: Some(locked),
            features: constraints.features.clone(),
            kept: constraints.kept.clone(),
            importance: constraints.importance.clone(),
            limits: constraints.limits,
            min_component_vertices: self.min_component_vertices,
            forbid_intersections: self.forbid_intersections,
            ..Protect::default()
        }
    }

    /// The `count` cheapest edges.
    pub fn cheapest_edges(
        &self,
        mesh: &mut TriMesh,
        constraints: &FitConstraints,
        count: usize,
    ) -> Vec<EdgeId> {
        let policies = Policies::new(Memoryless, Optimal::default());
        let fixed = self.fixed(mesh, constraints);
        let start = Start::followed_by(constraints.constraints.clone());
        cheapest_edges(mesh, policies, start, &fixed, count)
    }
}

/// Result of [`collapse_back_placed`].
pub struct Back {
    /// Constraints of the resulting mesh.
    pub constraints: FitConstraints,
    /// For each vertex, the vertex that it was merged into.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// New handles of the remaining elements.
    pub remap: Remap,
}

/// Replaces the vertices of a map by those of the next mesh.
pub(crate) fn follow(map: &mut VertexMap<Option<VertexId>>, next: &VertexMap<Option<VertexId>>) {
    for new in map.as_mut_slice() {
        *new = new.and_then(|v| next.get(v).copied().flatten());
    }
}

/// Collapses edges by the memoryless metric and closes the gaps. If the observer stops the run, more faces than wanted
/// remain.
pub(crate) fn collapse_back(
    mesh: &mut TriMesh,
    constraints: &FitConstraints,
    to: &CollapseBack<'_>,
    phase: Phase,
    observer: &mut Observer<'_>,
) -> Back {
    collapse_back_placed(mesh, constraints, to, Optimal::default(), (phase, observer))
}

/// Collapses edges with a given placement, and closes the gaps.
pub fn collapse_back_placed(
    mesh: &mut TriMesh,
    constraints: &FitConstraints,
    to: &CollapseBack<'_>,
    placement: impl Placement,
    (phase, observer): (Phase, &mut Observer<'_>),
) -> Back {
    let policies = Policies::new(Memoryless, placement);
    let fixed = to.fixed(mesh, constraints);
    let limits = Target { faces: Some(to.faces), ..Target::default() };
    let observe = &mut |now: &_| observer.observe_in(phase, now);
    let start = Start {
        first: to.first.map(<[_]>::to_vec),
        ..Start::followed_by(constraints.constraints.clone())
    };
    let run = collapse_edges_from(mesh, policies, start, &fixed, &limits, observe);
    let vertex_map = run.log.representatives(mesh, run.log.len());
    let remap = mesh.compact();
    let vertex_map = vertex_map.as_slice().iter().map(|&v| remap.new_handle(v)).collect();
    // Vertices locked for this run only are free again.
    let fixed = constraints.fixed.as_ref().map(|fixed| {
        let mut new = mesh.topology().vertex_map(false);
        for (v, _) in fixed.iter().filter(|(_, fixed)| **fixed) {
            if let Some(v) = remap.new_handle(v) {
                new[v] = true;
            }
        }
        new
    });
    let left = run.protected.compact(mesh, &remap);
    Back {
        constraints: FitConstraints {
            fixed,
            features: left.features,
            kept: left.kept,
            limits: constraints.limits,
            importance: left.importance,
            original_importance: constraints.original_importance.clone(),
            boundary_curve: constraints.boundary_curve.clone(),
            feature_curve: constraints.feature_curve.clone(),
            constraints: left.constraints,
        },
        vertex_map: VertexMap::from_vec(vertex_map),
        remap,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::{Irregular, Wave};

    #[test]
    fn edges_that_come_first_are_enough_for_a_few_collapses_and_the_others_follow() {
        let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
        let soup = wave.irregular_mesh(16, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        let all = mesh.topology().face_count();
        let constraints = FitConstraints::default();
        let to = |faces| CollapseBack {
            faces,
            locked: &[],
            boundary: Boundary::Quadrics,
            forbid_intersections: false,
            min_component_vertices: None,
            first: None,
        };
        let cheapest = to(0).cheapest_edges(&mut mesh, &constraints, 12);
        assert_eq!(cheapest.len(), 12);
        let (phase, observer) = (Phase::MaxError, &mut Observer::none());
        let mut collapse = |mesh: &TriMesh, faces, first| {
            let mut mesh = mesh.clone();
            let back = collapse_back(
                &mut mesh,
                &constraints,
                &CollapseBack { first, ..to(faces) },
                phase,
                observer,
            );
            (mesh, back)
        };
        let (few, back) = collapse(&mesh, all - 6, Some(&cheapest[..]));
        assert_eq!(few.topology().face_count(), all - 6);
        // Only ends of these edges have been merged.
        let is_end = |v| cheapest.iter().any(|&e| mesh.topology().edge_vertices(e).contains(&v));
        let mut vertex_map: Vec<_> = back.vertex_map.iter().map(|(v, new)| (*new, v)).collect();
        vertex_map.sort_unstable();
        for merged in vertex_map.chunk_by(|a, b| a.0 == b.0).filter(|merged| merged.len() > 1) {
            assert!(merged.iter().all(|&(_, v)| is_end(v)));
        }
        // These are the cheapest edges, so a run with all edges gives the same result.
        let (anew, _) = collapse(&mesh, all - 2, None);
        let (first, _) = collapse(&mesh, all - 2, Some(&cheapest[..]));
        assert_eq!(first.topology().canonical_triangles(), anew.topology().canonical_triangles());
        let left = collapse(&mesh, all / 2, Some(&cheapest[..])).0.topology().face_count();
        assert!(left == all / 2 || left + 1 == all / 2, "{left} of {all}");
    }
}
