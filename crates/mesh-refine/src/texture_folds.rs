//! Fitting without folds in the texture.
//!
//! A fit does not consider texture coordinates. If it folds faces over in the texture, it is undone at these faces, and
//! then at the faces around them that the vertices moved back have made cross, turn over or become slivers.

use mesh_collapse::NewIntersections;
use mesh_core::{EdgeId, EdgeMap, FaceId, TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::attributes::transfer::corner_sources;
use crate::attributes::wedges::{CornerAttributes, doubled_area};
use crate::error::RefineError;
use crate::face_quality::{keeps_height, keeps_side};
use crate::fit::constraints::FitConstraints;
use crate::fit::moves::cross;
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

/// [`fit`](crate::fit()), with the condition that no face folds over in the texture that did not before.
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
        let mut undoing: Option<Undoing> = None;
        for _ in 0..ROUNDS {
            let mut faults = check.folded(mesh);
            faults.retain(|face| before.binary_search(face).is_err());
            if let Some(undoing) = &undoing {
                faults.extend(undoing.faults(mesh, &start));
            }
            if faults.is_empty() {
                // Vertices that moved back may be too far from others.
                if constraints.limits.is_any() && !constraints.limits.allow_change(&start, mesh) {
                    break;
                }
                return Ok(report);
            }
            undoing.get_or_insert_with(|| Undoing::new(mesh, &start, options.forbid_intersections));
            if !undo(mesh, &start, &faults) {
                break;
            }
        }
        mesh.clone_from(&start);
    }
    Ok(FitReport::default())
}

/// What a fit that is undone in part must keep.
struct Undoing {
    /// The mesh after the fit.
    fitted: TriMesh,
    /// The crossings before the fit, and the faces that they belong to, if no others may arise.
    crossings: Option<(NewIntersections, Vec<FaceId>)>,
}

impl Undoing {
    fn new(fitted: &TriMesh, start: &TriMesh, forbid_intersections: bool) -> Self {
        let crossings = forbid_intersections.then(|| {
            let found = NewIntersections::new(start);
            let crossing = found.crossing(start);
            (found, crossing)
        });
        Self { fitted: fitted.clone(), crossings }
    }

    /// The faces that vertices moved back have turned too far, made slivers, or made cross.
    fn faults(&self, mesh: &TriMesh, start: &TriMesh) -> Vec<FaceId> {
        let topology = mesh.topology();
        let is_bent = |&face: &FaceId| {
            let corners = topology.face_vertices(face);
            let moved =
                |from: &TriMesh| corners.iter().any(|&v| mesh.position(v) != from.position(v));
            // An edge of the face may have been flipped back.
            let is_of = |from: &TriMesh| {
                from.topology().face_vertices(face).iter().all(|v| corners.contains(v))
            };
            let known = [&self.fitted, start].map(|from| (from, is_of(from)));
            let is_as_before = known.iter().any(|&(from, is_of)| is_of && !moved(from));
            let from = known.into_iter().find(|&(_, is_of)| is_of && !is_as_before);
            let Some((from, _)) = from else { return false };
            let [new, old] = [mesh, from].map(|mesh| mesh.triangle(face));
            !keeps_side(cross(new), cross(old)) || !keeps_height([new], [old])
        };
        let mut faults: Vec<FaceId> = topology.faces().filter(is_bent).collect();
        if let Some((found, before)) = &self.crossings {
            let mut found = found.clone();
            found.update(mesh, topology.faces());
            let crossing = found.crossing(mesh).into_iter();
            faults.extend(crossing.filter(|face| before.binary_search(face).is_err()));
        }
        faults
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Two sheets, one above the other, as one mesh.
    fn sheets(low: f64, high: f64) -> TriMesh {
        let plane = mesh_shapes::Plane { half_width: 1.0 };
        let soup =
            plane.irregular_mesh(6, mesh_shapes::Irregular { jitter: 0.2, seed: 1 }).unwrap();
        let flat = TriMesh::from_soup(&soup).unwrap();
        let count = flat.positions().len() as u32;
        let at = |height: f64| flat.positions().iter().map(move |&p| p + height * DVec3::Z);
        let points: Vec<DVec3> = at(low).chain(at(high)).collect();
        let faces: Vec<[u32; 3]> = flat.topology().triangles().collect();
        let above = faces.iter().map(|face| face.map(|v| v + count));
        let faces: Vec<[u32; 3]> = faces.iter().copied().chain(above).collect();
        TriMesh::from_triangles(&points, &faces).unwrap()
    }

    #[test]
    fn vertices_moved_back_must_not_bend_faces_or_make_them_cross() {
        let (start, fitted) = (sheets(0.0, 0.1), sheets(0.15, 0.25));
        let undoing = Undoing::new(&fitted, &start, true);
        assert_eq!(undoing.faults(&fitted, &start), []);
        assert_eq!(undoing.faults(&start, &start), []);
        // One vertex of the upper sheet pierces the lower one, the faces around it turn by less than sixty degrees.
        let mut mesh = fitted.clone();
        let topology = fitted.topology();
        let inner = topology.vertices().rfind(|&v| !topology.is_boundary_vertex(v)).unwrap();
        mesh.positions_mut()[inner.index()].z = 0.1;
        let faults = undoing.faults(&mesh, &start);
        assert!(topology.faces_of_vertex(inner).all(|face| faults.contains(&face)), "{faults:?}");
        let is_below = |face: &FaceId| mesh.triangle(*face).iter().all(|p| p.z == 0.15);
        assert!(faults.iter().any(is_below), "{faults:?}");
        assert!(Undoing::new(&fitted, &start, false).faults(&mesh, &start).is_empty());
        // From ten times the height, they turn farther.
        let (start, fitted) = (sheets(0.0, 0.1), sheets(3.0, 3.1));
        let mut mesh = fitted.clone();
        mesh.positions_mut()[inner.index()].z = 0.1;
        let bent = Undoing::new(&fitted, &start, false).faults(&mesh, &start);
        assert_eq!(bent.len(), topology.valence(inner));
    }
}
