//! What keeps collapses within a distance of the original.
//!
//! Every triangle of the original belongs to the faces of the mesh that cover it: divided into parts if
//! need be, all corners of each part are close enough to one of them. The distance from a triangle is
//! a convex function, so that then no point of the part is farther away than its corners. A collapse
//! is allowed when the triangles that belong to the faces it changes are covered again, and when
//! these faces, at all their points, are close enough to the original.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, parallel};
use mesh_metric::{CertifyOptions, Surface, SurfaceError, closest_on_triangle, one_sided_bounds};

use crate::collapse::patch::{Collapse, EdgePatch, Place};
use crate::collapse::placement::{Optimal, Placement};
use crate::collapse::policy::{Policy, Scratch};
use crate::collapse::quadric::Quadric;
use crate::collapse::refusal::Refusal;
use crate::limit::covers::Covers;

/// The triangles of the original and the faces to which they belong.
pub(crate) struct Tether<'a> {
    original: &'a Surface,
    limit: f64,
    covers: Covers,
    /// The triangles of the patch that is about to be collapsed.
    loose: Vec<u32>,
}

/// The pieces of faces to look at before a collapse counts as too far.
const MAX_PIECES: usize = 3000;

/// How often a triangle is cut into four before the corners of its parts alone tell.
const DEPTH: usize = 4;

type Triangle = [DVec3; 3];

impl<'a> Tether<'a> {
    pub(crate) fn new(
        mesh: &TriMesh,
        original: &'a Surface,
        limit: f64,
    ) -> Result<Self, SurfaceError> {
        let surface = Surface::new(mesh)?;
        let squared = limit * limit;
        let found = parallel::collect_with(
            original.triangle_count(),
            || (),
            |(), t| {
                let mut faces = Vec::new();
                find_covers(&surface, &original.triangle(t), squared, DEPTH, &mut faces);
                faces.sort_unstable();
                faces.dedup();
                faces
            },
        );
        let mut covers = Covers::new(mesh.topology().face_capacity(), original.triangle_count());
        for (triangle, faces) in (0..).zip(found) {
            faces.into_iter().for_each(|face| covers.add(triangle, face));
        }
        Ok(Self { original, limit, covers, loose: Vec::new() })
    }

    /// Whether the triangles of the patch are covered when the edge is collapsed to `x`, relative to
    /// its midpoint.
    fn holds(&self, patch: &EdgePatch<'_>, x: DVec3) -> bool {
        // Most places that do not hold are too far themselves.
        if self.original.distance(patch.origin() + x) > self.limit {
            return false;
        }
        let around: Vec<FaceId> = faces_of(patch).collect();
        let remaining = patch.remaining_faces().iter();
        let new: Vec<Triangle> = remaining
            .map(|face| [x, face.corners[1], face.corners[2]].map(|p| patch.origin() + p))
            .collect();
        let mut candidates = new.clone();
        let mut last = 0;
        for triangle in self.triangles_of(around.iter().copied()) {
            candidates.truncate(new.len());
            let others = self.covers.of_triangle(triangle).filter(|face| !around.contains(face));
            candidates.extend(others.map(|face| patch.mesh().triangle(face)));
            let corners = self.original.triangle(triangle as usize);
            if !is_covered(&corners, &candidates, self.limit * self.limit, DEPTH, &mut last) {
                return false;
            }
        }
        true
    }

    /// The triangles that belong to some faces, each once.
    fn triangles_of(&self, faces: impl Iterator<Item = FaceId>) -> Vec<u32> {
        let mut all: Vec<u32> = faces.flat_map(|face| self.covers.of_face(face)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether no point of the faces that remain is beyond the limit.
    fn is_proved(&self, patch: &EdgePatch<'_>, x: DVec3) -> bool {
        let mut places = vec![patch.origin() + x];
        let mut triangles = Vec::new();
        for face in patch.remaining_faces() {
            let [_, a, b] = face.corners.map(|corner| patch.origin() + corner);
            places.extend([a, b]);
            let last = places.len() as u32 - 1;
            triangles.push([0, last - 1, last]);
        }
        let Ok(surface) = Surface::from_triangles(&places, &triangles) else { return false };
        let options = CertifyOptions {
            limit: Some(self.limit),
            max_pieces: MAX_PIECES,
            ..CertifyOptions::default()
        };
        one_sided_bounds(&surface, self.original, &options).upper <= self.limit
    }
}

/// The faces of a patch before the collapse.
fn faces_of<'p>(patch: &EdgePatch<'p>) -> impl Iterator<Item = FaceId> + 'p {
    let topology = patch.mesh().topology();
    patch.faces().iter().filter_map(|face| topology.face(face.side))
}

fn is_within(point: DVec3, triangle: &Triangle, squared: f64) -> bool {
    closest_on_triangle(point, triangle).length_squared() <= squared
}

/// The four parts of a triangle.
fn parts([a, b, c]: &Triangle) -> [Triangle; 4] {
    let middle = |p: &DVec3, q: &DVec3| *p + 0.5 * (*q - *p);
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
}

/// Whether each part of a piece is within a distance of one of some triangles; parts that cannot be
/// divided any more when their corners are. `last` is the triangle to try first.
fn is_covered(
    piece: &Triangle,
    triangles: &[Triangle],
    squared: f64,
    depth: usize,
    last: &mut usize,
) -> bool {
    let mut reached = [false; 3];
    let first = (*last).min(triangles.len().saturating_sub(1));
    for i in core::iter::once(first).chain((0..triangles.len()).filter(|&i| i != first)) {
        let Some(triangle) = triangles.get(i) else { return false };
        // The corners in turn, until one is too far.
        let close = piece.iter().take_while(|&&p| is_within(p, triangle, squared)).count();
        reached[..close].fill(true);
        if close == 3 {
            *last = i;
            return true;
        }
    }
    let is_close = |p: DVec3| triangles.iter().any(|triangle| is_within(p, triangle, squared));
    piece.iter().zip(reached).all(|(&p, reached)| reached || is_close(p))
        && (depth == 0
            || parts(piece)
                .iter()
                .all(|part| is_covered(part, triangles, squared, depth - 1, last)))
}

/// As above, with all triangles of a surface; adds those that are needed. What is beyond the distance
/// belongs to the closest.
fn find_covers(
    surface: &Surface,
    piece: &Triangle,
    squared: f64,
    depth: usize,
    faces: &mut Vec<FaceId>,
) {
    let closest = piece.map(|corner| surface.closest(corner));
    let covers = |triangle: u32| {
        let triangle = surface.triangle(triangle as usize);
        piece.iter().all(|&p| is_within(p, &triangle, squared))
    };
    match closest.iter().find(|closest| covers(closest.triangle)) {
        Some(found) => faces.push(found.face),
        None if depth == 0 => faces.extend(closest.map(|closest| closest.face)),
        None => {
            for part in parts(piece) {
                find_covers(surface, &part, squared, depth - 1, faces);
            }
        }
    }
}

impl Policy for Tether<'_> {
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let around: Vec<FaceId> = mesh.topology().faces_of_vertex(collapse.kept).collect();
        let new: Vec<Triangle> = around.iter().map(|&face| mesh.triangle(face)).collect();
        let squared = self.limit * self.limit;
        let mut used = Vec::new();
        for &triangle in &self.loose {
            let others: Vec<FaceId> = self.covers.of_triangle(triangle).collect();
            let outside: Vec<Triangle> = others.iter().map(|&face| mesh.triangle(face)).collect();
            used.clear();
            let corners = self.original.triangle(triangle as usize);
            list_covers(&corners, [&new, &outside], squared, DEPTH, &mut used);
            used.sort_unstable();
            used.dedup();
            for &i in &used {
                if let Some(&face) = around.get(i) {
                    self.covers.add(triangle, face);
                }
            }
        }
    }
}

/// Adds the numbers of the triangles of the first list that cover a piece, as in [`is_covered`].
fn list_covers(
    piece: &Triangle,
    [new, outside]: [&[Triangle]; 2],
    squared: f64,
    depth: usize,
    used: &mut Vec<usize>,
) {
    let covers = |t: &Triangle| piece.iter().all(|&p| is_within(p, t, squared));
    let known = used.iter().copied().find(|&i| covers(&new[i]));
    if known.is_some() || outside.iter().any(covers) {
        return;
    }
    if let Some(i) = new.iter().position(covers) {
        used.push(i);
    } else if depth == 0 {
        used.extend(
            (0..new.len()).filter(|&i| piece.iter().any(|&p| is_within(p, &new[i], squared))),
        );
    } else {
        for part in parts(piece) {
            list_covers(&part, [new, outside], squared, depth - 1, used);
        }
    }
}

impl Placement for Tether<'_> {
    /// The best by the quadric.
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        Optimal { keep_volume: true }.place(patch, quadric, cost)
    }

    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Refusal> {
        let is_tied = self.holds(patch, x) && self.is_proved(patch, x);
        if is_tied { Ok(()) } else { Err(Refusal::Distance) }
    }

    /// Where the best place does not hold, the ends.
    fn instead(&self, refused: usize) -> Option<Place> {
        [Place::Kept, Place::Removed].get(refused).copied()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) {
        self.loose = self.triangles_of(faces_of(patch));
        for face in faces_of(patch) {
            self.covers.clear(face);
        }
    }
}
