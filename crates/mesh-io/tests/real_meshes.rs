//! Real meshes of all formats, if they are available.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use mesh_io::{
    Format, Location, Model, ReadErrorKind, ReadOptions, WriteOptions, read, read_with, write,
};
use std::path::PathBuf;

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("CURVMESH_MODELS").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: set CURVMESH_MODELS");
    }
    folder
}

/// One of the meshes is empty.
fn may_be_empty() -> ReadOptions {
    ReadOptions { allow_empty: true, ..ReadOptions::default() }
}

/// Vertices (0: not known), triangles after cutting polygons, and faces as stored; scenes expanded.
const COUNTS: &[(&str, usize, usize, usize)] = &[
    ("igea.ply", 134345, 268686, 268686),
    ("igea.obj", 134345, 268686, 268686),
    ("stanford-bunny.obj", 35947, 69451, 69451),
    ("horse.ply", 48485, 96966, 96966),
    ("armadillo_52k.off", 26002, 52000, 52000),
    ("max-planck_10k.obj", 5272, 10540, 10540),
    ("face_52k.obj", 25905, 51712, 51712),
    ("elephant_40k.off", 20007, 40022, 40022),
    ("cow.obj", 2903, 5804, 5804),
    ("homer.obj", 6002, 12000, 12000),
    ("fandisk.obj", 6475, 12946, 12946),
    ("rocker-arm.obj", 10044, 20088, 20088),
    ("casting.off", 5096, 10224, 10224),
    ("anchor_dense.off", 3793, 7598, 7598),
    ("block.off", 2132, 4272, 4272),
    ("conrod.stl", 3223, 6442, 6442),
    ("torus_4k6.obj", 2304, 4608, 4608),
    ("cylinder_open.off", 1200, 2262, 2262),
    ("sphere_1k2.off", 589, 1174, 1174),
    ("saddle.obj", 741, 1352, 1352),
    ("mountain.obj", 25600, 50562, 50562),
    ("plane_17k.obj", 8730, 17456, 17456),
    ("helicopter.glb", 28607, 33069, 33069),
    ("helicopter.obj", 16861, 33069, 33069),
    ("helicopter_ccby.glb", 5089, 4738, 4738),
    ("dragon_res3.ply", 22998, 47794, 47794),
    ("bunny_nm.ply", 8171, 16301, 16301),
    ("non_manif_hole.ply", 432, 755, 755),
    ("many_small_holes.ply", 2004, 3524, 3524),
    ("teapot.obj", 3644, 6320, 6320),
    ("beast.obj", 32311, 64618, 32364),
    ("suzanne.obj", 507, 968, 500),
    ("truck.obj", 2956, 4770, 4770),
    ("office_chair.obj", 3476, 6893, 3391),
    ("bathtub.obj", 2124, 4375, 4375),
    ("camel_seam.obj", 2032, 3576, 3576),
    ("blobby_shuffled.off", 2027, 4050, 4050),
    ("bunny10k_textured.obj", 5051, 9999, 9999),
    ("screwdriver_be.ply", 6789, 13574, 13574),
    ("elephant_tristrips.ply", 19753, 39290, 39290),
    ("spider_ascii.stl", 722, 1368, 1368),
    ("idler_riser.stl", 803, 1572, 1572),
    ("cesium_milk_truck.glb", 0, 3624, 3624),
    ("engine_2cyl.glb", 0, 121496, 121496),
    ("delft_georef.obj", 18262, 36271, 36271),
    ("zurich_georef.obj", 3670, 5142, 2123),
    ("moebius.obj", 280, 448, 224),
    ("fan3.obj", 5, 3, 3),
    ("hourglass_ico.obj", 23, 40, 40),
    ("inf_nan.obj", 3, 1, 1),
    ("box_infinite.glb", 24, 12, 12),
    ("deg_faces.obj", 6, 4, 4),
    ("negative_indices.obj", 8, 12, 6),
    ("box_longline.obj", 8, 944, 6),
    ("sphere_solid_header.stl", 682, 1360, 1360),
    ("empty.ply", 0, 0, 0),
];

fn triangles(model: &Model) -> usize {
    model.soup.faces().map(|face| face.len() - 2).sum()
}

#[test]
fn counts_agree_with_the_published_ones() {
    let Some(folder) = folder() else { return };
    let mut wrong = Vec::new();
    for &(name, vertices, faces, polygons) in COUNTS {
        let model = match read_with(folder.join(name), &may_be_empty()) {
            Ok(model) => model,
            Err(error) => {
                wrong.push(error.to_string());
                continue;
            }
        };
        model.check().unwrap();
        let found = (model.soup.vertex_count(), triangles(&model), model.soup.face_count());
        let vertices = if vertices == 0 { found.0 } else { vertices };
        if found != (vertices, faces, polygons) {
            wrong.push(format!("{name}: {found:?} instead of {:?}", (vertices, faces, polygons)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_file_without_anything_in_it_is_refused_unless_it_may_be_empty() {
    let Some(folder) = folder() else { return };
    let error = read(folder.join("empty.ply")).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Empty { .. }), "{error}");
}

#[test]
fn an_index_out_of_range_is_refused_with_its_line() {
    let Some(folder) = folder() else { return };
    let error = read(folder.join("malformed.obj")).unwrap_err();
    assert_eq!(error.location(), Some(&Location::Line(23)), "{error}");
    assert!(error.to_string().contains("malformed.obj"), "{error}");
}

#[test]
fn every_mesh_survives_every_format() {
    let Some(folder) = folder() else { return };
    let target = tempfile::tempdir().unwrap();
    for &(name, ..) in COUNTS {
        let model = read_with(folder.join(name), &may_be_empty()).unwrap();
        if model.soup.vertex_count() > 40_000 {
            continue;
        }
        for &format in Format::ALL {
            let path = target.path().join("mesh").with_extension(format.extension());
            let finite = model.soup.positions().iter().all(|p| p.is_finite());
            let gltf = matches!(format, Format::Gltf | Format::Glb);
            let report = match write(&path, &model, &WriteOptions::default()) {
                Err(error) => {
                    assert!(gltf && !finite, "{name} as {format}: {error}");
                    continue;
                }
                Ok(report) => report,
            };
            let again = read_with(&path, &may_be_empty())
                .unwrap_or_else(|error| panic!("{name} as {format}: {error}"));
            assert_eq!(triangles(&again), triangles(&model), "{name} as {format}");
            if !gltf && format != Format::Stl {
                assert_eq!(again.soup.corners(), model.soup.corners(), "{name} as {format}");
            }
            if report.rounding == 0.0 && finite && format != Format::Stl {
                let pairs = again.soup.positions().iter().zip(model.soup.positions());
                assert!(pairs.into_iter().all(|(a, b)| a == b), "{name} as {format}");
            }
            if gltf && model.soup.positions().iter().any(|p| p.x > 80_000.0) {
                assert!(report.rounding < 1e-3, "{name} as {format}: {report:?}");
            }
        }
    }
}
