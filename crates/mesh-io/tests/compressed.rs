//! Compressed glTF files. The files in `compressed_scenes/` are one torus, packed by the npm package `gltfpack` 1.3.0:
//! without compression, with `-c`, with `-cc`, and with `-cc -ce khr`.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use crate::built_scene::{glb, parts, rich, without};
use mesh_io::{
    Compression, Format, Model, NewMesh, NewPrimitive, ReadError, ReadErrorKind, ReadOptions,
    Scene, ScenePrimitive, WriteError, WriteOptions, read_from, write_to,
};
use serde_json::{Value, json};

const PLAIN: &[u8] = include_bytes!("compressed_scenes/plain.glb");
const EXT: &[u8] = include_bytes!("compressed_scenes/ext.glb");
const EXT_FILTERS: &[u8] = include_bytes!("compressed_scenes/ext_filters.glb");
const KHR: &[u8] = include_bytes!("compressed_scenes/khr.glb");

fn model(file: &[u8]) -> Result<Model, ReadError> {
    read_from(&mut &file[..], &ReadOptions::default())
}

fn scene(file: &[u8]) -> Result<Scene, ReadError> {
    Scene::read_from(&mut &file[..], &ReadOptions::default())
}

fn written(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    scene.write_to(&mut bytes, Format::Glb).unwrap();
    bytes
}

/// A corner: position, normal, texture coordinates.
type Corner = ([f64; 3], [f32; 3], [f32; 2]);

/// The triangles in an order that does not depend on the file.
fn triangles(model: &Model) -> Vec<Vec<Corner>> {
    let corner = |place: usize| {
        let vertex = model.soup.corners()[place] as usize;
        let normal = model.corner_normals.as_ref().unwrap()[place];
        let position = model.soup.positions()[vertex].to_array();
        (position, normal, model.corner_uvs.as_ref().unwrap()[place])
    };
    let key = |&(position, _, uv): &Corner| (position.map(f64::to_bits), uv.map(f32::to_bits));
    let mut all: Vec<Vec<Corner>> = (0..model.soup.face_count())
        .map(|face| {
            let mut corners: Vec<Corner> = (3 * face..3 * face + 3).map(corner).collect();
            let first = (0..3).min_by_key(|&i| key(&corners[i])).unwrap();
            corners.rotate_left(first);
            corners
        })
        .collect();
    all.sort_by_key(|corners| corners.iter().map(key).collect::<Vec<_>>());
    all
}

#[test]
fn compressed_files_have_the_triangles_of_the_plain_one() {
    let plain = triangles(&model(PLAIN).unwrap());
    assert_eq!(plain.len(), 80);
    for (name, file) in [("ext", EXT), ("ext_filters", EXT_FILTERS), ("khr", KHR)] {
        let model = model(file).unwrap();
        let found = triangles(&model);
        assert_eq!(found.len(), plain.len(), "{name}");
        for (a, b) in found.iter().flatten().zip(plain.iter().flatten()) {
            assert_eq!((a.0, a.2), (b.0, b.2), "{name}");
            // A filter keeps directions with the bits of the plain file, and the last one may differ.
            let most = (0..3).map(|c| (a.1[c] - b.1[c]).abs()).fold(0.0, f32::max);
            assert!(most <= if name == "ext" { 0.0 } else { 2.5 / 127.0 }, "{name} {most}");
        }
        assert!(!model.lost.iter().any(|lost| lost.what.contains("meshopt")), "{:?}", model.lost);
    }
}

#[test]
fn a_compressed_scene_is_written_as_it_was_read() {
    for file in [EXT, EXT_FILTERS, KHR] {
        let read = scene(file).unwrap();
        let (json, binary) = parts(file);
        let (json_again, binary_again) = parts(&written(&read));
        assert_eq!(json_again, json);
        assert_eq!(binary_again[..binary.len()], binary);
    }
}

/// A mesh that changes leaves no compressed data behind, and the file no longer requires the extension.
#[test]
fn changed_meshes_are_plain() {
    let read = scene(EXT).unwrap();
    let content = read.meshes(&[0]).unwrap().remove(0).unwrap();
    let corners = content.model.soup.corners().as_chunks::<3>().0.to_vec();
    let primitive = content.primitives.into_iter().next().unwrap();
    let (attributes, targets) = (primitive.attributes, primitive.targets);
    let primitive = NewPrimitive { index: 0, attributes, targets, triangles: corners };
    let new = NewMesh { mesh: 0, primitives: vec![primitive] };
    let (changed, lost) = read.replaced(&[new]).unwrap();
    assert!(lost.is_empty());
    let file = written(&changed);
    let (json, _) = parts(&file);
    assert!(!json.to_string().contains("meshopt"), "{json}");
    assert_eq!(json["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(triangles(&model(&file).unwrap()), triangles(&model(EXT).unwrap()));
}

fn edited(edit: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut json, mut binary) = parts(EXT);
    edit(&mut json, &mut binary);
    glb(&json, &binary)
}

fn extension(json: &mut Value, view: usize) -> &mut Value {
    &mut json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"]
}

#[test]
fn damaged_streams_are_named_with_their_view() {
    let broken = [
        edited(|_, binary| binary[0] = 0xb0),
        edited(|json, _| extension(json, 0)["byteLength"] = json!(300)),
        edited(|json, _| extension(json, 0)["count"] = json!(53)),
        edited(|json, _| extension(json, 0)["byteStride"] = json!(16)),
        edited(|json, _| extension(json, 0)["buffer"] = json!(7)),
        edited(|json, _| extension(json, 0)["byteOffset"] = json!(u64::MAX)),
        edited(|json, _| {
            json["bufferViews"][0]["byteLength"] = json!(0);
            extension(json, 0)["count"] = json!(0);
        }),
        edited(|json, _| extension(json, 1)["filter"] = json!("QUATERNION")),
        edited(|json, _| extension(json, 0)["mode"] = json!("TRIANGLES")),
    ];
    for (case, file) in broken.iter().enumerate() {
        for error in [model(file).unwrap_err(), scene(file).unwrap_err()] {
            assert!(matches!(error.kind, ReadErrorKind::Malformed { .. }), "{case}: {error}");
            let place = match case {
                // The view is sound, but too short for its accessor.
                6 => "",
                7 => "bufferViews[1]",
                _ => "bufferViews[0]",
            };
            assert!(error.to_string().contains(place), "{case}: {error}");
        }
    }
    let error = model(&broken[0]).unwrap_err().to_string();
    assert!(error.contains("0xb0") && error.contains("export it again"), "{error}");
    // An unknown filter is a thing of another version.
    let file = edited(|json, _| extension(json, 0)["filter"] = json!("WAVELET"));
    let error = model(&file).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Unsupported { .. }), "{error}");
}

#[test]
fn decompressed_data_count_as_memory() {
    // A view that pretends to be large is refused before anything is decompressed.
    let file = edited(|json, _| {
        json["bufferViews"][0]["byteLength"] = json!(8_u64 << 40);
        extension(json, 0)["count"] = json!(1_u64 << 40);
    });
    for error in [model(&file).unwrap_err(), scene(&file).unwrap_err()] {
        assert!(matches!(error.kind, ReadErrorKind::Memory { .. }), "{error}");
    }
}

/// The data of a fallback buffer are used if they are there, and not missed if its file is not.
#[test]
fn a_fallback_buffer_need_not_be_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.glb");
    let file = edited(|json, _| json["buffers"][1]["uri"] = json!("fallback.bin"));
    std::fs::write(&path, &file).unwrap();
    let compressed = mesh_io::read(&path).unwrap();
    assert_eq!(triangles(&compressed), triangles(&model(EXT).unwrap()));
    let read = Scene::read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(read.meshes(&[0]).unwrap().len(), 1);
    let (_, plain) = parts(PLAIN);
    std::fs::write(folder.path().join("fallback.bin"), &plain).unwrap();
    assert_eq!(mesh_io::read(&path).unwrap().soup.vertex_count(), 54);
    // A buffer without any mark is a fallback if only compressed views refer to it.
    let file = edited(|json, _| {
        json["buffers"][1].as_object_mut().unwrap().remove("extensions");
    });
    assert_eq!(triangles(&model(&file).unwrap()), triangles(&compressed));
    let file = edited(|json, _| {
        json["bufferViews"][3].as_object_mut().unwrap().remove("extensions");
    });
    let error = model(&file).unwrap_err().to_string();
    assert!(error.contains("bufferViews[3]") || error.contains("buffers[1]"), "{error}");
}

/// For each primitive, its index and its triangles with all data of their corners, in an order that does not depend on
/// the file.
fn corners_of(scene: &Scene, mesh: usize) -> Vec<(usize, Vec<Vec<Vec<u8>>>)> {
    let Some(content) = scene.meshes(&[mesh]).unwrap().remove(0) else { return Vec::new() };
    let corners = content.model.soup.corners();
    let of = |primitive: &ScenePrimitive| {
        let all: Vec<_> =
            primitive.attributes.iter().chain(primitive.targets.iter().flatten()).collect();
        let corner = |vertex: &u32| {
            let vertex = (vertex - primitive.first_vertex) as usize;
            all.iter().flat_map(|data| data.value(vertex).to_vec()).collect::<Vec<u8>>()
        };
        let corners = &corners[3 * primitive.faces.start..3 * primitive.faces.end];
        let mut triangles: Vec<Vec<Vec<u8>>> = corners
            .chunks_exact(3)
            .map(|triangle| {
                let mut triangle: Vec<Vec<u8>> = triangle.iter().map(corner).collect();
                let first = (0..3).min_by_key(|&i| &triangle[i]).unwrap();
                triangle.rotate_left(first);
                triangle
            })
            .collect();
        triangles.sort();
        (primitive.index, triangles)
    };
    content.primitives.iter().map(of).collect()
}

fn compressed(file: &[u8]) -> Vec<u8> {
    written(&scene(file).unwrap().compressed().unwrap())
}

fn same_content(before: &[u8], after: &[u8]) {
    let [before, after] = [before, after].map(|file| scene(file).unwrap());
    assert_eq!(before.mesh_count(), after.mesh_count());
    for mesh in 0..before.mesh_count() {
        assert_eq!(corners_of(&before, mesh), corners_of(&after, mesh), "mesh {mesh}");
    }
    let parts = ["buffers", "bufferViews", "accessors", "extensionsUsed", "extensionsRequired"];
    assert_eq!(without(before.json(), &parts), without(after.json(), &parts));
}

#[test]
fn compressed_scenes_hold_the_same() {
    let file = rich().glb();
    let small = compressed(&file);
    same_content(&file, &small);
    let (json, binary) = parts(&small);
    assert_eq!(
        json["extensionsRequired"].as_array().unwrap().last().unwrap(),
        "EXT_meshopt_compression"
    );
    // One buffer with bytes, and one for the places of what is decompressed.
    assert_eq!(json["buffers"].as_array().unwrap().len(), 2, "{}", json["buffers"]);
    assert!(binary.len() * 2 < parts(&file).1.len(), "{} {}", binary.len(), parts(&file).1.len());
    // The order is already good the second time, and the views are compressed.
    same_content(&file, &compressed(&small));
    // Files of other programs, with and without compression, stay what they are too.
    for file in [PLAIN, EXT, EXT_FILTERS, KHR] {
        same_content(file, &compressed(file));
    }
    // No larger than what another program makes of the same numbers, up to the text.
    let [ours, theirs] = [&compressed(PLAIN)[..], EXT].map(|file| parts(file).1.len());
    assert!(ours <= theirs + 16, "{ours} {theirs}");
}

/// An unknown extension may refer to vertices, so that their order and all numbers of parts stay.
#[test]
fn what_unknown_extensions_may_refer_to_stays() {
    let (mut json, binary) = parts(PLAIN);
    json["meshes"][0]["extensions"] = json!({ "ACME_marks": { "vertices": [1, 5] } });
    let file = glb(&json, &binary);
    let small = compressed(&file);
    let [before, after] =
        [&file, &small].map(|file| scene(file).unwrap().meshes(&[0]).unwrap().remove(0).unwrap());
    assert_eq!(before.primitives[0].attributes, after.primitives[0].attributes);
    assert_eq!(before.model.soup.face_count(), after.model.soup.face_count());
    let (json, bytes) = parts(&small);
    assert_eq!(json["accessors"], parts(PLAIN).0["accessors"]);
    assert!(bytes.len() < binary.len());
}

#[test]
fn meshes_are_written_with_compression() {
    let model = model(PLAIN).unwrap();
    let options = WriteOptions { compression: Compression::Meshopt, ..WriteOptions::default() };
    for format in [Format::Glb, Format::Gltf] {
        let (mut plain, mut small) = (Vec::new(), Vec::new());
        write_to(&mut plain, &model, format, &WriteOptions::default()).unwrap();
        write_to(&mut small, &model, format, &options).unwrap();
        assert!(small.len() < plain.len());
        let [plain, small] = [&plain, &small].map(|file| self::model(file).unwrap());
        assert_eq!(triangles(&plain), triangles(&small));
    }
    let error = write_to(&mut Vec::new(), &model, Format::Ply, &options).unwrap_err();
    assert!(matches!(error, WriteError::NoCompression(Format::Ply)), "{error}");
}

/// A torus that `gltf-transform draco` has compressed, and what `gltf-transform copy`, with the decoder of Google,
/// makes of that.
const DRACO: &[u8] = include_bytes!("compressed_scenes/draco.glb");
const DRACO_PLAIN: &[u8] = include_bytes!("compressed_scenes/draco_plain.glb");

#[test]
fn draco_is_decompressed() {
    let [plain, found] = [DRACO_PLAIN, DRACO].map(|file| triangles(&model(file).unwrap()));
    assert_eq!(plain.len(), 80);
    assert_eq!(found, plain);
    let read = scene(DRACO).unwrap();
    assert_eq!(corners_of(&read, 0), corners_of(&scene(DRACO_PLAIN).unwrap(), 0));
    // What does not change is written in its compressed form.
    let (json, binary) = parts(DRACO);
    let (json_again, binary_again) = parts(&written(&read));
    assert_eq!(json_again, json);
    assert_eq!(binary_again[..binary.len()], binary);
    assert_eq!(written(&read.compressed().unwrap()), written(&read));
}

#[test]
fn damaged_draco_data_are_errors() {
    let (json, binary) = parts(DRACO);
    let mut random = fastrand::Rng::with_seed(1);
    let mut errors = 0;
    for _ in 0..300 {
        let mut damaged = binary.clone();
        for _ in 0..random.usize(1..4) {
            let place = random.usize(..damaged.len());
            damaged[place] = random.u8(..);
        }
        errors += u32::from(model(&glb(&json, &damaged)).is_err());
    }
    assert!(errors > 100, "{errors}");
    let mut damaged = binary.clone();
    damaged[0] = 0;
    let error = model(&glb(&json, &damaged)).unwrap_err().to_string();
    let place = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    assert!(error.contains(place) && error.contains("export it again"), "{error}");
    // Values of another type than the document says, and an attribute that is not there.
    for (pointer, value) in [
        ("/accessors/1/componentType", json!(5123)),
        ("/accessors/3/type", json!("VEC3")),
        (
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/attributes/NORMAL",
            json!(9),
        ),
    ] {
        let mut json = json.clone();
        *json.pointer_mut(pointer).unwrap() = value;
        let error = model(&glb(&json, &binary)).unwrap_err();
        assert!(error.to_string().contains(place), "{error}");
    }
    let mut json = json.clone();
    json["accessors"][1]["count"] = json!(1_u64 << 40);
    let error = model(&glb(&json, &binary)).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Memory { .. }), "{error}");
}

#[test]
fn attributes_that_draco_data_do_not_contain_are_zero_without_data() {
    let (mut json, binary) = parts(DRACO);
    let count = json["accessors"][1]["count"].clone();
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "componentType": 5126, "count": count, "type": "SCALAR" }));
    json["meshes"][0]["primitives"][0]["attributes"]["_HEAT"] = (accessors.len() - 1).into();
    let file = glb(&json, &binary);
    assert_eq!(triangles(&model(&file).unwrap()), triangles(&model(DRACO).unwrap()));
    let mesh = scene(&file).unwrap().mesh(0).unwrap().unwrap();
    let heat = mesh.primitives[0].attributes.iter().find(|data| data.name == "_HEAT").unwrap();
    assert_eq!(heat.count() as u64, count.as_u64().unwrap());
    assert!(heat.bytes.iter().all(|&byte| byte == 0));
}
