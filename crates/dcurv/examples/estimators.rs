//! Comparison of estimators: the largest error of the mean curvature on an irregular torus under refinement, with and
//! without noise.
//!
//! `cargo run -p dcurv --example estimators`
#![allow(clippy::print_stdout)]

use std::error::Error;

use dcurv::{
    CurvatureOptions, Curvatures, FitScale, JetFitOptions, ball_curvatures, estimate_noise,
    fitted_curvatures,
};
use mesh_core::{TriMesh, VertexId};
use mesh_shapes::{AnalyticSurface, Irregular, Torus, add_normal_noise};

const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:>8} {:>6} {:>10} {:>10} {:>10}",
        "vertices", "noise", "pointwise", "fitted", "averaged"
    );
    for noise in [0.0, 0.02] {
        for n in [16_usize, 32, 64] {
            let mut soup = TORUS.irregular_mesh(2 * n, n, Irregular::default())?;
            add_normal_noise(&mut soup, noise, 1);
            let mesh = TriMesh::from_soup(&soup)?;
            let worst = |h: &dyn Fn(VertexId) -> f64| {
                let error = |v| (h(v) - TORUS.mean_curvature(mesh.position(v))).abs();
                mesh.topology().vertices().map(error).fold(0.0, f64::max)
            };
            let curvatures = Curvatures::of(&mesh, &CurvatureOptions::default());
            let scale = FitScale::Noise(estimate_noise(&mesh));
            let options = JetFitOptions { scale, ..JetFitOptions::default() };
            let fits = fitted_curvatures(&mesh, &options);
            let balls = ball_curvatures(&mesh, 2.0 / (n as f64).sqrt())?;
            println!(
                "{:8} {noise:6} {:10.4} {:10.4} {:10.4}",
                mesh.topology().vertex_count(),
                worst(&|v| curvatures[v].mean().value()),
                worst(&|v| fits[v].map_or(f64::NAN, |fit| fit.frame.mean().value())),
                worst(&|v| balls[v].mean().value()),
            );
        }
    }
    Ok(())
}
