//! Angles between the normals of surfaces.
#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use mesh_metric::{Surface, normal_deviation};

fn square(tilt: f64, reversed: bool) -> Surface {
    let (sin, cos) = tilt.sin_cos();
    let points = [[0.0, 0.0, 0.0], [cos, 0.0, sin], [cos, 1.0, sin], [0.0, 1.0, 0.0]];
    let faces = if reversed { [[2, 1, 0], [3, 2, 0]] } else { [[0, 1, 2], [0, 2, 3]] };
    Surface::from_triangles(&points, &faces).unwrap()
}

#[test]
fn planes_are_as_far_apart_as_their_tilt() {
    for tilt in [0.0, 1e-8, 0.3, 1.2] {
        let found = normal_deviation(&square(0.0, false), &square(tilt, false), 1000, 1);
        assert!((found - tilt).abs() < 1e-12 + 1e-9 * tilt, "{tilt}: {found}");
    }
    let found = normal_deviation(&square(0.0, false), &square(0.0, true), 1000, 1);
    assert!((found - PI).abs() < 1e-12);
    let line = Surface::from_triangles(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]);
    assert!(normal_deviation(&line.unwrap(), &square(0.0, false), 1000, 1).is_nan());
}
