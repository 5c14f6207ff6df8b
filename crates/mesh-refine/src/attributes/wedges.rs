//! Data at the corners of faces, updated with every collapse.
//!
//! A *wedge* is a sequence of corners at a vertex that share one value. A vertex inside a texture chart has one wedge;
//! a vertex on a seam has one on each side. A collapse merges wedges of the two ends of the edge if they meet in a face
//! of the edge. If the edge itself is a seam, the wedges of its two sides stay separate.

use glam::DVec3;
use mesh_collapse::{EdgePatch, PatchFace};
use mesh_core::{HalfEdgeId, HalfEdgeMap, Remap, TriMesh, UnitScale, VertexId, as_u32};
use mesh_metric::{closest_on_triangle, weights_of_closest};

use crate::error::RefineError;

/// The largest number of values per corner.
pub const MAX_CHANNELS: usize = 12;

type Value = [f64; MAX_CHANNELS];

/// Values at the corners of faces whose interpolation over the surface should be preserved: texture coordinates,
/// normals, colours.
///
/// Scale the values so that a difference of 1 is as bad as a distance of one model unit.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CornerAttributes {
    /// The wedge of the corner at the origin of each half-edge with a face.
    wedge: HalfEdgeMap<u32>,
    values: Vec<Value>,
    /// Whether the first two values are texture coordinates, which must not fold over.
    has_texture: bool,
}

const NO_WEDGE: u32 = u32::MAX;

impl CornerAttributes {
    /// Collects the values at the corners; if `has_texture`, the first two are texture coordinates. `of_corner` returns
    /// the values at the origin of a half-edge, in the face of that half-edge. Neighbouring corners with equal values
    /// form a wedge.
    ///
    /// # Errors
    /// There are more than [`MAX_CHANNELS`] values at a corner.
    pub fn new<const N: usize>(
        mesh: &TriMesh,
        has_texture: bool,
        of_corner: impl Fn(HalfEdgeId) -> [f64; N],
    ) -> Result<Self, RefineError> {
        if N > MAX_CHANNELS {
            return Err(RefineError::Channels { channels: N, most: MAX_CHANNELS });
        }
        let wedge = mesh.topology().half_edge_map(NO_WEDGE);
        let mut all = Self { wedge, values: Vec::new(), has_texture };
        all.add_vertices(mesh, &of_corner);
        Ok(all)
    }

    fn add_vertices<const N: usize>(
        &mut self,
        mesh: &TriMesh,
        of_corner: &impl Fn(HalfEdgeId) -> [f64; N],
    ) {
        let topology = mesh.topology();
        let mut corners = Vec::new();
        for v in topology.vertices() {
            corners.clear();
            corners.extend(topology.outgoing(v).filter(|&h| !topology.is_exterior(h)));
            self.add_vertex(&corners, of_corner);
            if let ([first, .., last], false) = (&corners[..], topology.is_boundary_vertex(v)) {
                self.join_ends(&corners, [*first, *last]);
            }
        }
    }

    /// Cuts the corners of a vertex, in order, into wedges.
    fn add_vertex<const N: usize>(
        &mut self,
        corners: &[HalfEdgeId],
        of_corner: &impl Fn(HalfEdgeId) -> [f64; N],
    ) {
        let mut previous = None;
        for &h in corners {
            let mut value = [0.0; MAX_CHANNELS];
            for (slot, number) in value.iter_mut().zip(of_corner(h)) {
                *slot = if number.is_finite() { number } else { 0.0 };
            }
            if previous != Some(value) {
                self.values.push(value);
                previous = Some(value);
            }
            self.wedge[h] = as_u32(self.values.len()) - 1;
        }
    }

    /// Joins the first and the last wedge around a vertex if they have the same value.
    fn join_ends(&mut self, corners: &[HalfEdgeId], ends: [HalfEdgeId; 2]) {
        let [first, last] = ends.map(|h| self.wedge[h]);
        if self.values[first as usize] == self.values[last as usize] {
            for &h in corners.iter().rev().take_while(|_| first != last) {
                if self.wedge[h] != last {
                    break;
                }
                self.wedge[h] = first;
            }
        }
    }

    /// The same kind of data, in which each corner has the values of the corner that `of_corner` names.
    #[must_use]
    pub fn taking(&self, mesh: &TriMesh, of_corner: impl Fn(HalfEdgeId) -> HalfEdgeId) -> Self {
        let topology = mesh.topology();
        let mut all = Self {
            wedge: topology.half_edge_map(NO_WEDGE),
            values: Vec::new(),
            has_texture: self.has_texture,
        };
        all.add_vertices(mesh, &|h| *self.value(of_corner(h)));
        all
    }

    /// The values for a scaled mesh.
    #[must_use]
    pub fn scaled(&self, scale: UnitScale) -> Self {
        let mut scaled = self.clone();
        scaled.values.iter_mut().flatten().for_each(|value| *value = scale.length(*value));
        scaled
    }

    /// Whether the first two values are texture coordinates.
    pub fn has_texture(&self) -> bool {
        self.has_texture
    }

    fn value(&self, h: HalfEdgeId) -> &Value {
        &self.values[self.wedge[h] as usize]
    }

    /// The texture coordinates at a corner.
    pub(crate) fn texture(&self, h: HalfEdgeId) -> [f64; 2] {
        let [u, v, ..] = *self.value(h);
        [u, v]
    }

    /// The attribute deviation of a collapse, see [`AttributeDeviation`](crate::AttributeDeviation).
    pub(crate) fn deviation(&self, patch: &EdgePatch<'_>, x: DVec3) -> f64 {
        let merge = Merge::new(self, patch);
        let mut sum = 0.0;
        for (v, end) in [(patch.removed(), patch.ends()[0]), (patch.kept(), patch.ends()[1])] {
            if end != x {
                sum += self.deviation_at(patch, &merge, v, end, x);
            }
        }
        sum
    }

    fn deviation_at(
        &self,
        patch: &EdgePatch<'_>,
        merge: &Merge,
        v: VertexId,
        end: DVec3,
        x: DVec3,
    ) -> f64 {
        let topology = patch.mesh().topology();
        let mut sum = 0.0;
        // The faces of a patch are grouped by end and ordered around it. So each wedge occurs once, or twice if the
        // walk starts inside it.
        let mut known: Option<(u32, f64)> = None;
        for face in patch.faces().iter().filter(|face| topology.origin(face.side) == v) {
            let wedge = self.wedge[face.side];
            let squared = match known {
                Some((same, squared)) if same == wedge => squared,
                _ => {
                    let new = self.at(patch, merge, merge.group(wedge), end, Some(x));
                    let old = &self.values[wedge as usize];
                    let new = new.unwrap_or(*old);
                    old.iter().zip(new).map(|(o, n)| (o - n) * (o - n)).sum()
                }
            };
            known = Some((wedge, squared));
            sum += face.cross.length() / 6.0 * squared;
        }
        sum
    }

    /// The value at the closest point to `point` on the faces of a group, in the current patch or with the ends moved
    /// to `moved`.
    fn at(
        &self,
        patch: &EdgePatch<'_>,
        merge: &Merge,
        group: u32,
        point: DVec3,
        moved: Option<DVec3>,
    ) -> Option<Value> {
        let faces = if moved.is_some() { patch.remaining_faces() } else { patch.faces() };
        let corners_of = |face: &PatchFace| match moved {
            Some(x) => [x, face.corners[1], face.corners[2]],
            None => face.corners,
        };
        let mut best: Option<(f64, &PatchFace)> = None;
        for face in faces.iter().filter(|face| merge.group(self.wedge[face.side]) == group) {
            let distance = closest_on_triangle(point, &corners_of(face)).length_squared();
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, face));
            }
        }
        let (_, face) = best?;
        let weights = weights_of_closest(point, &corners_of(face)).to_array();
        let topology = patch.mesh().topology();
        let second = topology.next(face.side);
        let first = match moved {
            Some(x) => self.at(patch, merge, group, x, None)?,
            None => *self.value(face.side),
        };
        let corners = [&first, self.value(second), self.value(topology.next(second))];
        Some(core::array::from_fn(|i| (0..3).map(|k| weights[k] * corners[k][i]).sum()))
    }

    /// Whether a face of the patch would turn over in the texture.
    pub(crate) fn folds(&self, patch: &EdgePatch<'_>, x: DVec3) -> bool {
        if !self.has_texture {
            return false;
        }
        let topology = patch.mesh().topology();
        let merge = Merge::new(self, patch);
        let mut known: Option<(u32, [f64; 2])> = None;
        for face in patch.remaining_faces() {
            let group = merge.group(self.wedge[face.side]);
            let moved = match known {
                Some((same, moved)) if same == group => moved,
                _ => {
                    let Some([u, v, ..]) = self.at(patch, &merge, group, x, None) else { continue };
                    [u, v]
                }
            };
            known = Some((group, moved));
            let second = topology.next(face.side);
            let [a, b, c] = [face.side, second, topology.next(second)].map(|h| self.texture(h));
            let (before, after) = (doubled_area(a, b, c), doubled_area(moved, b, c));
            if before * after < 0.0 || (after == 0.0 && before != 0.0) {
                return true;
            }
        }
        false
    }

    /// Moves the wedges to the handles of the mesh without gaps.
    pub(crate) fn compact(&mut self, remap: &Remap) {
        self.wedge = self.wedge.compact(remap);
    }

    /// Updates the wedges for a collapse that is about to happen.
    pub(crate) fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3) {
        let merge = Merge::new(self, patch);
        let topology = patch.mesh().topology();
        let mut groups: Vec<u32> =
            patch.faces().iter().map(|face| merge.group(self.wedge[face.side])).collect();
        groups.sort_unstable();
        groups.dedup();
        let values: Vec<_> =
            groups.iter().map(|&group| self.at(patch, &merge, group, x, None)).collect();
        for (group, value) in groups.into_iter().zip(values) {
            if let Some(value) = value {
                self.values[group as usize] = value;
            }
        }
        for face in patch.faces() {
            self.wedge[face.side] = merge.group(self.wedge[face.side]);
        }
        // One side of each removed face replaces the other side of another edge.
        let [h, twin] = [patch.half_edge(), patch.half_edge().twin()];
        if !topology.is_exterior(h) {
            let bc = topology.next(h);
            self.wedge[bc] = self.wedge[topology.next(bc).twin()];
        }
        if !topology.is_exterior(twin) {
            let ad = topology.next(twin);
            let db = topology.next(ad);
            self.wedge[db] = self.wedge[ad.twin()];
        }
    }
}

pub(crate) fn doubled_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The pairs of wedges that are merged: on either side of the edge, the wedge at the removed vertex and the wedge at
/// the remaining vertex.
struct Merge([Option<[u32; 2]>; 2]);

impl Merge {
    fn new(all: &CornerAttributes, patch: &EdgePatch<'_>) -> Self {
        let topology = patch.mesh().topology();
        let [h, twin] = [patch.half_edge(), patch.half_edge().twin()];
        let left = (!topology.is_exterior(h)).then(|| [h, topology.next(h)]);
        let right = (!topology.is_exterior(twin)).then(|| [topology.next(twin), twin]);
        let mut pairs = [left, right].map(|pair| pair.map(|corners| corners.map(|c| all.wedge[c])));
        // If one wedge surrounds an end completely, it also joins the two wedges that it meets at the other end.
        if let [Some(left), Some(right)] = &mut pairs
            && left[0] == right[0]
            && left[1] != right[1]
        {
            right[0] = NO_WEDGE;
        }
        Self(pairs)
    }

    /// The wedge that replaces `wedge` after the collapse.
    fn group(&self, wedge: u32) -> u32 {
        let joined = self.0.iter().flatten().find(|[removed, _]| *removed == wedge);
        joined.map_or(wedge, |[_, kept]| *kept)
    }
}
