//! Levels of detail: meshes after some of the collapses of a run.

use mesh_core::{Remap, RemapOf, TriMesh, VertexId, VertexMap};

use crate::collapse::constraint::Marks;
use crate::collapse::log::{CollapseLog, ReplayError};
use crate::collapse::run::Run;

/// A mesh after some collapses, without gaps.
pub(crate) struct Level {
    pub(crate) mesh: TriMesh,
    pub(crate) marks: Marks,
    /// For each vertex of the original, the one that it has become.
    pub(crate) became: VertexMap<Option<VertexId>>,
}

impl Level {
    /// The level after the first `count` collapses on a mesh with these marks.
    pub(crate) fn new(
        original: &TriMesh,
        marks: &Marks,
        log: &CollapseLog,
        count: usize,
    ) -> Result<Self, ReplayError> {
        let (mesh, marks) = with_gaps(original, marks, log, count)?;
        Ok(Self::compacted(mesh, &marks, log, count).0)
    }

    /// The mesh that a run has left.
    pub(crate) fn at_end(mesh: TriMesh, run: &Run) -> Self {
        let Run { locked, features, followers, log, .. } = run;
        let marks =
            Marks { locked: locked.clone(), features: features.clone(), guards: followers.clone() };
        Self::compacted(mesh, &marks, log, log.len()).0
    }

    /// What has been left [`with_gaps`], and where its elements are now.
    pub(crate) fn compacted(
        mut mesh: TriMesh,
        marks: &Marks,
        log: &CollapseLog,
        count: usize,
    ) -> (Self, Remap) {
        let became = log.representatives(&mesh, count);
        let remap = mesh.compact();
        let became = became.as_slice().iter().map(|&v| remap.new_handle(v));
        let became = VertexMap::from_vec(became.collect());
        let marks = marks.compact(&mesh, &remap);
        (Self { mesh, marks, became }, remap)
    }

    /// This level after more collapses, which have led to `next`.
    pub(crate) fn followed_by(self, next: Self) -> Self {
        let became = self.became.as_slice().iter().map(|v| v.and_then(|v| next.became[v]));
        Self { became: VertexMap::from_vec(became.collect()), ..next }
    }
}

/// A mesh and its marks after the first `count` collapses on it, with the gaps that these leave.
pub(crate) fn with_gaps(
    original: &TriMesh,
    marks: &Marks,
    log: &CollapseLog,
    count: usize,
) -> Result<(TriMesh, Marks), ReplayError> {
    let (mut mesh, mut marks) = (original.clone(), marks.clone());
    log.carry_out(count, &mut mesh, |mesh, collapse, merged| {
        marks.collapsed(mesh, collapse, merged);
    })?;
    Ok((mesh, marks))
}

impl CollapseLog {
    /// The mesh after the first `count` collapses, without gaps, and what the vertices of the
    /// original are in it: a level of detail.
    ///
    /// # Errors
    /// As [`CollapseLog::replay`].
    pub fn level(
        &self,
        mesh: &TriMesh,
        count: usize,
    ) -> Result<(TriMesh, VertexMap<Option<VertexId>>), ReplayError> {
        let Level { mesh, became, .. } = Level::new(mesh, &Marks::default(), self, count)?;
        Ok((mesh, became))
    }
}

#[cfg(test)]
mod tests {
    use core::ops::ControlFlow;

    use super::*;
    use crate::collapse::constraint::{Boundary, Constraints};
    use crate::collapse::cost::Hybrid;
    use crate::collapse::driver::collapse_edges;
    use crate::collapse::guard::{Guards, NormalGuard, ShapeGuard};
    use crate::collapse::placement::Optimal;
    use crate::collapse::policies::{Policies, Update};
    use crate::collapse::stop::Limits;
    use mesh_core::shapes::{Irregular, Wave};

    /// What is left of a run when it is cut off is the run that was allowed no more, refusals and
    /// marks included.
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
        let constraints = Constraints {
            boundary: Boundary::Lock,
            locked: Some(locked),
            features: Some(features),
        };
        let marks = Marks::new(&mesh, &constraints, Guards::default());
        for update in [Update::Lazy, Update::Eager] {
            let run = |collapses: Option<usize>| {
                let mut mesh = mesh.clone();
                let mut policies = Policies::new(Hybrid::default(), Optimal::default());
                policies.guards.push(NormalGuard::default());
                policies.guards.push(ShapeGuard::default());
                policies.update = update;
                let limits = Limits { collapses, ..Limits::default() };
                let go_on = &mut |_: &_| ControlFlow::Continue(());
                let run = collapse_edges(&mut mesh, policies, &constraints, &limits, go_on);
                (mesh, run)
            };
            let (_, whole) = run(None);
            let total = whole.log.len();
            assert!(total > 100 && whole.refusals.total() > 100, "{total} {:?}", whole.refusals);
            for collapses in [0, 1, total / 3, total - 1, total] {
                let (left, expected) = run(Some(collapses));
                let mut cut = whole.clone();
                cut.truncate(collapses);
                assert_eq!(cut.log, expected.log);
                assert_eq!(cut.refusals, expected.refusals, "{update:?} {collapses} of {total}");
                assert_eq!(cut.max_cost.to_bits(), expected.max_cost.to_bits());
                let level = Level::new(&mesh, &marks, &whole.log, collapses).unwrap();
                let end = Level::at_end(left, &expected);
                assert_eq!(level.mesh.positions(), end.mesh.positions());
                assert!(level.mesh.topology().triangles().eq(end.mesh.topology().triangles()));
                assert_eq!(level.marks.locked, end.marks.locked);
                assert_eq!((level.marks.features, level.became), (end.marks.features, end.became));
            }
        }
    }
}
