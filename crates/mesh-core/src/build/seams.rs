//! Joining open edges that lie on each other.
//!
//! Programs that export a surface face by face, or patch by patch, give every face or patch vertices of its own. Such a
//! surface is closed to the eye, but every patch has a boundary.
//!
//! A sheet that is given once per side, with vertices of its own for each side, has open edges that lie on each other as
//! well. There the faces fold back onto each other, and joining them would make a closed surface without an inside, so
//! they stay apart.

use glam::DVec3;

use crate::build::edges::NONE;
use crate::build::soup::PolygonSoup;
use crate::build::weld::weld_exact;
use crate::index::as_u32;
use crate::random::SplitMix64;
use crate::topology::disjoint_sets::DisjointSets;

/// Sines of smaller angles are rounding: the faces fold back onto each other.
const FOLDED: f64 = 1e-5;

/// All sides of larger groups are joined: comparing each with each would take too long.
const MOST_COMPARED: usize = 32;

/// An open side of a face: the face, and where the side starts among its corners.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    face: u32,
    corner: u32,
}

/// Whether each side has a side in the opposite direction, as in a closed surface. Numbers that stand for edges, with the
/// sign of the direction, sum to zero then, and otherwise only by a chance of one in 2^64.
fn is_closed(soup: &PolygonSoup) -> bool {
    let number = |from: u32, to: u32| {
        let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
        let number = SplitMix64::new(edge).bits();
        if from < to { number } else { number.wrapping_neg() }
    };
    let around = |face: &[u32]| {
        let last = face.last().zip(face.first()).map_or(0, |(&last, &first)| number(last, first));
        face.windows(2).fold(last, |sum, side| sum.wrapping_add(number(side[0], side[1])))
    };
    soup.faces().fold(0_u64, |sum, face| sum.wrapping_add(around(face))) == 0
}

/// The open sides that lie on others.
struct Seams<'a> {
    soup: &'a PolygonSoup,
    /// For each vertex the first one at its position.
    first: Vec<u32>,
    /// Sides with their ends at the first vertices; sides with equal ends are contiguous.
    open: Vec<([u32; 2], Side)>,
    /// For each face twice its area vector; empty if there are no seams.
    normals: Vec<DVec3>,
}

impl<'a> Seams<'a> {
    fn new(soup: &'a PolygonSoup) -> Self {
        let (mut first, mut open, mut normals) = (Vec::new(), Vec::new(), Vec::new());
        if is_closed(soup) {
            return Self { soup, first, open, normals };
        }
        first = weld_exact(soup.positions());
        let mut has_copies = vec![false; first.len()];
        for (vertex, &first) in first.iter().enumerate() {
            if vertex != first as usize {
                has_copies[vertex] = true;
                has_copies[first as usize] = true;
            }
        }
        if !has_copies.contains(&true) {
            return Self { soup, first, open, normals };
        }
        let has_copies = |v: u32| has_copies.get(v as usize).copied().unwrap_or(false);
        let mut sides: Vec<([u32; 2], Side)> = Vec::new();
        for (face, corners) in soup.faces().enumerate() {
            let next = corners.iter().cycle().skip(1);
            for (corner, (&from, &to)) in corners.iter().zip(next).enumerate() {
                let is_seam = has_copies(from) && has_copies(to);
                if is_seam && first[from as usize] != first[to as usize] {
                    let side = Side { face: as_u32(face), corner: as_u32(corner) };
                    sides.push(([from.min(to), from.max(to)], side));
                }
            }
        }
        sides.sort_unstable();
        open.extend(sides.chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() == 1).flatten());
        for (ends, _) in &mut open {
            *ends = ends.map(|vertex| first[vertex as usize]);
            ends.sort_unstable();
        }
        open.sort_unstable();
        if open.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            normals = soup.faces().map(|corners| area_vector(soup, corners)).collect();
        }
        Self { soup, first, open, normals }
    }

    /// The ends of a side, in its direction.
    fn ends(&self, side: Side) -> [u32; 2] {
        let corners = self.soup.face(side.face as usize);
        let corner = side.corner as usize;
        [corners[corner], corners[(corner + 1) % corners.len()]]
    }

    /// The direction into the face, at a right angle to a side.
    fn inward(&self, side: Side) -> DVec3 {
        let [from, to] = self.ends(side).map(|v| self.soup.positions()[v as usize]);
        self.normals[side.face as usize].cross(to - from).normalize_or_zero()
    }

    /// Passes the sides that are joined, two or more at a time.
    fn each_joined(&self, mut see: impl FnMut(&[Side])) {
        let (mut sides, mut inward) = (Vec::new(), Vec::new());
        for group in self.open.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
            sides.clear();
            sides.extend(group.iter().map(|&(_, side)| side));
            inward.clear();
            inward.extend(sides.iter().map(|&side| self.inward(side)));
            let is_folded = |a: usize, b: usize| {
                let (a, b): (DVec3, DVec3) = (inward[a], inward[b]);
                a.dot(b) > 0.0 && a.cross(b).length() < FOLDED
            };
            let count = sides.len();
            let has_folds = || (0..count).any(|a| (0..a).any(|b| is_folded(a, b)));
            if count > MOST_COMPARED || !has_folds() {
                see(&sides);
                continue;
            }
            // Each side goes on in the face that is most nearly straight ahead and runs the other way.
            let start = |side: usize| self.first[self.ends(sides[side])[0] as usize];
            let mut is_taken = [false; MOST_COMPARED];
            for a in 0..count {
                let ahead = (a + 1..count)
                    .filter(|&b| !is_taken[b] && start(a) != start(b) && !is_folded(a, b))
                    .min_by(|&b, &c| inward[a].dot(inward[b]).total_cmp(&inward[a].dot(inward[c])));
                if let Some(b) = ahead.filter(|_| !is_taken[a]) {
                    (is_taken[a], is_taken[b]) = (true, true);
                    see(&[sides[a], sides[b]]);
                }
            }
        }
    }
}

/// Twice the area of a polygon, times its normal.
fn area_vector(soup: &PolygonSoup, corners: &[u32]) -> DVec3 {
    let at = |v: u32| soup.positions().get(v as usize).copied().unwrap_or(DVec3::NAN);
    let origin = corners.first().map_or(DVec3::ZERO, |&v| at(v));
    let sides = corners.windows(2).map(|side| (at(side[0]) - origin).cross(at(side[1]) - origin));
    sides.sum()
}

/// The vertex that every vertex merges into so that open edges that lie on each other become one: the first of its set.
pub(crate) fn weld_seams(soup: &PolygonSoup) -> Vec<u32> {
    let seams = Seams::new(soup);
    let count = soup.vertex_count();
    let mut sets = DisjointSets::new(count);
    // Per position, by its first vertex, the vertex of the side before.
    let mut last = vec![NONE; seams.first.len()];
    seams.each_joined(|sides| {
        let vertices = || sides.iter().flat_map(|&side| seams.ends(side));
        let place = |v: u32| seams.first[v as usize] as usize;
        vertices().for_each(|v| last[place(v)] = NONE);
        for v in vertices() {
            let last = &mut last[place(v)];
            if *last != NONE {
                sets.union(*last, v);
            }
            *last = v;
        }
    });
    (0..as_u32(count)).map(|v| sets.find(v)).collect()
}

/// The number of open edges that [`Weld::Seams`](crate::build::Weld::Seams) joins with others.
#[must_use]
pub fn count_seam_edges(soup: &PolygonSoup) -> usize {
    if let Some((scaled, _)) = soup.at_unit_size() {
        return count_seam_edges(&scaled);
    }
    let mut count = 0;
    Seams::new(soup).each_joined(|sides| count += sides.len());
    count
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Faces with vertices of their own.
    fn apart(faces: &[&[[f64; 3]]]) -> PolygonSoup {
        let mut soup = PolygonSoup::new();
        for face in faces {
            let first = as_u32(soup.vertex_count());
            face.iter().for_each(|&p| soup.push_vertex(p));
            let corners: Vec<u32> = (first..).take(face.len()).collect();
            soup.push_face(&corners).unwrap();
        }
        soup
    }

    const SQUARE: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    const BESIDE: [[f64; 3]; 4] =
        [[1.0, 0.0, 0.0], [2.0, 0.0, 0.5], [2.0, 1.0, 0.5], [1.0, 1.0, 0.0]];

    fn reversed(mut face: [[f64; 3]; 4]) -> [[f64; 3]; 4] {
        face.reverse();
        face
    }

    #[test]
    fn edges_that_lie_on_each_other_are_joined() {
        let soup = apart(&[&SQUARE, &BESIDE]);
        assert_eq!(weld_seams(&soup), [0, 1, 2, 3, 1, 5, 6, 2]);
        assert_eq!(count_seam_edges(&soup), 2);
        // Also against their orientation.
        let soup = apart(&[&SQUARE, &reversed(BESIDE)]);
        assert_eq!(weld_seams(&soup), [0, 1, 2, 3, 2, 5, 6, 1]);
    }

    #[test]
    fn sheets_that_are_given_once_per_side_stay_apart() {
        let [back, behind] = [reversed(SQUARE), reversed(BESIDE)];
        let soup = apart(&[&SQUARE, &back]);
        assert_eq!(weld_seams(&soup), [0, 1, 2, 3, 4, 5, 6, 7]);
        // Each side goes on in the neighbour's side.
        let soup = apart(&[&SQUARE, &BESIDE, &behind, &back]);
        let found = weld_seams(&soup);
        assert_eq!(found[..8], [0, 1, 2, 3, 1, 5, 6, 2]);
        assert_eq!(found[8..], [8, 9, 10, 11, 12, 8, 11, 15]);
        assert_eq!(count_seam_edges(&soup), 4);
    }

    #[test]
    fn vertices_that_touch_stay_apart() {
        let corner = [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 2.0, 0.0], [1.0, 2.0, 0.0]];
        let soup = apart(&[&SQUARE, &corner]);
        assert_eq!(weld_seams(&soup), [0, 1, 2, 3, 4, 5, 6, 7]);
    }
}
