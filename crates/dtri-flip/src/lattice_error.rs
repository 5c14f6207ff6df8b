//! Error measure of DHKL01, Table 1.

use glam::DVec3;
use mesh_core::{EdgeId, FaceId, Handle, TriMesh, VertexId, parallel};

/// Norms of the distance between a mesh and a surface over lattice points on the mesh, in model units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LatticeError {
    /// The mean: `L1`.
    pub mean: f64,
    /// The root mean square: `L2`.
    pub rms: f64,
    /// The maximum: `L-infinity`.
    pub max: f64,
    /// Number of points.
    pub points: u64,
}

/// Measures the distance of a mesh to a surface as DHKL01 did for Table 1: at the points of a
/// barycentric lattice on every triangle, `subdivisions` steps along each side, each point once.
///
/// `distance` returns the distance of a point from the surface; the sign is ignored. The table in the
/// paper uses 100 subdivisions. Points on shared edges and vertices are counted once. A mesh without
/// faces has an error of 0. 0 subdivisions count as 1.
#[must_use]
pub fn lattice_error(
    mesh: &TriMesh,
    subdivisions: u32,
    distance: impl Fn(DVec3) -> f64 + Sync,
) -> LatticeError {
    let n = subdivisions.max(1);
    let topology = mesh.topology();
    let at = |point: DVec3| Sums::of(distance(point).abs());
    let of_vertex = |index: usize| {
        let v = VertexId::from_index(index);
        let used = topology.contains_vertex(v) && !topology.is_isolated_vertex(v);
        if used { at(mesh.position(v)) } else { Sums::NONE }
    };
    let of_edge = |index: usize| {
        let e = EdgeId::from_index(index);
        if !topology.contains_edge(e) {
            return Sums::NONE;
        }
        let [a, b] = mesh.segment(e);
        (1..n).map(|i| at(a + (b - a) * ratio(i, n))).fold(Sums::NONE, Sums::and)
    };
    let of_face = |index: usize| {
        let f = FaceId::from_index(index);
        if !topology.contains_face(f) {
            return Sums::NONE;
        }
        let [a, b, c] = mesh.triangle(f);
        let rows = (1..n).flat_map(|i| (1..n - i).map(move |j| (i, j)));
        rows.map(|(i, j)| at(a + (b - a) * ratio(i, n) + (c - a) * ratio(j, n)))
            .fold(Sums::NONE, Sums::and)
    };
    parallel::fold(topology.vertex_capacity(), Sums::NONE, of_vertex, Sums::and)
        .and(parallel::fold(topology.edge_capacity(), Sums::NONE, of_edge, Sums::and))
        .and(parallel::fold(topology.face_capacity(), Sums::NONE, of_face, Sums::and))
        .error()
}

fn ratio(i: u32, n: u32) -> f64 {
    f64::from(i) / f64::from(n)
}

#[derive(Clone, Copy)]
struct Sums {
    sum: f64,
    squares: f64,
    max: f64,
    points: u64,
}

impl Sums {
    const NONE: Self = Self { sum: 0.0, squares: 0.0, max: 0.0, points: 0 };

    fn of(distance: f64) -> Self {
        Self { sum: distance, squares: distance * distance, max: distance, points: 1 }
    }

    fn and(self, other: Self) -> Self {
        Self {
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            max: self.max.max(other.max),
            points: self.points + other.points,
        }
    }

    fn error(self) -> LatticeError {
        let count = self.points.max(1) as f64;
        let (mean, rms) = (self.sum / count, (self.squares / count).sqrt());
        LatticeError { mean, rms, max: self.max, points: self.points }
    }
}
