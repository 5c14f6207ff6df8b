//! Fitting without folds in the texture.
//!
//! A fit does not consider texture coordinates. If it folds faces over in the texture, it is undone at these faces.

use mesh_core::{EdgeId, EdgeMap, FaceId, TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::attributes::transfer::corner_sources;
use crate::attributes::wedges::{CornerAttributes, doubled_area};
use crate::error::RefineError;
use crate::fit::constraints::FitConstraints;
use crate::fit::{FitOptions, FitReport, fit_observed};
use crate::observer::Observer;

/// The number of times that folds are searched and undone before the fit is given up.
const ROUNDS: usize = 20;

/// The texture of the original.
pub struct Texture<'a> {
    /// The mesh with the texture.
    pub original: &'a TriMesh,
    /// Its texture coordinates.
    pub attributes: &'a CornerAttributes,
    /// Edges where the texture coordinates differ between the two sides.
    pub seams: &'a EdgeMap<bool>,
}

impl<'a> Texture<'a> {
    /// The test for folds of a mesh; `vertex_map` maps vertices of the original to its vertices.
    pub fn check(&self, vertex_map: &'a VertexMap<Option<VertexId>>) -> TextureCheck<'a> {
        let Self { original, attributes, seams } = *self;
        TextureCheck { original, attributes, seams, vertex_map }
    }
}

/// The test whether a mesh folds over in the texture of the original.
pub struct TextureCheck<'a> {
    pub original: &'a TriMesh,
    pub attributes: &'a CornerAttributes,
    pub seams: &'a EdgeMap<bool>,
    /// The vertex of the mesh for each vertex of the original.
    pub vertex_map: &'a VertexMap<Option<VertexId>>,
}

impl TextureCheck<'_> {
    /// The number of folded faces of a mesh; `then` maps the vertices of the first mesh to its vertices.
    pub fn folded_after(
        &self,
        mesh: &TriMesh,
        then: Option<&VertexMap<Option<VertexId>>>,
    ) -> usize {
        let Some(then) = then else { return self.folded(mesh).len() };
        let moved = |v: &Option<VertexId>| v.and_then(|v| then.get(v).copied().flatten());
        let vertex_map =
            VertexMap::from_vec(self.vertex_map.as_slice().iter().map(moved).collect());
        TextureCheck { vertex_map: &vertex_map, ..*self }.folded(mesh).len()
    }

    /// The faces whose orientation in the texture differs from the orientation at their source.
    pub fn folded(&self, mesh: &TriMesh) -> Vec<FaceId> {
        let sources = corner_sources(self.original, self.seams, None, mesh, self.vertex_map);
        let from = self.original.topology();
        let turns = |face: &FaceId| {
            let sides = mesh.topology().face_half_edges(*face);
            let [Some(a), Some(b), Some(c)] = sides.map(|h| sources[h]) else { return false };
            let [p, q, r] = [a, b, c].map(|source| {
                let corners = from.face_half_edges(source.face).map(|h| self.attributes.texture(h));
                core::array::from_fn(|i| (0..3).map(|k| source.weights[k] * corners[k][i]).sum())
            });
            let [s, t, u] = from.face_half_edges(a.face).map(|h| self.attributes.texture(h));
            doubled_area(p, q, r) * doubled_area(s, t, u) < 0.0
        };
        mesh.topology().faces().filter(turns).collect()
    }
}

/// [`fit`], with the condition that no face folds over in the texture that did not before.
pub(crate) fn fit_unfolded(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
    check: &TextureCheck<'_>,
    observer: &mut Observer<'_>,
) -> Result<FitReport, RefineError> {
    let start = mesh.clone();
    let before = check.folded(&start);
    // Without flips, every fold can be undone by moving vertices back.
    for flips in [options.flips, false] {
        let options = FitOptions { flips, ..*options };
        let report = fit_observed(mesh, original, constraints, &options, observer)?;
        for _ in 0..ROUNDS {
            let mut folded = check.folded(mesh);
            folded.retain(|face| !before.contains(face));
            if folded.is_empty() {
                // Vertices that moved back may be too far from others.
                if constraints.limits.is_any() && !constraints.limits.allow_change(&start, mesh) {
                    break;
                }
                return Ok(report);
            }
            if !undo(mesh, &start, &folded) {
                break;
            }
        }
        mesh.clone_from(&start);
    }
    Ok(FitReport::default())
}

/// Moves the vertices of faces back to their old positions. If they are there already, flips the edges at them back.
/// Returns whether anything has changed.
fn undo(mesh: &mut TriMesh, start: &TriMesh, faces: &[FaceId]) -> bool {
    let mut changed = false;
    for &face in faces {
        let corners = mesh.topology().face_vertices(face);
        if corners.into_iter().any(|v| mesh.position(v) != start.position(v)) {
            corners.iter().for_each(|v| mesh.positions_mut()[v.index()] = start.position(*v));
            changed = true;
            continue;
        }
        let edges: Vec<EdgeId> =
            corners.into_iter().flat_map(|v| mesh.topology().edges_of_vertex(v)).collect();
        for edge in edges {
            changed |= turn_back(mesh, start, edge);
        }
    }
    changed
}

/// Flips an edge if that restores the old edge.
fn turn_back(mesh: &mut TriMesh, start: &TriMesh, edge: EdgeId) -> bool {
    let mut after = edge.half_edges().map(|side| mesh.topology().apex(side));
    let mut before = start.topology().edge_vertices(edge).map(Some);
    after.sort_unstable();
    before.sort_unstable();
    match mesh.topology().check_flip(edge) {
        Ok(flip) if after == before => {
            mesh.flip(flip);
            true
        }
        _ => false,
    }
}
