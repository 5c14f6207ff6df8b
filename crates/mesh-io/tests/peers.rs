//! Other readers read the same files in the same way.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::path::Path;

use mesh_io::{ReadOptions, read_with};

/// The positions of the corners of all faces, in the order of the file, as `tobj` reads them; `None`
/// when it refuses the file.
fn corners_by_tobj(path: &Path) -> Option<Vec<[f64; 3]>> {
    let (models, _) = tobj::load_obj(path, &tobj::LoadOptions::default()).ok()?;
    let corners = models.iter().flat_map(|model| {
        let positions = &model.mesh.positions;
        model.mesh.indices.iter().map(|&i| {
            let i = 3 * i as usize;
            [positions[i], positions[i + 1], positions[i + 2]]
        })
    });
    Some(corners.collect())
}

fn corners(path: &Path) -> Vec<[f64; 3]> {
    let model = read_with(path, &ReadOptions::default()).unwrap();
    let soup = &model.soup;
    let vertices = soup.faces().flat_map(|face| face.iter().copied());
    vertices.map(|v| soup.positions()[v as usize].to_array()).collect()
}

/// Groups, materials, negative indices, polygons, missing texture coordinates.
const SAMPLE: &str = "mtllib none.mtl
o first
v 0.1 0 0
v 1 0.30000000000000004 0
v 1 1 1e-300
v 0 1 0.7
vt 0 0
vn 0 0 1
f 1 2 3 4
g second third
usemtl red
f -4/1/1 -3/1/1 -2/1/1
f 1//1 3//1 4//1
v 5 5 5
f 5 4 3 2 1
";

#[test]
fn obj_corners_are_those_that_tobj_reads() {
    let folder = tempfile::tempdir().unwrap();
    let sample = folder.path().join("sample.obj");
    std::fs::write(&sample, SAMPLE).unwrap();
    let ours = corners(&sample);
    assert_eq!(ours.len(), 15);
    assert_eq!(ours, corners_by_tobj(&sample).unwrap());
    let Some(models) = std::env::var_os("CURVMESH_MODELS") else {
        eprintln!("skipped: CURVMESH_MODELS names no folder of models");
        return;
    };
    let mut compared = 0;
    for entry in std::fs::read_dir(models).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "obj") {
            continue;
        }
        let Some(theirs) = corners_by_tobj(&path) else { continue };
        // NaN is compared as well.
        let bits = |all: Vec<[f64; 3]>| all.into_iter().map(|p| p.map(f64::to_bits));
        assert!(bits(corners(&path)).eq(bits(theirs)), "{}", path.display());
        compared += 1;
    }
    eprintln!("{compared} files compared");
    assert!(compared > 10);
}
