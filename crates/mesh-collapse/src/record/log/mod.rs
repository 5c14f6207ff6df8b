//! The record of a run: every collapse, in order, and what follows from it.

pub(crate) mod record;

use glam::DVec3;
use mesh_core::edit::CollapseRefusal;
use mesh_core::{EdgeId, HalfEdgeId, TriMesh, VertexId, VertexMap};

use crate::geometry::edge_patch::Collapse;

/// The collapses of a run, in order. Replayed on the same mesh they give the same result, stopped
/// early they give every level in between.
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
    /// The vertex that went.
    pub removed: VertexId,
    /// The vertex that stayed.
    pub kept: VertexId,
    /// Where it stayed.
    pub position: DVec3,
    /// What the collapse cost.
    pub cost: f64,
    /// How many faces the mesh had before.
    pub faces_before: u32,
}

impl LogEntry {
    /// The same with other numbers; `None` where an element has none.
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

/// Why a log cannot be replayed: it was made with another mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the collapses are those of another mesh, as number {collapse} of them tells; give the one that they were made on"
)]
pub struct ReplayError {
    /// The first collapse that does not fit the mesh, counted from 0.
    pub collapse: usize,
    /// What the mesh says to it; `None` when it would be legal, but joins other vertices, or comes at
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

    /// Makes room for so many more collapses: a list that doubles is there three times while it is copied.
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

    /// How many collapses it takes to have at most `faces` faces, or all when they do not suffice.
    /// With [`CollapseLog::replay`] this gives nested levels of detail from one run: the vertices
    /// of a coarser level have become of those of every finer one.
    #[must_use]
    pub fn count_for_faces(&self, faces: usize) -> usize {
        self.entries.partition_point(|entry| entry.faces_before as usize > faces)
    }

    /// Carries out the first `count` collapses, or all when there are fewer, on a copy of the mesh
    /// that the log was made with. Handles stay those of the original mesh: the result has
    /// removed elements.
    ///
    /// # Errors
    /// A collapse is not legal or not the one that was recorded: the mesh is another one.
    pub fn replay(&self, mesh: &TriMesh, count: usize) -> Result<TriMesh, ReplayError> {
        let mut mesh = mesh.clone();
        self.carry_out(count, &mut mesh, |_, _, _| {})?;
        Ok(mesh)
    }

    /// Carries out the first `count` collapses, or all when there are fewer, on the mesh itself. `follow` hears of
    /// each of them.
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

    /// For each vertex of the original mesh, the vertex that it has become after the first `count`
    /// collapses. Vertices that were not touched are themselves.
    #[must_use]
    pub fn representatives(&self, mesh: &TriMesh, count: usize) -> VertexMap<VertexId> {
        let mut map: VertexMap<VertexId> = VertexMap::from_vec(
            (0..mesh.topology().vertex_capacity()).map(|v| VertexId::new(v as u32)).collect(),
        );
        // Backwards, what a vertex was merged into is final when the vertex is met.
        for entry in self.entries.iter().take(count).rev() {
            map[entry.removed] = map[entry.kept];
        }
        map
    }
}
