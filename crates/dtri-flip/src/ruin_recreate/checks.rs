//! Constraints on a rebuilt patch: the constraints on single flips, applied to the patch as a whole.

use mesh_core::{FaceId, TriMesh, VertexId};

use super::patch::Patch;
use crate::cost::FlipCost;
use crate::fold::largest_turn;
use crate::run::Run;
use crate::self_intersection::face_crosses;
use crate::shape::Defects;

/// State of a patch before the round, against which the result is checked.
pub(super) struct PatchChecks {
    /// Largest angle between a face and its quadrilateral, if turns are limited.
    turn: f64,
    degenerate_faces: usize,
    defects: Defects,
    volume: f64,
    /// The triangles of the patch, if new triangles must not cross others.
    triangles: Option<Vec<[VertexId; 3]>>,
}

impl PatchChecks {
    pub(super) fn new<C: FlipCost>(run: &Run<'_, C>, patch: &Patch) -> Self {
        let triangles = run.tree.is_some().then(|| {
            let mut triangles: Vec<_> = patch.faces.iter().map(|&f| sorted(run.mesh, f)).collect();
            triangles.sort_unstable();
            triangles
        });
        let is_limited = run.rules.max_turn().is_some();
        Self {
            turn: if is_limited { turn(run, patch) } else { 0.0 },
            degenerate_faces: degenerate_faces(run, patch),
            defects: defects(run, patch),
            volume: volume(run.mesh, patch),
            triangles,
        }
    }

    pub(super) fn volume_change<C: FlipCost>(&self, run: &Run<'_, C>, patch: &Patch) -> f64 {
        volume(run.mesh, patch) - self.volume
    }

    /// Whether the patch satisfies the constraints of single flips and a closed mesh keeps its
    /// orientation.
    pub(super) fn allow<C: FlipCost>(&self, run: &Run<'_, C>, patch: &Patch) -> bool {
        let limit = run.rules.max_turn();
        let turns_inside_out = patch
            .volume
            .is_some_and(|volume| volume > 0.0 && volume + self.volume_change(run, patch) <= 0.0);
        !turns_inside_out
            && degenerate_faces(run, patch) <= self.degenerate_faces
            && defects(run, patch).check_against(|| self.defects).is_ok()
            && limit.is_none_or(|limit| turn(run, patch) <= limit.max(self.turn))
            && !self.crosses(run, patch)
    }

    fn crosses<C: FlipCost>(&self, run: &Run<'_, C>, patch: &Patch) -> bool {
        let (Some(tree), Some(known)) = (&run.tree, &self.triangles) else { return false };
        let is_new = |f: FaceId| known.binary_search(&sorted(run.mesh, f)).is_err();
        patch.faces.iter().any(|&f| is_new(f) && face_crosses(tree, run.mesh, f))
    }
}

fn sorted(mesh: &TriMesh, face: FaceId) -> [VertexId; 3] {
    let mut corners = mesh.topology().face_vertices(face);
    corners.sort_unstable();
    corners
}

fn turn<C: FlipCost>(run: &Run<'_, C>, patch: &Patch) -> f64 {
    let quads = patch.edges.iter().filter_map(|&e| run.quad(e));
    quads.map(|quad| largest_turn(run.mesh, &quad)).fold(0.0, f64::max)
}

fn degenerate_faces<C: FlipCost>(run: &Run<'_, C>, patch: &Patch) -> usize {
    let corners = |&f: &FaceId| run.mesh.topology().face_vertices(f);
    patch.faces.iter().filter(|f| run.rules.is_degenerate(run.mesh, corners(f))).count()
}

fn defects<C: FlipCost>(run: &Run<'_, C>, patch: &Patch) -> Defects {
    let corners = |&f: &FaceId| run.mesh.topology().face_vertices(f);
    run.rules.shape.defects(run.mesh, patch.faces.iter().map(corners))
}

/// The volume between the patch and the origin.
fn volume(mesh: &TriMesh, patch: &Patch) -> f64 {
    let tetrahedron = |&face: &FaceId| {
        let [a, b, c] = mesh.triangle(face);
        a.dot(b.cross(c)) / 6.0
    };
    patch.faces.iter().map(tetrahedron).sum()
}
