//! Convex hull of points in space.
//!
//! Quickhull (Barber, Dobkin, Huhdanpaa 1996) with an exact orientation test. Every point not yet inside is assigned to
//! one face that it sees. The farthest point of a face is joined to the border of all faces it sees, and the points
//! assigned to these faces are assigned to the new faces. Rounding affects only the order of the points, never
//! convexity.

use glam::DVec3;
use mesh_core::as_u32;
use robust::{Coord3D, orient3d};

/// Why points have no convex hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HullError {
    /// Fewer than four points, or all of them in one plane.
    #[error("the {points} points lie in one plane; a convex hull needs four points that do not")]
    Flat {
        /// The number of points.
        points: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} has a coordinate that is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// More points than 32-bit indices can address.
    #[error("{points} points are more than 32-bit indices can address")]
    TooMany {
        /// The number of points.
        points: usize,
    },
}

/// The convex hull of `points` as triangles, counter-clockwise seen from outside.
///
/// Each triangle starts with its smallest index and the triangles are sorted, so the result does not depend on the
/// order of the work. Flat parts of the hull consist of several coplanar triangles. Points inside the hull, on a flat
/// part or equal to another may be left out. The result is exact if products of three coordinate differences neither
/// overflow nor underflow. Expected time n log n.
///
/// # Errors
/// [`HullError`] when all points lie in a plane, a coordinate is not finite, or there are too many points.
pub fn convex_hull(points: &[DVec3]) -> Result<Vec<[u32; 3]>, HullError> {
    if points.len() >= u32::MAX as usize / 6 {
        return Err(HullError::TooMany { points: points.len() });
    }
    if let Some(point) = points.iter().position(|point| !point.is_finite()) {
        return Err(HullError::NotFinite { point });
    }
    let mut hull = Hull::start(points)?;
    while let Some((face, apex)) = hull.next_point() {
        hull.add(face, apex);
    }
    Ok(hull.triangles())
}

/// A face of the hull so far.
struct Face {
    /// Corners, counter-clockwise seen from outside.
    corners: [u32; 3],
    /// The face across the side from corner i to corner i + 1.
    across: [u32; 3],
    /// Points not yet inside the hull that see this face; each point is assigned to one face only.
    waiting: Vec<u32>,
    /// Whether the face is still part of the hull.
    alive: bool,
}

struct Hull<'a> {
    points: &'a [DVec3],
    faces: Vec<Face>,
    /// Faces that may have assigned points.
    open: Vec<u32>,
    /// For a vertex of the current horizon, the new face that starts there.
    starting_at: Vec<u32>,
}

impl<'a> Hull<'a> {
    /// A tetrahedron, with all other points assigned to its faces.
    fn start(points: &'a [DVec3]) -> Result<Self, HullError> {
        let [a, b, c, d] = first_corners(points).ok_or(HullError::Flat { points: points.len() })?;
        let mut hull = Self {
            points,
            faces: Vec::with_capacity(6 * points.len()),
            open: Vec::new(),
            starting_at: vec![0; points.len()],
        };
        // Across the sides of (a, b, c) lie the faces that have them in opposite direction.
        hull.push([a, b, c], [1, 2, 3]);
        hull.push([b, a, d], [0, 3, 2]);
        hull.push([c, b, d], [0, 1, 3]);
        hull.push([a, c, d], [0, 2, 1]);
        hull.distribute(0..as_u32(points.len()), 0);
        Ok(hull)
    }

    fn push(&mut self, corners: [u32; 3], across: [u32; 3]) -> u32 {
        self.faces.push(Face { corners, across, waiting: Vec::new(), alive: true });
        as_u32(self.faces.len() - 1)
    }

    /// Six times the volume between face and point: positive exactly if the point sees the face.
    fn height(&self, face: u32, point: u32) -> f64 {
        let [a, b, c] = self.faces[face as usize].corners.map(|i| self.points[i as usize]);
        above(a, b, c, self.points[point as usize])
    }

    /// Assigns points to the first face from `first` on that they see, if any.
    fn distribute(&mut self, points: impl Iterator<Item = u32>, first: u32) {
        let end = as_u32(self.faces.len());
        for point in points {
            if let Some(face) = (first..end).find(|&face| self.height(face, point) > 0.0) {
                self.faces[face as usize].waiting.push(point);
            }
        }
        self.open.extend((first..end).filter(|&f| !self.faces[f as usize].waiting.is_empty()));
    }

    /// A face and the farthest point assigned to it.
    fn next_point(&mut self) -> Option<(u32, u32)> {
        while let Some(face) = self.open.pop() {
            if !self.faces[face as usize].alive {
                continue;
            }
            let waiting = self.faces[face as usize].waiting.iter();
            let heights = waiting.map(|&point| (self.height(face, point), point));
            if let Some((_, apex)) = heights.max_by(|a, b| a.0.total_cmp(&b.0)) {
                return Some((face, apex));
            }
        }
        None
    }

    /// Replaces all faces that `apex` sees, including `seen`, by the cone from their border to `apex`.
    fn add(&mut self, seen: u32, apex: u32) {
        let mut waiting = Vec::new();
        let mut horizon = Vec::new();
        let mut stack = vec![seen];
        self.faces[seen as usize].alive = false;
        while let Some(face) = stack.pop() {
            waiting.append(&mut self.faces[face as usize].waiting);
            let Face { corners, across, .. } = self.faces[face as usize];
            for side in 0..3 {
                let other = across[side];
                if !self.faces[other as usize].alive {
                    continue;
                }
                if self.height(other, apex) > 0.0 {
                    self.faces[other as usize].alive = false;
                    stack.push(other);
                } else {
                    horizon.push(([corners[side], corners[(side + 1) % 3]], other));
                }
            }
        }
        let first = as_u32(self.faces.len());
        for &([from, to], other) in &horizon {
            let face = self.push([from, to, apex], [other, 0, 0]);
            self.starting_at[from as usize] = face;
            let beyond = &mut self.faces[other as usize];
            for side in 0..3 {
                if beyond.corners[side] == to && beyond.corners[(side + 1) % 3] == from {
                    beyond.across[side] = face;
                }
            }
        }
        for face in first..as_u32(self.faces.len()) {
            let next = self.starting_at[self.faces[face as usize].corners[1] as usize];
            self.faces[face as usize].across[1] = next;
            self.faces[next as usize].across[2] = face;
        }
        self.distribute(waiting.into_iter().filter(|&point| point != apex), first);
    }

    fn triangles(self) -> Vec<[u32; 3]> {
        let alive = self.faces.iter().filter(|face| face.alive);
        let mut triangles: Vec<[u32; 3]> = alive.map(|face| smallest_first(face.corners)).collect();
        triangles.sort_unstable();
        triangles
    }
}

/// Four points not in a plane, the fourth behind the first three. Their distances are large by rounded measures, and
/// their orientation is exact.
fn first_corners(points: &[DVec3]) -> Option<[u32; 4]> {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        let measured = points.iter().enumerate().map(|(i, &p)| (measure(p), i));
        measured.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
    };
    let a = farthest(&|p| -p.x)?;
    let b = farthest(&|p| p.distance_squared(points[a]))?;
    let c = farthest(&|p| (points[b] - points[a]).cross(p - points[a]).length_squared())?;
    let height = |p| above(points[a], points[b], points[c], p);
    let d = farthest(&|p| height(p).abs())?;
    let [i, j, k, l] = [a, b, c, d].map(|index| as_u32(index));
    match height(points[d]) {
        h if h > 0.0 => Some([i, k, j, l]),
        h if h < 0.0 => Some([i, j, k, l]),
        _ => None,
    }
}

/// Positive exactly if `p` lies on the side of the plane from which a, b, c are counter-clockwise; zero exactly in the
/// plane.
fn above(a: DVec3, b: DVec3, c: DVec3, p: DVec3) -> f64 {
    let [a, b, c, p] = [a, b, c, p].map(|v| Coord3D { x: v.x, y: v.y, z: v.z });
    -orient3d(a, b, c, p)
}

fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
