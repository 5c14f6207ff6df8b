//! Which files beside an OBJ file may be replaced.
#![cfg(all(feature = "obj", feature = "gltf"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use mesh_core::PolygonSoup;
use mesh_io::{
    Image, ImageData, Material, Model, WriteError, WriteOptions, WriteReport, read, write,
};
use std::path::{Path, PathBuf};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n one";

/// A triangle with a material and an embedded picture.
fn painted(red: f32, picture: &[u8]) -> Model {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut model = Model::from(PolygonSoup::from_triangles(&corners, &[[0, 1, 2]]).unwrap());
    let name = "paint".to_owned();
    model.materials = vec![Material {
        name,
        base_color: [red, 0.0, 0.0, 1.0],
        base_color_image: Some(0),
        ..Material::default()
    }];
    model.images = vec![Image {
        name: String::new(),
        media_type: String::new(),
        data: ImageData::Bytes(picture.to_vec()),
    }];
    model.face_materials = Some(vec![0]);
    model
}

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, content: &[u8]) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn get(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<_> = entries.map(|e| name(e).into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn write(&self, name: &str, model: &Model) -> Result<WriteReport, WriteError> {
        write(self.path(name), model, &WriteOptions::default())
    }

    fn overwrite(&self, name: &str, model: &Model) -> Result<WriteReport, WriteError> {
        let options = WriteOptions { overwrite_companions: true, ..WriteOptions::default() };
        write(self.path(name), model, &options)
    }

    /// Asserts that writing `x.obj` is refused because of a file, and that nothing changes.
    fn refuses(&self, model: &Model, in_the_way: &str) {
        let state = || -> Vec<_> {
            let content = |name: &String| std::fs::read(self.path(name)).ok();
            self.names().into_iter().map(|name| (content(&name), name)).collect()
        };
        let before = state();
        let error = self.write("x.obj", model).unwrap_err();
        let WriteError::Companion { path, .. } = &error else { panic!("{error}") };
        assert_eq!(path, &self.path(in_the_way));
        assert!(error.to_string().contains("`overwrite_companions`"), "{error}");
        assert!(state() == before);
    }
}

#[test]
fn a_material_library_of_others_is_not_replaced() {
    let place = Place::new();
    place.put("x.obj", b"old");
    place.put("x.mtl", b"newmtl mine\nKd 1 1 0\n");
    place.refuses(&painted(1.0, PNG), "x.mtl");
    let report = place.overwrite("x.obj", &painted(1.0, PNG)).unwrap();
    assert_eq!(report.companions, [place.path("x-0.png"), place.path("x.mtl")]);
    assert_eq!(read(place.path("x.obj")).unwrap().materials[0].base_color, [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_picture_of_others_is_not_replaced() {
    let place = Place::new();
    place.put("x-0.png", b"holiday");
    place.refuses(&painted(1.0, PNG), "x-0.png");
    place.overwrite("x.obj", &painted(1.0, PNG)).unwrap();
    assert_eq!(place.get("x-0.png"), PNG);
}

#[test]
fn the_same_picture_may_be_there_already() {
    let place = Place::new();
    place.put("x-0.png", PNG);
    place.write("x.obj", &painted(1.0, PNG)).unwrap();
    assert_eq!(place.names(), ["x-0.png", "x.mtl", "x.obj"]);
}

#[test]
fn companions_of_an_earlier_run_are_replaced() {
    let place = Place::new();
    place.write("x.obj", &painted(1.0, PNG)).unwrap();
    place.write("x.obj", &painted(0.5, b"\x89PNG\r\n\x1a\n two, which is longer")).unwrap();
    assert_eq!(place.get("x-0.png"), b"\x89PNG\r\n\x1a\n two, which is longer");
    assert_eq!(read(place.path("x.obj")).unwrap().materials[0].base_color[0], 0.5);
    assert_eq!(place.names(), ["x-0.png", "x.mtl", "x.obj"]);
}

#[test]
fn what_was_changed_since_is_someones_work() {
    let place = Place::new();
    place.write("x.obj", &painted(1.0, PNG)).unwrap();
    let mut library = place.get("x.mtl");
    library.extend_from_slice(b"Ns 96\n");
    place.put("x.mtl", &library);
    place.refuses(&painted(0.5, PNG), "x.mtl");
    place.overwrite("x.obj", &painted(0.5, PNG)).unwrap();
    place.put("x-0.png", b"retouched");
    place.refuses(&painted(0.5, PNG), "x-0.png");
}

#[test]
fn companions_of_another_output_are_not_replaced() {
    let place = Place::new();
    place.write("y.obj", &painted(1.0, PNG)).unwrap();
    std::fs::rename(place.path("y.mtl"), place.path("x.mtl")).unwrap();
    place.refuses(&painted(1.0, PNG), "x.mtl");
}

/// Nor a link to a file of an earlier run.
#[cfg(unix)]
#[test]
fn companions_never_go_through_a_link() {
    let place = Place::new();
    place.write("x.obj", &painted(1.0, PNG)).unwrap();
    for (name, picture) in [("x.mtl", PNG), ("x-0.png", b"\x89PNG\r\n\x1a\n two")] {
        let elsewhere = place.path("elsewhere");
        let content = place.get(name);
        std::fs::rename(place.path(name), &elsewhere).unwrap();
        std::os::unix::fs::symlink(&elsewhere, place.path(name)).unwrap();
        place.refuses(&painted(0.5, picture), name);
        // With permission, the link is replaced, not its target.
        place.overwrite("x.obj", &painted(1.0, PNG)).unwrap();
        assert!(!std::fs::symlink_metadata(place.path(name)).unwrap().is_symlink());
        assert_eq!(std::fs::read(&elsewhere).unwrap(), content);
        std::fs::remove_file(&elsewhere).unwrap();
    }
    // A dangling link is a link as well.
    let place = Place::new();
    std::os::unix::fs::symlink(place.path("gone"), place.path("x.mtl")).unwrap();
    place.refuses(&painted(1.0, PNG), "x.mtl");
}

#[test]
fn a_folder_in_the_way_of_a_companion_is_an_error() {
    let place = Place::new();
    std::fs::create_dir(place.path("x.mtl")).unwrap();
    let error = place.overwrite("x.obj", &painted(1.0, PNG)).unwrap_err();
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
    assert_eq!(place.names(), ["x.mtl"]);
}

#[test]
fn an_output_that_is_its_own_input_keeps_its_companions() {
    let place = Place::new();
    place.write("x.obj", &painted(1.0, PNG)).unwrap();
    for _ in 0..2 {
        let mut again = read(place.path("x.obj")).unwrap();
        again.materials[0].base_color[0] *= 0.5;
        place.write("x.obj", &again).unwrap();
    }
    assert_eq!(read(place.path("x.obj")).unwrap().materials[0].base_color[0], 0.25);
    assert_eq!(place.get("x-0.png"), PNG);
    // The picture is still known to be from the first run.
    place.write("x.obj", &painted(1.0, b"\x89PNG\r\n\x1a\n two")).unwrap();
    assert_eq!(place.get("x-0.png"), b"\x89PNG\r\n\x1a\n two");
}

#[test]
fn names_of_outputs_that_need_care() {
    for name in [
        "my mesh.obj",
        "two\nlines.obj",
        " spaces .obj",
        "back\\.obj",
        "in\\side.obj",
        "a:b.obj",
        "-s 1.obj",
        "é%20#1.obj",
    ] {
        if cfg!(windows) && name.contains(['\n', '\\', ':']) {
            continue;
        }
        let place = Place::new();
        place.write(name, &painted(0.5, PNG)).unwrap_or_else(|error| panic!("{name:?}: {error}"));
        let again = read(place.path(name)).unwrap();
        assert_eq!(again.materials[0].base_color[0], 0.5, "{name:?}: {:?}", again.notes);
        let image = &again.images[again.materials[0].base_color_image.unwrap() as usize];
        let ImageData::Uri(picture) = &image.data else { panic!("{image:?}") };
        assert_eq!(std::fs::read(place.folder.path().join(picture)).unwrap(), PNG, "{name:?}");
        // And again, in the same place.
        place.write(name, &painted(0.25, PNG)).unwrap();
    }
    // The library must not have the name of the output itself.
    let place = Place::new();
    let options = WriteOptions { format: Some(mesh_io::Format::Obj), ..WriteOptions::default() };
    write(place.path("x.mtl"), &painted(0.5, PNG), &options).unwrap();
    assert_eq!(place.names(), ["x-0.png", "x.mtl", "x.mtl.mtl"]);
}

#[cfg(unix)]
#[test]
fn a_device_gets_no_companions() {
    let options = WriteOptions { format: Some(mesh_io::Format::Obj), ..WriteOptions::default() };
    let report = write("/dev/null", &painted(0.5, PNG), &options).unwrap();
    assert!(report.companions.is_empty());
    assert!(report.lost.iter().any(|lost| lost.what == "embedded images"));
    assert!(!Path::new("/dev/null.mtl").exists());
}

#[test]
fn nothing_is_written_before_everything_can_be() {
    let place = Place::new();
    place.put("x.obj", b"old");
    std::fs::create_dir(place.path("y.obj")).unwrap();
    // The companions would be fine, the output is a folder.
    assert!(place.write("y.obj", &painted(1.0, PNG)).is_err());
    assert_eq!(place.names(), ["x.obj", "y.obj"]);
    let staged = mesh_io::stage(place.path("x.obj"), &painted(1.0, PNG), &WriteOptions::default());
    let staged = staged.unwrap();
    assert_eq!(staged.report().companions.len(), 2);
    assert_eq!(place.get("x.obj"), b"old");
    drop(staged);
    assert_eq!(place.names(), ["x.obj", "y.obj"]);
}

/// Another program creates the companion first.
#[test]
fn a_companion_that_appears_while_the_output_is_written_is_not_replaced() {
    let place = Place::new();
    let staged = mesh_io::stage(place.path("x.obj"), &painted(1.0, PNG), &WriteOptions::default());
    place.put("x-0.png", b"holiday");
    assert!(matches!(staged.unwrap().commit(), Err(WriteError::Io { .. })));
    assert_eq!(place.get("x-0.png"), b"holiday");
    assert_eq!(place.names(), ["x-0.png"]);
}

/// The file would name itself as its material library or picture, and what was there would be gone.
#[test]
fn an_output_is_not_its_own_companion() {
    let place = Place::new();
    place.put("x.png", PNG);
    place.put("x.mtl", b"newmtl paint\nmap_Kd x.png\n");
    place.put("x.obj", b"mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paint\nf 1 2 3\n");
    let model = read(place.path("x.obj")).unwrap();
    let refuses = |name: &str, format: mesh_io::Format| {
        let options = WriteOptions { format: Some(format), ..WriteOptions::default() };
        let error = write(place.path(name), &model, &options).unwrap_err();
        assert!(matches!(&error, WriteError::OwnCompanion { .. }), "{name}: {error}");
    };
    let before = place.names();
    refuses("x.mtl", mesh_io::Format::Obj);
    for format in [mesh_io::Format::Obj, mesh_io::Format::Ply, mesh_io::Format::Glb] {
        refuses("x.png", format);
    }
    assert_eq!((place.names(), place.get("x.png")), (before, PNG.to_vec()));
    // A file without references may have any name that it is given.
    let options = WriteOptions { format: Some(mesh_io::Format::Stl), ..WriteOptions::default() };
    write(place.path("x.png"), &model, &options).unwrap();
}
