//! A constraint on the edges, angles and valences of new faces.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh, VertexId};

use super::Constraint;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Limits on the edges, angles and valences of new faces. Edges, faces and valences that the input has beyond a limit
/// may stay as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FaceLimits {
    /// Greatest length of an edge, in model units, unless the same two places are joined by an edge of the input.
    pub max_edge: Option<f64>,
    /// Smallest angle of a face, in radians, unless the input has the same face.
    pub min_angle: Option<f64>,
    /// Greatest number of edges at a vertex, unless it was merged from a vertex of the input with at least as many.
    pub max_valence: Option<usize>,
}

impl FaceLimits {
    /// Whether there is any limit.
    #[inline]
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.max_edge.is_some() || self.min_angle.is_some() || self.max_valence.is_some()
    }

    /// Whether a new edge may join two points.
    #[inline]
    #[must_use]
    pub fn allows_edge(&self, a: DVec3, b: DVec3) -> bool {
        self.max_edge.is_none_or(|length| a.distance_squared(b) <= length * length)
    }

    /// Whether the angles of a new face are large enough.
    #[inline]
    #[must_use]
    pub fn allows_angles(&self, [a, b, c]: [DVec3; 3]) -> bool {
        self.min_angle.is_none_or(|least| {
            let double_area = (b - a).cross(c - a).length();
            let (sine, cosine) = least.sin_cos();
            // The sine of the difference between an angle and the limit has the sign of this difference.
            let is_wide = |from: DVec3, p: DVec3, q: DVec3| {
                double_area * cosine >= (p - from).dot(q - from) * sine
            };
            double_area > 0.0 && is_wide(a, b, c) && is_wide(b, c, a) && is_wide(c, a, b)
        })
    }

    /// Whether a vertex may get this many edges.
    #[inline]
    #[must_use]
    pub fn allows_valence(&self, valence: usize) -> bool {
        self.max_valence.is_none_or(|most| valence <= most)
    }

    /// Whether a vertex may move to a point, with regard to its edges and faces.
    #[must_use]
    pub fn allow_move(&self, mesh: &TriMesh, v: VertexId, to: DVec3) -> bool {
        if self.max_edge.is_none() && self.min_angle.is_none() || mesh.position(v) == to {
            return true;
        }
        let topology = mesh.topology();
        let at = |w: VertexId| if w == v { to } else { mesh.position(w) };
        topology.one_ring(v).all(|w| self.allows_edge(to, mesh.position(w)))
            && topology
                .faces_of_vertex(v)
                .all(|face| self.allows_angles(topology.face_vertices(face).map(at)))
    }

    /// Whether an edge with two faces may be flipped.
    #[must_use]
    pub fn allow_flip(&self, mesh: &TriMesh, edge: EdgeId) -> bool {
        if !self.is_any() {
            return true;
        }
        let topology = mesh.topology();
        let [Some(c), Some(d)] = edge.half_edges().map(|side| topology.apex(side)) else {
            return false;
        };
        let [a, b] = topology.edge_vertices(edge).map(|v| mesh.position(v));
        let [p, q] = [c, d].map(|v| mesh.position(v));
        self.allows_edge(p, q)
            && self.allows_angles([p, a, q])
            && self.allows_angles([q, b, p])
            && [c, d].into_iter().all(|v| self.allows_valence(topology.valence(v) + 1))
    }

    /// Whether an edge may be split at a point.
    #[must_use]
    pub fn allow_edge_split(&self, mesh: &TriMesh, edge: EdgeId, at: DVec3) -> bool {
        if !self.is_any() {
            return true;
        }
        let topology = mesh.topology();
        let ends = topology.edge_vertices(edge).map(|v| mesh.position(v));
        let apexes = edge.half_edges().map(|side| topology.apex(side));
        ends.into_iter().all(|end| self.allows_edge(at, end))
            && apexes.into_iter().flatten().all(|apex| {
                let p = mesh.position(apex);
                self.allows_edge(at, p)
                    && ends.into_iter().all(|end| self.allows_angles([at, p, end]))
                    && self.allows_valence(topology.valence(apex) + 1)
            })
    }

    /// Whether a face with these corners may be split at a point.
    #[must_use]
    pub fn allow_face_split(&self, mesh: &TriMesh, corners: [VertexId; 3], at: DVec3) -> bool {
        let points = corners.map(|v| mesh.position(v));
        !self.is_any()
            || (0..3).all(|i| {
                self.allows_edge(at, points[i])
                    && self.allows_angles([at, points[i], points[(i + 1) % 3]])
                    && self.allows_valence(mesh.topology().valence(corners[i]) + 1)
            })
    }

    /// Whether an earlier mesh has all edges, faces and valences of a mesh that are beyond a limit. Vertices are the
    /// same if they are at the same place.
    #[must_use]
    pub fn allow_change(&self, before: &TriMesh, after: &TriMesh) -> bool {
        let edges = |mesh: &TriMesh| {
            let segments = mesh.topology().edges().map(|edge| mesh.segment(edge));
            sorted(segments.filter(|[a, b]| !self.allows_edge(*a, *b)))
        };
        let faces = |mesh: &TriMesh| {
            let triangles = mesh.topology().faces().map(|face| mesh.triangle(face));
            sorted(triangles.filter(|corners| !self.allows_angles(*corners)))
        };
        let most = |mesh: &TriMesh| {
            mesh.topology().vertices().map(|v| mesh.topology().valence(v)).max().unwrap_or(0)
        };
        let is_part = |new: &[Bits], old: &[Bits]| new.iter().all(|x| old.binary_search(x).is_ok());
        (self.max_edge.is_none() || is_part(&edges(after), &edges(before)))
            && (self.min_angle.is_none() || is_part(&faces(after), &faces(before)))
            && (self.max_valence.is_none()
                || self.allows_valence(most(after))
                || most(after) <= most(before))
    }
}

/// Points as bits, which have an order.
type Bits = Vec<[u64; 3]>;

/// Sorted sets of points.
fn sorted<const N: usize>(sets: impl Iterator<Item = [DVec3; N]>) -> Vec<Bits> {
    let of_set = |points: [DVec3; N]| {
        let mut bits: Bits = points.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        bits.sort_unstable();
        bits
    };
    let mut all: Vec<Bits> = sets.map(of_set).collect();
    all.sort_unstable();
    all
}

impl Policy for FaceLimits {}

impl Constraint for FaceLimits {
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let moved = || patch.remaining_faces().iter().filter(|face| face.corners[0] != x);
        if self.max_edge.is_some() {
            // A vertex that stays at an end of the edge keeps its edges to the corners of the vanishing faces.
            let stays = patch.ends().contains(&x);
            let apexes = patch.vanishing_faces().map(|face| face.map(|face| face.corners[2]));
            let is_new = |p: &DVec3| !(stays && apexes.contains(&Some(*p)));
            let mut ring = moved().flat_map(|face| [face.corners[1], face.corners[2]]);
            // Without remaining faces, the two vertices are joined to the apexes only.
            if ring.any(|p| !self.allows_edge(x, p) && is_new(&p)) {
                return Err(Rejection::MaxEdge);
            }
        }
        if self.min_angle.is_some()
            && !moved().all(|face| self.allows_angles([x, face.corners[1], face.corners[2]]))
        {
            return Err(Rejection::MinAngle);
        }
        if self.max_valence.is_some() {
            let topology = patch.mesh().topology();
            let [a, b] = [patch.removed(), patch.kept()].map(|v| topology.valence(v));
            let vanishing = patch.vanishing_faces().iter().flatten().count();
            let valence = (a + b).saturating_sub(2 + vanishing);
            if !self.allows_valence(valence) && valence > a.max(b) {
                return Err(Rejection::MaxValence);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_compared_exactly_at_any_size() {
        let triangle = |degrees: f64, size: f64| {
            let half = 0.5 * degrees.to_radians();
            let (sine, cosine) = half.sin_cos();
            [[0.0, 0.0], [cosine, sine], [cosine, -sine]].map(|[x, y]| size * DVec3::new(x, y, 0.0))
        };
        let limits = FaceLimits { min_angle: Some(20_f64.to_radians()), ..FaceLimits::default() };
        for size in [1e-60, 1.0, 1e60] {
            assert!(limits.allows_angles(triangle(20.001, size)));
            assert!(!limits.allows_angles(triangle(19.999, size)));
            // The other two angles are 19.5 and 20.5 degrees.
            assert!(!limits.allows_angles(triangle(141.0, size)));
            assert!(limits.allows_angles(triangle(139.0, size)));
            assert!(!limits.allows_angles([DVec3::ZERO, size * DVec3::X, 3.0 * size * DVec3::X]));
            assert!(!limits.allows_angles([size * DVec3::X; 3]));
        }
        assert!(!limits.allows_angles([DVec3::NAN; 3]));
        assert!(FaceLimits::default().allows_angles([DVec3::X; 3]));
    }
}
