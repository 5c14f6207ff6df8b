//! The convergence of finer and finer polyhedra to a sphere, sampled and proved.
#![allow(missing_docs, clippy::print_stdout)]

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, CompareOptions, Surface, compare, hausdorff_bounds};
use mesh_shapes::Sphere;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = |level| -> Result<Surface, Box<dyn std::error::Error>> {
        Ok(Surface::new(&TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(level)?)?)?)
    };
    let fine = level(5)?;
    println!("faces      mean       largest    proved between");
    for coarse in 0..4 {
        let coarse = level(coarse)?;
        let samples = CompareOptions { samples: 20_000, ..CompareOptions::default() };
        let sampled = compare(&coarse, &fine, &samples);
        let proof = CertifyOptions { tolerance: 1e-3, ..CertifyOptions::default() };
        let bounds = hausdorff_bounds(&coarse, &fine, &proof);
        assert!(sampled.hausdorff() <= bounds.upper);
        println!(
            "{:5}  {:.7}  {:.7}  {:.7} and {:.7}, by {} pieces",
            coarse.triangle_count(),
            sampled.mean(),
            sampled.hausdorff(),
            bounds.lower,
            bounds.upper,
            bounds.pieces
        );
    }
    Ok(())
}
