//! Ambient occlusion: cavities and creases are darker, because less light from around gets there.
//!
//! It is found in the picture, from the depths of its pixels. At a pixel, the horizon in a direction is the highest
//! elevation of the surface seen there. The elevations of the horizons in two opposite directions cancel on a plane,
//! however tilted; in a cavity, their sum is the part of the half circle that is hidden. The mean over several pairs of
//! directions is the occlusion. Source: Bavoil, Sainz, Dimitrov 2008, Image-space horizon-based ambient occlusion; there
//! the tangent plane takes the place of the opposite direction.

use core::f32::consts::FRAC_1_PI;

use mesh_core::parallel;

use crate::raster::{Canvas, Triangle, depths};

/// Steps to neighbours in eight directions, about evenly around half a circle. With whole steps, all pixels of a direction
/// and of the opposite one lie on one line, and a plane hides nothing.
const DIRECTIONS: [[i16; 2]; 8] =
    [[1, 0], [2, 1], [1, 1], [1, 2], [0, 1], [-1, 2], [-1, 1], [-2, 1]];

/// The most pixels that are compared in each direction.
const STEPS: u16 = 8;

/// How far they are, as a share of the shorter side of the picture.
const REACH: f32 = 0.06;

/// Half of the half circle hidden is as dark as it gets.
const DARKEST: f32 = 2.0;

/// Darkens the pixels of a picture of the triangles. `scale` is the length of a unit of depth, in samples.
pub(crate) fn darken(
    pixels: &mut [[u8; 4]],
    canvas: &Canvas<'_>,
    triangles: &[Triangle],
    scale: f64,
    strength: f64,
) {
    let scale = (scale / f64::from(canvas.supersampling)) as f32;
    let depth: Vec<f32> =
        depths(canvas, triangles).into_iter().map(|depth| depth * scale).collect();
    let width = canvas.size[0] as usize;
    let steps = steps(REACH * canvas.size[0].min(canvas.size[1]) as f32);
    let rows = parallel::collect_each(depth.len() / width, |row| {
        (0..width)
            .map(|column| occlusion(&depth, width, [column, row], &steps))
            .collect::<Vec<f32>>()
    });
    for (pixel, occlusion) in pixels.iter_mut().zip(rows.into_iter().flatten()) {
        let light = 1.0 - strength as f32 * (DARKEST * occlusion).min(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
        let darker = |c: u8| (f32::from(c) * light).round().clamp(0.0, 255.0) as u8;
        let [r, g, b, alpha] = *pixel;
        *pixel = [darker(r), darker(g), darker(b), alpha];
    }
}

/// The columns and rows from a pixel to those compared in a direction, and their distance.
type Way = Vec<([i32; 2], f32)>;

/// The ways of each pair of directions, up to a distance in pixels. Near pixels are closer together.
fn steps(reach: f32) -> Vec<[Way; 2]> {
    let way = |[x, y]: [i16; 2], sign: i16| -> Way {
        let length = f32::from(x).hypot(f32::from(y));
        #[expect(clippy::cast_possible_truncation, reason = "within the picture")]
        let multiple = |i: u16| (reach / length * (f32::from(i) / f32::from(STEPS)).powi(2)) as i32;
        let mut multiples: Vec<i32> = (1..=STEPS).map(|i| multiple(i).max(i32::from(i))).collect();
        multiples.dedup();
        let step = |k: i32| [x, y].map(|part| k * i32::from(sign * part));
        multiples.into_iter().map(|k| (step(k), k as f32 * length)).collect()
    };
    DIRECTIONS.map(|direction| [way(direction, 1), way(direction, -1)]).into()
}

/// The part of the light from around that is hidden at a pixel, from 0 to 1.
fn occlusion(depth: &[f32], width: usize, [column, row]: [usize; 2], steps: &[[Way; 2]]) -> f32 {
    let own = depth[row * width + column];
    if own == f32::INFINITY {
        return 0.0;
    }
    let height = depth.len() / width;
    // What is farther in front than the way is long hides nothing: it is another part in front of the surface.
    let slope = |&([x, y], length): &([i32; 2], f32)| {
        let [x, y] = [column.checked_add_signed(x as isize)?, row.checked_add_signed(y as isize)?];
        let other = (x < width && y < height).then(|| depth[y * width + x])?;
        let rise = own - other;
        (other < f32::INFINITY && rise <= 4.0 * length).then_some(rise / length)
    };
    let horizon = |way: &Way| way.iter().filter_map(slope).reduce(f32::max).map(f32::atan);
    let hidden = |[there, back]: &[Way; 2]| match (horizon(there), horizon(back)) {
        (Some(there), Some(back)) => (there + back).max(0.0) * FRAC_1_PI,
        _ => 0.0,
    };
    steps.iter().map(hidden).sum::<f32>() / DIRECTIONS.len() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The occlusion in the middle of a surface whose height is a function of the place.
    fn at_middle(height: impl Fn(f32, f32) -> f32) -> f32 {
        let place = |i: usize| i as f32 - 50.0;
        let depth: Vec<f32> =
            (0..101 * 101).map(|i| -height(place(i % 101), place(i / 101))).collect();
        occlusion(&depth, 101, [50, 50], &steps(20.0))
    }

    #[test]
    fn planes_are_bright_and_cavities_dark() {
        for tilt in [0.0, 0.5, 3.0] {
            assert!(at_middle(|x, y| tilt * x - 0.3 * y).abs() < 1e-4, "{tilt}");
        }
        // A ridge hides nothing. A valley whose sides rise by 45 degrees hides half of the half circle across it.
        assert!(at_middle(|x, _| -x.abs()) < 1e-4);
        let valley = at_middle(|x, _| x.abs());
        let across = |[x, y]: [i16; 2]| {
            let slope = f32::from(x.abs()) / f32::from(x).hypot(f32::from(y));
            2.0 * slope.atan() * FRAC_1_PI
        };
        let expected = DIRECTIONS.map(across).iter().sum::<f32>() / DIRECTIONS.len() as f32;
        assert!((valley - expected).abs() < 0.02, "{valley} {expected}");
        assert!(at_middle(|x, y| 2.0 * x.hypot(y)) > valley);
    }

    #[test]
    fn nothing_beside_or_far_in_front_is_no_cavity() {
        let behind = f32::NEG_INFINITY;
        assert_eq!(at_middle(|x, _| if x.abs() > 2.0 { behind } else { 0.0 }), 0.0);
        assert!(at_middle(|x, _| if x > 2.0 { 1000.0 } else { 0.0 }) < 1e-6);
    }
}
