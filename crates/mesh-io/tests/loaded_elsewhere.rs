//! Models converted from the crates `tobj` and `gltf` equal the models of our readers.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use mesh_io::{Model, ReadOptions, read_with};
use std::path::{Path, PathBuf};

fn models(extensions: &[&str]) -> Vec<PathBuf> {
    let Some(folder) = std::env::var_os("CURVMESH_MODELS") else {
        eprintln!("skipped: CURVMESH_MODELS names no folder of models");
        return Vec::new();
    };
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let fits =
        |path: &PathBuf| extensions.iter().any(|e| path.extension().is_some_and(|p| p == *e));
    let mut paths: Vec<PathBuf> = paths.filter(fits).collect();
    paths.sort();
    paths
}

/// For every corner in the order of the file: its position, its texture coordinate and its material.
fn corners(model: &Model) -> Vec<([u64; 3], Option<[u32; 2]>, String)> {
    let soup = &model.soup;
    let mut all = Vec::new();
    for face in 0..soup.face_count() {
        let material = model.face_materials.as_ref().map_or(Model::NONE, |m| m[face]);
        let material = model.materials.get(material as usize).map_or("", |m| &m.name);
        for (corner, &vertex) in soup.corner_range(face).zip(soup.face(face)) {
            // Adding zero turns -0 into 0.
            let at = soup.positions()[vertex as usize].to_array().map(|x| (x + 0.0).to_bits());
            let uv = model.corner_uvs.as_ref().map(|uvs| uvs[corner]).filter(|uv| !uv[0].is_nan());
            all.push((at, uv.map(|uv| uv.map(f32::to_bits)), material.to_owned()));
        }
    }
    all
}

fn ours(path: &Path) -> Option<Model> {
    read_with(path, &ReadOptions::default()).ok()
}

#[test]
fn obj_files_by_tobj() {
    let mut compared = 0;
    for path in models(&["obj"]) {
        // The table of the README lists the files that tobj refuses or reads wrongly.
        let Ok((loaded, materials)) = tobj::load_obj(&path, &tobj::LoadOptions::default()) else {
            continue;
        };
        let materials = materials.unwrap_or_default();
        let Ok(model) = Model::from_tobj(&loaded, &materials) else { continue };
        let Some(expected) = ours(&path) else { continue };
        if model.soup.face_count() != expected.soup.face_count() {
            eprintln!("{}: tobj has other faces", path.display());
            continue;
        }
        let (found, expected) = (corners(&model), corners(&expected));
        // Without its library, a file has only names of materials.
        let named = !materials.is_empty();
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!((found.0, found.1), (expected.0, expected.1), "{}", path.display());
            assert!(!named || found.2 == expected.2, "{}", path.display());
        }
        compared += 1;
    }
    assert!(compared > 20 || std::env::var_os("CURVMESH_MODELS").is_none(), "{compared}");
}

#[test]
fn gltf_files_by_gltf() {
    let mut compared = 0;
    for path in models(&["glb", "gltf"]) {
        let bytes = std::fs::read(&path).unwrap();
        let Ok(gltf::Gltf { document, blob }) = gltf::Gltf::from_slice(&bytes) else { continue };
        let buffers: Vec<Vec<u8>> = blob.into_iter().collect();
        let model = Model::from_gltf(&document, &buffers).unwrap();
        let expected = ours(&path).unwrap();
        assert_eq!(corners(&model), corners(&expected), "{}", path.display());
        assert_eq!(model.groups, expected.groups);
        assert_eq!(model.images, expected.images);
        compared += 1;
    }
    assert!(compared > 3 || std::env::var_os("CURVMESH_MODELS").is_none(), "{compared}");
}

#[test]
fn polygons_lines_and_materials_of_tobj() {
    let text = "v 0 0 0 255 0 0\nv 1 0 0 255 0 0\nv 1 1 0 0 255 0\nv 0 1 0 0 0 0\nvt 0 0\nvt 1 1\n\
                o a\nusemtl red\nf 1/1 2/2 3/1 4/2\nl 1 2\no b\nf 1 2 4\n";
    let library = |_: &Path| {
        tobj::load_mtl_buf(&mut &b"newmtl red\nKd 1 0 0\nd 0.5\nmap_Kd maps\\red.png\n"[..])
    };
    let text = format!("mtllib x.mtl\n{text}");
    let (loaded, materials) =
        tobj::load_obj_buf(&mut text.as_bytes(), &tobj::LoadOptions::default(), library).unwrap();
    let model = Model::from_tobj(&loaded, &materials.unwrap()).unwrap();
    assert_eq!(model.soup.face(0).len(), 4);
    assert_eq!(model.materials[0].base_color, [1.0, 0.0, 0.0, 0.5]);
    assert_eq!(model.vertex_colors.as_ref().unwrap()[0], [1.0, 0.0, 0.0, 1.0]);
    assert!(matches!(&model.images[0].data, mesh_io::ImageData::Uri(uri) if uri == "maps/red.png"));
    assert!(model.notes.iter().any(|note| note.contains("divided")), "{:?}", model.notes);
}
