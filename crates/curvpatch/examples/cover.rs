//! A mesh replaced by smooth patches: their number for a tolerance, and their errors.
#![allow(missing_docs, clippy::print_stdout)]

use curvpatch::{CoverOptions, CurvatureEstimator, Params, cover};
use mesh_core::TriMesh;
use mesh_shapes::Torus;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = TriMesh::from_soup(&Torus { major: 2.0, minor: 1.0 }.mesh(48, 24)?)?;
    let estimator = CurvatureEstimator::new(&mesh, Params::robust())?;
    println!("tolerance  patches  faces under them  largest error");
    for tolerance in [0.1, 0.05, 0.02] {
        let cover = cover(&estimator, &CoverOptions::new(tolerance))?;
        println!(
            "{tolerance:9}  {:7}  {:4} of {:4}       {:.5}",
            cover.patches.len(),
            cover.covered_faces(),
            mesh.topology().face_count(),
            cover.max_error()
        );
        // Triangles for drawing, with one colour per patch.
        let triangles = cover.to_mesh(&mesh, 0.1 * tolerance)?;
        println!("           {} triangles to draw", triangles.triangles.len());
    }
    Ok(())
}
