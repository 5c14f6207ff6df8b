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
use crate::topology::disjoint_sets::DisjointSets;

/// Sines of smaller angles are rounding: the faces fold back onto each other.
const FOLDED: f64 = 1e-5;

/// All sides of larger groups are joined: comparing each with each would take too long.
const MOST_COMPARED: usize = 32;

/// An open side of a face: the face, and where the side starts among its corners.
#[derive(Clone, Copy)]
struct Side {
    face: u32,
    corner: u32,
}

/// The open sides that lie on others, in groups with equal ends; and for each vertex the first one at its position.
fn groups(soup: &PolygonSoup) -> (Vec<Vec<Side>>, Vec<u32>) {
    let first = weld_exact(soup.positions());
    let mut has_copies = vec![false; first.len()];
    for (vertex, &first) in
        first.iter().enumerate().filter(|&(vertex, &first)| vertex != first as usize)
    {
        has_copies[vertex] = true;
        has_copies[first as usize] = true;
    }
    if !has_copies.contains(&true) {
        return (Vec::new(), first);
    }
    let has_copies = |v: u32| has_copies.get(v as usize).copied().unwrap_or(false);
    let mut sides: Vec<([u32; 2], Side)> = Vec::new();
    for (face, corners) in soup.faces().enumerate() {
        let next = corners.iter().cycle().skip(1);
        for (corner, (&from, &to)) in corners.iter().zip(next).enumerate() {
            if has_copies(from) && has_copies(to) && first[from as usize] != first[to as usize] {
                let side = Side { face: as_u32(face), corner: as_u32(corner) };
                sides.push(([from.min(to), from.max(to)], side));
            }
        }
    }
    sides.sort_unstable_by_key(|&(ends, side)| (ends, side.face, side.corner));
    let mut open: Vec<([u32; 2], Side)> = sides
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|sides| sides.len() == 1)
        .flatten()
        .map(|&([a, b], side)| {
            let [a, b] = [first[a as usize], first[b as usize]];
            ([a.min(b), a.max(b)], side)
        })
        .collect();
    open.sort_unstable_by_key(|&(ends, side)| (ends, side.face, side.corner));
    let groups = open.chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() > 1);
    (groups.map(|sides| sides.iter().map(|&(_, side)| side).collect()).collect(), first)
}

/// The ends of a side, in its direction.
fn ends(soup: &PolygonSoup, side: Side) -> [u32; 2] {
    let corners = soup.face(side.face as usize);
    let corner = side.corner as usize;
    [corners[corner], corners[(corner + 1) % corners.len()]]
}

/// The direction into the face, at a right angle to a side.
fn inward(soup: &PolygonSoup, side: Side) -> DVec3 {
    let at = |v: u32| soup.positions().get(v as usize).copied().unwrap_or(DVec3::NAN);
    let [from, to] = ends(soup, side).map(at);
    let corners = soup.face(side.face as usize);
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = pairs.map(|(&a, &b)| (at(a) - from).cross(at(b) - from)).sum();
    normal.cross(to - from).normalize_or_zero()
}

/// The sides of a group that are joined, as sets of at least two sides.
fn joined(soup: &PolygonSoup, group: &[Side], first: &[u32]) -> Vec<Vec<Side>> {
    let inward: Vec<DVec3> = group.iter().map(|&side| inward(soup, side)).collect();
    let is_folded = |a: usize, b: usize| {
        inward[a].dot(inward[b]) > 0.0 && inward[a].cross(inward[b]).length() < FOLDED
    };
    let is_small = group.len() <= MOST_COMPARED;
    let has_folds = || (0..group.len()).any(|a| (0..a).any(|b| is_folded(a, b)));
    if !is_small || !has_folds() {
        return vec![group.to_vec()];
    }
    // Each side goes on in the face that is most nearly straight ahead and runs the other way.
    let start = |side: usize| first[ends(soup, group[side])[0] as usize];
    let mut is_taken = vec![false; group.len()];
    let mut pairs = Vec::new();
    for a in 0..group.len() {
        if is_taken[a] {
            continue;
        }
        let ahead = (a + 1..group.len())
            .filter(|&b| !is_taken[b] && start(a) != start(b) && !is_folded(a, b))
            .min_by(|&b, &c| inward[a].dot(inward[b]).total_cmp(&inward[a].dot(inward[c])));
        if let Some(b) = ahead {
            (is_taken[a], is_taken[b]) = (true, true);
            pairs.push(vec![group[a], group[b]]);
        }
    }
    pairs
}

/// The vertex that every vertex merges into so that open edges that lie on each other become one: the first of its set.
pub(crate) fn weld_seams(soup: &PolygonSoup) -> Vec<u32> {
    let (groups, first) = groups(soup);
    let count = as_u32(first.len());
    if groups.is_empty() {
        return (0..count).collect();
    }
    let mut sets = DisjointSets::new(first.len());
    // Per position, by its first vertex, the vertex of the side before.
    let mut last = vec![NONE; first.len()];
    for set in groups.iter().flat_map(|group| joined(soup, group, &first)) {
        let vertices = || set.iter().flat_map(|&side| ends(soup, side));
        vertices().for_each(|v| last[first[v as usize] as usize] = NONE);
        for v in vertices() {
            let last = &mut last[first[v as usize] as usize];
            if *last != NONE {
                sets.union(*last, v);
            }
            *last = v;
        }
    }
    (0..count).map(|v| sets.find(v)).collect()
}

/// The number of open edges that [`Weld::Seams`](crate::build::Weld::Seams) joins with others.
#[must_use]
pub fn count_seam_edges(soup: &PolygonSoup) -> usize {
    let (groups, first) = groups(soup);
    groups.iter().flat_map(|group| joined(soup, group, &first)).map(|set| set.len()).sum()
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
