//! Annealing of vertex positions and connectivity, guided by measured distances.
//!
//! A sweep has three parts. Every vertex makes a random jump; the jumps become smaller with time. Every edge is flipped
//! if that brings the mesh closer to samples of the original. Then smoothing moves each vertex to
//!
//! ```text
//! x = Σ ρ a c / Σ ρ a
//! ```
//!
//! over the areas a and the centroids c of its faces, with a [density](crate::density) ρ, and from there to the closest
//! point of the original. The formula is similar to that of optimal Delaunay triangulations (Chen and Holst 2011). Both
//! it and flips by distance are invariant under affine maps, so the faces get the shape that the curvature requires,
//! not an equilateral one.
//!
//! This holds where K > 0. A saddle contains straight lines, and to first order a thin triangle along them is as good
//! as a round one. So edges of faces with the original on both sides are flipped by the metric of the
//! [density](crate::density), in which the best shapes are equilateral as well. This applies to smooth surfaces only.
//! On others, such faces are often at a detail, and are left to the fit.

use std::time::Instant;

use glam::{DMat3, DVec3};
use mesh_core::{EdgeId, FaceId, Handle, TriMesh, VertexId, parallel};
use mesh_core::{SplitMix64, as_u32};
use mesh_metric::{Surface, closest_on_triangle};

use crate::density::{Density, PLACES, places};
use crate::face_lists::FaceLists;
use crate::face_quality::{keeps_height, keeps_side};
use crate::fit::constraints::FitConstraints;
use crate::fit::moves::{can_move, cross};
use crate::fit::spread::area;
use crate::observer::Observer;
use mesh_collapse::{ChangedFace, NewIntersections, Phase};

/// Options of the annealing of a layout.
#[derive(Clone, Copy)]
pub(crate) struct Cooling {
    pub(crate) sweeps: usize,
    /// Length of the first jumps of vertices, relative to the mean length of their edges.
    pub(crate) jump: f64,
    pub(crate) seed: u64,
    pub(crate) forbid_intersections: bool,
    pub(crate) deadline: Option<Instant>,
    /// Whether the surface is assumed to be smooth, so that faces with the original on both sides take part in the
    /// layout.
    pub(crate) is_smooth: bool,
}

impl Cooling {
    /// Whether the time limit has passed.
    pub(crate) fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

/// The fraction of the sweeps with jumps; the rest only smooth.
const WARM: f64 = 0.8;
/// The share of the summed distances that must lie on one side of a face for the face to count as domed.
const DOMED: f64 = 0.8;
/// The weight of round triangles relative to close ones. It is small, and keeps the shape of triangles where there is
/// no curvature.
const ROUNDNESS: f64 = 0.1;
/// A flip must reduce the error below this factor.
const NOTICEABLE: f64 = 1.0 - 1e-9;
/// The number of smoothing steps per sweep.
const SMOOTHINGS: usize = 2;
/// The number of passes of flips over all edges in each.
const FLIP_PASSES: usize = 2;

/// Anneals until the schedule, the time limit or the observer ends it. Returns the number of sweeps. The vertices then
/// lie on the original, so the mesh still has to be fitted.
pub(crate) fn anneal_layout(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    (schedule, density): (&Cooling, &mut Density),
    observer: &mut Observer<'_>,
) -> usize {
    let mut random = SplitMix64::new(schedule.seed);
    let mut layout = Layout::new(mesh, original, constraints, (schedule, density));
    let start = Instant::now();
    layout.settle();
    layout.draw();
    let mut made = 0;
    while made < schedule.sweeps && !observer.stops(Phase::Anneal, layout.mesh) {
        // With a time limit, the jumps shrink over the available time.
        let by_time = schedule.deadline.map_or(0.0, |deadline| {
            let all = deadline.saturating_duration_since(start).as_secs_f64();
            start.elapsed().as_secs_f64() / all.max(f64::MIN_POSITIVE)
        });
        if by_time >= 1.0 {
            break;
        }
        let share = (made as f64 / schedule.sweeps as f64).max(by_time);
        let jump = schedule.jump * (1.0 - share / WARM);
        if jump > 0.0 {
            layout.jump(jump, &mut random);
        }
        for _ in 0..SMOOTHINGS {
            layout.draw();
            layout.flip_all();
            layout.smooth();
        }
        made += 1;
    }
    layout.draw();
    layout.flip_all();
    made
}

/// Whether a vertex is free: not at the boundary, on a feature, or locked.
fn is_movable(mesh: &TriMesh, constraints: &FitConstraints, v: VertexId) -> bool {
    let topology = mesh.topology();
    let fixed = constraints.fixed.as_ref().and_then(|map| map.get(v)) == Some(&true);
    topology.contains_vertex(v)
        && !fixed
        && !topology.is_isolated_vertex(v)
        && !topology.is_boundary_vertex(v)
        && !topology.edges_of_vertex(v).any(|e| constraints.is_feature(e))
}

struct Layout<'a> {
    mesh: &'a mut TriMesh,
    original: &'a Surface,
    constraints: &'a FitConstraints,
    found: Option<NewIntersections>,
    movable: Vec<VertexId>,
    density: &'a mut Density,
    /// The mean density of each face.
    densities: Vec<f64>,
    /// Points of the original: the closest points to samples spread evenly over each face.
    points: Vec<DVec3>,
    /// The area that each point represents.
    shares: Vec<f64>,
    /// The squared distance of each point from its face.
    squares: Vec<f64>,
    /// The samples of each face.
    lists: FaceLists,
    /// The faces that a flip touches, and their samples, each with its new face and squared distance.
    faces: Vec<FaceId>,
    touched: Vec<(u32, u32, f64)>,
    /// Whether each face has the original on one side only.
    domed: Vec<bool>,
    /// The metric of each face, if the surface is assumed to be smooth.
    metrics: Option<Vec<DMat3>>,
    /// The weight of the [`spread`] of a face.
    roundness: f64,
}

impl<'a> Layout<'a> {
    fn new(
        mesh: &'a mut TriMesh,
        original: &'a Surface,
        constraints: &'a FitConstraints,
        (schedule, density): (&Cooling, &'a mut Density),
    ) -> Self {
        let found = schedule.forbid_intersections.then(|| NewIntersections::new(mesh));
        let movable = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index);
        let movable = movable.filter(|&v| is_movable(mesh, constraints, v)).collect();
        Self {
            mesh,
            original,
            constraints,
            found,
            movable,
            density,
            densities: Vec::new(),
            points: Vec::new(),
            shares: Vec::new(),
            squares: Vec::new(),
            lists: FaceLists::new(0, 0),
            faces: Vec::new(),
            touched: Vec::new(),
            domed: Vec::new(),
            metrics: schedule.is_smooth.then(Vec::new),
            roundness: 0.0,
        }
    }

    /// Finds the points of the original for every face, the same number for small and large faces.
    fn draw(&mut self) {
        let topology = self.mesh.topology();
        let faces: Vec<FaceId> = topology.faces().collect();
        let feet = parallel::collect(faces.len(), |i| {
            let points = places(self.mesh.triangle(faces[i]));
            let closest = self.original.closest_to_neighbours(&points);
            let feet: Vec<DVec3> = closest.iter().map(|closest| closest.point).collect();
            let places: Vec<FaceId> = self.density.places(&feet).collect();
            (feet, places)
        });
        let count = PLACES * faces.len();
        self.points = Vec::with_capacity(count);
        self.shares = Vec::with_capacity(count);
        self.squares = Vec::with_capacity(count);
        self.lists = FaceLists::new(topology.face_capacity(), self.points.len());
        self.domed = vec![false; topology.face_capacity()];
        self.densities = vec![0.0; topology.face_capacity()];
        if let Some(metrics) = &mut self.metrics {
            *metrics = vec![DMat3::ZERO; topology.face_capacity()];
            for (&face, (_, places)) in faces.iter().zip(&feet) {
                let all = places.iter().map(|&place| self.density.metric(place));
                metrics[face.index()] = all.fold(DMat3::ZERO, |sum, metric| sum + metric);
            }
        }
        let mut found = Vec::with_capacity(count);
        for (&face, (feet, places)) in faces.iter().zip(&feet) {
            let densities = places.iter().map(|&place| self.density.at(place));
            self.densities[face.index()] = densities.sum::<f64>() / PLACES as f64;
            let triangle = self.mesh.triangle(face);
            let cross = cross(triangle);
            let area = 0.5 * cross.length();
            let (mut sum, mut absolute, mut squares) = (0.0, 0.0, 0.0);
            for &foot in feet {
                self.lists.push(face, as_u32(self.points.len()));
                self.points.push(foot);
                self.shares.push(area / PLACES as f64);
                let offset = closest_on_triangle(foot, &triangle);
                self.squares.push(offset.length_squared());
                let height = offset.dot(cross) / cross.length();
                sum += height;
                absolute += height.abs();
                squares += height * height;
            }
            let is_domed = sum.abs() > DOMED * absolute;
            self.domed[face.index()] = is_domed;
            if is_domed || self.metrics.is_some() {
                // The fit will move the face by the mean, so only the variance counts.
                let count = PLACES as f64;
                let variance = squares / count - (sum / count).powi(2);
                let wanted = self.density.faces_for(area, variance);
                found.extend(places.iter().map(|&place| (place, wanted)));
            }
        }
        self.density.follow(found.into_iter());
        let spreads = faces.iter().map(|&f| spread(DMat3::IDENTITY, self.mesh.triangle(f)));
        let all = self.squares.iter().zip(&self.shares).map(|(squared, share)| share * squared);
        let ratio = all.sum::<f64>() / spreads.sum::<f64>();
        self.roundness = if ratio.is_finite() { ROUNDNESS * ratio } else { 0.0 };
    }

    /// The term of a sample in the error of a face.
    fn error(&self, sample: u32) -> f64 {
        self.shares[sample as usize] * self.squares[sample as usize]
    }

    /// Moves the vertices onto the original.
    fn settle(&mut self) {
        self.domed = vec![true; self.mesh.topology().face_capacity()];
        let places: Vec<DVec3> = self.movable.iter().map(|&v| self.mesh.position(v)).collect();
        self.move_to(&places);
    }

    /// Makes every vertex jump at random along the mesh. Jumps are shorter where faces are narrow, so that the method
    /// is invariant under affine maps.
    fn jump(&mut self, size: f64, random: &mut SplitMix64) {
        let topology = self.mesh.topology();
        let targets = self.movable.iter().map(|&v| {
            let at = self.mesh.position(v);
            let edges = topology.one_ring(v).map(|w| self.mesh.position(w) - at);
            let shift = edges.map(|edge| random.normal() * edge).sum::<DVec3>();
            // Edges in all directions with squared length l² have the sum valence / 2 l² in each direction.
            let scale = (2.0 / topology.valence(v).max(1) as f64).sqrt();
            at + size * scale * shift.reject_from_normalized(self.normal(v))
        });
        let targets: Vec<DVec3> = targets.collect();
        self.move_to(&targets);
    }

    /// Smooths once; see the module documentation.
    fn smooth(&mut self) {
        let topology = self.mesh.topology();
        let mut weights = vec![0.0; topology.face_capacity()];
        for face in topology.faces() {
            let density = self.densities[face.index()];
            weights[face.index()] = density * area(&self.mesh.triangle(face));
        }
        let targets = self.movable.iter().map(|&v| {
            let at = self.mesh.position(v);
            let (mut sum, mut all) = (DVec3::ZERO, 0.0);
            for face in topology.faces_of_vertex(v) {
                let [a, b, c] = self.mesh.triangle(face);
                let weight = weights[face.index()];
                sum += weight * (a + b + c) / 3.0;
                all += weight;
            }
            if all > 0.0 {
                at + (sum / all - at).reject_from_normalized(self.normal(v))
            } else {
                at
            }
        });
        let targets: Vec<DVec3> = targets.collect();
        self.move_to(&targets);
    }

    /// The mean of the normals of the faces, or an arbitrary direction if they cancel.
    fn normal(&self, v: VertexId) -> DVec3 {
        let crosses = self.mesh.topology().faces_of_vertex(v).map(|f| self.mesh.face_cross(f));
        crosses.sum::<DVec3>().normalize_or(DVec3::Z)
    }

    /// Moves vertices to the points of the original closest to the targets, if their faces keep their orientation and
    /// do not intersect others.
    fn move_to(&mut self, targets: &[DVec3]) {
        let feet = self.original.closest_points(targets);
        for (&v, foot) in self.movable.iter().zip(feet) {
            let to = foot.point;
            let topology = self.mesh.topology();
            if self.metrics.is_none()
                && !topology.faces_of_vertex(v).all(|face| self.domed[face.index()])
            {
                continue;
            }
            let crosses =
                || self.found.as_ref().is_some_and(|found| found.would_arise_at(self.mesh, v, to));
            if !can_move(self.mesh, &self.constraints.limits, v, to) || crosses() {
                continue;
            }
            self.mesh.positions_mut()[v.index()] = to;
            if let Some(found) = &mut self.found {
                found.update(self.mesh, self.mesh.topology().faces_of_vertex(v));
            }
        }
    }

    /// Flips every edge whose flip brings its faces closer to their samples.
    fn flip_all(&mut self) {
        for _ in 0..FLIP_PASSES {
            for index in 0..self.mesh.topology().edge_capacity() {
                self.flip(EdgeId::from_index(index));
            }
        }
    }

    fn flip(&mut self, edge: EdgeId) {
        let topology = self.mesh.topology();
        if !topology.contains_edge(edge) || self.constraints.is_held(edge) {
            return;
        }
        let [Some(left), Some(right)] = topology.edge_faces(edge) else { return };
        let is_domed = self.domed[left.index()] && self.domed[right.index()];
        let metric = match &self.metrics {
            _ if is_domed => None,
            Some(metrics) => Some(metrics[left.index()] + metrics[right.index()]),
            None => return,
        };
        let [h, twin] = edge.half_edges();
        let (Some(c), Some(d)) = (topology.apex(h), topology.apex(twin)) else { return };
        let [a, b] = topology.edge_vertices(edge);
        let corners = [[c, a, d], [d, b, c]];
        let triangles = corners.map(|triangle| triangle.map(|v| self.mesh.position(v)));
        let normal = self.mesh.face_cross(left) + self.mesh.face_cross(right);
        let before = [left, right].map(|face| self.mesh.triangle(face));
        if !triangles.iter().all(|&triangle| keeps_side(cross(triangle), normal))
            || !keeps_height(triangles, before)
            || !self.constraints.limits.allow_flip(self.mesh, edge)
        {
            return;
        }
        self.faces.clear();
        self.faces.extend([left, right]);
        let is_closer = match metric {
            Some(metric) => {
                let sum = |triangles: [[DVec3; 3]; 2]| -> f64 {
                    triangles.iter().map(|&triangle| spread(metric, triangle)).sum()
                };
                sum(triangles) < NOTICEABLE * sum(before)
            }
            None => self.reassign(&triangles, NOTICEABLE),
        };
        if !is_closer {
            return;
        }
        let Ok(legal) = self.mesh.topology().check_flip(edge) else { return };
        if let Some(found) = &self.found {
            let changed = |i: usize| ChangedFace {
                face: self.faces[i],
                triangle: (corners[i], triangles[i]),
            };
            if found.would_arise(self.mesh, &[changed(0), changed(1)], &[]) {
                return;
            }
        }
        self.mesh.flip(legal);
        if let (Some(metrics), Some(sum)) = (&mut self.metrics, metric) {
            for face in [left, right] {
                self.domed[face.index()] = false;
                metrics[face.index()] = 0.5 * sum;
            }
        }
        // The handles of the two faces may be swapped, so the samples are assigned by the current triangles.
        let now = self.faces.iter().map(|&face| self.mesh.triangle(face)).collect::<Vec<_>>();
        self.reassign(&now, f64::INFINITY);
        self.take();
    }

    /// Finds the closest of the new triangles for each sample of the faces. Returns whether the sum of the squared
    /// distances falls below `part` times its former value.
    fn reassign(&mut self, triangles: &[[DVec3; 3]], part: f64) -> bool {
        self.touched.clear();
        for &face in &self.faces {
            self.touched.extend(self.lists.of_face(face).map(|sample| (sample, 0, 0.0)));
        }
        let before: f64 = self.touched.iter().map(|t| self.error(t.0)).sum();
        let spread_before: f64 =
            self.faces.iter().map(|&f| spread(DMat3::IDENTITY, self.mesh.triangle(f))).sum();
        let spread_after: f64 = triangles.iter().map(|&t| spread(DMat3::IDENTITY, t)).sum();
        let mut left = if part.is_finite() {
            part * (before + self.roundness * spread_before) - self.roundness * spread_after
        } else {
            part
        };
        for (sample, place, squared) in &mut self.touched {
            let point = self.points[*sample as usize];
            *squared = f64::INFINITY;
            for (i, triangle) in triangles.iter().enumerate() {
                let distance = closest_on_triangle(point, triangle).length_squared();
                if distance < *squared {
                    (*place, *squared) = (as_u32(i), distance);
                }
            }
            left -= self.shares[*sample as usize] * *squared;
            if left <= 0.0 {
                return false;
            }
        }
        true
    }

    /// Assigns the samples to their new faces.
    fn take(&mut self) {
        for &face in &self.faces {
            self.lists.clear(face);
        }
        for &(sample, place, squared) in &self.touched {
            self.lists.push(self.faces[place as usize], sample);
            self.squares[sample as usize] = squared;
        }
        if let Some(found) = &mut self.found {
            found.update(self.mesh, self.faces.iter().copied());
        }
    }
}

/// The integrated squared distance of a triangle from a surface whose curvature is the same in all directions of a
/// metric, up to a factor: the area times the square of the sum of the squared sides.
fn spread(metric: DMat3, triangle: [DVec3; 3]) -> f64 {
    let [a, b, c] = triangle;
    let sides = [b - a, c - b, a - c].map(|side| side.dot(metric * side)).iter().sum::<f64>();
    area(&triangle) * sides * sides
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::Power;

    /// A rhombus of any size is cut along its shorter diagonal.
    #[test]
    fn edges_with_a_metric_are_flipped_when_that_makes_faces_rounder() {
        let schedule = Cooling {
            sweeps: 0,
            jump: 0.0,
            seed: 0,
            forbid_intersections: false,
            deadline: None,
            is_smooth: true,
        };
        for size in [0.01, 1.0, 100.0] {
            let corners = [[-3.0, 0.0], [3.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
            let points = corners.map(|[x, y]| [size * x, size * y, 0.0]);
            let mut mesh = TriMesh::from_triangles(&points, &[[0, 1, 2], [1, 0, 3]]).unwrap();
            let original = Surface::new(&mesh).unwrap();
            let constraints = FitConstraints::default();
            let mut density = Density::new(&mesh, &original, Power::SQUARE).unwrap();
            let with = (&schedule, &mut density);
            let mut layout = Layout::new(&mut mesh, &original, &constraints, with);
            layout.lists = FaceLists::new(2, 0);
            layout.domed = vec![false; 2];
            layout.metrics = Some(vec![DMat3::IDENTITY; 2]);
            layout.flip_all();
            let mut inner =
                mesh.topology().edges().filter(|&e| !mesh.topology().is_boundary_edge(e));
            let mut ends = mesh.topology().edge_vertices(inner.next().unwrap());
            ends.sort_unstable();
            assert_eq!(ends, [2, 3].map(VertexId::new), "{size}");
        }
    }
}
