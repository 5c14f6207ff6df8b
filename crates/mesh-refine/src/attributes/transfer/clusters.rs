//! Clusters of vertices that were merged into one.

use mesh_core::{VertexId, VertexMap};

/// The vertices of the original that each vertex of the result stands for.
pub(super) struct Clusters {
    members: Vec<VertexId>,
    ends: Vec<usize>,
}

impl Clusters {
    /// The clusters for a result with `count` vertices.
    pub(super) fn new(vertex_map: &VertexMap<Option<VertexId>>, count: usize) -> Self {
        let mut members: Vec<(VertexId, VertexId)> =
            vertex_map.iter().filter_map(|(old, new)| new.map(|new| (new, old))).collect();
        members.sort_unstable();
        let end = |v: usize| members.partition_point(|(new, _)| new.index() <= v);
        let ends = (0..count).map(end).collect();
        Self { members: members.into_iter().map(|(_, old)| old).collect(), ends }
    }

    pub(super) fn of(&self, v: VertexId) -> &[VertexId] {
        let start = if v.index() == 0 { 0 } else { self.ends[v.index() - 1] };
        &self.members[start..self.ends[v.index()]]
    }
}
