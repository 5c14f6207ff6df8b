//! Ridges: the vertices of an ellipsoid with the largest principal curvature, as line segments along the direction of
//! the smaller one (an OBJ of lines).
//!
//! `cargo run -p dcurv --example ridges > ridges.obj`

use std::error::Error;
use std::io::{Write, stdout};

use dcurv::{JetFitOptions, fitted_curvatures};
use mesh_core::TriMesh;
use mesh_core::glam::DVec3;
use mesh_shapes::{Ellipsoid, Irregular};

fn main() -> Result<(), Box<dyn Error>> {
    let ellipsoid = Ellipsoid { semi_axes: DVec3::new(1.0, 0.7, 0.4) };
    let mesh = TriMesh::from_soup(&ellipsoid.irregular_icosphere(4, Irregular::default())?)?;
    let fits = fitted_curvatures(&mesh, &JetFitOptions::default());
    let mut bends: Vec<_> =
        fits.iter().filter_map(|(v, fit)| fit.map(|fit| (v, fit.frame))).collect();
    bends.sort_by(|a, b| b.1.k_max.value().total_cmp(&a.1.k_max.value()));
    let half = 0.5 * mesh.mean_edge_length().ok_or("no edges")?;
    let mut out = stdout().lock();
    for (vertex, frame) in bends.iter().take(mesh.topology().vertex_count() / 20) {
        for sign in [-1.0, 1.0] {
            let p = mesh.position(*vertex) + sign * half * frame.direction_min;
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
        }
        writeln!(out, "l -2 -1")?;
    }
    Ok(())
}
