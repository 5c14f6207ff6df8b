//! Curvature of very small and very large meshes: angles have no unit.
#![allow(clippy::unwrap_used)]

use dcurv::{dihedral_angles, extrinsic_curvatures};
use mesh_core::TriMesh;
use mesh_shapes::{Irregular, Torus};

#[test]
fn angles_do_not_depend_on_the_size() {
    let measure = |scale: f64| {
        let soup =
            Torus { major: 1.0, minor: 0.4 }.irregular_mesh(12, 8, Irregular::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        mesh.positions_mut().iter_mut().for_each(|p| *p *= scale);
        let angles =
            dihedral_angles(&mesh).into_vec().into_iter().map(|angle| angle.unwrap_or(9.0));
        let parts = extrinsic_curvatures(&mesh).into_vec();
        let parts = parts.into_iter().flat_map(|part| [part.positive, part.negative]);
        angles.chain(parts.map(dcurv::Integral::value)).map(f64::to_bits).collect::<Vec<u64>>()
    };
    let unit = measure(1.0);
    // The smallest coordinates must keep their digits.
    for exponent in (-900..=990).step_by(70) {
        assert!(measure(f64::from(exponent).exp2()) == unit, "2^{exponent}");
    }
}
