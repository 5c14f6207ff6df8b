//! Random small meshes with holes, boundaries and several components, through every preset.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{Irregular, Plane, Sphere};
use proptest::prelude::*;
use simplify::{Boundary, ErrorCheck, Options, Preset, StopReason, simplify};

/// A bumpy grid with random faces removed, if that leaves a manifold, and a sphere beside it.
pub(crate) fn random_mesh(seed: u64, cells: usize, holes: usize, sphere: bool) -> Option<TriMesh> {
    let mut random = SplitMix64::new(seed);
    let irregular = Irregular { jitter: 0.2, seed };
    let soup = Plane { half_width: 1.0 }.irregular_mesh(cells, irregular).unwrap();
    let mut points: Vec<DVec3> = soup.positions().to_vec();
    points.iter_mut().for_each(|p| p.z = 0.3 * random.symmetric());
    let mut triangles: Vec<[u32; 3]> = soup.faces().map(|f| f.try_into().unwrap()).collect();
    for _ in 0..holes.min(triangles.len() - 1) {
        let gone = (random.uniform() * triangles.len() as f64) as usize;
        triangles.swap_remove(gone);
    }
    if sphere {
        let shift = points.len() as u32;
        let ball = Sphere { radius: 0.1 }.icosphere(1).unwrap();
        points.extend(ball.positions().iter().map(|&p| p + 5.0 * DVec3::X));
        triangles.extend(ball.faces().map(|f| [f[0] + shift, f[1] + shift, f[2] + shift]));
    }
    TriMesh::from_triangles(&points, &triangles).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_preset_gives_a_valid_mesh(
        seed in 0_u64..10_000,
        cells in 1_usize..9,
        holes in 0_usize..6,
        sphere in prop::bool::ANY,
        preset in 0..Preset::ALL.len(),
        floor in 0_usize..60,
        boundary in 0_usize..3,
    ) {
        let mesh = random_mesh(seed, cells, holes, sphere);
        prop_assume!(mesh.is_some());
        let mesh = mesh.unwrap();
        let mut options = Options::preset(Preset::ALL[preset]).to_faces(floor);
        options.record = true;
        options.protect.boundary =
            [Boundary::Quadrics, Boundary::Lock, Boundary::Free][boundary];
        let result = simplify(&mesh, &options).unwrap();
        let topology = result.mesh.topology();
        prop_assert_eq!(topology.validate(), Ok(()));
        prop_assert!(result.mesh.positions().iter().all(|p| p.is_finite()));
        let faces = topology.face_count();
        let before = mesh.topology().face_count();
        prop_assert!(faces + 1 >= floor.min(before));
        // The reduction of the largest errors may replace boundary vertices, and end with one face more or
        // fewer.
        let cut = result.max_error.is_some_and(|reduced| reduced.kept > 0);
        match result.stop {
            StopReason::Faces => prop_assert!(faces <= floor),
            _ => prop_assert!(faces > floor || cut),
        }
        // Topology stays as it was.
        prop_assert_eq!(topology.components().count, mesh.topology().components().count);
        prop_assert_eq!(topology.euler_characteristic(), mesh.topology().euler_characteristic());
        prop_assert_eq!(topology.boundary_loops().len(), mesh.topology().boundary_loops().len());
        // Every vertex maps to a vertex of the result, and the log leads to the same mesh.
        for (_, new) in result.vertex_map.iter() {
            prop_assert!(new.is_some_and(|v| topology.contains_vertex(v)));
        }
        let mut replayed = result.log.replay(&mesh, result.log.len()).unwrap();
        replayed.compact();
        let apart = replayed.topology().face_count().abs_diff(faces);
        prop_assert!(apart == 0 || (apart == 1 && cut));
        // Intermediate levels have the requested number of faces, or the smallest possible number.
        let level = usize::midpoint(faces, before);
        let level_mesh = result.log.replay(&mesh, result.log.count_for_faces(level)).unwrap();
        let got = level_mesh.topology().face_count();
        prop_assert!(got <= level && got + 2 > level.min(before), "{got} {level}");
        if !cut {
            let vertices = mesh.topology().vertex_count();
            prop_assert_eq!(result.log.len() + topology.vertex_count(), vertices);
        }
    }

    #[test]
    fn a_certified_error_limit_holds(
        seed in 0_u64..10_000, cells in 4_usize..9, limit in 0.01_f64..0.5
    ) {
        let mesh = random_mesh(seed, cells, 0, true).unwrap();
        let options = Options::default().within(limit, ErrorCheck::Certified);
        let result = simplify(&mesh, &options).unwrap();
        let error = result.error.unwrap();
        prop_assert!(error.upper.unwrap() <= limit, "{error:?} exceeds {limit}");
        prop_assert!(error.lower <= error.upper.unwrap());
        let original = mesh_metric::Surface::new(&mesh).unwrap();
        let surface = mesh_metric::Surface::new(&result.mesh).unwrap();
        let samples = mesh_metric::CompareOptions { samples: 2000, ..Default::default() };
        let sampled = mesh_metric::compare(&original, &surface, &samples);
        prop_assert!(sampled.hausdorff() <= limit);
    }
}
