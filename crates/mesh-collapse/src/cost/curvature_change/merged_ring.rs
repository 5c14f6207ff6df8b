//! The star of the remaining vertex after a collapse, evaluated in parallel.
//!
//! A walk around a vertex is sequential: each step waits for the one before. Here the incident edges are stored in
//! rows. First all neighbours and their data are looked up. Then faces, edges and vertices are evaluated in blocks of
//! rows, by loops that compilers turn into vector instructions of the widest kind that the processor has. The terms of
//! a vertex are added in a fixed order, so the width does not change the bits.

use core::f64::consts::PI;

use dcurv::{Area, Integral, VertexIntegrals, hinge_angle, triangle_angles};
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use mesh_core::{HalfEdgeId, VertexId};

use crate::cost::curvature_change::measure::{Measure, Term};
use crate::cost::curvature_change::rows::{Column, LANES, Lanes, Rows, Vector};
use crate::cost::curvature_change::tables::{DOUBLED_TO_THIRD, Tables};
use crate::geometry::edge_patch::EdgePatch;

/// A quarter of length times dihedral angle is the share of mean curvature that an edge gives to
/// each of its ends (KKL02 sec. 3.1).
const HINGE_SHARE: f64 = 0.25;

/// Buffers for a star, and the result of the last evaluation.
///
/// The incident edges are in rows 1 to `incident_edges.len()`, clockwise. The face of a row lies between its incident
/// edge and the incident edge of the row before; the link is the side of that face opposite to the centre. If the star
/// is closed, the row before the first incident edge repeats the last one, and the row after the last incident edge
/// repeats the first one. If it is open, the first row has no face. Further rows hold values of earlier stars, which
/// are not used.
#[derive(Clone, Debug)]
pub(super) struct MergedRing {
    level: Level,
    half_edges: Vec<HalfEdgeId>,
    incident_edges: Vec<IncidentEdge>,
    closed: bool,
    rows: Rows,
    center: Term,
    /// The input of the last evaluation: the measure, the version of the tables, and the collapse.
    evaluated: Option<(Measure, u64, HalfEdgeId, DVec3)>,
}

/// A neighbour of the remaining vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct IncidentEdge {
    /// The half-edge to it, in the mesh before the collapse.
    pub(super) side: HalfEdgeId,
    pub(super) vertex: VertexId,
}

/// A face of the remaining vertex after the collapse.
#[derive(Clone, Copy, Debug)]
pub(super) struct MergedFace {
    /// The angles at the remaining vertex, at the neighbour of this row, and at the neighbour of the row before.
    pub(super) angles: [f64; 3],
    pub(super) third: f64,
    pub(super) link_hinge: f64,
}

impl Default for MergedRing {
    fn default() -> Self {
        Self {
            level: Level::new(),
            half_edges: Vec::new(),
            incident_edges: Vec::new(),
            closed: false,
            rows: Rows::default(),
            center: Term::default(),
            evaluated: None,
        }
    }
}

impl MergedRing {
    /// Evaluates the star of the remaining vertex at `x` and the changes of its neighbours, unless the last evaluation
    /// had the same input.
    pub(super) fn evaluate(
        &mut self,
        tables: &Tables,
        (measure, version): (Measure, u64),
        patch: &EdgePatch<'_>,
        x: DVec3,
    ) {
        let asked = (measure, version, patch.half_edge(), x);
        if self.evaluated == Some(asked) {
            return;
        }
        self.evaluated = Some(asked);
        self.line_up(tables, patch, x);
        self.remove_vanishing(tables, patch);
        if measure.is_unsigned() {
            dispatch!(self.level, _ => self.evaluate_rows::<true>(measure));
        } else {
            dispatch!(self.level, _ => self.evaluate_rows::<false>(measure));
        }
        self.center = self.add_up(measure);
    }

    /// The remaining vertex after the collapse.
    pub(super) fn center(&self) -> &Term {
        &self.center
    }

    /// The neighbours of the remaining vertex.
    pub(super) fn incident_edges(&self) -> &[IncidentEdge] {
        &self.incident_edges
    }

    /// The measure of each neighbour after the collapse.
    pub(super) fn measured(&self) -> &[f64] {
        self.rows.column(Column::Measured, self.incident_edges.len())
    }

    /// A neighbour after the collapse.
    pub(super) fn neighbour(&self, incident_edge: usize) -> Term {
        let row = incident_edge + 1;
        Term {
            integrals: self.integrals(row),
            measured: self.rows[(Column::Measured, row)],
            boundary: self.rows[(Column::Inner, row)] == 0.0,
        }
    }

    /// The share of mean curvature of an incident edge after the collapse.
    pub(super) fn incident_hinge(&self, incident_edge: usize) -> f64 {
        self.rows[(Column::IncidentHinge, incident_edge + 1)]
    }

    /// The face between an incident edge and the one before it, if there is one.
    pub(super) fn face(&self, incident_edge: usize) -> Option<MergedFace> {
        let row = incident_edge + 1;
        (self.closed || incident_edge > 0).then(|| MergedFace {
            angles: [Column::CenterAngle, Column::Angle, Column::AngleBefore]
                .map(|column| self.rows[(column, row)]),
            third: self.rows[(Column::Third, row)],
            link_hinge: self.rows[(Column::LinkHinge, row)],
        })
    }

    /// Looks up the neighbours and their data.
    fn line_up(&mut self, tables: &Tables, patch: &EdgePatch<'_>, x: DVec3) {
        self.closed = patch.merged_ring(&mut self.half_edges);
        let count = self.half_edges.len();
        // Whole blocks of rows, and one more row at each end.
        self.rows.make_room(count.next_multiple_of(LANES) + 2);
        let rows = &mut self.rows;
        let mesh = patch.mesh();
        let topology = mesh.topology();
        let center = patch.origin() + x;
        self.incident_edges.clear();
        for (i, &side) in self.half_edges.iter().enumerate() {
            let row = i + 1;
            let vertex = topology.target(side);
            self.incident_edges.push(IncidentEdge { side, vertex });
            rows.set_vector(Vector::Along, row, mesh.position(vertex) - center);
            let is_open_end = !self.closed && (i == 0 || i + 1 == count);
            rows[(Column::IncidentShare, row)] = if is_open_end { 0.0 } else { HINGE_SHARE };

            let link = topology.next(side);
            let apex = topology.apex(link.twin());
            let outer = apex.map_or(DVec3::ZERO, |v| mesh.position(v) - center);
            rows.set_vector(Vector::Outer, row, outer);
            rows[(Column::LinkShare, row)] = if apex.is_some() { HINGE_SHARE } else { 0.0 };
            rows[(Column::LinkChange, row)] = tables.hinges[link.edge()];
            rows[(Column::AngleChange, row)] = tables.corners[link];
            rows[(Column::AngleBeforeChange, row)] = tables.corners[topology.next(link)];
            let third = topology.face(side).map_or(0.0, |face| tables.thirds[face]);
            rows[(Column::ThirdChange, row)] = third;

            let Term { integrals, boundary, .. } = tables.vertices[vertex];
            rows[(Column::Defect, row)] = integrals.angle_defect.value();
            rows[(Column::Mean, row)] = integrals.mean.value() - tables.hinges[side.edge()];
            rows[(Column::Area, row)] = integrals.area.value();
            rows[(Column::Inner, row)] = if boundary { 0.0 } else { 1.0 };
        }
        rows.repeat(Vector::Along, count, 0);
        rows.repeat(Vector::Along, 1, count + 1);
    }

    /// Subtracts the vanishing faces, and the second incident edge to each apex, from the terms of the apexes.
    fn remove_vanishing(&mut self, tables: &Tables, patch: &EdgePatch<'_>) {
        let topology = patch.mesh().topology();
        for side in [patch.half_edge(), patch.half_edge().twin()] {
            let Some(face) = topology.face(side) else { continue };
            let second = topology.next(side);
            let third = topology.next(second);
            let apex = topology.target(second);
            let Some(place) = self.incident_edges.iter().position(|s| s.vertex == apex) else {
                continue;
            };
            let is_second = self.incident_edges[place].side.edge() == second.edge();
            let other = if is_second { third } else { second };
            let row = place + 1;
            self.rows[(Column::Defect, row)] += tables.corners[third];
            self.rows[(Column::Mean, row)] -= tables.hinges[other.edge()];
            self.rows[(Column::Area, row)] -= tables.thirds[face];
        }
    }

    #[inline(always)]
    fn evaluate_rows<const UNSIGNED: bool>(&mut self, measure: Measure) {
        let count = self.incident_edges.len();
        for first in (1..=count).step_by(LANES) {
            self.evaluate_faces::<UNSIGNED>(first);
        }
        self.close();
        for first in (1..=count).step_by(LANES) {
            self.evaluate_neighbours::<UNSIGNED>(first);
        }
        // One loop per measure, so that the loops have no branches.
        match measure {
            Measure::AbsSum | Measure::UnsignedAbsSum => {
                self.measure(|terms, open| Measure::AbsSum.of(terms, open));
            }
            Measure::SquaredSum | Measure::UnsignedSquaredSum => {
                self.measure(|terms, open| Measure::SquaredSum.of(terms, open));
            }
            Measure::AbsIntegral => {
                self.measure(|terms, open| Measure::AbsIntegral.of(terms, open));
            }
        }
    }

    #[inline(always)]
    fn evaluate_faces<const UNSIGNED: bool>(&mut self, first: usize) {
        let rows = &mut self.rows;
        let from = rows.vectors(Vector::Along, first);
        let to = rows.vectors(Vector::Along, first - 1);
        let outer = rows.vectors(Vector::Outer, first);
        let link_share = rows.lanes(Column::LinkShare, first);
        let mut old_angle = rows.lanes(Column::AngleChange, first);
        let mut old_angle_before = rows.lanes(Column::AngleBeforeChange, first);
        let mut old_third = rows.lanes(Column::ThirdChange, first);
        let mut old_link = rows.lanes(Column::LinkChange, first);
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
            link_hinge[i] = link_share[i] * if UNSIGNED { bend.abs() } else { bend };
            old_angle[i] = this - old_angle[i];
            old_angle_before[i] = before - old_angle_before[i];
            old_third[i] = third[i] - old_third[i];
            old_link[i] = link_hinge[i] - old_link[i];
        }
        rows.store_vectors(Vector::Normal, first, &normals);
        let [center, this, before] = &angles;
        rows.store(Column::CenterAngle, first, center);
        rows.store(Column::Angle, first, this);
        rows.store(Column::AngleBefore, first, before);
        rows.store(Column::Third, first, &third);
        rows.store(Column::LinkHinge, first, &link_hinge);
        rows.store(Column::AngleChange, first, &old_angle);
        rows.store(Column::AngleBeforeChange, first, &old_angle_before);
        rows.store(Column::ThirdChange, first, &old_third);
        rows.store(Column::LinkChange, first, &old_link);
    }

    /// Copies the first face behind the last one; an open star has no face at either end.
    fn close(&mut self) {
        let end = self.incident_edges.len() + 1;
        let rows = &mut self.rows;
        rows.repeat(Vector::Normal, 1, end);
        let changes = [
            Column::AngleChange,
            Column::AngleBeforeChange,
            Column::ThirdChange,
            Column::LinkChange,
        ];
        if self.closed {
            changes.into_iter().for_each(|column| rows[(column, end)] = rows[(column, 1)]);
        } else {
            for row in [1, end] {
                changes.into_iter().for_each(|column| rows[(column, row)] = 0.0);
            }
            (rows[(Column::CenterAngle, 1)], rows[(Column::Third, 1)]) = (0.0, 0.0);
        }
    }

    #[inline(always)]
    fn evaluate_neighbours<const UNSIGNED: bool>(&mut self, first: usize) {
        let next = first + 1;
        let rows = &mut self.rows;
        let along = rows.vectors(Vector::Along, first);
        let next_along = rows.vectors(Vector::Along, next);
        let normal = rows.vectors(Vector::Normal, first);
        let next_normal = rows.vectors(Vector::Normal, next);
        let share = rows.lanes(Column::IncidentShare, first);
        let angle_change = rows.lanes(Column::AngleChange, first);
        let next_angle_change = rows.lanes(Column::AngleBeforeChange, next);
        let third_change = rows.lanes(Column::ThirdChange, first);
        let next_third_change = rows.lanes(Column::ThirdChange, next);
        let link_change = rows.lanes(Column::LinkChange, first);
        let next_link_change = rows.lanes(Column::LinkChange, next);
        let mut defect = rows.lanes(Column::Defect, first);
        let mut mean = rows.lanes(Column::Mean, first);
        let mut area = rows.lanes(Column::Area, first);
        let mut hinge = [0.0; LANES];
        for i in 0..LANES {
            let (incident_edge, right) = (at(&along, i), at(&next_along, i));
            let length = incident_edge.length();
            let bend = length * hinge_angle(length, at(&normal, i), at(&next_normal, i), right);
            hinge[i] = share[i] * if UNSIGNED { bend.abs() } else { bend };
            defect[i] -= angle_change[i] + next_angle_change[i];
            mean[i] += link_change[i] + next_link_change[i] + hinge[i];
            area[i] = (area[i] + third_change[i] + next_third_change[i]).max(0.0);
        }
        rows.store(Column::IncidentHinge, first, &hinge);
        rows.store(Column::Defect, first, &defect);
        rows.store(Column::Mean, first, &mean);
        rows.store(Column::Area, first, &area);
    }

    #[inline(always)]
    fn measure(&mut self, of: impl Fn(VertexIntegrals, bool) -> f64) {
        for first in (1..=self.incident_edges.len()).step_by(LANES) {
            let inner = self.rows.lanes(Column::Inner, first);
            let defect = self.rows.lanes(Column::Defect, first);
            let mean = self.rows.lanes(Column::Mean, first);
            let area = self.rows.lanes(Column::Area, first);
            let mut measured = [0.0; LANES];
            for i in 0..LANES {
                measured[i] = of(integrals(defect[i], mean[i], area[i]), inner[i] == 0.0);
            }
            self.rows.store(Column::Measured, first, &measured);
        }
    }

    /// The sums at the remaining vertex.
    fn add_up(&self, measure: Measure) -> Term {
        let count = self.incident_edges.len();
        let sum = |column| self.rows.column(column, count).iter().sum::<f64>();
        let full_angle = if self.closed { 2.0 * PI } else { PI };
        let defect = full_angle - sum(Column::CenterAngle);
        let integrals = integrals(defect, sum(Column::IncidentHinge), sum(Column::Third));
        Term::new(integrals, !self.closed, measure)
    }

    fn integrals(&self, row: usize) -> VertexIntegrals {
        let [defect, mean, area] =
            [Column::Defect, Column::Mean, Column::Area].map(|column| self.rows[(column, row)]);
        integrals(defect, mean, area)
    }
}

#[inline(always)]
fn at([x, y, z]: &[Lanes; 3], i: usize) -> DVec3 {
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

    use crate::cost::curvature_change::tests::bent_meshes;

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
            let signed = [Measure::AbsSum, Measure::SquaredSum, Measure::AbsIntegral];
            let unsigned = [Measure::UnsignedAbsSum, Measure::UnsignedSquaredSum];
            for measure in signed.into_iter().chain(unsigned) {
                let tables = Tables::new(&mesh, measure);
                let of = |level| {
                    let mut star = MergedRing { level, ..MergedRing::default() };
                    let mut found = Vec::new();
                    for h in mesh.topology().half_edges() {
                        let patch = EdgePatch::without_faces(&mesh, h);
                        star.evaluate(&tables, (measure, 0), &patch, DVec3::new(0.01, 0.02, 0.03));
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
