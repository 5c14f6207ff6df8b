//! Lines as thin rectangles that face the camera.

use glam::DVec3;

use crate::camera::Camera;
use crate::raster::{Cover, Triangle};
use crate::scene::Stroke;

/// Offset of lines towards the camera, as a share of the depth of the view: otherwise lines on a surface would be half
/// buried.
const LIFT: f64 = 0.004;

/// Appends a line through points, or a dot at a single one. Every piece is slightly extended, so that bends have no
/// gaps.
pub(crate) fn draw(
    line: &Stroke,
    samples_per_pixel: u32,
    camera: &Camera,
    triangles: &mut Vec<Triangle>,
) {
    let Stroke { points, color, width } = line;
    let half = 0.5 * width * f64::from(samples_per_pixel) / camera.resolution;
    let lift = camera.toward * (LIFT * camera.half_depth);
    let color = color.map(|c| f32::from(c) / 255.0);
    let mut piece = |from: DVec3, to: DVec3| {
        let flat = to - from;
        let along = (flat - camera.toward * flat.dot(camera.toward)).normalize_or(camera.right);
        let across = half * camera.toward.cross(along);
        let [p, q] = [from + lift - half * along, to + lift + half * along];
        for corners in [[p - across, q - across, q + across], [p - across, q + across, p + across]]
        {
            triangles.push(Triangle {
                at: corners.map(|p| camera.project(p).map(|x| x as f32)),
                color: [color; 3],
                cover: Cover::Blended,
                heights: [f32::INFINITY; 3],
            });
        }
    };
    match points[..] {
        [point] => piece(point, point),
        _ => points.windows(2).for_each(|pair| piece(pair[0], pair[1])),
    }
}
