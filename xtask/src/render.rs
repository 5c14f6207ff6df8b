//! Pictures of meshes without a display or a graphics card.
//!
//! Orthographic, depth-buffered, lit from beside the camera, drawn larger and averaged down so that
//! edges are smooth. The same [`View`] of two meshes shows them at the same scale.

use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use euc::{Interpolate, Pipeline, Target};
use glam::DVec3;
use image::RgbImage;
use mesh_core::{BoundingBox, TriMesh, VertexMap};

use crate::texture::{NO_IMAGE, Skin, Texture};

/// Samples per pixel and direction.
const OVERSAMPLING: usize = 3;
/// Where triangles have no colour of their own.
const CLAY: [f32; 3] = [0.78, 0.78, 0.76];
const BACKGROUND: [f32; 3] = [1.0, 1.0, 1.0];
const EDGE: [f32; 3] = [0.12, 0.12, 0.14];

/// Where the camera is and what it frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// From the model to the camera.
    pub(crate) toward: DVec3,
    /// What is up in the picture; need not be at right angles to `toward`.
    pub(crate) up: DVec3,
    /// What has to fit into the picture.
    pub(crate) bounds: BoundingBox,
}

/// How a mesh is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Style {
    /// Width and height of the picture in pixels.
    pub(crate) size: [u32; 2],
    /// One normal per vertex instead of one per face.
    pub(crate) smooth: bool,
    /// Width of the drawn edges in pixels; 0 draws none.
    pub(crate) edge_width: f64,
}

impl Default for Style {
    fn default() -> Self {
        Self { size: [900, 900], smooth: false, edge_width: 0.0 }
    }
}

/// Draws a mesh; vertices without a colour map are light grey.
pub(crate) fn render(
    mesh: &TriMesh,
    colors: Option<&VertexMap<[u8; 3]>>,
    view: &View,
    style: &Style,
) -> RgbImage {
    render_textured(mesh, colors, None, view, style)
}

/// As [`render`], with the faces painted; the mesh must have no gaps.
pub(crate) fn render_textured(
    mesh: &TriMesh,
    colors: Option<&VertexMap<[u8; 3]>>,
    texture: Option<&Texture>,
    view: &View,
    style: &Style,
) -> RgbImage {
    let [width, height] = style.size.map(|n| n as usize * OVERSAMPLING);
    let camera = Camera::new(view, [width, height]);
    let vertices = shaded_vertices(mesh, colors, texture, &camera, style);
    let mut color = Buffer2d::new([width, height], BACKGROUND);
    let mut depth = Buffer2d::new([width, height], f32::INFINITY);
    let line = (style.edge_width * OVERSAMPLING as f64 / 2.0) as f32;
    Shader { line, texture }.draw::<Triangles<'_, _, BackfaceCullingDisabled>, _>(
        &vertices,
        &mut color,
        Some(&mut depth),
    );
    average_down(&color, style.size)
}

/// Model coordinates to the unit cube of the rasteriser.
struct Camera {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
    center: DVec3,
    /// Half the visible width and height, and half the depth, in model units.
    half: DVec3,
    /// Pixels per model unit.
    resolution: f64,
}

impl Camera {
    fn new(view: &View, [width, height]: [usize; 2]) -> Self {
        let toward = view.toward.normalize_or(DVec3::Z);
        let right = view.up.cross(toward).normalize_or(toward.any_orthonormal_vector());
        let up = toward.cross(right);
        let extent = view.bounds.extent();
        let reach = |axis: DVec3| 0.5 * axis.abs().dot(extent);
        let margin = 1.04;
        let aspect = width as f64 / height as f64;
        let half_height = (margin * reach(up).max(reach(right) / aspect)).max(f64::MIN_POSITIVE);
        let half_depth = (margin * reach(toward)).max(f64::MIN_POSITIVE);
        Self {
            right,
            up,
            toward,
            center: view.bounds.center(),
            half: DVec3::new(half_height * aspect, half_height, half_depth),
            resolution: height as f64 / (2.0 * half_height),
        }
    }

    /// The point in the unit cube; smaller depth is nearer.
    fn project(&self, point: DVec3) -> [f32; 4] {
        let p = point - self.center;
        let q = DVec3::new(p.dot(self.right), p.dot(self.up), -p.dot(self.toward)) / self.half;
        [q.x as f32, q.y as f32, q.z as f32, 1.0]
    }

    /// How bright a surface with this normal is: light from the camera's upper left, a weaker one
    /// from the right, and both sides of the surface lit alike.
    fn brightness(&self, normal: DVec3) -> f32 {
        let n = if normal.dot(self.toward) < 0.0 { -normal } else { normal };
        let key = (self.toward + 0.6 * self.up - 0.7 * self.right).normalize_or(self.toward);
        let fill = (self.toward + 0.9 * self.right).normalize_or(self.toward);
        (0.22 + 0.62 * n.dot(key).max(0.0) + 0.22 * n.dot(fill).max(0.0)) as f32
    }
}

/// What the rasteriser interpolates: a lit colour, what to multiply it with, and the distances in
/// samples to the three edges.
#[derive(Clone, Copy)]
struct Surface {
    color: [f32; 3],
    image: f32,
    uv: [f32; 2],
    to_edges: [f32; 3],
}

impl Interpolate for Surface {
    fn lerp2(a: Self, b: Self, x: f32, y: f32) -> Self {
        Self::lerp3(a, b, b, x, y, 0.0)
    }

    fn lerp3(a: Self, b: Self, c: Self, x: f32, y: f32, z: f32) -> Self {
        fn mix<const N: usize>(values: [[f32; N]; 3], [x, y, z]: [f32; 3]) -> [f32; N] {
            core::array::from_fn(|i| values[0][i] * x + values[1][i] * y + values[2][i] * z)
        }
        let weights = [x, y, z];
        Self {
            color: mix([a.color, b.color, c.color], weights),
            // The same at the three corners.
            image: a.image,
            uv: mix([a.uv, b.uv, c.uv], weights),
            to_edges: mix([a.to_edges, b.to_edges, c.to_edges], weights),
        }
    }
}

struct Shader<'a> {
    /// Half the width of an edge, in samples.
    line: f32,
    texture: Option<&'a Texture>,
}

impl Pipeline for Shader<'_> {
    type Vertex = ([f32; 4], Surface);
    type VsOut = Surface;
    type Pixel = [f32; 3];

    fn vert(&self, vertex: &Self::Vertex) -> ([f32; 4], Surface) {
        *vertex
    }

    fn frag(&self, surface: &Surface) -> [f32; 3] {
        let nearest = surface.to_edges.into_iter().fold(f32::INFINITY, f32::min);
        match self.texture {
            _ if nearest < self.line => EDGE,
            Some(texture) if surface.image >= 0.0 => {
                let texel = texture.sample(surface.image, surface.uv);
                core::array::from_fn(|i| surface.color[i] * texel[i])
            }
            _ => surface.color,
        }
    }
}

/// Three lit vertices for every face that is visible at all.
fn shaded_vertices(
    mesh: &TriMesh,
    colors: Option<&VertexMap<[u8; 3]>>,
    texture: Option<&Texture>,
    camera: &Camera,
    style: &Style,
) -> Vec<([f32; 4], Surface)> {
    let topology = mesh.topology();
    let vertex_normals = style.smooth.then(|| mesh.vertex_normals());
    let mut vertices = Vec::with_capacity(3 * topology.face_count());
    for face in topology.faces() {
        let corners = topology.face_vertices(face);
        let points = corners.map(|v| mesh.position(v));
        let projected = points.map(|p| camera.project(p));
        if !covers_samples(projected) {
            continue;
        }
        let heights = sample_heights(points, camera);
        let face_normal = mesh.face_normal(face);
        let bare = Skin { color: CLAY, image: NO_IMAGE, uvs: [[0.0; 2]; 3] };
        let skin = texture.map_or(bare, |texture| texture.skin(face.index()));
        for corner in 0..3 {
            let normal =
                vertex_normals.as_ref().map_or(face_normal, |normals| normals[corners[corner]]);
            let light = camera.brightness(normal);
            let base =
                colors.map_or(skin.color, |map| map[corners[corner]].map(|c| f32::from(c) / 255.0));
            let mut to_edges = [0.0; 3];
            to_edges[corner] = heights[corner];
            let color = base.map(|c| c * light);
            let Skin { image, uvs, .. } = skin;
            let surface = Surface { color, image, uv: uvs[corner], to_edges };
            vertices.push((projected[corner], surface));
        }
    }
    vertices
}

/// Whether the projected triangle has an area: one seen edge-on would divide by zero.
fn covers_samples([a, b, c]: [[f32; 4]; 3]) -> bool {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() > 1e-12
}

/// The height of the projected triangle over the edge opposite to each corner, in samples.
fn sample_heights(points: [DVec3; 3], camera: &Camera) -> [f32; 3] {
    let flat = points.map(|p| {
        let p = p - camera.center;
        DVec3::new(p.dot(camera.right), p.dot(camera.up), 0.0) * camera.resolution
    });
    let twice_area = (flat[1] - flat[0]).cross(flat[2] - flat[0]).length();
    core::array::from_fn(|i| {
        let base = flat[(i + 1) % 3].distance(flat[(i + 2) % 3]);
        (twice_area / base.max(f64::MIN_POSITIVE)) as f32
    })
}

fn average_down(samples: &Buffer2d<[f32; 3]>, [width, height]: [u32; 2]) -> RgbImage {
    let rows: &[[f32; 3]] = samples.as_ref();
    let stride = samples.size()[0];
    RgbImage::from_fn(width, height, |x, y| {
        let mut total = [0.0; 3];
        for row in 0..OVERSAMPLING {
            let start = (y as usize * OVERSAMPLING + row) * stride + x as usize * OVERSAMPLING;
            for sample in &rows[start..start + OVERSAMPLING] {
                for (sum, value) in total.iter_mut().zip(sample) {
                    *sum += value;
                }
            }
        }
        let count = (OVERSAMPLING * OVERSAMPLING) as f32;
        image::Rgb(total.map(|sum| (255.0 * (sum / count).clamp(0.0, 1.0)).round() as u8))
    })
}
