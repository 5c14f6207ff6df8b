//! Laws for every mesh, on the meshes of a folder.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use core::f64::consts::TAU;
use std::path::PathBuf;

use dcurv::{
    CurvatureOptions, Curvatures, FitScale, FittedCurvature, JetFitOptions, VertexCurvature,
    ball_curvatures, estimate_noise, fitted_curvatures, principal_frames, willmore_energies,
};
use mesh_core::fill::{FillOptions, FillRefusal};
use mesh_core::{Repair, TriMesh, build};

/// The meshes of the folder that load, repaired where they need it.
fn meshes() -> Vec<(String, TriMesh)> {
    let Some(folder) = std::env::var_os("CURVMESH_MODELS").map(PathBuf::from) else {
        println!("skipped: set CURVMESH_MODELS");
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let load = |path: PathBuf| {
        let soup = mesh_io::read(&path).ok()?.soup;
        let built = build(&soup, &Repair::lenient()).ok()?;
        Some((path.file_name()?.to_string_lossy().into_owned(), built.mesh))
    };
    paths.into_iter().filter_map(load).collect()
}

#[test]
fn gauss_bonnet_and_finite_values_on_real_meshes() {
    for (name, mesh) in meshes() {
        let topology = mesh.topology();
        let isolated = topology.vertices().filter(|&v| topology.is_isolated_vertex(v)).count();
        let euler = (topology.vertex_count() - isolated) as f64 - topology.edge_count() as f64
            + topology.face_count() as f64;
        let all = Curvatures::of(&mesh, &CurvatureOptions::default());
        let totals = all.totals();
        // Relative to the sum of the sizes of all defects.
        let added = all.vertices().as_slice().iter();
        let size: f64 = added.map(|at| at.integrals().angle_defect.value().abs()).sum();
        let residual = (totals.gaussian.value() - TAU * euler).abs() / size.max(TAU);
        println!(
            "{name:28} chi {euler:5} residual {residual:8.1e} F1 {:10.4} F2 {:10.4} F3 {:10.4} \
             clamped {} without area {}",
            totals.f1,
            totals.f2(),
            totals.f3,
            totals.clamped,
            totals.without_area
        );
        assert!(residual < 1e-9, "{name}");
        assert!(all.vertices().as_slice().iter().all(is_finite), "{name}");
        assert!(willmore_energies(&mesh).as_slice().iter().all(|w| w.is_finite()), "{name}");
        for frame in principal_frames(&mesh).as_slice().iter().flatten() {
            assert!(frame.k_max >= frame.k_min, "{name}");
            assert!((frame.direction_max.length() - 1.0).abs() < 1e-9, "{name}");
        }
    }
}

fn is_finite(at: &VertexCurvature) -> bool {
    let [k1, k2] = at.principal().map(dcurv::Pointwise::value);
    let integrals = at.integrals();
    let values = [
        integrals.angle_defect.value(),
        integrals.mean.value(),
        integrals.abs_dihedral.value(),
        integrals.area.value(),
        at.gaussian().value(),
        at.mean().value(),
        at.abs_dihedral().value(),
        at.shape_index(),
        k1,
        k2,
    ];
    values.iter().all(|value| value.is_finite())
}

#[test]
fn fits_and_averages_are_finite_on_real_meshes() {
    for (name, mesh) in meshes() {
        // The choice of a scale takes some ten times as long.
        let is_small = mesh.topology().face_count() < 8_000;
        let scale =
            if is_small { FitScale::Noise(estimate_noise(&mesh)) } else { FitScale::Nearest };
        let fits = fitted_curvatures(&mesh, &JetFitOptions { scale, ..JetFitOptions::default() });
        let fitted = fits.iter().filter(|(_, fit)| fit.is_some()).count();
        // If the sizes of triangles differ strongly, a ball may contain most of the mesh.
        if mesh.topology().face_count() > 15_000 {
            continue;
        }
        let radius = 0.5 * mesh.mean_edge_length().unwrap();
        let balls = ball_curvatures(&mesh, radius).unwrap();
        println!("{name:28} {fitted} of {} vertices fitted", fits.len());
        for FittedCurvature { frame, error, .. } in fits.as_slice().iter().flatten() {
            let values = [frame.mean(), frame.gaussian(), frame.k_max, frame.k_min, *error];
            assert!(values.iter().all(|k| k.value().is_finite()), "{name}");
        }
        for ball in balls.as_slice() {
            let values = [ball.mean(), ball.gaussian(), ball.abs_dihedral()];
            assert!(values.iter().all(|k| k.value().is_finite()), "{name} {ball:?}");
            assert!(ball.area.value() >= 0.0 && ball.area.value() < 100.0 * mesh.area(), "{name}");
        }
    }
}

#[test]
fn holes_of_real_meshes_are_filled_and_curvature_adds_up() {
    for (name, mut mesh) in meshes() {
        let report = mesh.fill_holes(&FillOptions::default());
        let topology = mesh.topology();
        topology.validate().unwrap();
        assert_eq!(topology.boundary_loops().len(), report.left.len(), "{name}");
        assert!(
            report.left.iter().all(|left| matches!(
                left.1,
                FillRefusal::Pillow(_) | FillRefusal::Duplicate(_) | FillRefusal::NoArea
            )),
            "{name}"
        );
        if report.filled.is_empty() {
            continue;
        }
        println!(
            "{name:28} {} holes, {} faces, {} vertices",
            report.filled.len(),
            report.new_faces(),
            report.new_vertices()
        );
        let totals = Curvatures::of(&mesh, &CurvatureOptions::default()).totals();
        let euler = topology.euler_characteristic() as f64;
        let residual = (totals.gaussian.value() - TAU * euler).abs();
        assert!(residual < 1e-9 * topology.vertex_count() as f64, "{name} {residual}");
    }
}
