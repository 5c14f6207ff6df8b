//! Published and independently computed numbers.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use dcurv::{
    CurvatureOptions, Curvatures, Totals, VertexArea, total_willmore_energy, willmore_energies,
};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::{Torus, inset_cube, polyhedra, seven_points};

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

fn totals(soup: &PolygonSoup, area: VertexArea) -> Totals {
    Curvatures::of(&mesh(soup), &CurvatureOptions { area }).totals()
}

fn assert_costs(found: Totals, expected: [f64; 3]) {
    let found = [found.f1, found.f2(), found.f3];
    println!("F1, F2, F3 = {found:.6?}");
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn costs_of_the_torus_of_dhkl01() {
    let torus = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6).unwrap();
    let found = totals(&torus, VertexArea::Voronoi);
    assert_costs(found, [130.173_069, 220.300_037, 457.569_662]);
}

#[test]
fn costs_of_the_seven_points_of_dhkl01() {
    let given = totals(&seven_points::given(), VertexArea::Voronoi);
    assert_costs(given, [31.369_089, 89.381_538, 178.763_077]);
    let convex = totals(&seven_points::convex(), VertexArea::Voronoi);
    assert_costs(convex, [32.958_906, 88.960_816, 177.921_633]);
}

#[test]
fn willmore_energy_of_an_octahedron_is_zero() {
    let energies = willmore_energies(&mesh(&polyhedra::octahedron()));
    assert_eq!(energies.len(), 6);
    assert!(energies.as_slice().iter().all(|w| w.abs() < 1e-12), "{energies:?}");
}

#[test]
fn willmore_energy_of_the_inset_cube() {
    for (inset, expected) in [(0.0, 25.1327), (0.1, 29.9173), (0.2, 34.6139)] {
        let found = total_willmore_energy(&mesh(&inset_cube(inset).unwrap()));
        println!("inset {inset}: W = {found:.4}");
        assert!((found - expected).abs() < 5e-5);
    }
    let torus = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6).unwrap();
    let found = total_willmore_energy(&mesh(&torus));
    println!("shifted torus: W = {found:.4}");
    assert!((found - 180.22).abs() < 5e-3);
}

/// KKL02 eq. 1 and 2, worked out by hand.
#[test]
fn norms_of_kkl02_on_an_octahedron() {
    let found = totals(&polyhedra::octahedron(), VertexArea::Barycentric);
    // The octahedron with edges of length e: S = 4/3 · sqrt(3)/4 e², K̄ = 2 pi - 4 pi / 3,
    // H̄ = e acos(1/3) as the dihedral angle between normals is acos(1/3).
    let edge = 2.0_f64.sqrt();
    let s = edge * edge / 3.0_f64.sqrt();
    let (k, h) = (core::f64::consts::TAU / 3.0 / s, edge * (1.0_f64 / 3.0).acos() / s);
    assert!((found.norm_l1 - 6.0 * 2.0 * h).abs() < 1e-12);
    assert!((found.norm_l2_squared - 6.0 * (4.0 * h * h - 2.0 * k)).abs() < 1e-12);
}
