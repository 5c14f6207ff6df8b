//! Which other files a file may make the reader open.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use mesh_io::{
    External, ImageData, Model, ReadError, ReadErrorKind, ReadOptions, read, read_from, read_with,
};
use std::fs;
use std::path::Path;

/// Three vertices, 36 bytes.
fn triangle() -> Vec<u8> {
    let positions = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    positions.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn document(uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":{}}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]}}"#,
        serde_json::to_string(uri).unwrap()
    )
}

fn any() -> ReadOptions {
    ReadOptions { external: External::Any, ..ReadOptions::default() }
}

/// A folder `inside` with a buffer and a library in it and below it, and another pair in the folder around it.
fn folders() -> tempfile::TempDir {
    let outer = tempfile::tempdir().unwrap();
    let inside = outer.path().join("inside");
    fs::create_dir_all(inside.join("below")).unwrap();
    for folder in [outer.path(), &inside, &inside.join("below")] {
        fs::write(folder.join("a b.bin"), triangle()).unwrap();
        fs::write(folder.join("a b.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    }
    outer
}

fn read_gltf(outer: &Path, uri: &str, options: &ReadOptions) -> Result<Model, ReadError> {
    let path = outer.join("inside").join("mesh.gltf");
    fs::write(&path, document(uri)).unwrap();
    read_with(path, options)
}

/// Whether the material got its colour.
fn reads_library(outer: &Path, name: &str, options: &ReadOptions) -> bool {
    let path = outer.join("inside").join("mesh.obj");
    fs::write(&path, format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"))
        .unwrap();
    let model = read_with(path, options).unwrap();
    let reads = model.materials[0].base_color == [1.0, 0.0, 0.0, 1.0];
    // Files that were not read are mentioned in the notes.
    assert_eq!(reads, model.notes.is_empty(), "{:?}", model.notes);
    reads
}

/// Names that lead out of the folder, encoded or not, in the notation of any system.
fn names_outside(outer: &Path) -> Vec<String> {
    let absolute = outer.join("a b.bin").to_str().unwrap().to_owned();
    [
        &absolute,
        &absolute.replace('/', "%2F"),
        "%2Fetc%2Fpasswd",
        "..%2Fa%20b.bin",
        "../a b.bin",
        "%2E%2E/a b.bin",
        "below/../../a b.bin",
        "below%5C..%5C..%5Ca%20b.bin",
        "..\\a b.bin",
        "\\\\host\\share\\a b.bin",
        "//host/share/a b.bin",
        "C:\\a b.bin",
        "C:a b.bin",
        "C%3A%5Ca%20b.bin",
        "file:///etc/passwd",
        "a b.bin:stream",
        "",
        ".",
        "below",
        "a\u{0}b",
    ]
    .map(str::to_owned)
    .into()
}

#[test]
fn a_buffer_outside_the_folder_is_refused_however_it_is_written() {
    let outer = folders();
    for name in names_outside(outer.path()) {
        let error = read_gltf(outer.path(), &name, &ReadOptions::default()).expect_err(&name);
        assert!(matches!(error.kind, ReadErrorKind::MissingResource { .. }), "{name}: {error}");
    }
}

#[test]
fn a_material_library_outside_the_folder_is_not_read() {
    let outer = folders();
    for name in names_outside(outer.path()) {
        // An OBJ file does not encode names.
        let name = name.replace(".bin", ".mtl");
        if !name.contains('\0') {
            assert!(!reads_library(outer.path(), &name, &ReadOptions::default()), "{name}");
        }
    }
}

#[test]
fn files_in_and_below_the_folder_are_read() {
    let outer = folders();
    for name in [
        "a%20b.bin",
        "a b.bin",
        "./a b.bin",
        "below/a b.bin",
        "below%2Fa%20b.bin",
        "below\\a b.bin",
    ] {
        let model = read_gltf(outer.path(), name, &ReadOptions::default()).unwrap();
        assert_eq!(model.soup.face_count(), 1, "{name}");
    }
    for name in ["a b.mtl", "./a b.mtl", "below/a b.mtl", "below\\a b.mtl"] {
        assert!(reads_library(outer.path(), name, &ReadOptions::default()), "{name}");
    }
}

#[test]
fn other_files_are_read_when_any_may_be() {
    let outer = folders();
    let absolute = outer.path().join("a b.bin").to_str().unwrap().to_owned();
    for name in ["../a b.bin", "..%2Fa%20b.bin", "..\\a b.bin", &absolute] {
        assert_eq!(read_gltf(outer.path(), name, &any()).expect(name).soup.face_count(), 1);
    }
    assert!(reads_library(outer.path(), "../a b.mtl", &any()));
    let error = read_gltf(outer.path(), "../a b.bin", &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("--external any"), "{error}");
}

#[test]
fn no_other_file_is_read_when_none_may_be() {
    let outer = folders();
    let none = ReadOptions { external: External::None, ..ReadOptions::default() };
    assert!(read_gltf(outer.path(), "a b.bin", &none).is_err());
    assert!(!reads_library(outer.path(), "a b.mtl", &none));
}

#[test]
fn a_stream_has_no_folder() {
    let outer = folders();
    // Not even if the working folder has a file of that name.
    for options in [ReadOptions::default(), any()] {
        for uri in ["Cargo.toml", outer.path().join("a b.bin").to_str().unwrap()] {
            let error = read_from(&mut document(uri).as_bytes(), &options).unwrap_err();
            assert!(matches!(error.kind, ReadErrorKind::MissingResource { .. }), "{error}");
        }
    }
    let folder = Some(outer.path().to_owned());
    let options = ReadOptions { folder, ..ReadOptions::default() };
    assert!(read_from(&mut document("a b.bin").as_bytes(), &options).is_ok());
}

#[cfg(unix)]
#[test]
fn a_link_out_of_the_folder_is_not_followed() {
    use std::os::unix::fs::symlink;
    let outer = folders();
    let inside = outer.path().join("inside");
    symlink("../a b.bin", inside.join("out.bin")).unwrap();
    symlink("..", inside.join("up")).unwrap();
    symlink("below/a b.bin", inside.join("within.bin")).unwrap();
    symlink("../a b.mtl", inside.join("out.mtl")).unwrap();
    for name in ["out.bin", "up/a b.bin"] {
        assert!(read_gltf(outer.path(), name, &ReadOptions::default()).is_err(), "{name}");
        assert!(read_gltf(outer.path(), name, &any()).is_ok(), "{name}");
    }
    assert!(!reads_library(outer.path(), "out.mtl", &ReadOptions::default()));
    assert!(reads_library(outer.path(), "out.mtl", &any()));
    assert!(read_gltf(outer.path(), "within.bin", &ReadOptions::default()).is_ok());
}

/// Opening a pipe would wait forever for a writer.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_not_opened() {
    let outer = folders();
    let pipe = outer.path().join("inside").join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    for options in [ReadOptions::default(), any()] {
        let error = read_gltf(outer.path(), "pipe", &options).unwrap_err();
        assert!(error.to_string().contains("not a regular file"), "{error}");
        assert!(!reads_library(outer.path(), "pipe", &options));
    }
    assert!(read_gltf(outer.path(), "/dev/zero", &any()).is_err());
}

#[test]
fn a_file_of_the_working_folder_has_that_folder() {
    let folder = folders();
    let inside = folder.path().join("inside");
    fs::write(inside.join("mesh.gltf"), document("a%20b.bin")).unwrap();
    // A relative path without a folder before the name has an empty parent.
    let options = ReadOptions { folder: Some("".into()), ..ReadOptions::default() };
    let error = read_with(inside.join("mesh.gltf"), &options).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::MissingResource { .. }), "{error}");
    assert!(read(inside.join("mesh.gltf")).is_ok());
}

#[test]
fn pictures_are_opened_by_the_same_rule() {
    let outer = folders();
    let inside = outer.path().join("inside");
    assert!(External::Folder.open(&inside, "below/a b.bin").is_ok());
    assert!(External::Any.open(&inside, "../a b.bin").is_ok());
    for (external, name) in [
        (External::Folder, "../a b.bin"),
        (External::Folder, "below"),
        (External::None, "a b.bin"),
        (External::Any, "/dev/zero"),
    ] {
        assert!(external.open(&inside, name).is_err(), "{external:?} {name}");
    }
}

#[test]
fn names_of_pictures_are_the_same_from_gltf_and_from_material_libraries() {
    let folder = tempfile::tempdir().unwrap();
    let gltf = folder.path().join("a.gltf");
    let text = r#"{"asset":{"version":"2.0"},"images":[{"uri":"sub/my%20wood%23.png"},{"uri":"https://host/a%20b.png"}],
        "textures":[{"source":0}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]}"#;
    fs::write(&gltf, text).unwrap();
    let empty = ReadOptions { allow_empty: true, ..ReadOptions::default() };
    let of_gltf = read_with(gltf, &empty).unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl m\nmap_Kd -s 1 1 1 sub\\my wood#.png\n")
        .unwrap();
    let obj = folder.path().join("a.obj");
    fs::write(&obj, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n").unwrap();
    let of_obj = read(obj).unwrap();
    assert_eq!(of_obj.images[0].data, ImageData::Uri("sub/my wood#.png".to_owned()));
    assert_eq!(of_gltf.images[0].data, of_obj.images[0].data);
    assert_eq!(of_gltf.images[1].data, ImageData::Uri("https://host/a%20b.png".to_owned()));
    assert!(of_obj.notes.is_empty(), "{:?}", of_obj.notes);
}

#[test]
fn options_of_a_texture_are_not_part_of_its_name() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl m\nmap_Kd -s 2 2 1 -clamp on x.png\n").unwrap();
    let obj = folder.path().join("a.obj");
    fs::write(&obj, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n").unwrap();
    let model = read(obj).unwrap();
    assert_eq!(model.images[0].data, ImageData::Uri("x.png".to_owned()));
    assert!(model.notes[0].contains("not applied"), "{:?}", model.notes);
}

/// `Tr` is the opposite of `d`, which counts where a library has both.
#[test]
fn transparency_is_the_opposite_of_opacity() {
    let folder = tempfile::tempdir().unwrap();
    let materials = [
        ("Tr 0.25", 0.75),
        ("Tr 0.5\nd 0.25", 0.25),
        ("d 1\nTr 1", 1.0),
        ("d -halo 0.5", 0.5),
        ("Kd 1 0 0", 1.0),
        ("Tr none", 1.0),
    ];
    let (mut library, mut mesh) =
        (String::new(), "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned());
    for (place, (lines, _)) in materials.iter().enumerate() {
        library += &format!("newmtl {place}\n{lines}\n");
        mesh += &format!("usemtl {place}\nf 1 2 3\n");
    }
    fs::write(folder.path().join("a.mtl"), library).unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, mesh).unwrap();
    let model = read(&path).unwrap();
    let opacities: Vec<f32> =
        model.materials.iter().map(|material| material.base_color[3]).collect();
    assert_eq!(opacities, materials.map(|(_, opacity)| opacity));
    let is_blended = |material: &mesh_io::Material| material.alpha == mesh_io::Alpha::Blend;
    assert!(model.materials.iter().all(|m| is_blended(m) == (m.base_color[3] < 1.0)));
    assert!(model.lost.is_empty(), "{:?}", model.lost);
}
