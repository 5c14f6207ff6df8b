//! Taking down the largest errors.
//!
//! A metric that adds up squared distances over areas lets a small part go far from its place. Where
//! that is asked for, the vertices round the largest distances first move to a place where these are
//! smaller: a fit in which the farthest pairs count most. Then each round looks for the vertices of
//! the original that are farthest from the mesh, puts vertices there, and collapses the cheapest
//! edges elsewhere until there are as many faces as before.
//! Vertices of the mesh that are far from the original go back to it. The result is kept when the
//! largest distance has become smaller and the root mean square is not much larger than at the
//! start.

use glam::DVec3;
use mesh_core::{FaceId, Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{ClosestPoint, Surface, SurfaceError, edge_points, sample_surface};

use crate::collapse::constraint::Boundary;
use crate::finish::collapse_back::{CollapseBack, collapse_back};
use crate::finish::fit::{FitConstraints, FitOptions, fit, try_move, weights_of_closest};

/// How to take down peaks; see [`cut_peaks`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakOptions {
    /// How many rounds at most.
    pub rounds: usize,
    /// What counts as a peak in a round, relative to the largest distance.
    pub above: f64,
    /// The most vertices that are put in place in a round, as a part of the faces.
    pub share: f64,
    /// How far apart points are on the longer edges of the original, which are measured besides its
    /// vertices: in roots of the mean area of its triangles.
    pub spacing: f64,
    /// How much the mean or the root mean square of the distances may rise in all, as a ratio.
    pub max_rise: f64,
    /// How many faces must be left. A round that ends on the boundary may take one more than it
    /// has made.
    pub min_faces: usize,
    /// How the vertices round the peaks are fitted before the rounds and after each that was kept,
    /// with [`FitOptions::tail`], for as many rounds as that lowers the peaks; edges are not
    /// flipped. Not at all with 0 rounds.
    pub fit: FitOptions,
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
            spacing: 3.0,
            max_rise: 1.03,
            min_faces: 0,
            fit: FitOptions { rounds: 0, tail: 300.0, ..FitOptions::default() },
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
    /// The largest distance at the start, of the points of both surfaces that were measured.
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
    let faces = mesh.topology().face_count();
    let points = Points::new(original, options.spacing, SAMPLES_PER_FACE * faces);
    let identity = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index).map(Some);
    let mut map: VertexMap<Option<VertexId>> = VertexMap::from_vec(identity.collect());
    let mut peaks = Peaks::new(mesh, original, &points)?;
    let largest_before = peaks.largest;
    let most = Most { mean: options.max_rise * peaks.mean, rms: options.max_rise * peaks.rms };
    let (mut rounds, mut kept) = (0, 0);
    peaks.flatten(mesh, original, constraints, options, most)?;
    // As many as there are; when that is too many, the farthest only.
    let (mut share, mut returning) = (options.share, usize::MAX);
    let mut failed = 0;
    while rounds < options.rounds && failed < PATIENCE && peaks.largest > 0.0 {
        rounds += 1;
        let count = ((share * faces as f64) as usize).max(1);
        let mut next = mesh.clone();
        let bar = options.above * peaks.largest;
        let mut placed = peaks.bring_back(&mut next, constraints, bar, returning);
        placed.extend(peaks.put_vertices(&mut next, constraints, bar, count));
        let step = CollapseBack {
            faces,
            locked: &placed,
            boundary: Boundary::Quadrics,
            forbid_intersections: options.forbid_intersections,
            min_component_vertices: options.min_component_vertices,
        };
        let back = collapse_back(&mut next, constraints, &step);
        let found = Peaks::new(&next, original, &points)?;
        let is_better = found.largest < peaks.largest && found.rms <= most.rms;
        let left = next.topology().face_count();
        if is_better && (options.min_faces..=faces).contains(&left) {
            for new in map.as_mut_slice() {
                *new = new.and_then(|v| back.vertex_map.get(v).copied().flatten());
            }
            (*mesh, *constraints, peaks) = (next, back.constraints, found);
            peaks.flatten(mesh, original, constraints, options, most)?;
            (kept, failed) = (kept + 1, 0);
        } else if returning > count {
            returning = count;
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

/// Points of the original, to be asked how far they are from the mesh.
struct Points {
    /// The vertices, points on edges that are longer than most, and samples.
    all: Vec<DVec3>,
    /// From here on samples, uniform by area: the averages are those of these.
    samples: usize,
}

impl Points {
    fn new(original: &Surface, spacing: f64, samples: usize) -> Self {
        let triangles = (0..original.triangle_count()).map(|t| original.triangle(t));
        let area: f64 = triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        let spacing = spacing * (area / original.triangle_count() as f64).sqrt();
        let vertices = original.used_vertices().into_iter();
        let mut all: Vec<DVec3> = vertices.map(|v| original.positions()[v as usize]).collect();
        all.extend(edge_points(original, spacing, MAX_ON_EDGE));
        let first = all.len();
        all.extend(sample_surface(original, samples, SEED).iter().map(|sample| sample.position));
        Self { all, samples: first }
    }
}

const SAMPLES_PER_FACE: usize = 10;
const SEED: u64 = 1;

/// The most points on an edge of the original.
const MAX_ON_EDGE: usize = 100;

/// How far the averages may rise.
#[derive(Clone, Copy)]
struct Most {
    mean: f64,
    rms: f64,
}

/// A step that lowers the largest distance by less than this ratio is not worth another.
const ENOUGH: f64 = 0.999;

/// The parts of a step that are tried, one after the other.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.12];

/// What counts as a peak there, relative to the largest distance.
const FLATTENED: f64 = 0.85;

/// Distances of vertices, both ways.
struct Peaks<'a> {
    points: &'a Points,
    /// For each of the points, what is closest on the mesh.
    forward: Vec<ClosestPoint>,
    /// For each vertex of the mesh, what is closest on the original.
    backward: Vec<ClosestPoint>,
    /// Faces of the mesh and how far the original is from their centres and from the middle of
    /// their sides.
    inner: Vec<(FaceId, f64)>,
    largest: f64,
    /// The mean of `forward`, and the root of the mean square.
    mean: f64,
    rms: f64,
}

impl<'a> Peaks<'a> {
    fn new(mesh: &TriMesh, original: &Surface, points: &'a Points) -> Result<Self, SurfaceError> {
        let forward = Surface::new(mesh)?.closest_points(&points.all);
        let backward = original.closest_points(mesh.positions());
        let (faces, centers): (Vec<FaceId>, Vec<DVec3>) = inner_points(mesh).unzip();
        let inner: Vec<(FaceId, f64)> =
            faces.into_iter().zip(original.distances(&centers)).collect();
        let vertices = forward.iter().chain(&backward).map(|closest| closest.distance);
        let largest =
            vertices.chain(inner.iter().map(|&(_, distance)| distance)).fold(0.0, f64::max);
        let samples = forward.get(points.samples..).unwrap_or_default();
        let sum: f64 = samples.iter().map(|c| c.distance).sum();
        let squares: f64 = samples.iter().map(|c| c.distance * c.distance).sum();
        let count = samples.len().max(1) as f64;
        let (mean, rms) = (sum / count, (squares / count).sqrt());
        Ok(Self { points, forward, backward, inner, largest, mean, rms })
    }

    /// Moves the vertices round the peaks so that these become lower, as long as that works.
    fn flatten(
        &mut self,
        mesh: &mut TriMesh,
        original: &Surface,
        constraints: &FitConstraints,
        options: &PeakOptions,
        most: Most,
    ) -> Result<(), SurfaceError> {
        for round in 0..options.fit.rounds {
            let local = self.all_but_peaks_fixed(mesh, constraints, FLATTENED * self.largest);
            let seed = options.fit.seed + round as u64;
            let once = FitOptions { rounds: 1, flips: false, seed, ..options.fit };
            let mut moved = mesh.clone();
            fit(&mut moved, original, &local, &once)?;
            let mut better = None;
            // A part of a step without intersections may have some.
            let parts = if once.forbid_intersections { &STEPS[..1] } else { &STEPS[..] };
            for &part in parts {
                let mut next = moved.clone();
                for (to, from) in next.positions_mut().iter_mut().zip(mesh.positions()) {
                    *to = *from + part * (*to - *from);
                }
                let found = Self::new(&next, original, self.points)?;
                if found.largest < ENOUGH * self.largest && found.mean <= most.mean {
                    better = Some((next, found));
                    break;
                }
            }
            let Some((next, found)) = better else { break };
            (*mesh, *self) = (next, found);
        }
        Ok(())
    }

    /// The constraints, with all vertices fixed that are not next to a face with a peak.
    fn all_but_peaks_fixed(
        &self,
        mesh: &TriMesh,
        constraints: &FitConstraints,
        bar: f64,
    ) -> FitConstraints {
        let topology = mesh.topology();
        let forward = self.forward.iter().map(|closest| (closest.face, closest.distance));
        let far = forward.chain(self.inner.iter().copied()).filter(|&(_, distance)| distance > bar);
        let corners = far.flat_map(|(face, _)| topology.face_vertices(face));
        let far = self.backward.iter().enumerate().filter(|(_, closest)| closest.distance > bar);
        let own = far.map(|(index, _)| VertexId::from_index(index));
        let mut fixed = topology.vertex_map(true);
        for v in corners.chain(own) {
            fixed[v] = false;
            topology.one_ring(v).for_each(|w| fixed[w] = false);
        }
        let before = constraints.fixed.iter().flat_map(VertexMap::iter);
        before.filter(|(_, was)| **was).for_each(|(v, _)| fixed[v] = true);
        FitConstraints { fixed: Some(fixed), ..constraints.clone() }
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
        let mut moved = Vec::new();
        let mut before = Vec::new();
        for index in farthest_first(&self.backward, bar).into_iter().take(most) {
            let (v, closest) = (VertexId::from_index(index), &self.backward[index]);
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
        let mut used = vec![false; mesh.topology().face_capacity()];
        let mut placed = Vec::new();
        for i in farthest_first(&self.forward, bar) {
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
            placed.extend(put_vertex(mesh, constraints, self.points.all[i], &self.forward[i]));
            if placed.len() >= most {
                break;
            }
        }
        placed
    }
}

/// The indices of those that are farther away than `bar`, the farthest first.
fn farthest_first(closest: &[ClosestPoint], bar: f64) -> Vec<usize> {
    let distance = |i: usize| closest[i].distance;
    let mut far: Vec<usize> = (0..closest.len()).filter(|&i| distance(i) > bar).collect();
    far.sort_by(|&i, &j| distance(j).total_cmp(&distance(i)).then(i.cmp(&j)));
    far
}

/// The centres of the faces and the middle of every edge, with a face that they are on.
fn inner_points(mesh: &TriMesh) -> impl Iterator<Item = (FaceId, DVec3)> {
    let topology = mesh.topology();
    let centers = topology.faces().map(|f| {
        let [a, b, c] = mesh.triangle(f);
        (f, a + ((b - a) + (c - a)) / 3.0)
    });
    let middles = topology.edges().filter_map(|e| {
        let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
        let face = topology.edge_faces(e).into_iter().flatten().next()?;
        Some((face, a + 0.5 * (b - a)))
    });
    centers.chain(middles)
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
