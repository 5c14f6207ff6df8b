//! Renders a mesh to a picture.

use mesh_core::VertexMap;

use crate::camera::{Camera, View};
use crate::error::RenderError;
use crate::picture::Picture;
use crate::raster::{Canvas, Triangle, rasterize};
use crate::scene::{Paint, Scene, Style};
use crate::{silhouette, stroke};

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
    let samples = f64::from(style.supersampling);
    let camera = Camera::new(view, style.size.map(|n| n * style.supersampling), style.margin);
    let normals = style.smooth.then(|| scene.mesh.vertex_normals());
    let mut triangles = shaded(scene, &camera, normals.as_ref(), style.edge_width > 0.0);
    for line in scene.strokes {
        stroke::draw(&line.points, line.color, line.width * samples, &camera, &mut triangles);
    }
    if style.silhouette_width > 0.0 {
        let width = style.silhouette_width * samples;
        for piece in silhouette::outline(scene.mesh, camera.toward, normals.as_ref(), style.crease)
        {
            stroke::draw(&piece, OUTLINE, width, &camera, &mut triangles);
        }
    }
    let canvas = Canvas {
        size: style.size,
        supersampling: style.supersampling,
        line: (0.5 * style.edge_width * samples) as f32,
        texture: match scene.paint {
            Paint::Texture(texture) => Some(texture),
            _ => None,
        },
        background: style.background,
    };
    Ok(Picture::from_pixels(style.size, rasterize(&canvas, &triangles)))
}

/// The lit faces of the mesh.
fn shaded(
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
        let (mut image, mut uvs) = (None, [[0.0; 2]; 3]);
        let base = match paint {
            Paint::Clay => [CLAY; 3],
            Paint::Vertices(colors) => corners.map(|v| unit(colors[v])),
            Paint::Faces(colors) => [unit(colors[face]); 3],
            Paint::Texture(texture) => {
                let skin = texture.skin(face.index());
                (image, uvs) = (skin.image, skin.uvs);
                [skin.color; 3]
            }
        };
        let color = core::array::from_fn(|i| {
            let normal = normals.map_or(face_normal, |normals| normals[corners[i]]);
            let light = camera.brightness(normal);
            base[i].map(|c| c * light)
        });
        let is_edged = edges && edged.is_none_or(|edged| edged[face]);
        let heights = if is_edged { heights(projected) } else { [f32::INFINITY; 3] };
        let at = projected.map(|p| p.map(|x| x as f32));
        triangles.push(Triangle { at, color, image, uvs, heights });
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
