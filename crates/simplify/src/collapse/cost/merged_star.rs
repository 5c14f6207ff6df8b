//! The star of the vertex that remains after a collapse, its spokes side by side.
//!
//! Every step of a turn round a vertex waits for the one before, which leaves a processor little to
//! do at once. Here the spokes stand in rows: first the neighbours and what is known of them is
//! looked up, then faces, edges and vertices are evaluated in blocks of rows by loops that compilers
//! turn into vector instructions, of the widest kind that the processor has. The terms of a vertex
//! are added in a fixed order, so that the width does not change the bits.

use core::f64::consts::PI;

use dcurv::{Area, Integral, VertexIntegrals, hinge_angle, triangle_angles};
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use mesh_core::{EdgeMap, FaceMap, HalfEdgeId, HalfEdgeMap, VertexId, VertexMap};

use super::curvature_change::{Measure, Term};
use crate::collapse::patch::EdgePatch;

/// What is known of the mesh as it is.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    pub(super) vertices: VertexMap<Term>,
    /// The integral of mean curvature over each edge that belongs to each of its ends.
    pub(super) hinges: EdgeMap<f64>,
    /// The interior angle of each face at the origin of each of its half-edges.
    pub(super) corners: HalfEdgeMap<f64>,
    /// A third of the area of each face.
    pub(super) thirds: FaceMap<f64>,
}

/// A quarter of length times dihedral angle is the share of mean curvature that an edge gives to
/// each of its ends (KKL02 sec. 3.1).
const HINGE_SHARE: f64 = 0.25;

/// From the length of a vector area, doubled, to a third of the area.
pub(super) const DOUBLED_TO_THIRD: f64 = 1.0 / 6.0;

/// How many rows are evaluated at once.
const LANES: usize = 4;

/// Memory for a star, and what was found of the last one.
///
/// The spokes stand in rows 1 to `spokes.len()`, clockwise. The face of a row lies between its spoke
/// and that of the row before; the link is the side of that face opposite to the centre. The row
/// before the first spoke repeats the last one and the other way round when the star is closed; when
/// it is open, the first row has no face. Rows beyond hold numbers of earlier stars, which nothing
/// depends on.
#[derive(Clone, Debug)]
pub(super) struct MergedStar {
    level: Level,
    half_edges: Vec<HalfEdgeId>,
    spokes: Vec<Spoke>,
    closed: bool,
    /// From the centre to the neighbour.
    along: Columns,
    /// From the centre to the vertex on the other side of the link.
    outer: Columns,
    /// The vector area of the face, doubled.
    normal: Columns,
    /// [`HINGE_SHARE`], or 0 where the spoke or the link lies on the boundary.
    spoke_share: Vec<f64>,
    link_share: Vec<f64>,
    /// The angles of the face at the centre, at this neighbour and at that of the row before.
    center_angle: Vec<f64>,
    angle: Vec<f64>,
    angle_before: Vec<f64>,
    /// A third of the area of the face.
    third: Vec<f64>,
    spoke_hinge: Vec<f64>,
    link_hinge: Vec<f64>,
    /// By how much the angles, the third of the area and the hinge of the link change. Before
    /// evaluation, what they are in the mesh as it is.
    angle_change: Vec<f64>,
    angle_before_change: Vec<f64>,
    third_change: Vec<f64>,
    link_change: Vec<f64>,
    /// What is integrated over the neighbour. Before evaluation, that is as it is in the mesh, but
    /// without what vanishes.
    defect: Vec<f64>,
    mean: Vec<f64>,
    area: Vec<f64>,
    /// 0 for neighbours on the boundary, 1 for others.
    inner: Vec<f64>,
    measured: Vec<f64>,
    center: Term,
    /// The collapse that was evaluated last, unless the tables have changed since.
    evaluated: Option<(HalfEdgeId, DVec3)>,
}

/// Vectors, coordinate by coordinate.
#[derive(Clone, Debug, Default)]
struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

/// A neighbour of the vertex that remains.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spoke {
    /// The half-edge to it, in the mesh before the collapse.
    pub(super) side: HalfEdgeId,
    pub(super) vertex: VertexId,
}

/// A face of the vertex that remains, as it would be.
#[derive(Clone, Copy, Debug)]
pub(super) struct MergedFace {
    /// At the vertex that remains, at the neighbour of this row, and at that of the row before.
    pub(super) angles: [f64; 3],
    pub(super) third: f64,
    pub(super) link_hinge: f64,
}

impl MergedStar {
    pub(super) fn new() -> Self {
        Self {
            level: Level::new(),
            half_edges: Vec::new(),
            spokes: Vec::new(),
            closed: false,
            along: Columns::default(),
            outer: Columns::default(),
            normal: Columns::default(),
            spoke_share: Vec::new(),
            link_share: Vec::new(),
            center_angle: Vec::new(),
            angle: Vec::new(),
            angle_before: Vec::new(),
            third: Vec::new(),
            spoke_hinge: Vec::new(),
            link_hinge: Vec::new(),
            angle_change: Vec::new(),
            angle_before_change: Vec::new(),
            third_change: Vec::new(),
            link_change: Vec::new(),
            defect: Vec::new(),
            mean: Vec::new(),
            area: Vec::new(),
            inner: Vec::new(),
            measured: Vec::new(),
            center: Term::default(),
            evaluated: None,
        }
    }

    /// Evaluates the star of the vertex that remains at `x`, and what becomes of its neighbours,
    /// unless that was what was evaluated last.
    pub(super) fn evaluate(
        &mut self,
        tables: &Tables,
        measure: Measure,
        patch: &EdgePatch<'_>,
        x: DVec3,
    ) {
        let collapse = (patch.half_edge(), x);
        if self.evaluated == Some(collapse) {
            return;
        }
        self.evaluated = Some(collapse);
        self.line_up(tables, patch, x);
        self.remove_vanishing(tables, patch);
        dispatch!(self.level, _ => self.evaluate_rows(measure));
        self.center = self.add_up(measure);
    }

    /// Called when the mesh or the tables change.
    pub(super) fn forget(&mut self) {
        self.evaluated = None;
    }

    /// The vertex that remains, as it would be.
    pub(super) fn center(&self) -> &Term {
        &self.center
    }

    /// The neighbours of the vertex that remains.
    pub(super) fn spokes(&self) -> &[Spoke] {
        &self.spokes
    }

    /// What is measured at each neighbour, as it would be.
    pub(super) fn measured(&self) -> &[f64] {
        &self.measured[1..=self.spokes.len()]
    }

    /// A neighbour as it would be.
    pub(super) fn neighbour(&self, spoke: usize) -> Term {
        let row = spoke + 1;
        Term {
            integrals: self.integrals(row),
            measured: self.measured[row],
            boundary: self.inner[row] == 0.0,
        }
    }

    /// The share of mean curvature of a spoke, as it would be.
    pub(super) fn spoke_hinge(&self, spoke: usize) -> f64 {
        self.spoke_hinge[spoke + 1]
    }

    /// The face between a spoke and the one before it, if there is one.
    pub(super) fn face(&self, spoke: usize) -> Option<MergedFace> {
        let row = spoke + 1;
        (self.closed || spoke > 0).then(|| MergedFace {
            angles: [self.center_angle[row], self.angle[row], self.angle_before[row]],
            third: self.third[row],
            link_hinge: self.link_hinge[row],
        })
    }

    /// Looks up the neighbours and everything that is known of them.
    fn line_up(&mut self, tables: &Tables, patch: &EdgePatch<'_>, x: DVec3) {
        self.closed = patch.merged_ring(&mut self.half_edges);
        self.make_room();
        let mesh = patch.mesh();
        let topology = mesh.topology();
        let center = patch.origin() + x;
        let count = self.half_edges.len();
        let [along_x, along_y, along_z] = self.along.rows_mut(count);
        let [outer_x, outer_y, outer_z] = self.outer.rows_mut(count);
        let spoke_share = rows_mut(&mut self.spoke_share, count);
        let link_share = rows_mut(&mut self.link_share, count);
        let old_angle = rows_mut(&mut self.angle_change, count);
        let old_angle_before = rows_mut(&mut self.angle_before_change, count);
        let old_third = rows_mut(&mut self.third_change, count);
        let old_link = rows_mut(&mut self.link_change, count);
        let defect = rows_mut(&mut self.defect, count);
        let mean = rows_mut(&mut self.mean, count);
        let area = rows_mut(&mut self.area, count);
        let inner = rows_mut(&mut self.inner, count);
        self.spokes.clear();
        for (i, &side) in self.half_edges.iter().enumerate() {
            let vertex = topology.target(side);
            self.spokes.push(Spoke { side, vertex });
            let along = mesh.position(vertex) - center;
            (along_x[i], along_y[i], along_z[i]) = (along.x, along.y, along.z);
            let is_open_end = !self.closed && (i == 0 || i + 1 == count);
            spoke_share[i] = if is_open_end { 0.0 } else { HINGE_SHARE };

            let link = topology.next(side);
            let apex = topology.apex(link.twin());
            let outer = apex.map_or(DVec3::ZERO, |v| mesh.position(v) - center);
            (outer_x[i], outer_y[i], outer_z[i]) = (outer.x, outer.y, outer.z);
            link_share[i] = if apex.is_some() { HINGE_SHARE } else { 0.0 };
            old_link[i] = tables.hinges[link.edge()];
            old_angle[i] = tables.corners[link];
            old_angle_before[i] = tables.corners[topology.next(link)];
            old_third[i] = topology.face(side).map_or(0.0, |face| tables.thirds[face]);

            let Term { integrals, boundary, .. } = tables.vertices[vertex];
            defect[i] = integrals.angle_defect.value();
            mean[i] = integrals.mean.value() - tables.hinges[side.edge()];
            area[i] = integrals.area.value();
            inner[i] = if boundary { 0.0 } else { 1.0 };
        }
        self.along.repeat(count, 0);
        self.along.repeat(1, count + 1);
    }

    /// Takes the faces that vanish away from their apexes, with the second spoke to each.
    fn remove_vanishing(&mut self, tables: &Tables, patch: &EdgePatch<'_>) {
        let topology = patch.mesh().topology();
        for side in [patch.half_edge(), patch.half_edge().twin()] {
            let Some(face) = topology.face(side) else { continue };
            let second = topology.next(side);
            let third = topology.next(second);
            let apex = topology.target(second);
            let Some(place) = self.spokes.iter().position(|s| s.vertex == apex) else { continue };
            let is_second = self.spokes[place].side.edge() == second.edge();
            let other = if is_second { third } else { second };
            let row = place + 1;
            self.defect[row] += tables.corners[third];
            self.mean[row] -= tables.hinges[other.edge()];
            self.area[row] -= tables.thirds[face];
        }
    }

    #[inline(always)]
    fn evaluate_rows(&mut self, measure: Measure) {
        let count = self.spokes.len();
        for first in (1..=count).step_by(LANES) {
            self.evaluate_faces(first);
        }
        self.close();
        for first in (1..=count).step_by(LANES) {
            self.evaluate_neighbours(first);
        }
        // One loop for each, so that none has to choose.
        match measure {
            Measure::AbsSum => self.measure(|terms, open| Measure::AbsSum.of(terms, open)),
            Measure::SquaredSum => self.measure(|terms, open| Measure::SquaredSum.of(terms, open)),
            Measure::AbsIntegral => {
                self.measure(|terms, open| Measure::AbsIntegral.of(terms, open));
            }
        }
    }

    #[inline(always)]
    fn evaluate_faces(&mut self, first: usize) {
        let (from, to) = (self.along.lanes(first), self.along.lanes(first - 1));
        let outer = self.outer.lanes(first);
        let link_share = lanes(&self.link_share, first);
        let mut old_angle = lanes(&self.angle_change, first);
        let mut old_angle_before = lanes(&self.angle_before_change, first);
        let mut old_third = lanes(&self.third_change, first);
        let mut old_link = lanes(&self.link_change, first);
        let mut normals = [[0.0; LANES]; 3];
        let mut angles = [[0.0; LANES]; 3];
        let (mut third, mut link_hinge) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (from, to) = (at(&from, i), at(&to, i));
            let normal = from.cross(to);
            let size = normal.length();
            let [center, this, before] = triangle_angles(from, to, size);
            let (link, right) = (to - from, at(&outer, i) - from);
            let length = link.length();
            let bend = length * hinge_angle(length, normal, right.cross(link), right);
            (normals[0][i], normals[1][i], normals[2][i]) = (normal.x, normal.y, normal.z);
            (angles[0][i], angles[1][i], angles[2][i]) = (center, this, before);
            third[i] = DOUBLED_TO_THIRD * size;
            link_hinge[i] = link_share[i] * bend;
            old_angle[i] = this - old_angle[i];
            old_angle_before[i] = before - old_angle_before[i];
            old_third[i] = third[i] - old_third[i];
            old_link[i] = link_hinge[i] - old_link[i];
        }
        self.normal.store(first, &normals);
        let [center, this, before] = &angles;
        store(&mut self.center_angle, first, center);
        store(&mut self.angle, first, this);
        store(&mut self.angle_before, first, before);
        store(&mut self.third, first, &third);
        store(&mut self.link_hinge, first, &link_hinge);
        store(&mut self.angle_change, first, &old_angle);
        store(&mut self.angle_before_change, first, &old_angle_before);
        store(&mut self.third_change, first, &old_third);
        store(&mut self.link_change, first, &old_link);
    }

    /// Puts the first face behind the last one; when the star is open, there is none at either end.
    fn close(&mut self) {
        let end = self.spokes.len() + 1;
        self.normal.repeat(1, end);
        let changes = [
            &mut self.angle_change,
            &mut self.angle_before_change,
            &mut self.third_change,
            &mut self.link_change,
        ];
        if self.closed {
            changes.into_iter().for_each(|column| column[end] = column[1]);
        } else {
            changes.into_iter().for_each(|column| (column[1], column[end]) = (0.0, 0.0));
            (self.center_angle[1], self.third[1]) = (0.0, 0.0);
        }
    }

    #[inline(always)]
    fn evaluate_neighbours(&mut self, first: usize) {
        let next = first + 1;
        let (along, next_along) = (self.along.lanes(first), self.along.lanes(next));
        let (normal, next_normal) = (self.normal.lanes(first), self.normal.lanes(next));
        let share = lanes(&self.spoke_share, first);
        let angle_change = lanes(&self.angle_change, first);
        let next_angle_change = lanes(&self.angle_before_change, next);
        let third_change = lanes(&self.third_change, first);
        let next_third_change = lanes(&self.third_change, next);
        let link_change = lanes(&self.link_change, first);
        let next_link_change = lanes(&self.link_change, next);
        let mut defect = lanes(&self.defect, first);
        let mut mean = lanes(&self.mean, first);
        let mut area = lanes(&self.area, first);
        let mut hinge = [0.0; LANES];
        for i in 0..LANES {
            let (spoke, right) = (at(&along, i), at(&next_along, i));
            let length = spoke.length();
            let bend = length * hinge_angle(length, at(&normal, i), at(&next_normal, i), right);
            hinge[i] = share[i] * bend;
            defect[i] -= angle_change[i] + next_angle_change[i];
            mean[i] += link_change[i] + next_link_change[i] + hinge[i];
            area[i] = (area[i] + third_change[i] + next_third_change[i]).max(0.0);
        }
        store(&mut self.spoke_hinge, first, &hinge);
        store(&mut self.defect, first, &defect);
        store(&mut self.mean, first, &mean);
        store(&mut self.area, first, &area);
    }

    #[inline(always)]
    fn measure(&mut self, of: impl Fn(VertexIntegrals, bool) -> f64) {
        for first in (1..=self.spokes.len()).step_by(LANES) {
            let inner = lanes(&self.inner, first);
            let defect = lanes(&self.defect, first);
            let mean = lanes(&self.mean, first);
            let area = lanes(&self.area, first);
            let mut measured = [0.0; LANES];
            for i in 0..LANES {
                measured[i] = of(integrals(defect[i], mean[i], area[i]), inner[i] == 0.0);
            }
            store(&mut self.measured, first, &measured);
        }
    }

    /// The vertex that remains.
    fn add_up(&self, measure: Measure) -> Term {
        let sum = |column: &[f64]| column[1..=self.spokes.len()].iter().sum::<f64>();
        let full_angle = if self.closed { 2.0 * PI } else { PI };
        let defect = full_angle - sum(&self.center_angle);
        let integrals = integrals(defect, sum(&self.spoke_hinge), sum(&self.third));
        Term::new(integrals, !self.closed, measure)
    }

    fn integrals(&self, row: usize) -> VertexIntegrals {
        integrals(self.defect[row], self.mean[row], self.area[row])
    }

    /// Lengthens all columns to whole blocks of rows, and one more at each end.
    fn make_room(&mut self) {
        let rows = self.half_edges.len().next_multiple_of(LANES) + 2;
        if self.measured.len() >= rows {
            return;
        }
        for columns in [&mut self.along, &mut self.outer, &mut self.normal] {
            for column in [&mut columns.x, &mut columns.y, &mut columns.z] {
                column.resize(rows, 0.0);
            }
        }
        for column in [
            &mut self.spoke_share,
            &mut self.link_share,
            &mut self.center_angle,
            &mut self.angle,
            &mut self.angle_before,
            &mut self.third,
            &mut self.spoke_hinge,
            &mut self.link_hinge,
            &mut self.angle_change,
            &mut self.angle_before_change,
            &mut self.third_change,
            &mut self.link_change,
            &mut self.defect,
            &mut self.mean,
            &mut self.area,
            &mut self.inner,
            &mut self.measured,
        ] {
            column.resize(rows, 0.0);
        }
    }
}

impl Columns {
    #[inline]
    fn rows_mut(&mut self, count: usize) -> [&mut [f64]; 3] {
        [&mut self.x, &mut self.y, &mut self.z].map(|column| rows_mut(column, count))
    }

    #[inline]
    fn repeat(&mut self, row: usize, to: usize) {
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            column[to] = column[row];
        }
    }

    #[inline(always)]
    fn lanes(&self, first: usize) -> [[f64; LANES]; 3] {
        [lanes(&self.x, first), lanes(&self.y, first), lanes(&self.z, first)]
    }

    #[inline(always)]
    fn store(&mut self, first: usize, [x, y, z]: &[[f64; LANES]; 3]) {
        store(&mut self.x, first, x);
        store(&mut self.y, first, y);
        store(&mut self.z, first, z);
    }
}

/// The rows of the spokes.
#[inline]
fn rows_mut(column: &mut [f64], count: usize) -> &mut [f64] {
    &mut column[1..=count]
}

/// A block of rows, copied: compilers see that copies do not overlap.
#[inline(always)]
fn lanes(column: &[f64], first: usize) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&column[first..first + LANES]);
    lanes
}

#[inline(always)]
fn store(column: &mut [f64], first: usize, lanes: &[f64; LANES]) {
    column[first..first + LANES].copy_from_slice(lanes);
}

#[inline(always)]
fn at([x, y, z]: &[[f64; LANES]; 3], i: usize) -> DVec3 {
    DVec3::new(x[i], y[i], z[i])
}

#[inline(always)]
fn integrals(defect: f64, mean: f64, area: f64) -> VertexIntegrals {
    VertexIntegrals {
        angle_defect: Integral::new(defect),
        mean: Integral::new(mean),
        area: Area::new(area),
        ..VertexIntegrals::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::Simd;

    use crate::collapse::cost::curvature_change::CurvatureChange;
    use crate::collapse::cost::curvature_change::tests::bent_meshes;

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

    #[test]
    fn every_vector_width_gives_the_same_bits() {
        for mesh in bent_meshes(80, 3, 6) {
            for measure in [Measure::AbsSum, Measure::SquaredSum, Measure::AbsIntegral] {
                let mut change = CurvatureChange::new(measure);
                change.prepare(&mesh);
                let of = |level| {
                    let mut star = MergedStar { level, ..MergedStar::new() };
                    let mut found = Vec::new();
                    for h in mesh.topology().half_edges() {
                        let patch = EdgePatch::without_faces(&mesh, h);
                        star.evaluate(
                            change.tables(),
                            measure,
                            &patch,
                            DVec3::new(0.01, 0.02, 0.03),
                        );
                        found.push(star.center().measured);
                        found.extend(star.measured());
                    }
                    found
                };
                let expected = of(Level::baseline());
                assert!(expected.iter().all(|measured| measured.is_finite()));
                assert!(levels().into_iter().all(|level| of(level) == expected));
            }
        }
    }
}
