//! The faces around an edge, and the tests whether its collapse is allowed.
//!
//! The remaining faces around an end of the edge form a fan over a row of points: the neighbours in order. An interior
//! vertex has one row, from one apex of the edge to the other; a vertex at the rim has up to two. All rows are stored
//! one after the other, each followed by a NaN point. So the faces between consecutive points can be processed four at
//! a time, and comparisons are false for faces that do not exist.

use fearless_simd::f64x4;
use fearless_simd::prelude::*;
use glam::DVec3;

use crate::blocks::block_vertex::BlockVertex;
use crate::blocks::corner_table::{CornerTable, NONE, next, previous};
use crate::blocks::lanes::{LANES, Row, Vectors, columns};
use crate::blocks::rules::Rules;
use crate::constraint::shape::STILL_AS_GOOD;
use crate::engine::valence::MOST_EDGES;
use crate::rejection::Rejection;

/// The faces around an edge.
#[derive(Debug)]
pub(super) struct Patch {
    /// For each point, its position relative to the midpoint of the edge, and the end that its row belongs to, as a
    /// multiple of half the edge.
    points: Vec<Row>,
    count: usize,
    /// Half the edge vector.
    half: DVec3,
    /// The apexes of the vanishing faces, relative to the midpoint.
    apexes: [Option<DVec3>; 2],
    /// The corners at the removed end, except corners of vanishing faces.
    fan: Vec<u32>,
    /// Whether one of the ends lies at the rim.
    at_rim: bool,
    /// Whether edges at the neighbours were rejected.
    any_refused: bool,
    /// The number of patches so far.
    number: u32,
}

/// No point.
const GAP: Row = [f64::NAN; LANES];

/// An upper limit of the number of points, with gaps.
const MOST_POINTS: usize = 2 * MOST_EDGES as usize + 4 * LANES;

/// Four remaining faces.
struct Fours<S: Simd> {
    /// The corner at an end of the edge, as a multiple of half the edge.
    end: f64x4<S>,
    second: Vectors<S>,
    third: Vectors<S>,
}

/// The remaining faces, four at a time.
struct Faces<'a, S: Simd> {
    /// The columns of the current four points.
    now: [f64x4<S>; LANES],
    rest: &'a [[Row; LANES]],
}

impl<S: Simd> Faces<'_, S> {
    #[inline(always)]
    fn next(&mut self, simd: S) -> Option<Fours<S>> {
        let ([a, b, c, d], rest) = self.rest.split_first()?;
        let following = columns(simd, [a, b, c, d]);
        let now = core::mem::replace(&mut self.now, following);
        self.rest = rest;
        let second = Vectors::of(now);
        Some(Fours { end: now[3], second, third: second.following(Vectors::of(following)) })
    }
}

/// The start and end of a walk around one end of an edge.
struct Round<S: Simd> {
    /// The corners at the end in the vanishing faces, counter-clockwise before and after the edge.
    start: u32,
    stop: u32,
    /// The origin, which is subtracted from the points.
    center: f64x4<S>,
}

/// The result of a walk around an end.
struct Walk {
    is_closed: bool,
    /// Whether a point that is not an apex was also visited around the other end.
    meets: bool,
    any_refused: bool,
}

impl Patch {
    pub(super) fn new() -> Self {
        Self {
            points: vec![GAP; MOST_POINTS],
            count: 0,
            half: DVec3::ZERO,
            apexes: [None; 2],
            fan: Vec::new(),
            at_rim: false,
            any_refused: false,
            number: 0,
        }
    }

    /// The corners at the removed end, except corners of vanishing faces.
    pub(super) fn fan(&self) -> &[u32] {
        &self.fan
    }

    /// Whether one of the ends lies at the rim.
    pub(super) fn is_at_rim(&self) -> bool {
        self.at_rim
    }

    /// Whether edges at the neighbours of the ends were rejected.
    pub(super) fn any_refused(&self) -> bool {
        self.any_refused
    }

    /// Collects the faces, and tests the conditions that depend on connectivity.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(
        &mut self,
        simd: S,
        corners: &CornerTable,
        vertices: &mut [BlockVertex],
        side: u32,
        half: DVec3,
    ) -> Result<(), Rejection> {
        let twin = corners.twin(side);
        let ends = [corners.vertex(side), corners.target(side)];
        let origin = vertices[ends[0] as usize].position + half;
        let apexes = [corners.apex(side), corners.apex(twin)];
        let at = |v: u32| (v != NONE).then(|| vertices[v as usize].position - origin);
        self.apexes = [at(apexes[0]), at(apexes[1])];
        self.half = half;
        self.number = self.number.wrapping_add(1);
        self.fan.clear();
        self.count = 0;
        let [x, y, z] = origin.to_array();
        let stop = if twin == NONE { NONE } else { next(twin) };
        let center = f64x4::load_array(simd, [x, y, z, 1.0]);
        let round = Round { start: side, stop, center };
        let first = self.walk::<S, true>(corners, vertices, &round, apexes);
        let center = f64x4::load_array(simd, [x, y, z, -1.0]);
        let round = Round { start: twin, stop: next(side), center };
        let second = self.walk::<S, false>(corners, vertices, &round, apexes);
        self.any_refused = first.any_refused || second.any_refused;
        // The last block of faces also reads the points of the block after it.
        self.points[self.count..self.count + 2 * LANES].fill(GAP);
        self.at_rim = !first.is_closed || !second.is_closed;
        if second.meets {
            return Err(Rejection::LinkCondition);
        }
        if twin != NONE && !first.is_closed && !second.is_closed {
            return Err(Rejection::JoinsBoundaries);
        }
        if !self.at_rim && ends.iter().all(|&v| vertices[v as usize].valence() == 3) {
            return Err(Rejection::Tetrahedron);
        }
        for side in [side, twin] {
            if side != NONE && [next(side), previous(side)].iter().all(|&s| corners.twin(s) == NONE)
            {
                return Err(Rejection::LastFace);
            }
        }
        Ok(())
    }

    /// Walks around the first or second end of an edge.
    #[inline(always)]
    fn walk<S: Simd, const FIRST: bool>(
        &mut self,
        corners: &CornerTable,
        vertices: &mut [BlockVertex],
        &Round { start, stop, center }: &Round<S>,
        apexes: [u32; 2],
    ) -> Walk {
        let mut walk = Walk { is_closed: false, meets: false, any_refused: false };
        if start != NONE {
            let mut side = previous(start);
            self.visit::<S, FIRST>(vertices, corners.vertex(side), center, apexes, &mut walk);
            let mut corner = corners.twin(side);
            while corner != NONE && corner != stop {
                side = previous(corner);
                self.visit::<S, FIRST>(vertices, corners.vertex(side), center, apexes, &mut walk);
                if FIRST {
                    self.fan.push(corner);
                }
                corner = corners.twin(side);
            }
            walk.is_closed = corner != NONE;
            self.push(GAP);
        }
        if !walk.is_closed && stop != NONE {
            // Turn the other way, to the other side at the rim.
            let first = self.count;
            let mut corner = stop;
            loop {
                self.visit::<S, FIRST>(vertices, corners.target(corner), center, apexes, &mut walk);
                let across = corners.twin(corner);
                if across == NONE {
                    break;
                }
                corner = next(across);
                if FIRST {
                    self.fan.push(corner);
                }
            }
            self.points[first..self.count].reverse();
            self.push(GAP);
        }
        walk
    }

    /// Adds a neighbour of an end.
    #[inline(always)]
    fn visit<S: Simd, const FIRST: bool>(
        &mut self,
        vertices: &mut [BlockVertex],
        v: u32,
        center: f64x4<S>,
        apexes: [u32; 2],
        walk: &mut Walk,
    ) {
        let vertex = &mut vertices[v as usize];
        let place = f64x4::load_array(center.simd, vertex.place());
        walk.any_refused |= vertex.has_refused();
        if FIRST {
            vertex.met = self.number;
        } else {
            walk.meets |= vertex.met == self.number && v != apexes[0] && v != apexes[1];
        }
        self.push((place - center).to_array());
    }

    #[inline(always)]
    fn push(&mut self, point: Row) {
        self.points[self.count] = point;
        self.count += 1;
    }

    /// The sum of the doubled vector areas of all faces, the sum of the dot products of each with a corner, and the sum
    /// of their squares.
    #[inline(always)]
    pub(super) fn volume<S: Simd>(&self, simd: S) -> (DVec3, f64, f64) {
        let zero = f64x4::splat(simd, 0.0);
        let half = Vectors::splat(simd, self.half);
        let nothing = Vectors::splat(simd, DVec3::ZERO);
        let (mut normals, mut offsets, mut sizes) = (nothing, zero, zero);
        let mut faces = self.faces(simd);
        while let Some(Fours { end, second, third }) = faces.next(simd) {
            let own = half * end;
            let cross = (second - own).cross(third - own);
            let size = cross.squared();
            let is_face = size.simd_eq(size);
            normals = normals + Vectors::select(is_face, cross, nothing);
            offsets += is_face.select(cross.dot(own), zero);
            sizes += is_face.select(size, zero);
        }
        let sum = |row: f64x4<S>| (row[0] + row[1]) + (row[2] + row[3]);
        let normal = DVec3::new(sum(normals.x), sum(normals.y), sum(normals.z));
        let mut volume = (normal, sum(offsets), sum(sizes));
        for [a, b, c] in self.vanishing() {
            let cross = (b - a).cross(c - a);
            volume.0 += cross;
            volume.1 += cross.dot(a);
            volume.2 += cross.length_squared();
        }
        volume
    }

    /// Whether the faces allow the collapse of the edge to a position.
    #[inline(always)]
    pub(super) fn check<S: Simd>(&self, simd: S, x: DVec3, rules: &Rules) -> Result<(), Rejection> {
        let half = Vectors::splat(simd, self.half);
        let place = Vectors::splat(simd, x);
        // Cosines are compared by their squares with sign.
        let min_cosine = rules.min_cosine.unwrap_or(-2.0);
        let min_cosine = f64x4::splat(simd, min_cosine * min_cosine.abs());
        // Comparisons with NaN are false, so this disables the limit.
        let min_shape = rules.min_shape.unwrap_or(f64::NAN);
        let min_shape = f64x4::splat(simd, min_shape * min_shape / 12.0);
        let mut any_thin = false;
        let mut faces = self.faces(simd);
        while let Some(Fours { end, second, third }) = faces.next(simd) {
            let own = half * end;
            let old = (second - own).cross(third - own);
            let (to_second, to_third) = (second - place, third - place);
            let new = to_second.cross(to_third);
            let (along, squared) = (old.dot(new), new.squared());
            let is_turned = (along * along.abs()).simd_lt(min_cosine * (old.squared() * squared));
            if is_turned.any_true() {
                return Err(Rejection::NormalTurn);
            }
            let sides = to_second.squared() + (third - second).squared() + to_third.squared();
            any_thin |= squared.simd_le(min_shape * (sides * sides)).any_true();
        }
        if any_thin && !self.is_no_thinner(x, rules.min_shape) {
            return Err(Rejection::Sliver);
        }
        Ok(())
    }

    /// The remaining faces.
    #[inline(always)]
    fn faces<S: Simd>(&self, simd: S) -> Faces<'_, S> {
        let (blocks, _) = self.points[..self.count + 2 * LANES].as_chunks::<LANES>();
        let [a, b, c, d] = &blocks[0];
        Faces { now: columns(simd, [a, b, c, d]), rest: &blocks[1..] }
    }

    /// The vanishing faces.
    fn vanishing(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let half = self.half;
        let ends = [[-half, half], [half, -half]];
        let faces = self.apexes.into_iter().zip(ends);
        faces.filter_map(|(apex, [a, b])| apex.map(|c| [a, b, c]))
    }

    /// Whether no face becomes noticeably thinner than the thinnest face was before; for patches with a face below the limit.
    #[cold]
    #[inline(never)]
    fn is_no_thinner(&self, x: DVec3, min_shape: Option<f64>) -> bool {
        let point = |[x, y, z, _]: Row| DVec3::new(x, y, z);
        let (mut worst, mut before) = (1.0_f64, 1.0_f64);
        for pair in self.points[..self.count].windows(2) {
            let own = self.half * pair[0][3];
            let [second, third] = [pair[0], pair[1]].map(point);
            // `min` ignores the NaN of a gap.
            worst = worst.min(squared_shape([x, second, third]));
            before = before.min(squared_shape([own, second, third]));
        }
        before = self.vanishing().map(squared_shape).fold(before, f64::min);
        let is_thin = min_shape.is_some_and(|least| worst < least * least);
        !is_thin || (worst > 0.0 && worst >= STILL_AS_GOOD * STILL_AS_GOOD * before)
    }
}

/// The square of the shape of a face, as defined by [`ShapeConstraint`](crate::ShapeConstraint).
fn squared_shape([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    // Twice the area of an equilateral triangle is half a squared side times the square root of 3.
    let squared_equilateral = sides * sides / 12.0;
    if squared_equilateral == 0.0 {
        return 0.0;
    }
    (b - a).cross(c - a).length_squared() / squared_equilateral
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use mesh_core::{PolygonSoup, TriMesh};
    use mesh_shapes::{Irregular, Sphere, Wave};

    use super::*;
    use crate::blocks::lanes::levels;
    use crate::blocks::rules::Rules;
    use crate::geometry::quadric::Quadric;

    fn meshes() -> [TriMesh; 2] {
        let wave = Wave { amplitude: 0.15, wavelength: 0.7, half_width: 1.0 };
        let hills = wave.irregular_mesh(9, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        let ball = Sphere { radius: 1.0 }.icosphere(1).unwrap();
        [hills, ball].map(|soup: PolygonSoup| TriMesh::from_soup(&soup).unwrap())
    }

    /// The walks around the ends find the same faces as a search through all triangles.
    #[test]
    fn patches_are_the_triangles_round_an_edge() {
        let mut outcomes = std::collections::BTreeMap::<_, usize>::new();
        for mesh in meshes() {
            let rules = Rules { min_shape: Some(0.25), ..Rules::new(&mesh) };
            let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
            let corners = CornerTable::new(mesh.positions().len(), &triangles);
            let vertex = |&position| BlockVertex::new(position, &Quadric::default());
            let mut vertices: Vec<BlockVertex> = mesh.positions().iter().map(vertex).collect();
            for &v in triangles.as_flattened() {
                let vertex = &mut vertices[v as usize];
                vertex.set_valence(vertex.valence() + 1);
            }
            let mut patch = Patch::new();
            let sides =
                (0..triangles.len() as u32).flat_map(|face| [0, 1, 2].map(|i| 4 * face + i));
            for side in sides {
                let ends = [corners.vertex(side), corners.target(side)];
                let [a, b] = ends.map(|v| mesh.positions()[v as usize]);
                let half = 0.5 * (b - a);
                let shift = DVec3::new(0.3, 0.1, -0.2) * (half.length() * f64::from(side % 7));
                let round: Vec<[u32; 3]> = triangles
                    .iter()
                    .copied()
                    .filter(|t| ends.iter().any(|v| t.contains(v)))
                    .collect();
                let (vanishing, staying): (Vec<[u32; 3]>, Vec<[u32; 3]>) =
                    round.iter().partition(|t| ends.iter().all(|v| t.contains(v)));
                let at = |v: u32| mesh.positions()[v as usize] - (a + half);
                let moved = |v: u32| if ends.contains(&v) { shift } else { at(v) };
                let cross = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
                let is_turned = staying.iter().any(|t| {
                    let [old, new] = [cross(t.map(at)), cross(t.map(moved))];
                    old.dot(new) < 0.2 * old.length() * new.length()
                });
                let shape =
                    |t: &[u32; 3], at: &dyn Fn(u32) -> DVec3| squared_shape(t.map(at)).sqrt();
                let worst = staying.iter().map(|t| shape(t, &moved)).fold(1.0, f64::min);
                let before = round.iter().map(|t| shape(t, &at)).fold(1.0, f64::min);
                let rims =
                    ends.map(|v| mesh.topology().is_boundary_vertex(mesh_core::VertexId::new(v)));
                let expected = if vanishing.len() == 2 && rims == [true; 2] {
                    Err(Rejection::JoinsBoundaries)
                } else if is_turned {
                    Err(Rejection::NormalTurn)
                } else if worst < 0.25 && worst < STILL_AS_GOOD * before {
                    Err(Rejection::Sliver)
                } else {
                    Ok(())
                };
                for level in levels() {
                    let (found, volume) = dispatch!(level, simd => {
                        let gathered = patch.gather(simd, &corners, &mut vertices, side, half);
                        let checked = gathered.and_then(|()| patch.check(simd, shift, &rules));
                        (checked, patch.volume(simd))
                    });
                    // The expected result does not include the link condition.
                    if found != Err(Rejection::LinkCondition) && found != Err(Rejection::LastFace) {
                        assert_eq!(found, expected, "{side}");
                    }
                    let normal: DVec3 = round.iter().map(|t| cross(t.map(at))).sum();
                    let offset: f64 = round.iter().map(|t| cross(t.map(at)).dot(at(t[0]))).sum();
                    assert!(volume.0.distance(normal) < 1e-12 && (volume.1 - offset).abs() < 1e-12);
                    let size: f64 = round.iter().map(|t| cross(t.map(at)).length_squared()).sum();
                    assert!((volume.2 - size).abs() < 1e-12);
                    let fan = patch.fan().iter().map(|&corner| corners.vertex(corner));
                    assert!(fan.clone().all(|v| v == ends[0]));
                    let own = staying.iter().filter(|t| t.contains(&ends[0]));
                    assert_eq!(fan.count(), own.count());
                }
                *outcomes.entry(format!("{expected:?}")).or_default() += 1;
            }
        }
        assert!(outcomes.len() == 4 && outcomes.values().all(|&n| n > 1), "{outcomes:?}");
    }
}
