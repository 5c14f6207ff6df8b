//! Fitting without folds in the texture.
//!
//! A fit knows nothing of texture coordinates. Where faces turn over in the texture because of it,
//! it is done again with their surroundings held.

use mesh_core::{EdgeMap, FaceId, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError};

use crate::anneal::AnnealReport;
use crate::fit::{FitConstraints, FitOptions, FitReport, fit};
use crate::transfer::corner_sources;
use crate::wedges::{CornerAttributes, doubled_area};

/// How often a fit is repeated before it is given up.
const ATTEMPTS: usize = 4;

/// What tells whether a mesh folds over in the texture of the original.
pub(crate) struct TextureCheck<'a> {
    pub(crate) original: &'a TriMesh,
    pub(crate) attributes: &'a CornerAttributes,
    pub(crate) seams: &'a EdgeMap<bool>,
    /// What the vertices of the original are in the mesh to be fitted.
    pub(crate) became: &'a VertexMap<Option<VertexId>>,
}

impl TextureCheck<'_> {
    /// Whether annealing has made faces turn over in the texture that did not before.
    pub(crate) fn folds_more(&self, after: &TriMesh, before: &TriMesh, by: &AnnealReport) -> bool {
        let moved = |v: &Option<VertexId>| v.and_then(|v| by.vertex_map.get(v).copied().flatten());
        let became = VertexMap::from_vec(self.became.as_slice().iter().map(moved).collect());
        let annealed = TextureCheck { became: &became, ..*self };
        annealed.folded(after).len() > self.folded(before).len()
    }

    /// The faces that lie the other way round in the texture than where they come from.
    pub(crate) fn folded(&self, mesh: &TriMesh) -> Vec<FaceId> {
        let sources = corner_sources(self.original, self.seams, mesh, self.became);
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

/// As [`fit`], so that no face turns over in the texture that did not before.
pub(crate) fn fit_unfolded(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
    check: &TextureCheck<'_>,
) -> Result<FitReport, SurfaceError> {
    let start = mesh.clone();
    let before = check.folded(&start);
    let mut constraints = constraints.clone();
    for _ in 0..ATTEMPTS {
        let report = fit(mesh, original, &constraints, options)?;
        let mut folded = check.folded(mesh);
        folded.retain(|face| !before.contains(face));
        if folded.is_empty() {
            return Ok(report);
        }
        hold(&mut constraints, mesh, &start, &folded);
        mesh.clone_from(&start);
    }
    Ok(FitReport::default())
}

/// Adds the vertices of faces and their neighbours to those that stay, and all edges between them to
/// those that are not flipped.
fn hold(constraints: &mut FitConstraints, fitted: &TriMesh, start: &TriMesh, faces: &[FaceId]) {
    let topology = start.topology();
    let fixed = constraints.fixed.get_or_insert_with(|| topology.vertex_map(false));
    let features = constraints.features.get_or_insert_with(|| topology.edge_map(false));
    for v in faces.iter().flat_map(|&face| fitted.topology().face_vertices(face)) {
        fixed[v] = true;
        for h in topology.outgoing(v) {
            features[h.edge()] = true;
            fixed[topology.target(h)] = true;
        }
    }
}
