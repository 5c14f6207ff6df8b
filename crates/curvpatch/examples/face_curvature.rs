//! Curvature of faces compared with the exact curvature of a torus, for both presets and several radii.
#![allow(missing_docs, clippy::print_stdout)]

use curvpatch::{CurvatureEstimator, Params};
use mesh_core::TriMesh;
use mesh_shapes::{AnalyticSurface, Torus};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let torus = Torus { major: 2.0, minor: 1.0 };
    let mesh = TriMesh::from_soup(&torus.mesh(64, 32)?)?;
    println!("preset  radius  median error of the principal curvatures");
    for (name, params) in [("paper", Params::paper()), ("robust", Params::robust())] {
        let estimator = CurvatureEstimator::new(&mesh, params)?;
        for edges in [1.0, 2.0, 4.0] {
            let radius = 0.25 * edges * estimator.suggested_radius();
            let mut errors = Vec::new();
            for (_, disc) in estimator.all_faces(radius)?.iter() {
                let disc = disc.as_ref().map_err(Clone::clone)?;
                let exact = torus.principal_curvatures(disc.center);
                let [k1, k2] = disc.curvatures;
                errors.push((k1.max(k2) - exact.max).abs().max((k1.min(k2) - exact.min).abs()));
            }
            errors.sort_by(f64::total_cmp);
            println!("{name:6}  {radius:.4}  {:.5}", errors[errors.len() / 2]);
        }
    }
    Ok(())
}
