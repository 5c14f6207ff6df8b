//! Renders a mesh to a picture.

use mesh_core::VertexMap;

use crate::camera::{Camera, View};
use crate::error::RenderError;
use crate::picture::Picture;
use crate::raster::{Canvas, Cover, Triangle, rasterize};
use crate::scene::{Paint, Scene, Stroke, Style};
use crate::{occlusion, silhouette, stroke};

/// The colour of triangles without a colour.
const CLAY: [f32; 3] = [0.78, 0.78, 0.76];
const OUTLINE: [u8; 3] = [24, 24, 28];

/// Draws a mesh and the lines on it.
///
/// # Errors
/// The size, a width or the number of samples is out of range, or a map has too few entries.
pub fn render(scene: &Scene<'_>, view: &View, style: &Style) -> Result<Picture, RenderError> {
    scene.check()?;
    style.check()?;
    let camera = camera(view, style);
    let normals = style.smooth.then(|| scene.mesh.vertex_normals());
    let mut triangles = shaded(scene, &camera, normals.as_ref(), style.edge_width > 0.0);
    for line in lines(scene, style, &camera, normals.as_ref()) {
        stroke::draw(&line, style.supersampling, &camera, &mut triangles);
    }
    let canvas = canvas(scene, style);
    let mut pixels = rasterize(&canvas, &triangles);
    if style.occlusion > 0.0 {
        let scale = camera.half_depth * camera.resolution;
        occlusion::darken(&mut pixels, &canvas, &triangles, scale, style.occlusion);
    }
    Ok(Picture::from_pixels(style.size, pixels))
}

/// The camera of a picture in this style.
pub(crate) fn camera(view: &View, style: &Style) -> Camera {
    Camera::new(view, style.size.map(|n| n * style.supersampling), style.margin)
}

/// The canvas of a picture in this style.
pub(crate) fn canvas<'s>(scene: &Scene<'s>, style: &Style) -> Canvas<'s> {
    Canvas {
        size: style.size,
        supersampling: style.supersampling,
        line: (0.5 * style.edge_width * f64::from(style.supersampling)) as f32,
        texture: match scene.paint {
            Paint::Texture(texture) => Some(texture),
            _ => None,
        },
        background: style.background,
    }
}

/// The lines of the caller and the outlines.
pub(crate) fn lines(
    scene: &Scene<'_>,
    style: &Style,
    camera: &Camera,
    normals: Option<&VertexMap<glam::DVec3>>,
) -> Vec<Stroke> {
    let mut lines = scene.strokes.to_vec();
    if style.silhouette_width > 0.0 {
        let outline = silhouette::outline(scene.mesh, camera.toward, normals, style.crease);
        let line = |piece: [glam::DVec3; 2]| Stroke {
            points: piece.to_vec(),
            color: OUTLINE,
            width: style.silhouette_width,
        };
        lines.extend(outline.into_iter().map(line));
    }
    lines
}

/// The lit faces of the mesh.
pub(crate) fn shaded(
    scene: &Scene<'_>,
    camera: &Camera,
    normals: Option<&VertexMap<glam::DVec3>>,
    edges: bool,
) -> Vec<Triangle> {
    let Scene { mesh, paint, edged, .. } = scene;
    let topology = mesh.topology();
    let unit = |color: [u8; 3]| color.map(|c| f32::from(c) / 255.0);
    let mut triangles = Vec::with_capacity(topology.face_count());
    for face in topology.faces() {
        let corners = topology.face_vertices(face);
        let projected = corners.map(|v| camera.project(mesh.position(v)));
        let face_normal = mesh.face_normal(face);
        let light =
            corners.map(|v| camera.brightness(normals.map_or(face_normal, |normals| normals[v])));
        let mut cover = Cover::Blended;
        let base = match paint {
            Paint::Clay => [CLAY; 3],
            Paint::Vertices(colors) => corners.map(|v| unit(colors[v])),
            Paint::Labels(colors) => {
                cover = Cover::Nearest(light);
                corners.map(|v| unit(colors[v]))
            }
            Paint::Faces(colors) => [unit(colors[face]); 3],
            Paint::Texture(texture) => {
                let skin = texture.skin(face.index());
                cover = skin.image.map_or(cover, |image| Cover::Picture(image, skin.uvs));
                [skin.color; 3]
            }
        };
        let color = match cover {
            Cover::Nearest(_) => base,
            _ => core::array::from_fn(|i| base[i].map(|c| c * light[i])),
        };
        let is_edged = edges && edged.is_none_or(|edged| edged[face]);
        let heights = if is_edged { heights(projected) } else { [f32::INFINITY; 3] };
        let at = projected.map(|p| p.map(|x| x as f32));
        triangles.push(Triangle { at, color, cover, heights });
    }
    triangles
}

/// The height of the projected triangle over the edge opposite to each corner.
fn heights(points: [[f64; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = points.map(|[x, y, _]| glam::DVec2::new(x, y));
    let double_area = (b - a).perp_dot(c - a).abs();
    [b.distance(c), c.distance(a), a.distance(b)]
        .map(|base| (double_area / base.max(f64::MIN_POSITIVE)) as f32)
}
