//! The record of a run: every collapse, in order.

pub(crate) mod serialization;

use glam::DVec3;
use mesh_core::edit::CollapseRefusal;
use mesh_core::{EdgeId, HalfEdgeId, TriMesh, VertexId, VertexMap, as_u32};

use crate::geometry::edge_patch::Collapse;

/// The collapses of a run, in order. A replay on the same mesh gives the same result; a partial replay gives any level
/// in between.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CollapseLog {
    entries: Vec<LogEntry>,
}

/// One collapse.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LogEntry {
    /// The half-edge that was collapsed, in the numbering of the original mesh.
    pub half_edge: HalfEdgeId,
    /// The removed vertex.
    pub removed: VertexId,
    /// The remaining vertex.
    pub kept: VertexId,
    /// The position of the remaining vertex.
    pub position: DVec3,
    /// The cost of the collapse.
    pub cost: f64,
    /// The number of faces before the collapse.
    pub faces_before: u32,
}

impl LogEntry {
    /// The entry with other handles; `None` if an element has none.
    pub fn renumbered(
        &self,
        half_edge: impl FnOnce(HalfEdgeId) -> Option<HalfEdgeId>,
        vertex: impl Fn(VertexId) -> Option<VertexId>,
    ) -> Option<Self> {
        Some(Self {
            half_edge: half_edge(self.half_edge)?,
            removed: vertex(self.removed)?,
            kept: vertex(self.kept)?,
            ..*self
        })
    }
}

/// The error of a log that was made with another mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the collapses belong to another mesh: number {collapse} does not fit; give the mesh that they were made on"
)]
pub struct ReplayError {
    /// The first collapse that does not fit the mesh, counted from 0.
    pub collapse: usize,
    /// The reason why the mesh rejects the collapse. `None` if it is legal, but merges other vertices or happens at
    /// another number of faces.
    #[source]
    pub rejection: Option<CollapseRefusal>,
}

impl CollapseLog {
    /// A log of these collapses, in this order.
    pub fn from_entries(entries: Vec<LogEntry>) -> Self {
        Self { entries }
    }

    /// The collapses, in order.
    pub fn into_entries(self) -> Vec<LogEntry> {
        self.entries
    }

    /// Reserves memory for this many more collapses. Growth by doubling would need three times the memory during the
    /// copy.
    pub(crate) fn reserve(&mut self, collapses: usize) {
        self.entries.reserve_exact(collapses);
    }

    /// Appends a collapse.
    pub fn push(&mut self, entry: LogEntry) {
        self.entries.push(entry);
    }

    /// Keeps the first `count` collapses.
    pub fn truncate(&mut self, count: usize) {
        self.entries.truncate(count);
    }

    /// The collapses, in order.
    #[must_use]
    pub fn entries(&self) -> &[LogEntry] {
        &self.entries
    }

    /// The number of collapses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether nothing was collapsed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The number of collapses after which at most `faces` faces are left, or all collapses if they do not suffice.
    /// With [`CollapseLog::replay`], this gives nested levels of detail from one run: every vertex of a finer level
    /// maps to a vertex of each coarser level.
    #[must_use]
    pub fn count_for_faces(&self, faces: usize) -> usize {
        self.entries.partition_point(|entry| entry.faces_before as usize > faces)
    }

    /// Applies the first `count` collapses, or all if there are fewer, to a copy of the mesh that the log was made
    /// with. The result keeps the handles of the original mesh, and has removed elements.
    ///
    /// # Errors
    /// A collapse is illegal or differs from the recorded one: the mesh is another one.
    pub fn replay(&self, mesh: &TriMesh, count: usize) -> Result<TriMesh, ReplayError> {
        let mut mesh = mesh.clone();
        self.carry_out(count, &mut mesh, |_, _, _| {})?;
        Ok(mesh)
    }

    /// Applies the first `count` collapses, or all if there are fewer, to the mesh itself, and calls `follow` for each.
    pub fn carry_out(
        &self,
        count: usize,
        mesh: &mut TriMesh,
        mut follow: impl FnMut(&TriMesh, &Collapse, [Option<(EdgeId, EdgeId)>; 2]),
    ) -> Result<(), ReplayError> {
        for (number, entry) in self.entries.iter().enumerate().take(count) {
            let other = |rejection| ReplayError { collapse: number, rejection };
            let legal = mesh.topology().check_collapse(entry.half_edge);
            let collapse = legal.map_err(|rejection| other(Some(rejection)))?;
            let (removed, kept) = (collapse.removed(), collapse.kept());
            let faces = mesh.topology().face_count();
            if [removed, kept] != [entry.removed, entry.kept]
                || faces != entry.faces_before as usize
            {
                return Err(other(None));
            }
            let done = Collapse::new(mesh, &collapse, entry.position);
            let collapsed = mesh.collapse(collapse, entry.position);
            follow(mesh, &done, collapsed.merged_edges);
        }
        Ok(())
    }

    /// For each vertex of the original mesh, the vertex that it was merged into by the first `count` collapses. Other
    /// vertices map to themselves.
    #[must_use]
    pub fn representatives(&self, mesh: &TriMesh, count: usize) -> VertexMap<VertexId> {
        let mut map: VertexMap<VertexId> = VertexMap::from_vec(
            (0..mesh.topology().vertex_capacity()).map(|v| VertexId::new(as_u32(v))).collect(),
        );
        // In reverse order, the target of each merge is already final.
        for entry in self.entries.iter().take(count).rev() {
            map[entry.removed] = map[entry.kept];
        }
        map
    }
}
