//! Vectorised evaluation of the stars of a block of vertices.
//!
//! In a single star each step depends on the one before. Here the edge vectors (incident edges) of many stars are
//! stored in flat arrays, so that plain loops evaluate all faces and then all edges. Compilers vectorise these loops,
//! and `fearless_simd` selects the widest instructions of the processor. Formulas and order of summation are the same
//! as in [`VertexStar`](crate::VertexStar) and [`willmore_energy`](crate::willmore_energy), so results have the same
//! bits at any width.

use core::f64::consts::TAU;
use core::iter::zip;
use core::mem::take;
use core::ops::Range;

use fearless_simd::{Level, dispatch};
use glam::{DVec2, DVec3};
use mesh_core::{Handle, TriMesh, VertexId};

use crate::angle::{collapsed_corner, unit_scaled};
use crate::area::{VertexArea, barycentric_share, voronoi_share};
use crate::atan2::atan2;
use crate::circumcircle_angle::{is_in_range, product};
use crate::dihedral::hinge_angle;
use crate::star::{StarTotals, VertexIntegrals, full_angle, vertex_integrals};

/// Vertices per block: long loops, but a block fits in the first-level cache.
pub(crate) const BLOCK: usize = 64;

/// The stars of a block of vertices. Array entries beyond the incident edges of the block are stale and unused.
#[derive(Clone, Debug)]
pub(crate) struct StarBatch {
    level: Level,
    /// The gathered vertices.
    vertices: Range<usize>,
    stars: Vec<Star>,
    /// Centre and other end of each incident edge, clockwise, star by star. A closed star repeats its first two
    /// incident edges at the end, so that each face lies between two consecutive incident edges and each interior edge
    /// between two consecutive faces.
    ends: Vec<[VertexId; 2]>,
    incident_edges: Columns,
    /// Normal of the face between this incident edge and the next.
    normals: Columns,
    /// A vector with the angle between this incident edge and the next; zero if an incident edge has no length.
    cosines: Vec<f64>,
    sines: Vec<f64>,
    shares: Vec<f64>,
    /// The length of this incident edge times its dihedral angle.
    bends: Vec<f64>,
    totals: Vec<StarTotals>,
    angle_defects: Vec<f64>,
    /// From the end of this incident edge to the end of the next.
    rims: Columns,
    /// Intersection angle of this incident edge, or NaN where the fast formula overflows.
    intersections: Vec<f64>,
}

/// Position of the incident edges of a star.
#[derive(Clone, Copy, Debug)]
struct Star {
    first: usize,
    faces: usize,
    closed: bool,
    full_angle: f64,
}

/// Vectors as structure of arrays.
#[derive(Clone, Debug, Default)]
struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Columns {
    fn lengthen(&mut self, length: usize) {
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            lengthen(column, length);
        }
    }

    #[inline]
    fn at(&self, index: usize) -> DVec3 {
        DVec3::new(self.x[index], self.y[index], self.z[index])
    }
}

fn lengthen(column: &mut Vec<f64>, length: usize) {
    if column.len() < length {
        column.resize(length, 0.0);
    }
}

impl StarBatch {
    /// A constructor for the widest vector instructions of the processor.
    pub(crate) fn maker() -> impl Fn() -> Self + Sync + Send {
        let level = Level::new();
        move || Self::new(level)
    }

    /// An empty batch for these vector instructions.
    fn new(level: Level) -> Self {
        Self {
            level,
            vertices: 0..0,
            stars: Vec::new(),
            ends: Vec::new(),
            incident_edges: Columns::default(),
            normals: Columns::default(),
            cosines: Vec::new(),
            sines: Vec::new(),
            shares: Vec::new(),
            bends: Vec::new(),
            totals: Vec::new(),
            angle_defects: Vec::new(),
            rims: Columns::default(),
            intersections: Vec::new(),
        }
    }

    /// Stores the edges around each of these vertices.
    #[inline(always)]
    pub(crate) fn gather(&mut self, mesh: &TriMesh, vertices: Range<usize>) {
        let topology = mesh.topology();
        self.stars.clear();
        self.ends.clear();
        for vertex in vertices.clone().map(VertexId::from_index) {
            let first = self.ends.len();
            self.ends.extend(topology.one_ring(vertex).map(|neighbour| [vertex, neighbour]));
            let incident_edges = self.ends.len() - first;
            let closed = !topology.is_boundary_vertex(vertex);
            if closed {
                self.ends.extend_from_within(first..first + incident_edges.min(2));
            }
            let faces = if closed { incident_edges } else { incident_edges - 1 };
            let full_angle = if incident_edges == 0 { 0.0 } else { full_angle(closed) };
            self.stars.push(Star { first, faces, closed, full_angle });
        }
        self.vertices = vertices;
        self.incident_edges.lengthen(self.ends.len());
        self.evaluate_incident_edges(mesh.positions());
    }

    /// Whether each gathered vertex lies on the boundary.
    #[inline]
    pub(crate) fn on_boundary(&self) -> impl Iterator<Item = bool> {
        self.stars.iter().map(|star| !star.closed)
    }

    /// The integrals of each gathered vertex, then defaults.
    #[inline(always)]
    pub(crate) fn integrals(
        &mut self,
        mesh: &TriMesh,
        area: VertexArea,
    ) -> [VertexIntegrals; BLOCK] {
        let length = self.ends.len();
        self.normals.lengthen(length);
        for column in [&mut self.cosines, &mut self.sines, &mut self.shares, &mut self.bends] {
            lengthen(column, length);
        }
        lengthen(&mut self.angle_defects, self.stars.len());
        dispatch!(self.level, _ => self.evaluate(area));
        self.add_up();
        dispatch!(self.level, _ => self.evaluate_defects());
        let mut integrals = [VertexIntegrals::default(); BLOCK];
        let rows = zip(zip(&self.totals, &self.angle_defects), self.vertices.clone());
        for (slot, ((totals, &defect), index)) in zip(&mut integrals, rows) {
            *slot = totals.integrals(defect);
            if !slot.is_in_range() {
                *slot = vertex_integrals(mesh, VertexId::from_index(index), area);
            }
        }
        integrals
    }

    /// The Willmore energy of each gathered vertex; `None` where the fast formula overflows.
    #[inline(always)]
    pub(crate) fn energies(
        &mut self,
        mesh: &TriMesh,
    ) -> impl Iterator<Item = (VertexId, Option<f64>)> {
        let length = self.ends.len();
        self.rims.lengthen(length);
        lengthen(&mut self.intersections, length);
        dispatch!(self.level, _ => self.evaluate_intersections(mesh.positions()));
        zip(&self.stars, self.vertices.clone()).map(|(star, index)| {
            let energy = Some(self.energy(star)).filter(|energy| !energy.is_nan());
            (VertexId::from_index(index), energy)
        })
    }

    #[inline(always)]
    fn evaluate(&mut self, area: VertexArea) {
        // None of the vertices has faces.
        if self.ends.is_empty() {
            return;
        }
        match area {
            VertexArea::Voronoi => self.evaluate_faces(voronoi_share),
            VertexArea::Barycentric => self.evaluate_faces(barycentric_share),
        }
        self.evaluate_edges();
    }

    fn evaluate_incident_edges(&mut self, positions: &[DVec3]) {
        let count = self.ends.len();
        let Columns { x, y, z } = &mut self.incident_edges;
        let (x, y, z) = (&mut x[..count], &mut y[..count], &mut z[..count]);
        for (i, &[center, neighbour]) in self.ends.iter().enumerate() {
            let incident_edge = positions[neighbour.index()] - positions[center.index()];
            (x[i], y[i], z[i]) = (incident_edge.x, incident_edge.y, incident_edge.z);
        }
    }

    #[inline(always)]
    fn evaluate_faces(&mut self, share: impl Fn(DVec3, DVec3, f64) -> f64) {
        let count = self.ends.len().saturating_sub(1);
        let Columns { x, y, z } = &self.incident_edges;
        let (x, y, z) = (&x[..=count], &y[..=count], &z[..=count]);
        let Columns { x: nx, y: ny, z: nz } = &mut self.normals;
        let (nx, ny, nz) = (&mut nx[..count], &mut ny[..count], &mut nz[..count]);
        let (cosines, sines) = (&mut self.cosines[..count], &mut self.sines[..count]);
        let shares = &mut self.shares[..count];
        for i in 0..count {
            let from = DVec3::new(x[i], y[i], z[i]);
            let to = DVec3::new(x[i + 1], y[i + 1], z[i + 1]);
            let normal = to.cross(from);
            let twice_area = normal.length();
            (nx[i], ny[i], nz[i]) = (normal.x, normal.y, normal.z);
            let corner = unit_scaled(DVec2::new(from.dot(to), twice_area));
            (cosines[i], sines[i]) = (corner.x, corner.y);
            shares[i] = share(from, to, twice_area);
        }
    }

    #[inline(always)]
    fn evaluate_edges(&mut self) {
        let count = self.ends.len().saturating_sub(2);
        let Columns { x, y, z } = &self.incident_edges;
        let (x, y, z) = (&x[..count + 2], &y[..count + 2], &z[..count + 2]);
        let Columns { x: nx, y: ny, z: nz } = &self.normals;
        let (nx, ny, nz) = (&nx[..=count], &ny[..=count], &nz[..=count]);
        let bends = &mut self.bends[1..=count];
        for i in 0..count {
            let incident_edge = DVec3::new(x[i + 1], y[i + 1], z[i + 1]);
            let right = DVec3::new(x[i + 2], y[i + 2], z[i + 2]);
            let left_normal = DVec3::new(nx[i], ny[i], nz[i]);
            let right_normal = DVec3::new(nx[i + 1], ny[i + 1], nz[i + 1]);
            let length = incident_edge.length();
            bends[i] = length * hinge_angle(length, left_normal, right_normal, right);
        }
    }

    /// [`intersection_angle`](crate::intersection_angle) of the centre and the ends of each incident edge, the
    /// incident edge before it and the incident edge after it.
    #[inline(always)]
    fn evaluate_intersections(&mut self, positions: &[DVec3]) {
        let mut points = self.ends.iter().map(|&[_, neighbour]| positions[neighbour.index()]);
        // None of the vertices has faces.
        let Some(mut from) = points.next() else { return };
        let count = self.ends.len().saturating_sub(2);
        let Columns { x: rx, y: ry, z: rz } = &mut self.rims;
        let (rx, ry, rz) = (&mut rx[..=count], &mut ry[..=count], &mut rz[..=count]);
        for (i, to) in points.enumerate() {
            let rim = to - from;
            (rx[i], ry[i], rz[i]) = (rim.x, rim.y, rim.z);
            from = to;
        }
        let Columns { x, y, z } = &self.incident_edges;
        let (x, y, z) = (&x[..count + 2], &y[..count + 2], &z[..count + 2]);
        let angles = &mut self.intersections[1..=count];
        for i in 0..count {
            let left = DVec3::new(x[i], y[i], z[i]);
            let right = DVec3::new(x[i + 2], y[i + 2], z[i + 2]);
            let left_rim = DVec3::new(rx[i], ry[i], rz[i]);
            let right_rim = DVec3::new(rx[i + 1], ry[i + 1], rz[i + 1]);
            let (real, imaginary) = product([right, -right_rim, -left_rim, -left]);
            let angle = atan2(imaginary, real);
            angles[i] = if is_in_range(real, imaginary) { angle } else { f64::NAN };
        }
    }

    /// The energy of a star: 0 at the boundary.
    #[inline]
    fn energy(&self, star: &Star) -> f64 {
        if !star.closed || star.faces == 0 {
            return 0.0;
        }
        let angles = &self.intersections[star.first + 1..=star.first + star.faces];
        angles.iter().fold(0.0, |sum, angle| sum + angle) - TAU
    }

    /// Sums the terms of each star in clockwise order.
    fn add_up(&mut self) {
        let mut totals = take(&mut self.totals);
        totals.clear();
        totals.extend(self.stars.iter().map(|star| self.total(star)));
        self.totals = totals;
    }

    #[inline]
    fn total(&self, star: &Star) -> StarTotals {
        let mut totals = StarTotals::ZERO;
        if star.faces == 0 {
            return totals;
        }
        let last = star.first + star.faces - 1;
        for face in star.first..last {
            totals.add_face(self.corner(face), self.shares[face]);
            totals.add_edge(self.bends[face + 1]);
        }
        totals.add_face(self.corner(last), self.shares[last]);
        if star.closed {
            totals.add_edge(self.bends[last + 1]);
        }
        totals
    }

    #[inline]
    fn corner(&self, face: usize) -> DVec2 {
        let corner = DVec2::new(self.cosines[face], self.sines[face]);
        if corner == DVec2::ZERO {
            unit_scaled(collapsed_corner(
                self.incident_edges.at(face),
                self.incident_edges.at(face + 1),
            ))
        } else {
            corner
        }
    }

    #[inline(always)]
    fn evaluate_defects(&mut self) {
        let rows = zip(&self.stars, &self.totals).zip(&mut self.angle_defects);
        for ((star, totals), defect) in rows {
            *defect = totals.angle_defect(star.full_angle);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertex::vertex_curvature;
    use crate::willmore::willmore_energy;
    use fearless_simd::Simd;
    use mesh_core::SplitMix64;
    use mesh_shapes::scramble;

    fn levels() -> Vec<Level> {
        let best = Level::new();
        let mut levels = vec![Level::baseline(), best];
        #[cfg(target_arch = "x86_64")]
        {
            levels.extend(best.as_sse4_2().map(Simd::level));
            levels.extend(best.as_avx2().map(Simd::level));
        }
        levels
    }

    /// A cone of many faces, whole or with a gap, with random neighbours and an isolated vertex.
    fn cone(sides: u32, closed: bool, random: &mut SplitMix64) -> TriMesh {
        let mut point = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
        let points: Vec<DVec3> = (0..sides + 2).map(|_| point()).collect();
        let last = if closed { sides } else { sides - 1 };
        let faces: Vec<[u32; 3]> = (0..last).map(|i| [sides, i, (i + 1) % sides]).collect();
        TriMesh::from_triangles(&points, &faces).unwrap()
    }

    /// A grid with flipped diagonals, some of whose points coincide.
    fn crumpled_grid(random: &mut SplitMix64) -> TriMesh {
        let side = 20;
        let mut points: Vec<DVec3> = (0..side * side)
            .map(|i| DVec3::new(f64::from(i % side), f64::from(i / side), random.uniform()))
            .collect();
        for i in [45, 46, 67, 210] {
            points[i + 1] = points[i];
            points[i + 20] = points[i];
        }
        let cell = |i: u32| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]];
        let cells = (0..side * (side - 1)).filter(|i| i % side != side - 1);
        let faces: Vec<[u32; 3]> = cells.flat_map(cell).collect();
        let mut mesh = TriMesh::from_triangles(&points, &faces).unwrap();
        scramble(&mut mesh, 500, random, |_, _| true);
        mesh
    }

    fn scaled(mut mesh: TriMesh, scale: f64) -> TriMesh {
        mesh.positions_mut().iter_mut().for_each(|p| *p *= scale);
        mesh
    }

    #[test]
    fn side_by_side_and_one_by_one_give_the_same_bits() {
        let mut random = SplitMix64::new(3);
        let meshes = [
            TriMesh::from_triangles::<_, u32>(&[DVec3::X; 3], &[]).unwrap(),
            cone(4, true, &mut random),
            cone(3000, true, &mut random),
            cone(3000, false, &mut random),
            crumpled_grid(&mut random),
            scaled(cone(40, true, &mut random), 1e-65),
            scaled(crumpled_grid(&mut random), 1e60),
        ];
        for (mesh, level) in meshes.iter().flat_map(|m| levels().into_iter().map(move |l| (m, l))) {
            let mut block = StarBatch::new(level);
            let topology = mesh.topology();
            for first in (0..topology.vertex_capacity()).step_by(BLOCK) {
                let vertices = first..topology.vertex_capacity().min(first + BLOCK);
                block.gather(mesh, vertices.clone());
                for area in [VertexArea::Voronoi, VertexArea::Barycentric] {
                    for (vertex, found) in zip(vertices.clone(), block.integrals(mesh, area)) {
                        let vertex = VertexId::from_index(vertex);
                        let expected = vertex_curvature(mesh, vertex, area);
                        assert_eq!(found, *expected.integrals(), "{vertex:?} {level:?}");
                    }
                }
                for (vertex, found) in block.energies(mesh) {
                    let expected = willmore_energy(mesh, vertex);
                    assert_eq!(found.unwrap_or(expected), expected, "{vertex:?} {level:?}");
                }
            }
        }
    }
}
