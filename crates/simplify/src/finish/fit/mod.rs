//! Moving the vertices of a simplified mesh, and flipping its edges, to come closer to the
//! original.
//!
//! Each round
//!
//! 1. pairs samples of the original with the closest points of the mesh, and samples of the mesh
//!    with the closest points of the original;
//! 2. flips edges where that lowers the squared distance of the samples of the original;
//! 3. takes one Gauss-Newton step for the vertex positions `x`: with the weights `b` of a sample in
//!    its face, its partner `p` on the original and the normal `n` there, it minimises the sum of
//!    `(n·(Σ b x - p))² + pull |Σ b x - p|²` over all pairs.
//!
//! Boundary vertices slide along the boundary of the original, vertices on feature lines along
//! these; corners and fixed vertices stay. A vertex goes only as far as its faces keep their normals
//! and, if that is asked for, run into no others.

use std::sync::Arc;

use glam::DVec3;
use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, EdgeMap, FaceId, Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{
    ClosestPoint, Surface, SurfaceError, SurfaceSample, closest_on_triangle, sample_surface,
};

use crate::collapse::intersection::{ChangedFace, Intersections};
use crate::collapse::symmetric::{Factors, Symmetric3};
use crate::finish::curve::Curve;
use crate::finish::face_lists::FaceLists;

/// How to fit; see [`fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// How many rounds.
    pub rounds: usize,
    /// Samples per face of the mesh, in each direction.
    pub samples_per_face: usize,
    /// How strongly samples are drawn to their partners along the surface, relative to across it.
    pub pull: f64,
    /// How much more than the others the farthest pairs count, and the vertices of the original
    /// that are about as far: the weight of a pair at the distance d is 1 + tail (d / largest)^12.
    /// With 0 the mean square is minimised; otherwise the largest distance becomes smaller at the
    /// expense of the mean.
    pub tail: f64,
    /// Whether edges are flipped.
    pub flips: bool,
    /// Whether faces must not come to cross that did not before.
    pub forbid_intersections: bool,
    /// Where the random numbers start.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            rounds: 2,
            samples_per_face: 30,
            pull: 4e-4,
            tail: 0.0,
            flips: true,
            forbid_intersections: false,
            seed: 1,
        }
    }
}

/// What a fit must leave alone.
#[derive(Clone, Debug, Default)]
pub struct FitConstraints {
    /// Vertices that do not move.
    pub fixed: Option<VertexMap<bool>>,
    /// Edges that are not flipped.
    pub features: Option<EdgeMap<bool>>,
    /// The boundary of the original. Boundary vertices slide along it and stay as far from it as
    /// they are; those closest to its corners do not move. Without it no boundary vertex moves.
    pub boundary_curve: Option<Arc<Curve>>,
    /// The feature lines of the original, for the vertices of the edges in `features`, in the same
    /// way.
    pub feature_curve: Option<Arc<Curve>>,
}

impl FitConstraints {
    pub(crate) fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().and_then(|map| map.get(e)).is_some_and(|&feature| feature)
    }

    fn curve(&self, freedom: Freedom) -> Option<&Curve> {
        match freedom {
            Freedom::AlongBoundary => self.boundary_curve.as_deref(),
            Freedom::AlongFeature => self.feature_curve.as_deref(),
            Freedom::Free | Freedom::Fixed => None,
        }
    }
}

/// What a fit did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitReport {
    /// How many rounds were made.
    pub rounds: usize,
    /// How many edges were flipped.
    pub flips: usize,
    /// Root mean square distance of the pairs at the start of the first round.
    pub rms_before: f64,
    /// Root mean square distance of the pairs at the start of the last round.
    pub rms_last: f64,
}

/// Fits a mesh to the original it was made from.
///
/// # Errors
/// The mesh has no faces.
pub fn fit(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
) -> Result<FitReport, SurfaceError> {
    let count = options.samples_per_face.saturating_mul(mesh.topology().face_count());
    let targets: Vec<Target> = sample_surface(original, count, options.seed)
        .iter()
        .map(|sample| Target::new(original, sample))
        .collect();
    let points: Vec<DVec3> = targets.iter().map(|target| target.point).collect();
    let rough_targets: Vec<Target> = targets.iter().step_by(2).copied().collect();
    let rough_points: Vec<DVec3> = rough_targets.iter().map(|target| target.point).collect();
    let mut report = FitReport::default();
    let lines = Lines::new(mesh, original, constraints, count);
    let mut found = options.forbid_intersections.then(|| Intersections::new(mesh));
    for round in 0..options.rounds {
        let surface = Surface::new(mesh)?;
        let mut paired = Pairs::new(mesh);
        // The first of several rounds is a rough one.
        let part = if round + 1 < options.rounds && round == 0 { 2 } else { 1 };
        let (targets, points, count) = match part {
            1 => (&targets, &points, count),
            _ => (&rough_targets, &rough_points, count / 2),
        };
        for (target, closest) in targets.iter().zip(surface.closest_points(points)) {
            paired.push(&closest, *target);
        }
        if options.tail > 0.0 {
            paired.push_far(&surface, original);
        }
        if options.flips {
            report.flips += flip_edges(mesh, &mut paired, constraints, found.as_mut());
        }
        let freedoms = freedoms(mesh, constraints);
        let mut system = System::new(mesh);
        lines.add_to(&mut system, mesh);
        let mut tally = Tally::default();
        let largest = paired.squares.iter().copied().fold(0.0, f64::max);
        let weighting = Weighting { pull: options.pull, tail: options.tail, largest };
        paired.for_each(mesh, |face, target| {
            let weights = weights_of_closest(target.point, &mesh.triangle(face));
            tally.add(system.add(mesh, face, weights, target, weighting));
        });
        let samples = if options.flips {
            // The faces are others now.
            sample_surface(&Surface::new(mesh)?, count, options.seed + round as u64 + 1)
        } else {
            sample_surface(&surface, count, options.seed + round as u64 + 1)
        };
        add_own_samples(mesh, original, &samples, weighting, &mut system, &mut tally);
        report.rms_last = tally.rms();
        if round == 0 {
            report.rms_before = tally.rms();
        }
        let moved = system.solve(mesh, &freedoms, constraints);
        move_vertices(mesh, &moved, &freedoms, constraints, found.as_mut());
        report.rounds += 1;
    }
    Ok(report)
}

/// A point of the original that the mesh is drawn to.
#[derive(Clone, Copy)]
struct Target {
    point: DVec3,
    normal: DVec3,
}

impl Target {
    fn new(original: &Surface, sample: &SurfaceSample) -> Self {
        Self { point: sample.position, normal: normal_of(original, sample.triangle as usize) }
    }
}

/// Points of the lines of the original, and the edges of the mesh that stand for these lines.
///
/// The pairs of samples of the surfaces do not feel a boundary that moves within the surface; these
/// do.
struct Lines(Vec<Line>);

struct Line {
    points: Vec<DVec3>,
    edges: Vec<EdgeId>,
}

impl Lines {
    /// As densely sampled as the surface.
    fn new(
        mesh: &TriMesh,
        original: &Surface,
        constraints: &FitConstraints,
        samples: usize,
    ) -> Self {
        let topology = mesh.topology();
        let area: f64 = (0..original.triangle_count())
            .map(|t| original.triangle(t))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
            .sum();
        let spacing = (area / samples.max(1) as f64).sqrt();
        let line = |curve: &Option<Arc<Curve>>, is_line: &dyn Fn(EdgeId) -> bool| {
            let points = curve.as_ref()?.points(spacing);
            Some(Line { points, edges: topology.edges().filter(|&e| is_line(e)).collect() })
        };
        let boundary = line(&constraints.boundary_curve, &|e| topology.is_boundary_edge(e));
        let features = line(&constraints.feature_curve, &|e| constraints.is_feature(e));
        Self([boundary, features].into_iter().flatten().collect())
    }

    fn add_to(&self, system: &mut System, mesh: &TriMesh) {
        for Line { points, edges } in &self.0 {
            // None of the lines may be left.
            let Some(curve) = Curve::new(mesh, edges) else { continue };
            for (point, (edge, along)) in points.iter().zip(curve.closest_edges(points)) {
                system.add_to_edge(mesh, edges[edge], along, *point);
            }
        }
    }
}

fn normal_of(surface: &Surface, triangle: usize) -> DVec3 {
    let [a, b, c] = surface.triangle(triangle);
    (b - a).cross(c - a).normalize_or_zero()
}

fn add_own_samples(
    mesh: &TriMesh,
    original: &Surface,
    samples: &[SurfaceSample],
    weighting: Weighting,
    system: &mut System,
    tally: &mut Tally,
) {
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let points: Vec<DVec3> = samples.iter().map(|sample| sample.position).collect();
    let closest = original.closest_points(&points);
    let largest =
        closest.iter().map(|c| c.offset.length_squared()).fold(weighting.largest, f64::max);
    let weighting = Weighting { largest, ..weighting };
    for (sample, closest) in samples.iter().zip(closest) {
        let ClosestPoint { point, triangle, .. } = closest;
        let target = Target { point, normal: normal_of(original, triangle as usize) };
        let face = faces[sample.triangle as usize];
        tally.add(system.add(mesh, face, DVec3::from(sample.weights), target, weighting));
    }
}

/// Barycentric coordinates of the point of a triangle that is closest to `point`.
pub(crate) fn weights_of_closest(point: DVec3, triangle: &[DVec3; 3]) -> DVec3 {
    let at = point + closest_on_triangle(point, triangle);
    let [a, b, c] = triangle.map(|corner| corner - at);
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let parts = DVec3::new(b.cross(c).dot(normal), c.cross(a).dot(normal), a.cross(b).dot(normal));
    let parts = parts.max(DVec3::ZERO);
    let sum = parts.element_sum();
    if sum > 0.0 { parts / sum } else { DVec3::splat(1.0 / 3.0) }
}

/// How much a pair counts.
#[derive(Clone, Copy)]
struct Weighting {
    pull: f64,
    tail: f64,
    /// The largest squared distance of a pair.
    largest: f64,
}

impl Weighting {
    fn of(&self, squared: f64) -> f64 {
        let ratio = if self.largest > 0.0 { squared / self.largest } else { 0.0 };
        1.0 + self.tail * ratio.powi(6)
    }
}

#[derive(Default)]
struct Tally {
    squares: f64,
    count: usize,
}

impl Tally {
    fn add(&mut self, squared: f64) {
        self.squares += squared;
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

/// Targets by the face that is closest to them.
struct Pairs {
    lists: FaceLists,
    targets: Vec<Target>,
    /// The squared distance of each target from its face.
    squares: Vec<f64>,
}

impl Pairs {
    fn new(mesh: &TriMesh) -> Self {
        let lists = FaceLists::new(mesh.topology().face_capacity());
        Self { lists, targets: Vec::new(), squares: Vec::new() }
    }

    fn push(&mut self, closest: &ClosestPoint, target: Target) {
        self.lists.push(closest.face, self.targets.len() as u32);
        self.squares.push(closest.offset.length_squared());
        self.targets.push(target);
    }

    /// Adds the vertices of the original that are more than half as far as the farthest target.
    /// The normals there are the directions in which they are.
    fn push_far(&mut self, surface: &Surface, original: &Surface) {
        let at = |v: u32| original.positions()[v as usize];
        let points: Vec<DVec3> = original.used_vertices().into_iter().map(at).collect();
        let bar = 0.5 * self.squares.iter().copied().fold(0.0, f64::max).sqrt();
        for (&point, closest) in points.iter().zip(surface.closest_points(&points)) {
            if closest.distance > bar {
                self.push(&closest, Target { point, normal: closest.offset.normalize_or_zero() });
            }
        }
    }

    fn for_each(&self, mesh: &TriMesh, mut act: impl FnMut(FaceId, Target)) {
        for face in mesh.topology().faces() {
            for index in self.lists.of_face(face) {
                act(face, self.targets[index as usize]);
            }
        }
    }

    /// Gives the targets of two faces to the one that is closer, the faces being as they are now.
    fn redistribute(&mut self, mesh: &TriMesh, faces: [FaceId; 2], scratch: &mut Vec<u32>) {
        scratch.clear();
        for face in faces {
            scratch.extend(self.lists.of_face(face));
            self.lists.clear(face);
        }
        let triangles = faces.map(|face| mesh.triangle(face));
        for &index in scratch.iter() {
            let point = self.targets[index as usize].point;
            let [d0, d1] = [&triangles[0], &triangles[1]]
                .map(|triangle| closest_on_triangle(point, triangle).length_squared());
            self.lists.push(faces[usize::from(d1 < d0)], index);
            self.squares[index as usize] = d0.min(d1);
        }
    }
}

/// The smallest cosine between the normals of faces before and after a flip or a move.
const MIN_COSINE: f64 = 0.5;

/// Flips every edge whose flip lowers the squared distance of the targets of its two faces.
fn flip_edges(
    mesh: &mut TriMesh,
    paired: &mut Pairs,
    constraints: &FitConstraints,
    mut found: Option<&mut Intersections>,
) -> usize {
    let mut scratch = Vec::new();
    let mut flips = 0;
    for index in 0..mesh.topology().edge_capacity() {
        let edge = EdgeId::from_index(index);
        if constraints.is_feature(edge) || !flip_is_closer(mesh, paired, edge) {
            continue;
        }
        let Ok(legal) = mesh.topology().check_flip(edge) else { continue };
        if found.as_ref().is_some_and(|found| flip_crosses(mesh, found, &legal)) {
            continue;
        }
        mesh.flip(legal);
        flips += 1;
        if let Some(found) = &mut found {
            found.update(mesh, mesh.topology().edge_faces(edge).into_iter().flatten());
        }
        if let [Some(left), Some(right)] = mesh.topology().edge_faces(edge) {
            paired.redistribute(mesh, [left, right], &mut scratch);
        }
    }
    flips
}

fn flip_is_closer(mesh: &TriMesh, paired: &Pairs, edge: EdgeId) -> bool {
    let topology = mesh.topology();
    if !topology.contains_edge(edge) {
        return false;
    }
    let [h, twin] = edge.half_edges();
    let (Some(c), Some(d)) = (topology.apex(h), topology.apex(twin)) else { return false };
    let [a, b] = topology.edge_vertices(edge).map(|v| mesh.position(v));
    let (c, d) = (mesh.position(c), mesh.position(d));
    let new = [[c, a, d], [d, b, c]];
    let cross = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p);
    let normal = cross([a, b, c]) + cross([b, a, d]);
    let keeps_side = |n: DVec3| n.dot(normal) > MIN_COSINE * n.length() * normal.length();
    if !new.into_iter().all(|triangle| keeps_side(cross(triangle))) {
        return false;
    }
    let faces = || topology.edge_faces(edge).into_iter().flatten();
    let targets =
        || faces().flat_map(|face| paired.lists.of_face(face)).map(|index| index as usize);
    let before: f64 = targets().map(|index| paired.squares[index]).sum();
    let mut left = before * (1.0 - 1e-9);
    for index in targets() {
        let point = paired.targets[index].point;
        let [p, q] = [&new[0], &new[1]].map(|t| closest_on_triangle(point, t).length_squared());
        left -= p.min(q);
        // Most flips are for the worse, as the first few targets tell.
        if left <= 0.0 {
            return false;
        }
    }
    before > 0.0
}

fn flip_crosses(mesh: &TriMesh, found: &Intersections, flip: &LegalFlip) -> bool {
    let [a, b, c, d] = flip.quad();
    let faces = mesh.topology().edge_faces(flip.edge()).into_iter().flatten();
    let changed: Vec<ChangedFace> = faces
        .zip([[c, a, d], [d, b, c]])
        .map(|(face, vertices)| {
            let triangle = (vertices, vertices.map(|v| mesh.position(v)));
            ChangedFace { face, triangle }
        })
        .collect();
    found.would_arise(mesh, &changed, &[])
}

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Freedom {
    Fixed,
    Free,
    AlongBoundary,
    AlongFeature,
}

/// What each vertex may do, by index.
fn freedoms(mesh: &TriMesh, constraints: &FitConstraints) -> Vec<Freedom> {
    let topology = mesh.topology();
    let of_vertex = |index: usize| {
        let v = VertexId::from_index(index);
        let fixed = constraints.fixed.as_ref().and_then(|map| map.get(v)) == Some(&true);
        if fixed || !topology.contains_vertex(v) {
            return Freedom::Fixed;
        }
        let features = topology.edges_of_vertex(v).filter(|&e| constraints.is_feature(e)).count();
        match (topology.is_boundary_vertex(v), features) {
            (false, 0) => Freedom::Free,
            (true, 0) if constraints.boundary_curve.is_some() => Freedom::AlongBoundary,
            (false, 2) if constraints.feature_curve.is_some() => Freedom::AlongFeature,
            _ => Freedom::Fixed,
        }
    };
    let mut freedoms: Vec<Freedom> = (0..topology.vertex_capacity()).map(of_vertex).collect();
    let curves = [
        (Freedom::AlongBoundary, &constraints.boundary_curve),
        (Freedom::AlongFeature, &constraints.feature_curve),
    ];
    for (kind, curve) in curves {
        let corners = curve.as_ref().map_or(&[][..], |curve| curve.corners());
        fix_closest(mesh, &mut freedoms, kind, corners);
    }
    freedoms
}

/// Fixes, of the vertices of one kind, the one that is closest to each corner.
fn fix_closest(mesh: &TriMesh, freedoms: &mut [Freedom], kind: Freedom, corners: &[DVec3]) {
    let of_kind = (0..freedoms.len() as u32).filter(|&v| freedoms[v as usize] == kind);
    let points: Vec<[u32; 3]> = of_kind.map(|v| [v; 3]).collect();
    // Without such vertices there is nothing to fix.
    let Ok(surface) = Surface::from_triangles(mesh.positions(), &points) else { return };
    for closest in surface.closest_points(corners) {
        let [v, ..] = points[closest.triangle as usize];
        freedoms[v as usize] = Freedom::Fixed;
    }
}

/// The normal equations of the Gauss-Newton step, in blocks of three by three: one per vertex and
/// one per edge.
struct System {
    of_vertex: Vec<Symmetric3>,
    of_edge: Vec<Symmetric3>,
    /// Minus the gradient where the vertices are.
    residual: Vec<DVec3>,
}

impl System {
    fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        Self {
            of_vertex: vec![Symmetric3::default(); topology.vertex_capacity()],
            of_edge: vec![Symmetric3::default(); topology.edge_capacity()],
            residual: vec![DVec3::ZERO; topology.vertex_capacity()],
        }
    }

    /// Adds a pair: the point of `face` with these weights and its target. Returns the squared
    /// distance of the two.
    fn add(
        &mut self,
        mesh: &TriMesh,
        face: FaceId,
        weights: DVec3,
        target: Target,
        weighting: Weighting,
    ) -> f64 {
        let sides = mesh.topology().face_half_edges(face);
        let corners = mesh.topology().face_vertices(face);
        let [a, b, c] = corners.map(|v| mesh.position(v) - target.point);
        let gap = a * weights.x + b * weights.y + c * weights.z;
        let squared = gap.length_squared();
        let weight = weighting.of(squared);
        let mut matrix = Symmetric3::square(target.normal, weight);
        matrix.diagonal += weight * weighting.pull;
        let force = matrix.times(gap);
        for i in 0..3 {
            self.of_vertex[corners[i].index()] += weights[i] * weights[i] * matrix;
            self.of_edge[sides[i].edge().index()] += weights[i] * weights[(i + 1) % 3] * matrix;
            self.residual[corners[i].index()] -= weights[i] * force;
        }
        squared
    }

    /// Adds a pair of the point that is `along` an edge, as a part of its length, and its target.
    fn add_to_edge(&mut self, mesh: &TriMesh, edge: EdgeId, along: f64, target: DVec3) {
        let ends = mesh.topology().edge_vertices(edge);
        let [a, b] = ends.map(|v| mesh.position(v) - target);
        let weights = [1.0 - along, along];
        let force = weights[0] * a + weights[1] * b;
        let unit = Symmetric3 { diagonal: DVec3::ONE, mixed: DVec3::ZERO };
        for (v, weight) in ends.into_iter().zip(weights) {
            self.of_vertex[v.index()] += weight * weight * unit;
            self.residual[v.index()] -= weight * force;
        }
        self.of_edge[edge.index()] += weights[0] * weights[1] * unit;
    }

    /// The displacement of each vertex, by conjugate gradients preconditioned with the blocks of
    /// the vertices.
    fn solve(
        &self,
        mesh: &TriMesh,
        freedoms: &[Freedom],
        constraints: &FitConstraints,
    ) -> Vec<DVec3> {
        let inverses: Vec<Inverse> = freedoms
            .iter()
            .zip(&self.of_vertex)
            .zip(mesh.positions())
            .map(|((&freedom, block), &at)| match (freedom, constraints.curve(freedom)) {
                (Freedom::Free, _) => Inverse::of(block),
                (_, Some(curve)) => Inverse::along(block, curve.direction(at)),
                _ => Inverse::Zero,
            })
            .collect();
        let precondition = |r: &[DVec3]| -> Vec<DVec3> {
            r.iter().zip(&inverses).map(|(r, inverse)| inverse.times(*r)).collect()
        };
        let dot =
            |p: &[DVec3], q: &[DVec3]| -> f64 { p.iter().zip(q).map(|(a, b)| a.dot(*b)).sum() };
        let mut x = vec![DVec3::ZERO; freedoms.len()];
        let mut r = self.residual.clone();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let enough = TOLERANCE * TOLERANCE * rz;
        for _ in 0..ITERATIONS {
            if rz <= enough {
                break;
            }
            let ap = self.times(mesh, &p);
            let step = rz / dot(&p, &ap);
            if !step.is_finite() {
                break;
            }
            for v in 0..freedoms.len() {
                x[v] += step * p[v];
                r[v] -= step * ap[v];
            }
            z = precondition(&r);
            let following = dot(&r, &z);
            let keep = following / rz;
            rz = following;
            for v in 0..freedoms.len() {
                p[v] = z[v] + keep * p[v];
            }
        }
        x
    }

    fn times(&self, mesh: &TriMesh, p: &[DVec3]) -> Vec<DVec3> {
        let topology = mesh.topology();
        let mut out: Vec<DVec3> =
            p.iter().zip(&self.of_vertex).map(|(p, block)| block.times(*p)).collect();
        for e in topology.edges() {
            let [a, b] = topology.edge_vertices(e).map(VertexId::index);
            out[a] += self.of_edge[e.index()].times(p[b]);
            out[b] += self.of_edge[e.index()].times(p[a]);
        }
        out
    }
}

/// The inverse of the block of a vertex among the directions in which it may go. What it gives has
/// no part in the others, so that conjugate gradients stay among these directions.
enum Inverse {
    Zero,
    Full(Factors),
    Along(DVec3),
}

impl Inverse {
    fn of(block: &Symmetric3) -> Self {
        block.factors(DAMPING).map_or(Self::Zero, Self::Full)
    }

    fn along(block: &Symmetric3, direction: DVec3) -> Self {
        let scale = direction.dot(block.times(direction)).sqrt().recip();
        if scale.is_finite() { Self::Along(scale * direction) } else { Self::Zero }
    }

    fn times(&self, r: DVec3) -> DVec3 {
        match self {
            Self::Zero => DVec3::ZERO,
            Self::Full(factors) => factors.solve(r),
            Self::Along(direction) => direction.dot(r) * *direction,
        }
    }
}

/// Relative to the trace of a block.
const DAMPING: f64 = 1e-9;
const TOLERANCE: f64 = 1e-4;
const ITERATIONS: usize = 60;

/// Moves each vertex by its displacement, or by half or a quarter of it, or not at all, so that no
/// face turns too far.
fn move_vertices(
    mesh: &mut TriMesh,
    displacements: &[DVec3],
    freedoms: &[Freedom],
    constraints: &FitConstraints,
    mut found: Option<&mut Intersections>,
) {
    let mut before: Vec<DVec3> = Vec::new();
    for (index, &displacement) in displacements.iter().enumerate() {
        let v = VertexId::from_index(index);
        if displacement == DVec3::ZERO || !displacement.is_finite() {
            continue;
        }
        let from = mesh.position(v);
        let curve = constraints.curve(freedoms[index]);
        let displacement = match curve {
            Some(_) => displacement.clamp_length_max(0.5 * shortest_edge(mesh, v)),
            None => displacement,
        };
        before.clear();
        before.extend(mesh.topology().faces_of_vertex(v).map(|f| mesh.face_cross(f)));
        for part in [1.0, 0.5, 0.25] {
            let free = from + part * displacement;
            // As far from the curve as it was.
            let to = curve.map_or(free, |c| from + (c.closest(free) - c.closest(from)));
            let crosses = found.as_ref().is_some_and(|found| found.would_arise_at(mesh, v, to));
            if !crosses && try_move(mesh, v, to, &before) {
                if let Some(found) = &mut found {
                    found.update(mesh, mesh.topology().faces_of_vertex(v));
                }
                break;
            }
        }
    }
}

fn shortest_edge(mesh: &TriMesh, v: VertexId) -> f64 {
    let lengths = mesh.topology().one_ring(v).map(|w| mesh.position(w).distance(mesh.position(v)));
    lengths.fold(f64::INFINITY, f64::min)
}

/// Moves a vertex unless that turns a face too far from its normal before.
pub(crate) fn try_move(mesh: &mut TriMesh, v: VertexId, to: DVec3, before: &[DVec3]) -> bool {
    let from = mesh.position(v);
    mesh.positions_mut()[v.index()] = to;
    let keeps_side = mesh.topology().faces_of_vertex(v).zip(before).all(|(f, old)| {
        let new = mesh.face_cross(f);
        new.dot(*old) > MIN_COSINE * new.length() * old.length()
    });
    if !keeps_side {
        mesh.positions_mut()[v.index()] = from;
    }
    keeps_side
}
