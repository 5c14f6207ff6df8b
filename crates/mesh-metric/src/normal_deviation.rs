//! How far the normals of two surfaces are apart.

use glam::DVec3;
use mesh_core::{parallel, triangle_normal};

use crate::frame::Frame;
use crate::sampling::sample_surface;
use crate::surface::Surface;

/// The mean angle between the normals of two surfaces, in radians from 0 to pi: at `samples` points of each surface,
/// uniform by area, between the normal of its triangle and the normal of the closest triangle of the other surface.
/// The mean of both directions; pointwise, without unit. NaN if a surface has no area.
///
/// Surfaces whose faces are oriented in opposite ways are pi apart.
#[must_use]
pub fn normal_deviation(a: &Surface, b: &Surface, samples: usize, seed: u64) -> f64 {
    if let Some(frame) = Frame::of(a.bounding_box(), b.bounding_box())
        && let (Some(a), Some(b)) = (a.placed(frame), b.placed(frame))
    {
        return normal_deviation(&a, &b, samples, seed);
    }
    0.5 * (one_sided(a, b, samples, seed) + one_sided(b, a, samples, seed))
}

fn one_sided(from: &Surface, to: &Surface, samples: usize, seed: u64) -> f64 {
    let samples = sample_surface(from, samples, seed);
    let points: Vec<DVec3> = samples.iter().map(|sample| sample.position).collect();
    let closest = to.closest_points(&points);
    let angle = |i: usize| {
        let (sample, found) = (samples.get(i)?, closest.get(i)?);
        let [a, b] = [(from, sample.triangle), (to, found.triangle)]
            .map(|(surface, triangle)| triangle_normal(surface.triangle(triangle as usize)));
        // Precise for small angles, and zero for a triangle without a normal.
        Some(a.cross(b).length().atan2(a.dot(b)))
    };
    parallel::sum(samples.len(), |i| angle(i).unwrap_or(0.0)) / samples.len() as f64
}
