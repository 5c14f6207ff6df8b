//! How far a mesh and the original are from each other, point by point.
//!
//! After a change of a few faces only what these were closest to is asked again: other points can
//! only have come closer, to a face that has changed.

use glam::DVec3;
use mesh_core::{EdgeId, FaceId, Remap, RemapOf, TriMesh, VertexId, parallel};
use mesh_metric::{Surface, SurfaceError, edge_points};

use crate::finish::blocks::for_blocks_in_turn;
use crate::finish::fit::spread::{Spread, area};

/// Points of the original, to be asked how far they are from the mesh.
pub(super) struct Points {
    /// The vertices, points on edges that are longer than most, and samples; vertices and samples so that
    /// neighbours in order are close to each other.
    pub(super) all: Vec<DVec3>,
    /// The vertices, as they come first among the points.
    pub(super) vertices: Vec<u32>,
    /// From here on samples, uniform by area: the averages are those of these.
    pub(super) samples: usize,
}

impl Points {
    /// `spacing` is in roots of the mean area of the triangles; samples are as many as suit a mesh of
    /// `faces` faces, but not more than one for every other triangle.
    pub(super) fn new(original: &Surface, spacing: f64, faces: usize) -> Self {
        let count = original.triangle_count();
        let samples = (SAMPLES_PER_FACE * faces).min((count / 2).max(LEAST_SAMPLES));
        let whole = parallel::sum(count, |t| area(&original.triangle(t)));
        let spacing = spacing * (whole / count as f64).sqrt();
        let most = (MAX_ON_EDGES_PER_FACE * count).max(LEAST_ON_EDGES);
        let on_edges = edge_points(original, spacing, MAX_ON_EDGE, most);
        let vertices = vertices_in_space(original);
        let first = vertices.len() + on_edges.len();
        let corners = |t: u32| original.triangle(t as usize);
        let spread = Spread::even(original.in_space(), corners, samples, SEED);
        let mut all = Vec::with_capacity(first + spread.len());
        all.extend(vertices.iter().map(|&v| original.positions()[v as usize]));
        all.extend(on_edges);
        all.extend(spread.points(corners, 0..spread.len()));
        Self { all, vertices, samples: first }
    }
}

/// The vertices that belong to a triangle, neighbours close to each other.
fn vertices_in_space(surface: &Surface) -> Vec<u32> {
    let mut is_there = vec![false; surface.positions().len()];
    let mut vertices = Vec::with_capacity(surface.positions().len());
    for &triangle in surface.in_space() {
        for v in surface.triangles()[triangle as usize] {
            if !core::mem::replace(&mut is_there[v as usize], true) {
                vertices.push(v);
            }
        }
    }
    vertices
}

const SAMPLES_PER_FACE: usize = 10;
/// So many samples may there be however few triangles the original has.
const LEAST_SAMPLES: usize = 40_000;
const SEED: u64 = 1;

/// The most points on an edge of the original.
const MAX_ON_EDGE: usize = 100;
/// The most points on all edges for each triangle. Long thin triangles side by side have far more long
/// edges than there is to know about them: points are farther apart there.
const MAX_ON_EDGES_PER_FACE: usize = 4;
/// So many points on edges may there be however few triangles the original has.
const LEAST_ON_EDGES: usize = 20_000;

/// How far the averages may rise.
#[derive(Clone, Copy)]
pub(super) struct Most {
    pub(super) mean: f64,
    pub(super) rms: f64,
}

/// Distances of a mesh without gaps, both ways.
#[derive(Clone)]
pub(super) struct Peaks<'a> {
    pub(super) points: &'a Points,
    pub(super) surface: Surface,
    /// For each of the points, the closest face of the mesh and the distance.
    pub(super) forward: Vec<Closest>,
    /// How far the original is from each vertex of the mesh, 0 for those without a face, from the
    /// middle of each edge, and from the centre of each face.
    pub(super) of_vertex: Vec<f64>,
    pub(super) of_edge: Vec<f64>,
    pub(super) of_face: Vec<f64>,
    pub(super) largest: f64,
    /// The mean of the samples, and the root of the mean square.
    pub(super) mean: f64,
    pub(super) rms: f64,
}

/// The closest face of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closest {
    pub(super) distance: f64,
    pub(super) face: FaceId,
}

/// What became of the elements of a mesh.
#[derive(Clone, Copy)]
pub(super) enum Became<'r> {
    /// They are the same, though maybe somewhere else.
    Same,
    /// They were renumbered.
    Other(&'r Remap),
}

impl Became<'_> {
    fn new_handle<H>(self, old: H) -> Option<H>
    where
        Remap: RemapOf<H>,
    {
        match self {
            Self::Same => Some(old),
            Self::Other(remap) => remap.new_handle(old),
        }
    }
}

/// Points that one thread asks for at a time.
const BLOCK: usize = 1024;

impl<'a> Peaks<'a> {
    pub(super) fn new(
        mesh: &TriMesh,
        original: &Surface,
        points: &'a Points,
    ) -> Result<Self, SurfaceError> {
        let surface = Surface::new(mesh)?;
        let forward = in_blocks(points.all.len(), |range| {
            let closest = surface.closest_to_neighbours(&points.all[range]).into_iter();
            closest.map(|c| Closest { distance: c.distance, face: c.face }).collect()
        });
        let topology = mesh.topology();
        let mut new = Self {
            points,
            surface,
            forward,
            of_vertex: vec![UNKNOWN; topology.vertex_capacity()],
            of_edge: vec![UNKNOWN; topology.edge_capacity()],
            of_face: vec![UNKNOWN; topology.face_capacity()],
            largest: 0.0,
            mean: 0.0,
            rms: 0.0,
        };
        new.ask(mesh, original);
        Ok(new)
    }

    /// The distances of another mesh without gaps that this one, `before`, has become.
    pub(super) fn after(
        &self,
        before: &TriMesh,
        mesh: &TriMesh,
        original: &Surface,
        became: Became<'_>,
    ) -> Result<Self, SurfaceError> {
        let surface = match became {
            Became::Same => {
                let mut surface = self.surface.clone();
                surface.follow(mesh)?;
                surface
            }
            Became::Other(_) => Surface::new(mesh)?,
        };
        let topology = mesh.topology();
        let stays = |old: VertexId, new: VertexId| before.position(old) == mesh.position(new);
        // The new face of each that has not moved.
        let mut new_faces: Vec<Option<FaceId>> = vec![None; before.topology().face_capacity()];
        let mut of_face = vec![UNKNOWN; topology.face_capacity()];
        for old in before.topology().faces() {
            let Some(new) = became.new_handle(old) else { continue };
            if before.triangle(old) == mesh.triangle(new) {
                new_faces[old.index()] = Some(new);
                of_face[new.index()] = self.of_face[old.index()];
            }
        }
        let mut of_vertex = vec![UNKNOWN; topology.vertex_capacity()];
        for old in before.topology().vertices() {
            if let Some(new) = became.new_handle(old).filter(|&new| stays(old, new)) {
                of_vertex[new.index()] = self.of_vertex[old.index()];
            }
        }
        let mut of_edge = vec![UNKNOWN; topology.edge_capacity()];
        for old in before.topology().edges() {
            let Some(new) = became.new_handle(old) else { continue };
            let [a, b] = before.topology().edge_vertices(old);
            let [p, q] = topology.edge_vertices(new);
            if stays(a, p) && stays(b, q) {
                of_edge[new.index()] = self.of_edge[old.index()];
            }
        }
        let changed: Vec<FaceId> =
            topology.faces().filter(|face| is_unknown(of_face[face.index()])).collect();
        let triangles: Vec<[u32; 3]> = changed
            .iter()
            .map(|&face| topology.face_vertices(face).map(|v| v.index() as u32))
            .collect();
        // Without one that has changed there is none to come closer to.
        let nearby = Surface::from_triangles(mesh.positions(), &triangles).ok();
        let is_near = nearby.as_ref().map(|nearby| self.faces_near(before, nearby));
        let forward = in_blocks(self.forward.len(), |range| {
            let (old, points) = (&self.forward[range.clone()], &self.points.all[range]);
            let pairs = || old.iter().zip(points);
            let is_near =
                |face: FaceId| is_near.as_ref().is_some_and(|is_near| is_near[face.index()]);
            let lost = pairs().filter(|(old, _)| new_faces[old.face.index()].is_none());
            let lost: Vec<DVec3> = lost.map(|(_, &point)| point).collect();
            let mut anew = surface.closest_to_neighbours(&lost).into_iter();
            let near = pairs()
                .filter(|(old, _)| new_faces[old.face.index()].is_some() && is_near(old.face));
            let (near, bounds): (Vec<DVec3>, Vec<f64>) =
                near.map(|(old, &point)| (point, old.distance)).unzip();
            let closer = nearby.as_ref().map(|nearby| nearby.closer_points(&near, &bounds));
            let mut closer = closer.into_iter().flatten();
            let now = |old: &Closest| {
                let Some(face) = new_faces[old.face.index()] else {
                    let found = anew.next()?;
                    return Some(Closest { distance: found.distance, face: found.face });
                };
                let found = if is_near(old.face) { closer.next().flatten() } else { None };
                let taken = found.map(|found| (found.distance, changed[found.triangle as usize]));
                let (distance, face) = taken.unwrap_or((old.distance, face));
                Some(Closest { distance, face })
            };
            old.iter().filter_map(now).collect()
        });
        let points = self.points;
        let (largest, mean, rms) = (0.0, 0.0, 0.0);
        let mut new =
            Self { points, surface, forward, of_vertex, of_edge, of_face, largest, mean, rms };
        new.ask(mesh, original);
        Ok(new)
    }

    /// Which faces of the mesh have points that may be closer to another surface, by index. A point at the
    /// distance d from its face is at most r + d from the centroid of that, where r is as far as the
    /// corners are, and so what is closer to the point than d is within r + 2 d of the centroid.
    fn faces_near(&self, mesh: &TriMesh, other: &Surface) -> Vec<bool> {
        let topology = mesh.topology();
        let mut farthest = vec![0.0_f64; topology.face_capacity()];
        for closest in &self.forward {
            let farthest = &mut farthest[closest.face.index()];
            *farthest = farthest.max(closest.distance);
        }
        let faces: Vec<FaceId> = topology.faces().collect();
        let balls = parallel::collect(faces.len(), |i| {
            let triangle = mesh.triangle(faces[i]);
            let centroid = triangle.iter().sum::<DVec3>() / 3.0;
            let corners = triangle.iter().map(|corner| corner.distance_squared(centroid));
            let radius = corners.fold(0.0, f64::max).sqrt() + 2.0 * farthest[faces[i].index()];
            (centroid, (1.0 + ROUNDING) * radius)
        });
        let (centroids, radii): (Vec<DVec3>, Vec<f64>) = balls.into_iter().unzip();
        let mut is_near = vec![false; topology.face_capacity()];
        for (face, found) in faces.iter().zip(other.closer_points(&centroids, &radii)) {
            is_near[face.index()] = found.is_some();
        }
        is_near
    }

    /// Finds the distances from the original that are unknown, and sums up.
    fn ask(&mut self, mesh: &TriMesh, original: &Surface) {
        let (asked, points) = self.unknown(mesh);
        let found = in_blocks(points.len(), |range| {
            let closest = original.closest_to_neighbours(&points[range]).into_iter();
            closest.map(|closest| closest.distance).collect()
        });
        for (element, distance) in asked.into_iter().zip(found) {
            *self.slot(element) = distance;
        }
        // What is left has no face.
        for distances in [&mut self.of_vertex, &mut self.of_edge, &mut self.of_face] {
            distances.iter_mut().filter(|d| is_unknown(**d)).for_each(|d| *d = 0.0);
        }
        let backward = self.of_vertex.iter().chain(&self.of_edge).chain(&self.of_face).copied();
        let forward = self.forward.iter().map(|closest| closest.distance);
        self.largest = forward.chain(backward).fold(0.0, f64::max);
        let samples = self.forward.get(self.points.samples..).unwrap_or_default();
        let (sum, squares) = parallel::fold(
            samples.len(),
            (0.0, 0.0),
            |i| (samples[i].distance, samples[i].distance * samples[i].distance),
            |a, b| (a.0 + b.0, a.1 + b.1),
        );
        let count = samples.len().max(1) as f64;
        (self.mean, self.rms) = (sum / count, (squares / count).sqrt());
    }

    /// The elements of faces whose distance is unknown, each with its point: face by face, so that
    /// neighbours in order are close to each other.
    fn unknown(&mut self, mesh: &TriMesh) -> (Vec<Element>, Vec<DVec3>) {
        let topology = mesh.topology();
        let faces: Vec<FaceId> = topology.faces().collect();
        let (mut elements, mut points) = (Vec::new(), Vec::new());
        for &place in self.surface.in_space() {
            let face = faces[place as usize];
            let [a, b, c] = mesh.triangle(face);
            let mut visit = |element: Element, distance: &mut f64, point: DVec3| {
                if is_unknown(*distance) {
                    *distance = 0.0;
                    elements.push(element);
                    points.push(point);
                }
            };
            let distance = &mut self.of_face[face.index()];
            visit(Element::Face(face), distance, a + ((b - a) + (c - a)) / 3.0);
            for side in topology.face_half_edges(face) {
                let (v, edge) = (topology.origin(side), side.edge());
                visit(Element::Vertex(v), &mut self.of_vertex[v.index()], mesh.position(v));
                let [p, q] = topology.edge_vertices(edge).map(|v| mesh.position(v));
                let distance = &mut self.of_edge[edge.index()];
                visit(Element::Edge(edge), distance, p + 0.5 * (q - p));
            }
        }
        (elements, points)
    }

    fn slot(&mut self, element: Element) -> &mut f64 {
        match element {
            Element::Vertex(v) => &mut self.of_vertex[v.index()],
            Element::Edge(e) => &mut self.of_edge[e.index()],
            Element::Face(f) => &mut self.of_face[f.index()],
        }
    }
}

/// An element of the mesh that has a distance.
#[derive(Clone, Copy)]
enum Element {
    Vertex(VertexId),
    Edge(EdgeId),
    Face(FaceId),
}

/// More than the rounding of a distance between points of a mesh, relative to it.
const ROUNDING: f64 = 1e-9;

/// A distance that was not asked for yet.
const UNKNOWN: f64 = -1.0;

fn is_unknown(distance: f64) -> bool {
    distance < 0.0
}

/// Values of consecutive indices, block by block on all cores.
fn in_blocks<T: Send>(
    count: usize,
    values: impl Fn(core::ops::Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut all = Vec::with_capacity(count);
    for_blocks_in_turn(count, BLOCK, values, |block| all.extend(block));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::shapes::Plane;

    fn plane(half_width: f64, cells: usize, place: impl Fn(DVec3) -> DVec3) -> TriMesh {
        let soup = Plane { half_width }.mesh(cells, Default::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        mesh.positions_mut().iter_mut().for_each(|p| *p = place(*p));
        mesh
    }

    #[test]
    fn points_are_spaced_by_the_mean_area_of_the_triangles() {
        let mesh = plane(1.0, 4, |p| p);
        let surface = Surface::new(&mesh).unwrap();
        for times in [0.3, 0.9, 3.0] {
            let triangles = mesh.topology().face_count() as f64;
            let spacing = times * (4.0 / triangles).sqrt();
            let on_edges = edge_points(&surface, spacing, 100, usize::MAX).len();
            assert_eq!(on_edges == 0, times == 3.0);
            let points = Points::new(&surface, times, 20);
            assert_eq!(points.samples, mesh.topology().vertex_count() + on_edges);
            assert_eq!(points.all.len(), points.samples + 200);
        }
    }

    #[test]
    fn distances_are_those_of_points_vertices_centres_and_middles() {
        // The plane z = x, and below it a square: the distance at x is x / sqrt 2.
        let tilted = Surface::new(&plane(8.0, 8, |p| p.with_z(p.x))).unwrap();
        let mesh = plane(1.0, 1, |p| p);
        let points = Points::new(&tilted, 3.0, 1);
        let peaks = Peaks::new(&mesh, &tilted, &points).unwrap();
        let (height, topology) = (|x: f64| x.abs() / 2.0_f64.sqrt(), mesh.topology());
        for f in topology.faces() {
            let x = mesh.triangle(f).iter().map(|p| p.x).sum::<f64>() / 3.0;
            assert!((peaks.of_face[f.index()] - height(x)).abs() < 1e-12);
        }
        for e in topology.edges() {
            let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v).x);
            assert!((peaks.of_edge[e.index()] - height(0.5 * (a + b))).abs() < 1e-12);
        }
        for v in topology.vertices() {
            let x = mesh.position(v).x;
            assert!((peaks.of_vertex[v.index()] - height(x)).abs() < 1e-12);
        }
        let forward = || peaks.forward.iter().map(|closest| closest.distance);
        assert_eq!(peaks.largest, forward().fold(0.0, f64::max));
        let samples: Vec<f64> = forward().skip(points.samples).collect();
        let count = samples.len() as f64;
        assert_eq!(count, 10.0);
        assert!((peaks.mean - samples.iter().sum::<f64>() / count).abs() < 1e-12);
        let square = samples.iter().map(|d| d * d).sum::<f64>() / count;
        assert!((peaks.rms - square.sqrt()).abs() < 1e-12);
    }

    /// What is asked again after a change is what would be asked anew.
    fn check_after(before: &TriMesh, after: &TriMesh, original: &Surface, became: Became<'_>) {
        let points = Points::new(original, 0.5, 400);
        let old = Peaks::new(before, original, &points).unwrap();
        let [found, anew] = [
            old.after(before, after, original, became).unwrap(),
            Peaks::new(after, original, &points).unwrap(),
        ];
        assert_eq!(found.of_vertex, anew.of_vertex);
        assert_eq!(found.of_edge, anew.of_edge);
        assert_eq!(found.of_face, anew.of_face);
        let distances = |p: &Peaks<'_>| p.forward.iter().map(|c| c.distance).collect::<Vec<_>>();
        assert_eq!(distances(&found), distances(&anew));
        assert_ne!(distances(&found), distances(&old));
        for (point, closest) in points.all.iter().zip(&found.forward) {
            let triangle = after.triangle(closest.face);
            let distance = mesh_metric::closest_on_triangle(*point, &triangle).length();
            assert!((distance - closest.distance).abs() < 1e-12);
        }
        assert_eq!((found.largest, found.mean, found.rms), (anew.largest, anew.mean, anew.rms));
    }

    #[test]
    fn after_a_change_only_the_rest_is_kept() {
        let wave = |p: DVec3| p.with_z(0.2 * (4.0 * p.x).sin() * (3.0 * p.y).cos());
        let original = Surface::new(&plane(1.0, 30, wave)).unwrap();
        let before = plane(1.0, 9, |p| wave(p) + 0.01 * DVec3::Z);
        let mut moved = before.clone();
        moved.positions_mut()[45].z += 0.3;
        moved.positions_mut()[12].z -= 0.2;
        check_after(&before, &moved, &original, Became::Same);
        // Split, collapsed and renumbered.
        let mut other = before.clone();
        let face = other.topology().faces().nth(77).unwrap();
        let at = other.triangle(face).iter().sum::<DVec3>() / 3.0 + 0.4 * DVec3::Z;
        let split = other.topology().check_split_face(face).unwrap();
        other.split_face(split, at);
        let edges: Vec<EdgeId> = other.topology().edges().collect();
        let legal =
            edges.into_iter().find_map(|e| other.topology().check_collapse(e.half_edges()[0]).ok());
        other.collapse(legal.unwrap(), DVec3::new(0.1, 0.2, 0.3));
        let remap = other.compact();
        check_after(&before, &other, &original, Became::Other(&remap));
    }
}
