//! Taking down the largest errors.
//!
//! A metric that adds up squared distances over areas lets a small part go far from its place. Each
//! round looks for the vertices of the original that are farthest from the mesh, puts vertices
//! there, and collapses the cheapest edges elsewhere until there are as many faces as before.
//! Vertices of the mesh that are far from the original go back to it. The result is kept when the
//! largest distance has become smaller and the root mean square is not larger than at the start by
//! more than three percent.

use glam::DVec3;
use mesh_core::{Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{ClosestPoint, Surface, SurfaceError};

use crate::collapse_back::{CollapseBack, collapse_back};
use crate::constraint::Boundary;
use crate::fit::{FitConstraints, try_move, weights_of_closest};

/// How to take down peaks; see [`cut_peaks`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakOptions {
    /// How many rounds at most.
    pub rounds: usize,
    /// What counts as a peak in a round, relative to the largest distance.
    pub above: f64,
    /// The most vertices that are put in place in a round, as a part of the faces.
    pub share: f64,
    /// How many faces must be left. A round that ends on the boundary may take one more than it
    /// has made.
    pub min_faces: usize,
    /// Whether faces must not come to cross that did not before.
    pub forbid_intersections: bool,
    /// How many vertices every component keeps.
    pub min_component_vertices: Option<usize>,
}

impl Default for PeakOptions {
    fn default() -> Self {
        Self {
            rounds: 5,
            above: 0.7,
            share: 0.003,
            min_faces: 0,
            forbid_intersections: false,
            min_component_vertices: None,
        }
    }
}

/// What [`cut_peaks`] did.
#[derive(Clone, Debug, PartialEq)]
pub struct PeakReport {
    /// How many rounds were made.
    pub rounds: usize,
    /// How many of them were kept.
    pub kept: usize,
    /// The largest distance of a vertex of the original at the start.
    pub largest_before: f64,
    /// That distance at the end.
    pub largest_after: f64,
    /// For each vertex of the mesh that was given, the vertex that it has become.
    pub vertex_map: VertexMap<Option<VertexId>>,
}

/// Takes down the largest distances of the vertices of the original from a mesh without gaps. The
/// number of faces does not rise; `constraints` follow the mesh.
///
/// # Errors
/// The mesh has no faces.
pub fn cut_peaks(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    options: &PeakOptions,
) -> Result<PeakReport, SurfaceError> {
    let used = original.used_vertices();
    let points: Vec<DVec3> = used.iter().map(|&v| original.positions()[v as usize]).collect();
    let identity = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index).map(Some);
    let mut map: VertexMap<Option<VertexId>> = VertexMap::from_vec(identity.collect());
    let faces = mesh.topology().face_count();
    let mut peaks = Peaks::new(mesh, original, &points)?;
    let (largest_before, allowed) = (peaks.largest, MAX_RISE * peaks.square);
    let (mut rounds, mut kept) = (0, 0);
    // As many as there are; when that is too many, the farthest only.
    let (mut share, mut returning) = (options.share, usize::MAX);
    let mut failed = 0;
    while rounds < options.rounds && failed < PATIENCE && peaks.largest > 0.0 {
        rounds += 1;
        let most = ((share * faces as f64) as usize).max(1);
        let mut next = mesh.clone();
        let bar = options.above * peaks.largest;
        let mut placed = peaks.bring_back(&mut next, constraints, bar, returning);
        placed.extend(peaks.put_vertices(&mut next, constraints, bar, most));
        let step = CollapseBack {
            faces,
            locked: &placed,
            boundary: Boundary::Quadrics,
            forbid_intersections: options.forbid_intersections,
            min_component_vertices: options.min_component_vertices,
        };
        let back = collapse_back(&mut next, constraints, &step);
        let found = Peaks::new(&next, original, &points)?;
        let is_better = found.largest < peaks.largest && found.square <= allowed;
        let left = next.topology().face_count();
        if is_better && (options.min_faces..=faces).contains(&left) {
            for new in map.as_mut_slice() {
                *new = new.and_then(|v| back.vertex_map.get(v).copied().flatten());
            }
            (*mesh, *constraints, peaks) = (next, back.constraints, found);
            (kept, failed) = (kept + 1, 0);
        } else if returning > most {
            returning = most;
        } else {
            share *= 0.3;
            failed += 1;
        }
    }
    let largest_after = peaks.largest;
    Ok(PeakReport { rounds, kept, largest_before, largest_after, vertex_map: map })
}

/// After so many rounds in vain in a row, it is enough.
const PATIENCE: usize = 2;

/// How much the mean square may rise in all: root mean squares by three percent.
const MAX_RISE: f64 = 1.06;

/// Distances of vertices, both ways.
struct Peaks<'a> {
    /// The vertices of the original.
    points: &'a [DVec3],
    /// For each of them, what is closest on the mesh.
    forward: Vec<ClosestPoint>,
    /// For each vertex of the mesh, what is closest on the original.
    backward: Vec<ClosestPoint>,
    largest: f64,
    /// The mean of the squares of `forward`.
    square: f64,
}

impl<'a> Peaks<'a> {
    fn new(mesh: &TriMesh, original: &Surface, points: &'a [DVec3]) -> Result<Self, SurfaceError> {
        let forward = Surface::new(mesh)?.closest_points(points);
        let backward = original.closest_points(mesh.positions());
        let largest = forward.iter().chain(&backward).map(|c| c.distance).fold(0.0, f64::max);
        let squares: f64 = forward.iter().map(|c| c.distance * c.distance).sum();
        let square = squares / points.len().max(1) as f64;
        Ok(Self { points, forward, backward, largest, square })
    }

    /// Moves vertices that are farther away than `bar` to the original. Returns them.
    fn bring_back(
        &self,
        mesh: &mut TriMesh,
        constraints: &FitConstraints,
        bar: f64,
        most: usize,
    ) -> Vec<VertexId> {
        let is_fixed = |v| constraints.fixed.as_ref().and_then(|map| map.get(v)) == Some(&true);
        let far = self.backward.iter().enumerate().filter(|(_, closest)| closest.distance > bar);
        let mut far: Vec<(VertexId, &ClosestPoint)> =
            far.map(|(index, closest)| (VertexId::from_index(index), closest)).collect();
        far.sort_by(|p, q| q.1.distance.total_cmp(&p.1.distance).then(p.0.cmp(&q.0)));
        let mut moved = Vec::new();
        let mut before = Vec::new();
        for (v, closest) in far.into_iter().take(most) {
            let on_line = mesh.topology().edges_of_vertex(v).any(|e| constraints.is_feature(e));
            before.clear();
            before.extend(mesh.topology().faces_of_vertex(v).map(|f| mesh.face_cross(f)));
            if !is_fixed(v) && !on_line && try_move(mesh, v, closest.point, &before) {
                moved.push(v);
            }
        }
        moved
    }

    /// Puts vertices at the points that are farther away than `bar`, the farthest first, no two of
    /// them at the same or at neighbouring faces. Returns them.
    fn put_vertices(
        &self,
        mesh: &mut TriMesh,
        constraints: &FitConstraints,
        bar: f64,
        most: usize,
    ) -> Vec<VertexId> {
        let distance = |i: usize| self.forward[i].distance;
        let mut peaks: Vec<usize> = (0..self.points.len()).filter(|&i| distance(i) > bar).collect();
        peaks.sort_by(|&i, &j| distance(j).total_cmp(&distance(i)).then(i.cmp(&j)));
        let mut used = vec![false; mesh.topology().face_capacity()];
        let mut placed = Vec::new();
        for i in peaks {
            let face = self.forward[i].face;
            if used[face.index()] {
                continue;
            }
            for v in mesh.topology().face_vertices(face) {
                // Faces that were made here are beyond the end.
                let round = mesh.topology().faces_of_vertex(v);
                for f in round {
                    if let Some(used) = used.get_mut(f.index()) {
                        *used = true;
                    }
                }
            }
            placed.extend(put_vertex(mesh, constraints, self.points[i], &self.forward[i]));
            if placed.len() >= most {
                break;
            }
        }
        placed
    }
}

/// Below this weight of a corner the closest point counts as on the side opposite to it.
const ON_SIDE: f64 = 0.1;

/// Splits the face or the edge that is closest to `point` there.
fn put_vertex(
    mesh: &mut TriMesh,
    constraints: &FitConstraints,
    point: DVec3,
    closest: &ClosestPoint,
) -> Option<VertexId> {
    let topology = mesh.topology();
    let weights = weights_of_closest(point, &mesh.triangle(closest.face)).to_array();
    let least = (0..3).min_by(|&i, &j| weights[i].total_cmp(&weights[j]))?;
    if weights[least] > ON_SIDE {
        let split = topology.check_split_face(closest.face).ok()?;
        return Some(mesh.split_face(split, point).vertex);
    }
    let edge = topology.face_half_edges(closest.face)[(least + 1) % 3].edge();
    if constraints.is_feature(edge) {
        return None;
    }
    let split = topology.check_split_edge(edge).ok()?;
    Some(mesh.split_edge(split, point).vertex)
}
