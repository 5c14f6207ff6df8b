//! The faces that belong together at an edge where closed surfaces touch.
//!
//! Two cubes that share only an edge have four faces there. Around the edge, each face bounds the inside on one side:
//! counter-clockwise, as seen against the direction of the edge, a face whose side runs back begins a wedge of the
//! inside, and a face whose side runs along ends one. Beginnings and ends are matched like brackets, so every wedge has
//! its two faces, and the cubes come apart closed.

use core::f64::consts::TAU;

use glam::DVec3;

use crate::build::edges::{across, edge_ends, same_direction};
use crate::topology::pairing::side_ends;

/// What the two faces of a pair enclose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wedges {
    /// Solids that touch come apart.
    Inside,
    /// Solids that touch are joined.
    Outside,
}

/// Faces at a smaller angle, in radians, lie on each other: single precision leaves no smaller one.
const SAME_ANGLE: f64 = 1e-5;

/// Whether an edge of more than two faces has as many sides that run along it as back.
pub(crate) fn is_closed_around(triangles: &[[u32; 3]], edge: &[u32]) -> bool {
    let [first, ..] = *edge else { return false };
    let along = edge.iter().filter(|&&side| same_direction(triangles, first, side)).count();
    edge.len() > 2 && 2 * along == edge.len()
}

/// Whether the triangles as a whole face inward: they enclose a negative volume.
pub(crate) fn is_inside_out(position: impl Fn(u32) -> DVec3, triangles: &[[u32; 3]]) -> bool {
    let Some(&[first, ..]) = triangles.first() else { return false };
    let origin = position(first);
    let terms = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|v| position(v) - origin);
        a.dot(b.cross(c))
    });
    terms.sum::<f64>() < 0.0
}

/// The sides of an edge that is closed around, in pairs. The faces show outward, or inward if they are inside out.
pub(crate) fn pairs_around(
    position: impl Fn(u32) -> DVec3,
    triangles: &[[u32; 3]],
    edge: &[u32],
    wedges: Wedges,
    is_inside_out: bool,
) -> Vec<[u32; 2]> {
    let Some(&first) = edge.first() else { return Vec::new() };
    let [from, to] = edge_ends(triangles, first);
    let origin = position(from);
    let axis = (position(to) - origin).normalize_or_zero();
    let arm = |side: u32| across(&position, triangles, side, origin, axis);
    let x = arm(first);
    let y = axis.cross(x);
    let begins = |side: u32| (side_ends(triangles, side)[0] == from) == is_inside_out;
    let mut around: Vec<(f64, bool, u32)> = edge
        .iter()
        .map(|&side| {
            let angle = arm(side).dot(y).atan2(arm(side).dot(x)).rem_euclid(TAU);
            let angle = if angle > TAU - SAME_ANGLE { 0.0 } else { angle };
            (angle, begins(side), side)
        })
        .collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Where faces of two solids lie on each other, one solid ends before the other one begins.
    for faces in around.chunk_by_mut(|a, b| b.0 - a.0 < SAME_ANGLE) {
        faces.sort_by_key(|&(_, begins, _)| begins);
    }
    let mut open = Vec::new();
    let mut pairs = Vec::with_capacity(edge.len() / 2);
    // What is still open after one turn ends at a face before it.
    let mut is_paired = vec![false; around.len()];
    for turn in 0..2 {
        for (place, &(_, begins, side)) in around.iter().enumerate() {
            if begins == (wedges == Wedges::Inside) {
                if turn == 0 {
                    open.push(side);
                }
            } else if !is_paired[place]
                && let Some(begin) = open.pop()
            {
                is_paired[place] = true;
                pairs.push([begin, side]);
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces around the z axis at the given angles in degrees; negative numbers run back.
    fn star(angles: &[(f64, bool)]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut positions = vec![DVec3::ZERO, DVec3::Z];
        let mut triangles = Vec::new();
        for (&(angle, runs_along), vertex) in angles.iter().zip(2..) {
            let (y, x) = angle.to_radians().sin_cos();
            positions.push(DVec3::new(x, y, 0.3));
            triangles.push(if runs_along { [0, 1, vertex] } else { [1, 0, vertex] });
        }
        (positions, triangles)
    }

    fn pairs(angles: &[(f64, bool)], wedges: Wedges) -> Vec<[u32; 2]> {
        let (positions, triangles) = star(angles);
        let edge: Vec<u32> = (0..).step_by(3).take(triangles.len()).collect();
        assert!(is_closed_around(&triangles, &edge));
        let mut pairs = pairs_around(|v| positions[v as usize], &triangles, &edge, wedges, false);
        pairs.iter_mut().for_each(|pair| *pair = pair.map(|side| side / 3));
        pairs.iter_mut().for_each(|pair| pair.sort_unstable());
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn wedges_of_the_inside_have_their_two_faces() {
        let (begins, ends) = (false, true);
        // Two cubes that touch along an edge.
        let cubes = [(0.0, begins), (90.0, ends), (180.0, begins), (270.0, ends)];
        assert_eq!(pairs(&cubes, Wedges::Inside), [[0, 1], [2, 3]]);
        assert_eq!(pairs(&cubes, Wedges::Outside), [[0, 3], [1, 2]]);
        // The list begins within a wedge.
        let turned = [(90.0, ends), (180.0, begins), (270.0, ends), (0.0, begins)];
        assert_eq!(pairs(&turned, Wedges::Inside), [[0, 3], [1, 2]]);
        // Cubes that lie on each other with a face each, of different diagonals.
        for noise in [0.0, 1e-7, -1e-7] {
            let walls = [(0.0, begins), (90.0 + noise, begins), (90.0, ends), (180.0, ends)];
            assert_eq!(pairs(&walls, Wedges::Inside), [[0, 2], [1, 3]]);
        }
        // A shell in a shell.
        let nested = [(0.0, begins), (30.0, begins), (60.0, ends), (90.0, ends)];
        assert_eq!(pairs(&nested, Wedges::Inside), [[0, 3], [1, 2]]);
    }
}
