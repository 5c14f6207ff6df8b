//! Cuts a surface at non-manifold edges and vertices.
//!
//! The corners at a vertex are linked through the edges along which exactly two faces meet, in
//! opposite directions, and through [the faces that belong together](crate::build::touching) at
//! edges of more than two faces, [as far as they go up in pairs](crate::build::fins); a maximal
//! chain of linked corners is a *fan*. Every fan beyond
//! the first at a vertex gets its own copy of the vertex, which also cuts the surface along all other
//! edges of several faces.
//!
//! Why the result is a 2-manifold: a chain that does not close has two ends, one cut side that
//! leaves the vertex and one that enters it. So of the cut sides of an edge `uv`, at most one runs
//! from a given copy of `u` to a given copy of `v` and at most one runs back. Two such sides meet
//! again as one proper edge, which closes the fan at both copies: surfaces that touch along an edge
//! come apart closed, without a slit of zero width. All other cut sides end up on the boundary.
//! Every vertex has one fan, and no two edges have the same ends. Where linked sides of an edge end
//! at the same copies of both vertices as others, they are linked in the other way, or else cut.

use glam::DVec3;

use crate::build::edges::{EdgeTable, NONE, next, previous, proper_pair};
use crate::build::fins::Parts;
use crate::build::touching::{Wedges, is_inside_out, pairs_around};
use crate::index::as_u32;
use crate::measure::any_size::unit_sized_points;
use crate::topology::pairing::{TopologyError, check_corners};

/// The fans of corners around the vertices.
pub(crate) struct Fans {
    /// Per corner, its fan.
    of_corner: Vec<u32>,
    /// Per fan, the vertex it lies at. Fans come in order of their first corner.
    vertex: Vec<u32>,
}

/// Per side, the side that it is linked with: the other one of its edge, if exactly two faces meet there.
fn links(triangles: &[[u32; 3]], edges: &EdgeTable) -> Vec<u32> {
    let mut mate = vec![NONE; 3 * triangles.len()];
    edges
        .iter()
        .filter_map(|edge| proper_pair(triangles, edge))
        .for_each(|pair| link(pair, &mut mate));
    mate
}

fn link([a, b]: [u32; 2], mate: &mut [u32]) {
    mate[a as usize] = b;
    mate[b as usize] = a;
}

impl Fans {
    pub(crate) fn new(triangles: &[[u32; 3]], edges: &EdgeTable) -> Self {
        Self::linked(triangles, &links(triangles, edges))
    }

    fn linked(triangles: &[[u32; 3]], mate: &[u32]) -> Self {
        let mut fans = Self { of_corner: vec![NONE; mate.len()], vertex: Vec::new() };
        for (corner, &vertex) in triangles.as_flattened().iter().enumerate() {
            if fans.of_corner[corner] == NONE {
                fans.collect(as_u32(corner), vertex, mate);
            }
        }
        fans
    }

    /// Collects the fan of a corner: first counter-clockwise, through the sides that enter the vertex. If that does not
    /// lead back to the corner, then also clockwise, through the sides that leave the vertex.
    fn collect(&mut self, first: u32, vertex: u32, mate: &[u32]) {
        let fan = as_u32(self.vertex.len());
        self.vertex.push(vertex);
        let mut corner = first;
        while corner != NONE {
            self.of_corner[corner as usize] = fan;
            corner = mate[previous(corner) as usize];
            if corner == first {
                return;
            }
        }
        let mut neighbour = mate[first as usize];
        while neighbour != NONE {
            let corner = next(neighbour);
            self.of_corner[corner as usize] = fan;
            neighbour = mate[corner as usize];
        }
    }

    /// Whether two sides of an edge run from the same fan to the same fan, or two of its faces have the same fans at all
    /// corners.
    fn has_twins(&self, edge: &[u32]) -> bool {
        let fan = |corner: u32| self.of_corner[corner as usize];
        let mut sides: Vec<_> = edge.iter().map(|&side| [side, next(side)].map(fan)).collect();
        let mut faces: Vec<_> =
            edge.iter().map(|&side| [side, next(side), previous(side)].map(fan)).collect();
        faces.iter_mut().for_each(|face| face.sort_unstable());
        has_equal(&mut sides) || has_equal(&mut faces)
    }

    /// The vertices with more than one fan and the number of fans at each, ascending.
    pub(crate) fn pinched(&self) -> Vec<(u32, usize)> {
        let mut vertices = self.vertex.clone();
        vertices.sort_unstable();
        vertices
            .chunk_by(|a, b| a == b)
            .filter(|fans| fans.len() > 1)
            .map(|fans| (fans[0], fans.len()))
            .collect()
    }
}

fn has_equal<T: Ord>(list: &mut [T]) -> bool {
    list.sort_unstable();
    list.windows(2).any(|pair| pair[0] == pair[1])
}

/// Cuts triangles apart where they are no oriented 2-manifold, and changes nothing else: the last step of
/// [`crate::build()`], for part of a mesh. Copies of vertices are numbered after the given vertices; returns the
/// original vertex of each.
///
/// # Errors
/// An index is out of range, a triangle uses a vertex twice, or there are too many triangles.
pub fn cut_non_manifold(
    positions: &[DVec3],
    triangles: &mut [[u32; 3]],
) -> Result<Vec<u32>, TopologyError> {
    check_corners(positions.len(), triangles)?;
    let (positions, _) = unit_sized_points(positions);
    let edges = EdgeTable::new(positions.len(), triangles);
    Ok(cut_apart(positions.len(), |v| positions[v as usize], triangles, &edges))
}

/// Gives every fan beyond the first at a vertex its own copy of the vertex, appended after the given ones. Returns the
/// original vertex of each copy.
pub(crate) fn cut_apart(
    vertex_count: usize,
    position: impl Fn(u32) -> DVec3,
    triangles: &mut [[u32; 3]],
    edges: &EdgeTable,
) -> Vec<u32> {
    let mut mate = links(triangles, edges);
    let mut fans = Fans::linked(triangles, &mate);
    let crowded: Vec<&[u32]> = edges.iter().filter(|edge| edge.len() > 2).collect();
    let mut parts = (!crowded.is_empty())
        .then(|| (Parts::new(&position, triangles, edges), is_inside_out(&position, triangles)));
    let mut unresolved = crowded.clone();
    for wedges in [Some(Wedges::Inside), Some(Wedges::Outside), None] {
        let Some((parts, is_inside_out)) = parts.as_mut().filter(|_| !unresolved.is_empty()) else {
            break;
        };
        for edge in unresolved {
            edge.iter().for_each(|&side| mate[side as usize] = NONE);
            let Some(wedges) = wedges else { continue };
            for sides in parts.groups(triangles, edge) {
                let pairs = pairs_around(&position, triangles, &sides, wedges, *is_inside_out);
                pairs.into_iter().for_each(|pair| link(pair, &mut mate));
            }
        }
        fans = Fans::linked(triangles, &mate);
        unresolved = crowded.iter().copied().filter(|edge| fans.has_twins(edge)).collect();
    }
    let mut taken = vec![false; vertex_count];
    let mut copies = Vec::new();
    let vertex_of_fan: Vec<u32> = fans
        .vertex
        .iter()
        .map(|&vertex| {
            if core::mem::replace(&mut taken[vertex as usize], true) {
                copies.push(vertex);
                as_u32(vertex_count + copies.len() - 1)
            } else {
                vertex
            }
        })
        .collect();
    for (corner, &fan) in triangles.as_flattened_mut().iter_mut().zip(&fans.of_corner) {
        *corner = vertex_of_fan[fan as usize];
    }
    copies
}
