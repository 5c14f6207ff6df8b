//! Pictures of meshes without a display or a graphics card.
//!
//! Orthographic, depth-buffered, lit from beside the camera, drawn larger and averaged down so that
//! edges are smooth. The same [`View`] of two meshes shows them at the same scale.

use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use euc::{Interpolate, Pipeline, Target};
use glam::DVec3;
use image::RgbImage;
use mesh_core::{BoundingBox, FaceMap, TriMesh, VertexMap};

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
    /// What has to fit into it as seen from a direction, which is tighter; used if it is this one.
    pub(crate) frame: Option<Frame>,
}

/// The extent of a mesh as seen from a direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    toward: DVec3,
    up: DVec3,
    center: DVec3,
    /// Half the extent to the right, up, and towards the camera.
    half: DVec3,
}

/// Right, up and towards the camera, at right angles.
fn axes(toward: DVec3, up: DVec3) -> [DVec3; 3] {
    let toward = toward.normalize_or(DVec3::Z);
    let right = up.cross(toward).normalize_or(toward.any_orthonormal_vector());
    [right, toward.cross(right), toward]
}

impl View {
    /// A mesh from a direction, as large as fits; `None` if it has no faces.
    pub(crate) fn of(mesh: &TriMesh, toward: DVec3, up: DVec3) -> Option<Self> {
        let bounds = mesh.bounding_box()?;
        let axes = axes(toward, up);
        let seen = mesh.topology().vertices().map(|v| {
            let p = mesh.position(v) - bounds.center();
            DVec3::from_array(axes.map(|axis| axis.dot(p)))
        });
        let seen = BoundingBox::of_points(seen)?;
        let offset = seen.center();
        let center = bounds.center() + offset.x * axes[0] + offset.y * axes[1] + offset.z * axes[2];
        let frame = Frame { toward, up, center, half: 0.5 * seen.extent() };
        Some(Self { toward, up, bounds, frame: Some(frame) })
    }
}

/// A mesh and what is drawn on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) mesh: &'a TriMesh,
    /// Without, the mesh is light grey.
    pub(crate) colors: Option<&'a VertexMap<[u8; 3]>>,
    /// What the faces are painted with where there are no colours; the mesh must have no gaps.
    pub(crate) texture: Option<&'a Texture>,
    /// The faces whose edges are drawn; without, those of all faces.
    pub(crate) edged: Option<&'a FaceMap<bool>>,
    /// Lines on the surface or beside it; hidden where the surface is well in front.
    pub(crate) strokes: &'a [Stroke],
}

/// A line through points, or a dot at a single one.
#[derive(Clone, Debug)]
pub(crate) struct Stroke {
    pub(crate) points: Vec<DVec3>,
    pub(crate) color: [u8; 3],
    /// In pixels.
    pub(crate) width: f64,
}

impl<'a> Scene<'a> {
    /// The mesh alone.
    pub(crate) fn of(mesh: &'a TriMesh) -> Self {
        Self { mesh, colors: None, texture: None, edged: None, strokes: &[] }
    }
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

/// Draws a mesh and the lines on it.
pub(crate) fn render(scene: &Scene<'_>, view: &View, style: &Style) -> RgbImage {
    let [width, height] = style.size.map(|n| n as usize * OVERSAMPLING);
    let camera = Camera::new(view, [width, height]);
    let mut vertices = shaded_vertices(scene, &camera, style);
    vertices.extend(scene.strokes.iter().flat_map(|stroke| stroke_vertices(stroke, &camera)));
    let mut color = Buffer2d::new([width, height], BACKGROUND);
    let mut depth = Buffer2d::new([width, height], f32::INFINITY);
    let line = (style.edge_width * OVERSAMPLING as f64 / 2.0) as f32;
    Shader { line, texture: scene.texture }.draw::<Triangles<'_, _, BackfaceCullingDisabled>, _>(
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
        let [right, up, toward] = axes(view.toward, view.up);
        let (center, half) = match view.frame {
            Some(frame) if (frame.toward, frame.up) == (view.toward, view.up) => {
                (frame.center, frame.half)
            }
            _ => {
                let extent = view.bounds.extent();
                let reach = |axis: DVec3| 0.5 * axis.abs().dot(extent);
                (view.bounds.center(), DVec3::new(reach(right), reach(up), reach(toward)))
            }
        };
        let margin = 1.04;
        let aspect = width as f64 / height as f64;
        let half_height = (margin * half.y.max(half.x / aspect)).max(f64::MIN_POSITIVE);
        let half_depth = (margin * half.z).max(f64::MIN_POSITIVE);
        Self {
            right,
            up,
            toward,
            center,
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
fn shaded_vertices(scene: &Scene<'_>, camera: &Camera, style: &Style) -> Vec<([f32; 4], Surface)> {
    let Scene { mesh, colors, texture, edged, .. } = scene;
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
        let has_edges = edged.is_none_or(|edged| edged[face]);
        let bare = Skin { color: CLAY, image: NO_IMAGE, uvs: [[0.0; 2]; 3] };
        let skin = texture.map_or(bare, |texture| texture.skin(face.index()));
        for corner in 0..3 {
            let normal =
                vertex_normals.as_ref().map_or(face_normal, |normals| normals[corners[corner]]);
            let light = camera.brightness(normal);
            let base =
                colors.map_or(skin.color, |map| map[corners[corner]].map(|c| f32::from(c) / 255.0));
            let mut to_edges = if has_edges { [0.0; 3] } else { [f32::INFINITY; 3] };
            if has_edges {
                to_edges[corner] = heights[corner];
            }
            let color = base.map(|c| c * light);
            let Skin { image, uvs, .. } = skin;
            let surface = Surface { color, image, uv: uvs[corner], to_edges };
            vertices.push((projected[corner], surface));
        }
    }
    vertices
}

/// How far lines are drawn in front of where they are, as a share of the depth of the view: on a
/// surface they would be half buried.
const STROKE_LIFT: f64 = 0.004;

/// Every piece of a line as a thin rectangle that faces the camera, a little longer than the piece
/// so that bends have no gaps.
fn stroke_vertices(stroke: &Stroke, camera: &Camera) -> Vec<([f32; 4], Surface)> {
    let half = 0.5 * stroke.width * OVERSAMPLING as f64 / camera.resolution;
    let lift = camera.toward * (STROKE_LIFT * camera.half.z);
    let color = stroke.color.map(|c| f32::from(c) / 255.0);
    let to_edges = [f32::INFINITY; 3];
    let surface = Surface { color, image: NO_IMAGE, uv: [0.0; 2], to_edges };
    let single = [stroke.points[..].first(), stroke.points[..].first()];
    let pieces = match stroke.points.len() {
        1 => single.iter().flatten().map(|&&p| p).collect::<Vec<_>>(),
        _ => stroke.points.clone(),
    };
    let rectangle = |piece: &[DVec3]| {
        let flat = piece[1] - piece[0];
        let along = (flat - camera.toward * flat.dot(camera.toward)).normalize_or(camera.right);
        let across = half * camera.toward.cross(along);
        let [p, q] = [piece[0] + lift - half * along, piece[1] + lift + half * along];
        [p - across, q - across, q + across, p - across, q + across, p + across]
    };
    let corners = pieces.windows(2).flat_map(rectangle);
    corners.map(|p| (camera.project(p), surface)).collect()
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
