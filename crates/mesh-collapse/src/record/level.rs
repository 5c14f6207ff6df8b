//! Levels of detail: meshes after some of the collapses of a run.

use mesh_core::{Remap, RemapOf, TriMesh, VertexId, VertexMap};

use crate::protect::Protected;
use crate::record::log::{CollapseLog, ReplayError};
use crate::record::run::Run;

/// A mesh after some collapses, without gaps.
pub struct Level {
    /// The mesh of the level.
    pub mesh: TriMesh,
    /// The protected vertices and edges of the level.
    pub protected: Protected,
    /// For each vertex of the original, the vertex that it was merged into.
    pub vertex_map: VertexMap<Option<VertexId>>,
}

impl Level {
    /// The level after the first `count` collapses on a mesh with these protected elements.
    pub fn new(
        original: &TriMesh,
        protected: &Protected,
        log: &CollapseLog,
        count: usize,
    ) -> Result<Self, ReplayError> {
        let (mesh, protected) = with_gaps(original, protected, log, count)?;
        Ok(Self::compacted(mesh, &protected, log, count).0)
    }

    /// The mesh at the end of a run.
    pub fn at_end(mesh: TriMesh, run: &Run) -> Self {
        let Run { protected, log, .. } = run;
        Self::compacted(mesh, protected, log, log.len()).0
    }

    /// The result of [`with_gaps`] without its gaps, and the new handles of its elements.
    pub fn compacted(
        mut mesh: TriMesh,
        protected: &Protected,
        log: &CollapseLog,
        count: usize,
    ) -> (Self, Remap) {
        let vertex_map = log.representatives(&mesh, count);
        let remap = mesh.compact();
        let vertex_map = vertex_map.as_slice().iter().map(|&v| remap.new_handle(v));
        let vertex_map = VertexMap::from_vec(vertex_map.collect());
        let protected = protected.compact(&mesh, &remap);
        (Self { mesh, protected, vertex_map }, remap)
    }

    /// Combines this level with `next`, which was made from it by more collapses.
    pub fn followed_by(self, next: Self) -> Self {
        let vertex_map =
            self.vertex_map.as_slice().iter().map(|v| v.and_then(|v| next.vertex_map[v]));
        Self { vertex_map: VertexMap::from_vec(vertex_map.collect()), ..next }
    }
}

/// A mesh and its protected elements after the first `count` collapses, with gaps.
pub fn with_gaps(
    original: &TriMesh,
    protected: &Protected,
    log: &CollapseLog,
    count: usize,
) -> Result<(TriMesh, Protected), ReplayError> {
    let (mut mesh, mut protected) = (original.clone(), protected.clone());
    log.carry_out(count, &mut mesh, |mesh, collapse, merged| {
        protected.collapsed(mesh, collapse, merged);
    })?;
    Ok((mesh, protected))
}

impl CollapseLog {
    /// A level of detail: the mesh after the first `count` collapses, without gaps, and the vertex of the level for
    /// each vertex of the original.
    ///
    /// # Errors
    /// As [`CollapseLog::replay`].
    pub fn level(
        &self,
        mesh: &TriMesh,
        count: usize,
    ) -> Result<(TriMesh, VertexMap<Option<VertexId>>), ReplayError> {
        let Level { mesh, vertex_map, .. } = Level::new(mesh, &Protected::default(), self, count)?;
        Ok((mesh, vertex_map))
    }
}

#[cfg(test)]
mod tests {
    use core::ops::ControlFlow;

    use super::*;
    use crate::constraint::Constraints;
    use crate::cost::Hybrid;
    use crate::engine::edge_collapse::collapse_edges;
    use crate::placement::Optimal;
    use crate::policies::{Policies, Schedule};
    use crate::protect::{Boundary, Protect};
    use crate::record::target::Target;
    use mesh_shapes::{Irregular, Wave};

    /// A truncated run equals a run with a lower limit, including its rejections and protected elements.
    #[test]
    fn a_run_cut_off_is_the_run_with_fewer_collapses() {
        let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
        let soup = wave.irregular_mesh(20, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let topology = mesh.topology();
        let mut features = topology.edge_map(false);
        topology.edges().filter(|e| e.index() % 19 == 0).for_each(|e| features[e] = true);
        let mut locked = topology.vertex_map(false);
        topology.vertices().filter(|v| v.index() % 50 == 0).for_each(|v| locked[v] = true);
        let protect = Protect {
            boundary: Boundary::Lock,
            locked: Some(locked),
            features: Some(features),
            ..Protect::default()
        };
        let protected = Protected::new(&mesh, &protect, Constraints::default());
        for schedule in [Schedule::Lazy, Schedule::Exact] {
            let run = |collapses: Option<usize>| {
                let mut mesh = mesh.clone();
                let mut policies = Policies::new(Hybrid::default(), Optimal::default());
                policies.schedule = schedule;
                let limits = Target { collapses, ..Target::default() };
                let go_on = &mut |_: &_| ControlFlow::Continue(());
                let run = collapse_edges(&mut mesh, policies, &protect, &limits, go_on);
                (mesh, run)
            };
            let (_, whole) = run(None);
            let total = whole.log.len();
            assert!(
                total > 100 && whole.rejections.total() > 100,
                "{total} {:?}",
                whole.rejections
            );
            for collapses in [0, 1, total / 3, total - 1, total] {
                let (left, expected) = run(Some(collapses));
                let mut cut = whole.clone();
                cut.truncate(collapses);
                assert_eq!(cut.log, expected.log);
                assert_eq!(
                    cut.rejections, expected.rejections,
                    "{schedule:?} {collapses} of {total}"
                );
                assert_eq!(cut.max_cost.to_bits(), expected.max_cost.to_bits());
                let level = Level::new(&mesh, &protected, &whole.log, collapses).unwrap();
                let end = Level::at_end(left, &expected);
                assert_eq!(level.mesh.positions(), end.mesh.positions());
                assert!(level.mesh.topology().triangles().eq(end.mesh.topology().triangles()));
                assert_eq!(level.protected.locked, end.protected.locked);
                assert_eq!(
                    (level.protected.features, level.vertex_map),
                    (end.protected.features, end.vertex_map)
                );
            }
        }
    }
}
