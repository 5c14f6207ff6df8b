//! Patches, sections and frames drawn on a mesh.

use core::f64::consts::TAU;

use curvpatch::{Cover, Patch};
use glam::DVec3;
use mesh_core::{FaceId, FaceMap, TriMesh, VertexMap};

use super::super::item::Figure;
use super::super::run::{Picture, Run};
use mesh_render::{Paint, Scene, Stroke, Style, View};
use xtask_common::Failure;

/// A mesh and what lies on it, put together for one picture.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawing {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    colors: Vec<[u8; 3]>,
    edged: Vec<bool>,
    strokes: Vec<Stroke>,
}

pub(super) const CLAY: [u8; 3] = [228, 226, 220];
pub(super) const ORANGE: [u8; 3] = [240, 150, 60];
pub(super) const BLUE: [u8; 3] = [90, 150, 220];
pub(super) const GREEN: [u8; 3] = [60, 160, 90];
/// Faces that no patch covers.
pub(super) const RESIDUAL: [u8; 3] = [196, 38, 46];
pub(super) const DARK: [u8; 3] = [30, 30, 36];
pub(super) const RED_LINE: [u8; 3] = [200, 30, 40];
pub(super) const BLUE_LINE: [u8; 3] = [25, 80, 190];

/// Pieces of a drawn curve.
const PIECES: u32 = 72;

impl Drawing {
    /// A mesh with its edges, some of its faces in another colour.
    pub(super) fn of(mesh: &TriMesh, marked: &[FaceId], color: [u8; 3]) -> Self {
        Self::part_of(mesh, marked, color, |_| true)
    }

    /// The same for those faces of the mesh that `keep` wants.
    pub(super) fn part_of(
        mesh: &TriMesh,
        marked: &[FaceId],
        color: [u8; 3],
        keep: impl Fn(FaceId) -> bool,
    ) -> Self {
        let mut is_marked = mesh.topology().face_map(false);
        for &face in marked {
            is_marked[face] = true;
        }
        let mut drawing = Self::default();
        for face in mesh.topology().faces().filter(|&face| keep(face)) {
            let color = if is_marked[face] { color } else { CLAY };
            drawing.triangle(mesh.triangle(face), color, true);
        }
        drawing
    }

    /// Each triangle has its own vertices, so that it has its own colour.
    fn triangle(&mut self, corners: [DVec3; 3], color: [u8; 3], edged: bool) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.colors.extend([color; 3]);
        self.triangles.push([first, first + 1, first + 2]);
        self.edged.push(edged);
    }

    /// A patch as a smooth surface with its rim and both principal arcs, lifted along its normal so
    /// that the mesh does not show through.
    pub(super) fn patch(
        &mut self,
        patch: &Patch,
        color: [u8; 3],
        lift: f64,
        width: f64,
    ) -> Result<(), Failure> {
        let up = lift * patch.frame()[2];
        let [l1, l2] = patch.arcs();
        let part = patch.tessellate(2e-4 * l1.max(l2)).map_err(Failure::mesh)?;
        for t in part.triangles {
            self.triangle(t.map(|v| part.positions[v as usize] + up), color, false);
        }
        self.line(rim(patch).map(|p| p + up).collect(), DARK, width);
        for (phi, color) in [(0.0, RED_LINE), (0.25 * TAU, BLUE_LINE)] {
            self.line(arc(patch, phi).map(|p| p + up).collect(), color, width);
        }
        Ok(())
    }

    pub(super) fn line(&mut self, points: Vec<DVec3>, color: [u8; 3], width: f64) {
        self.strokes.push(Stroke { points, color, width });
    }

    /// A round dot that faces the camera, a little in front of its place.
    pub(super) fn dot(&mut self, at: DVec3, radius: f64, toward: DVec3, color: [u8; 3]) {
        let toward = toward.normalize_or(DVec3::Z);
        let (right, up) = toward.any_orthonormal_pair();
        let center = at + radius * toward;
        let corner = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / 24.0).sin_cos();
            center + radius * (cos * right + sin * up)
        };
        for i in 0..24 {
            self.triangle([center, corner(i), corner(i + 1)], color, false);
        }
    }

    /// An arrow, its head spread across the direction to the camera.
    pub(super) fn arrow(&mut self, from: DVec3, vector: DVec3, toward: DVec3, color: [u8; 3]) {
        let tip = from + vector;
        let across = toward.cross(vector).normalize_or_zero() * (0.1 * vector.length());
        let back = tip - 0.22 * vector;
        self.line(vec![from, tip], color, 5.0);
        self.line(vec![back + across, tip, back - across], color, 5.0);
    }

    pub(super) fn draw(
        &self,
        run: &Run<'_>,
        view: &View,
        style: &Style,
        name: &str,
        caption: &str,
    ) -> Result<Figure, Failure> {
        let mesh =
            TriMesh::from_triangles(&self.positions, &self.triangles).map_err(Failure::mesh)?;
        let colors = VertexMap::from_vec(self.colors.clone());
        let edged = FaceMap::from_vec(self.edged.clone());
        let scene = Scene {
            mesh: &mesh,
            paint: Paint::Vertices(&colors),
            edged: Some(&edged),
            strokes: &self.strokes,
        };
        run.draw(&Picture { scene, view, style, name, caption })
    }
}

/// The boundary curve of a patch.
pub(super) fn rim(patch: &Patch) -> impl Iterator<Item = DVec3> + '_ {
    (0..=PIECES).map(|i| patch.point(1.0, TAU * f64::from(i) / f64::from(PIECES)))
}

/// The arc of a patch over a line through its centre.
pub(super) fn arc(patch: &Patch, phi: f64) -> impl Iterator<Item = DVec3> + '_ {
    (0..=PIECES).map(move |i| {
        let u = 2.0 * f64::from(i) / f64::from(PIECES) - 1.0;
        let phi = if u < 0.0 { phi + 0.5 * TAU } else { phi };
        patch.point(u.abs(), phi)
    })
}

/// The colour of a patch, paler than in files, and red for what no patch covers.
fn cover_color(patch: Option<u32>) -> [u8; 3] {
    let pale = |c: u8| ((u16::from(c) + 255) / 2) as u8;
    patch.map_or(RESIDUAL, |patch| curvpatch::patch_color(patch).map(pale))
}

/// A cover: the mesh in the colours of its patches, and the faces that none covers in red.
pub(super) fn cover(mesh: &TriMesh, cover: &Cover) -> Drawing {
    let mut drawing = Drawing::default();
    for face in mesh.topology().faces() {
        let color = cover_color(cover.patch_of_face[face]);
        drawing.triangle(mesh.triangle(face), color, true);
    }
    drawing
}

/// The patches of a cover themselves, and the faces that none covers as they are, in red.
pub(super) fn patches(mesh: &TriMesh, cover: &Cover) -> Result<Drawing, Failure> {
    let parts = cover.to_mesh(mesh, 0.05 * cover.tolerance).map_err(Failure::mesh)?;
    let mut drawing = Drawing::default();
    for (t, patch) in parts.triangles.iter().zip(&parts.patch_of_triangle) {
        let color = cover_color(*patch);
        drawing.triangle(t.map(|v| parts.positions[v as usize]), color, patch.is_none());
    }
    Ok(drawing)
}
