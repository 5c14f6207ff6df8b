//! The distance that a fit minimises, by norm.
#![allow(clippy::unwrap_used)]

use mesh_core::TriMesh;
use mesh_metric::{Surface, sample_surface};
use mesh_shapes::{Irregular, SignedDistance, Sphere, Torus};
use simplify::{FitNorm, Options, Preset, simplify};

/// The mean, root mean square and largest distance of a mesh from a surface.
fn distances(mesh: &TriMesh, surface: &impl SignedDistance) -> [f64; 3] {
    let samples = sample_surface(&Surface::new(mesh).unwrap(), 60_000, 3);
    let vertices = mesh.topology().vertices().map(|v| mesh.position(v));
    let of = |p| surface.signed_distance(p).abs();
    let d: Vec<f64> = samples.iter().map(|sample| of(sample.position)).collect();
    let mean = d.iter().sum::<f64>() / d.len() as f64;
    let rms = (d.iter().map(|d| d * d).sum::<f64>() / d.len() as f64).sqrt();
    [mean, rms, d.iter().copied().chain(vertices.map(of)).fold(0.0, f64::max)]
}

fn each_norm_makes_its_own_distance_least(mesh: &TriMesh, surface: &impl SignedDistance) {
    let found = [FitNorm::L1, FitNorm::L2, FitNorm::Max].map(|norm| {
        let mut options = Options::preset(Preset::Quality).to_faces(400);
        options.refine.norm = norm;
        let result = simplify(mesh, &options).unwrap();
        assert_eq!(result.fit.unwrap().norm, norm);
        distances(&result.mesh, surface)
    });
    for own in 0..3 {
        for other in (0..3).filter(|&other| other != own) {
            assert!(found[own][own] < found[other][own], "{own} {other}: {found:?}");
        }
    }
    // The largest distance is clearly smaller, not just a little.
    assert!(found[2][2] < 0.92 * found[1][2], "{found:?}");
}

#[test]
fn on_a_sphere_each_norm_makes_its_own_distance_least() {
    let sphere = Sphere { radius: 1.0 };
    let soup = sphere.irregular_icosphere(5, Irregular { jitter: 0.2, seed: 1 }).unwrap();
    each_norm_makes_its_own_distance_least(&TriMesh::from_soup(&soup).unwrap(), &sphere);
}

#[test]
fn on_a_torus_each_norm_makes_its_own_distance_least() {
    let torus = Torus { major: 2.0, minor: 1.0 };
    let soup = torus.irregular_mesh(140, 70, Irregular { jitter: 0.2, seed: 1 }).unwrap();
    each_norm_makes_its_own_distance_least(&TriMesh::from_soup(&soup).unwrap(), &torus);
}
