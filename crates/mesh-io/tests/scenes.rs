//! Scenes that are kept whole.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use crate::built_scene::{Builder, glb, parts, rich, tube, values, without};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mesh_io::{
    Format, NewMesh, NewPrimitive, ReadErrorKind, ReadOptions, Scene, SceneMesh, WriteError,
    read_from,
};
use proptest::prelude::*;
use serde_json::{Value, json};

fn scene(file: &[u8]) -> Scene {
    Scene::read_from(&mut &file[..], &ReadOptions::default()).unwrap()
}

fn written(scene: &Scene, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    scene.write_to(&mut bytes, format).unwrap();
    bytes
}

/// The document and the buffers of a written file.
fn content(file: &[u8]) -> (Value, Vec<Vec<u8>>) {
    if file.starts_with(b"glTF") {
        let (json, binary) = parts(file);
        return (json, vec![binary]);
    }
    let json: Value = serde_json::from_slice(file).unwrap();
    let of = |buffer: &Value| {
        let (_, data) = buffer["uri"].as_str().unwrap().split_once(',').unwrap();
        STANDARD.decode(data).unwrap()
    };
    let buffers = json["buffers"].as_array().unwrap().iter().map(of).collect();
    (json, buffers)
}

/// All primitives with triangles, as they are.
fn same(mesh: usize, content: SceneMesh) -> NewMesh {
    let corners = content.model.soup.corners();
    let primitive = |primitive: mesh_io::ScenePrimitive| {
        let corners = &corners[3 * primitive.faces.start..3 * primitive.faces.end];
        let triangles = corners.as_chunks::<3>().0.iter();
        NewPrimitive {
            index: primitive.index,
            triangles: triangles.map(|t| t.map(|v| v - primitive.first_vertex)).collect(),
            attributes: primitive.attributes,
            targets: primitive.targets,
        }
    };
    NewMesh { mesh, primitives: content.primitives.into_iter().map(primitive).collect() }
}

#[test]
fn a_scene_with_one_buffer_is_written_bit_for_bit() {
    let file = rich().glb();
    let (json, binary) = parts(&file);
    let (json_again, binary_again) = parts(&written(&scene(&file), Format::Glb));
    assert_eq!(json, json_again);
    assert!(binary == binary_again);
}

#[test]
fn everything_else_stays_where_vertices_are_replaced() {
    let file = rich().glb();
    let before = scene(&file);
    let meshes: Vec<NewMesh> = (0..before.mesh_count())
        .filter_map(|mesh| Some(same(mesh, before.mesh(mesh).unwrap()?)))
        .collect();
    assert_eq!(meshes.len(), 3);
    let (after, lost) = before.replaced(&meshes).unwrap();
    assert_eq!(lost, []);
    for format in [Format::Glb, Format::Gltf] {
        let (old, old_bytes) = content(&file);
        let (new, new_bytes) = content(&written(&after, format));
        let changing = ["accessors", "bufferViews", "buffers", "meshes", "animations", "skins"];
        assert_eq!(without(&old, &changing), without(&new, &changing));
        // The values of all accessors are the same, through every reference.
        let same_values = |old_accessor: &Value, new_accessor: &Value| {
            let index = |accessor: &Value| accessor.as_u64().unwrap() as usize;
            let old = values(&old, &old_bytes, index(old_accessor));
            let new = values(&new, &new_bytes, index(new_accessor));
            assert_eq!(old, new);
        };
        for (pointer, count) in [("/animations/0/samplers/0", 2), ("/skins/0", 1)] {
            let names = ["input", "output", "inverseBindMatrices"];
            let [old, new] = [&old, &new].map(|json| json.pointer(pointer).unwrap());
            let found = names.iter().filter_map(|name| Some((old.get(name)?, new.get(name)?)));
            assert_eq!(found.map(|(old, new)| same_values(old, new)).count(), count);
        }
        for mesh in 0..3 {
            let [old, new] = [&old, &new].map(|json| &json["meshes"][mesh]);
            assert_eq!(without(old, &["primitives"]), without(new, &["primitives"]));
            let [old, new] = [old, new].map(|mesh| mesh["primitives"].as_array().unwrap());
            assert_eq!(old.len(), new.len());
            for (old, new) in old.iter().zip(new) {
                let changing = ["attributes", "indices", "targets"];
                assert_eq!(without(old, &changing), without(new, &changing));
                if let Some(indices) = old.get("indices") {
                    same_values(indices, &new["indices"]);
                }
                for (name, accessor) in old["attributes"].as_object().unwrap() {
                    same_values(accessor, &new["attributes"][name]);
                }
                if let Some(targets) = old.get("targets") {
                    same_values(&targets[0]["POSITION"], &new["targets"][0]["POSITION"]);
                }
            }
        }
        // A reader that is not ours agrees with the format, and nothing is left over.
        let gltf::Gltf { document, .. } = gltf::Gltf::from_slice(&written(&after, format)).unwrap();
        assert_eq!(document.nodes().count(), 8);
        assert_eq!(document.animations().next().unwrap().name(), Some("wave"));
        let used = used_accessors(&new);
        assert!(used.iter().all(|&is| is), "{used:?}");
    }
    // The lines have kept their positions: 441 of them beside the new ones.
    let lines = &after.json()["meshes"][2]["primitives"][2];
    assert_eq!(lines["mode"], 3);
}

fn used_accessors(json: &Value) -> Vec<bool> {
    let mut used = vec![false; json["accessors"].as_array().unwrap().len()];
    let mut mark = |value: &Value| {
        if let Some(index) = value.as_u64() {
            used[index as usize] = true;
        }
    };
    for mesh in json["meshes"].as_array().unwrap() {
        for primitive in mesh["primitives"].as_array().unwrap() {
            mark(&primitive["indices"]);
            primitive["attributes"].as_object().unwrap().values().for_each(&mut mark);
            mark(&primitive["targets"][0]["POSITION"]);
        }
    }
    mark(&json["skins"][0]["inverseBindMatrices"]);
    mark(&json["animations"][0]["samplers"][0]["input"]);
    mark(&json["animations"][0]["samplers"][0]["output"]);
    used
}

#[test]
fn fewer_triangles_make_the_file_smaller_by_what_they_took() {
    let file = rich().glb();
    let before = scene(&file);
    let mut wheel = same(0, before.mesh(0).unwrap().unwrap());
    let old = wheel.primitives[0].triangles.len();
    wheel.primitives[0].triangles.truncate(old / 2);
    let (after, _) = before.replaced(&[wheel]).unwrap();
    let sizes = [&before, &after].map(|scene| content(&written(scene, Format::Glb)).1[0].len());
    // Indices had four bytes each, and have two.
    assert_eq!(sizes[0] - sizes[1], 4 * 3 * old - 2 * 3 * (old / 2));
    let model = read_from(&mut &written(&after, Format::Glb)[..], &ReadOptions::default()).unwrap();
    let whole = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
    // The wheel is drawn twice.
    assert_eq!(model.soup.face_count(), whole.soup.face_count() - 2 * (old - old / 2));
}

#[test]
fn a_mesh_is_read_as_the_reader_of_models_reads_it() {
    let mut alone = Builder::new();
    let tube = tube(12, 9);
    let attributes = json!({
        "POSITION": alone.positions(&tube.positions), "NORMAL": alone.floats(&tube.normals),
        "TEXCOORD_0": alone.floats(&tube.uvs), "TEXCOORD_1": alone.floats(&tube.uvs),
    });
    let primitive = json!({ "attributes": attributes, "indices": alone.indices(&tube.triangles) });
    alone.push("meshes", json!({ "primitives": [primitive] }));
    alone.node(json!({ "mesh": 0 }));
    let file = alone.glb();
    let model = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
    let scene = scene(&file);
    let mesh = scene.mesh(0).unwrap().unwrap();
    assert_eq!(mesh.model.soup, model.soup);
    assert_eq!(mesh.model.corner_uvs, model.corner_uvs);
    assert_eq!(mesh.model.more_corner_uvs, model.more_corner_uvs);
    assert_eq!(mesh.model.corner_normals, model.corner_normals);
    let counts = [model.soup.vertex_count() as u64, model.soup.face_count() as u64];
    assert_eq!(scene.counts(), counts);
}

#[test]
fn meshes_are_where_the_nodes_draw_them() {
    let scene = scene(&rich().glb());
    let draws = scene.draws().unwrap();
    let of = |mesh: usize| draws.iter().filter(move |draw| draw.mesh == mesh);
    let scales: Vec<f64> = of(0).map(mesh_io::SceneDraw::scale).collect();
    assert!(
        scales.len() == 2 && (scales[0] - 1.0).abs() < 1e-12 && (scales[1] - 3.0).abs() < 1e-12
    );
    // The joints and their inverses cancel in the rest pose.
    let arm: Vec<_> = of(1).collect();
    assert!(arm.len() == 1 && arm[0].times == 1 && (arm[0].scale() - 1.0).abs() < 1e-12);
    let whole = read_from(&mut &rich().glb()[..], &ReadOptions::default()).unwrap();
    assert_eq!(scene.counts()[1], whole.soup.face_count() as u64);
}

#[test]
fn extensions_that_may_refer_to_vertices_are_named_or_refused() {
    let place = |scene: &mut Builder, extension: Value| {
        scene.json["meshes"][0]["primitives"][0]["extensions"] =
            json!({ "ACME_outline": extension });
        scene.json["extensionsUsed"].as_array_mut().unwrap().push("ACME_outline".into());
    };
    let mut builder = rich();
    place(&mut builder, json!({ "indices": 3 }));
    let outlined = scene(&builder.glb());
    let new = [same(0, outlined.mesh(0).unwrap().unwrap())];
    let (after, lost) = outlined.replaced(&new).unwrap();
    assert!(lost.len() == 1 && lost[0].what.contains("ACME_outline"), "{lost:?}");
    assert!(!after.json().to_string().contains("ACME_outline"));
    // Without numbers it cannot refer to anything, and stays.
    let mut builder = rich();
    place(&mut builder, json!({ "width": 0.5, "color": "red" }));
    let outlined = scene(&builder.glb());
    let (after, lost) = outlined.replaced(&new).unwrap();
    assert_eq!(lost, []);
    assert_eq!(
        after.json()["meshes"][0]["primitives"][0]["extensions"]["ACME_outline"]["width"],
        0.5
    );
    // A document that requires it is refused.
    let mut builder = rich();
    place(&mut builder, json!({ "indices": 3 }));
    builder.json["extensionsRequired"] = json!(["ACME_outline"]);
    let outlined = scene(&builder.glb());
    let error = outlined.replaced(&new).unwrap_err();
    assert!(matches!(&error, WriteError::Scene(text) if text.contains("requires")), "{error}");
    // Elsewhere, what it refers to keeps its index, and the old data stay.
    let mut builder = rich();
    builder.json["nodes"][0]["extensions"] = json!({ "ACME_sound": { "bufferView": 2 } });
    builder.json["extensionsUsed"].as_array_mut().unwrap().push("ACME_sound".into());
    let sounding = scene(&builder.glb());
    let (after, lost) = sounding.replaced(&new).unwrap();
    assert_eq!(lost, []);
    for list in ["accessors", "bufferViews", "buffers"] {
        let [old, new] = [&sounding, &after].map(|scene| scene.json()[list].as_array().unwrap());
        assert!(new.len() > old.len() && new[..old.len()] == old[..], "{list}");
    }
    // The buffers stay apart, and the file can be read.
    for format in [Format::Glb, Format::Gltf] {
        scene(&written(&after, format)).mesh(0).unwrap().unwrap();
    }
}

#[test]
fn data_that_do_not_fit_are_refused() {
    let before = scene(&rich().glb());
    let new = || same(0, before.mesh(0).unwrap().unwrap());
    let refused = |change: &dyn Fn(&mut NewMesh)| {
        let mut mesh = new();
        change(&mut mesh);
        let error = before.replaced(&[mesh]).unwrap_err();
        assert!(matches!(error, WriteError::Scene(_)), "{error}");
    };
    refused(&|mesh| mesh.mesh = 99);
    refused(&|mesh| mesh.primitives[0].index = 99);
    refused(&|mesh| mesh.primitives[0].attributes.clear());
    refused(&|mesh| mesh.primitives[0].attributes[0].bytes.truncate(13));
    refused(&|mesh| mesh.primitives[0].triangles[0][0] = 1_000_000);
    refused(&|mesh| mesh.primitives[0].triangles.clear());
}

#[test]
fn hostile_documents_are_errors() {
    let error = |json: Value| {
        let file = glb(&json, &[0; 64]);
        let read = Scene::read_from(&mut &file[..], &ReadOptions::default());
        read.and_then(|scene| {
            scene.draws()?;
            scene.meshes(&(0..scene.mesh_count()).collect::<Vec<_>>())
        })
    };
    let base = |accessor: Value, primitive: Value| {
        json!({
            "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 64 }],
            "bufferViews": [{ "buffer": 0, "byteLength": 64 }], "accessors": [accessor],
            "meshes": [{ "primitives": [primitive] }], "nodes": [{ "mesh": 0 }],
        })
    };
    let positions = json!({ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" });
    let plain = json!({ "attributes": { "POSITION": 0 } });
    assert!(error(base(positions.clone(), plain.clone())).is_ok());
    let huge = json!({ "componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3" });
    let lying = json!({ "bufferView": 0, "componentType": 5126, "count": 99, "type": "VEC3" });
    for accessor in [huge, lying] {
        assert!(error(base(accessor, plain.clone())).is_err());
    }
    for primitive in [
        json!({ "attributes": { "POSITION": 9 } }),
        json!({ "attributes": { "POSITION": 0 }, "indices": 7 }),
        json!({ "attributes": { "POSITION": 0 }, "material": 7 }),
        json!({ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 7 }] }),
        json!({ "attributes": { "POSITION": 0, "_M": 1 } }),
    ] {
        assert!(error(base(positions.clone(), primitive)).is_err());
    }
    // Many meshes that share their data: each would get a copy.
    let mut shared = base(positions.clone(), plain.clone());
    shared["accessors"][0] = json!({ "componentType": 5126, "count": 300_000, "type": "VEC3" });
    shared["meshes"] = Value::from(vec![shared["meshes"][0].clone(); 3000]);
    let found = error(shared).unwrap_err();
    assert!(matches!(found.kind, ReadErrorKind::Memory { .. }), "{found}");
    // A document that becomes far more than its text.
    let many = vec![json!({ "": 0 }); 200_000];
    let mut wide = base(positions.clone(), plain.clone());
    wide["extras"] = Value::from(many);
    let found = error(wide).unwrap_err();
    assert!(matches!(found.kind, ReadErrorKind::Memory { .. }), "{found}");
    // Nodes that are their own parents.
    let mut loops = base(positions, plain);
    loops["nodes"] = json!([{ "children": [0] }]);
    loops["scenes"] = json!([{ "nodes": [0] }]);
    assert!(error(loops).is_err());
    let ply =
        Scene::read_from(&mut &b"ply\nformat ascii 1.0\nend_header\n"[..], &ReadOptions::default());
    assert!(matches!(ply.unwrap_err().kind, ReadErrorKind::Malformed { .. }));
}

#[test]
fn damaged_files_never_panic() {
    let file = rich().glb();
    let text = 20 + parts(&file).0.to_string().len();
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..400 {
        let mut damaged = file.clone();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(20..text);
            // Digits become other digits, so that most documents stay JSON.
            damaged[at] =
                if damaged[at].is_ascii_digit() { b'0' + random.u8(0..10) } else { damaged[at] };
        }
        let Ok(scene) = Scene::read_from(&mut &damaged[..], &ReadOptions::default()) else {
            continue;
        };
        let _ = scene.draws();
        let mut out = Vec::new();
        let _ = scene.write_to(&mut out, Format::Glb);
        for mesh in 0..scene.mesh_count() {
            if let Ok(Some(content)) = scene.mesh(mesh)
                && let Ok((after, _)) = scene.replaced(&[same(mesh, content)])
            {
                let _ = after.write_to(&mut out, Format::Gltf);
            }
        }
    }
}

/// An accessor of any type, dense or sparse, interleaved or not.
#[derive(Clone, Debug)]
struct Layout {
    kind: u32,
    width: usize,
    count: usize,
    gap: usize,
    offset: usize,
    buffer: usize,
    sparse: bool,
    seed: u64,
}

fn layouts() -> impl Strategy<Value = Vec<Layout>> {
    let kind = prop::sample::select(vec![5120_u32, 5121, 5122, 5123, 5125, 5126]);
    let one = (
        kind,
        1..=4_usize,
        1..20_usize,
        0..3_usize,
        0..3_usize,
        0..3_usize,
        any::<bool>(),
        any::<u64>(),
    );
    let one = one.prop_map(|(kind, width, count, gap, offset, buffer, sparse, seed)| Layout {
        kind,
        width,
        count,
        gap,
        offset,
        buffer,
        sparse,
        seed,
    });
    prop::collection::vec(one, 1..8)
}

/// A document with these accessors in three buffers, and nothing that uses them except extras.
fn document(layouts: &[Layout]) -> (Value, Vec<Vec<u8>>) {
    let mut buffers = vec![Vec::new(); 3];
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    for layout in layouts {
        let size = match layout.kind {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        };
        let mut random = fastrand::Rng::with_seed(layout.seed);
        let length = size * layout.width;
        let stride = length.next_multiple_of(4) + 4 * layout.gap;
        let buffer: &mut Vec<u8> = &mut buffers[layout.buffer];
        let mut view = |bytes: usize, stride: Option<usize>, random: &mut fastrand::Rng| {
            let start = buffer.len().next_multiple_of(4);
            buffer.resize(start, 0);
            buffer.extend((0..bytes).map(|_| random.u8(0..128)));
            let mut view =
                json!({ "buffer": layout.buffer, "byteOffset": start, "byteLength": bytes });
            if let Some(stride) = stride {
                view["byteStride"] = stride.into();
            }
            views.push(view);
            views.len() - 1
        };
        let offset = 4 * layout.offset;
        let dense = view(offset + layout.count * stride, Some(stride), &mut random);
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][layout.width - 1];
        let mut accessor = json!({
            "bufferView": dense, "byteOffset": offset, "componentType": layout.kind,
            "count": layout.count, "type": shape,
        });
        if layout.sparse {
            let values = view(length, None, &mut random);
            buffer_zero(&mut views, &mut buffers[layout.buffer], &mut accessor, values);
        }
        accessors.push(accessor);
    }
    let mut triangle = Vec::new();
    triangle.extend(
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()),
    );
    let start = buffers[0].len().next_multiple_of(4);
    buffers[0].resize(start, 0);
    buffers[0].extend(triangle);
    views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": 36 }));
    accessors.push(json!({
        "bufferView": views.len() - 1, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0],
    }));
    let position = accessors.len() - 1;
    let json = json!({
        "asset": { "version": "2.0" }, "bufferViews": views, "accessors": accessors,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": position } }] }], "nodes": [{ "mesh": 0 }],
    });
    (json, buffers)
}

/// Makes the first value of an accessor a sparse one.
fn buffer_zero(views: &mut Vec<Value>, buffer: &mut Vec<u8>, accessor: &mut Value, values: usize) {
    let start = buffer.len();
    buffer.push(0);
    let index = json!({ "buffer": views[values]["buffer"], "byteOffset": start, "byteLength": 1 });
    views.push(index);
    accessor["sparse"] = json!({
        "count": 1, "indices": { "bufferView": views.len() - 1, "componentType": 5121 },
        "values": { "bufferView": values },
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_values_of_all_accessors_survive(layouts in layouts()) {
        let (mut json, buffers) = document(&layouts);
        let uri = |bytes: &Vec<u8>| {
            let hex: String = bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
            json!({ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream,{hex}") })
        };
        json["buffers"] = buffers.iter().map(uri).collect();
        // An empty buffer is none.
        prop_assume!(buffers.iter().all(|buffer| !buffer.is_empty()));
        let before = scene(json.to_string().as_bytes());
        let (replaced, _) = before.replaced(&[same(0, before.mesh(0).unwrap().unwrap())]).unwrap();
        for scene in [&before, &replaced] {
            for format in [Format::Glb, Format::Gltf] {
                let (found, bytes) = content(&written(scene, format));
                for accessor in 0..layouts.len() {
                    let [old, new] = [(&json, &buffers), (&found, &bytes)]
                        .map(|(json, bytes)| values(json, bytes, accessor));
                    prop_assert_eq!(old, new);
                }
                let is_plain = std::ptr::eq(scene, &before);
                prop_assert!(!is_plain || found["accessors"] == json["accessors"]);
            }
        }
    }
}

#[test]
fn colours_in_whole_numbers_are_marked_and_mostly_zero_targets_stay_sparse() {
    let mut builder = rich();
    let colors =
        builder.json["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"].as_u64().unwrap();
    builder.json["accessors"][colors as usize]["normalized"] = false.into();
    let before = scene(&builder.glb());
    assert!(
        before.notes().len() == 1 && before.notes()[0].contains("marked"),
        "{:?}",
        before.notes()
    );
    let arm = before.mesh(1).unwrap().unwrap();
    assert!(
        arm.model.vertex_colors.as_ref().unwrap().iter().flatten().all(|channel| *channel <= 1.0)
    );
    let (after, _) = before.replaced(&[same(1, arm)]).unwrap();
    let arm = &after.json()["meshes"][1]["primitives"][0];
    let accessor = |index: &Value| &after.json()["accessors"][index.as_u64().unwrap() as usize];
    assert_eq!(accessor(&arm["attributes"]["COLOR_0"])["normalized"], true);
    let target = accessor(&arm["targets"][0]["POSITION"]);
    assert!(target.get("sparse").is_some() && target.get("bufferView").is_none(), "{target}");
}

#[test]
fn extensions_that_vertices_do_not_affect_may_be_required() {
    let mut builder = rich();
    builder.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    builder.json["extensionsRequired"] = json!(["KHR_node_visibility", "KHR_animation_pointer"]);
    let file = builder.clone().glb();
    let before = scene(&file);
    let new = same(0, before.mesh(0).unwrap().unwrap());
    let (after, lost) = before.replaced(&[new]).unwrap();
    assert_eq!(lost, []);
    for list in ["extensionsRequired", "nodes"] {
        assert_eq!(after.json()[list], builder.json[list]);
    }
    // One mesh of the whole scene would show what is hidden.
    let error = read_from(&mut &file[..], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("KHR_node_visibility"), "{error}");
    // An unknown extension can mean anything.
    builder.json["extensionsRequired"] = json!(["ACME_story"]);
    let error = scene(&builder.glb()).mesh(0).unwrap_err();
    assert!(error.to_string().contains("ACME_story"), "{error}");
}

#[test]
fn images_in_addresses_become_views_of_a_binary_file() {
    let picture = b"\x89PNG\r\n\x1a\nno more than its beginning";
    let uri = |media_type: &str| format!("data:{media_type};base64,{}", STANDARD.encode(picture));
    let mut builder = rich();
    for image in [
        json!({ "name": "a", "uri": uri("image/png") }),
        json!({ "uri": uri("application/octet-stream"), "extras": 7 }),
        json!({ "uri": uri("image/jpeg"), "mimeType": "image/jpeg" }),
        json!({ "uri": "apart.png" }),
    ] {
        builder.push("images", image);
    }
    let file = builder.glb();
    let read = scene(&file);
    let (old, old_bytes) = content(&file);
    let (new, new_bytes) = content(&written(&read, Format::Glb));
    assert!(new_bytes[0].starts_with(&old_bytes[0]));
    // The binary chunk is padded.
    let length = new["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
    assert_eq!(length.next_multiple_of(4), new_bytes[0].len());
    let changing = ["images", "bufferViews", "buffers"];
    assert_eq!(without(&old, &changing), without(&new, &changing));
    let [old_views, views] = [&old, &new].map(|json| json["bufferViews"].as_array().unwrap());
    assert_eq!(old_views[..], views[..old_views.len()]);
    let images = &new["images"];
    for (place, media_type) in ["image/png", "image/png", "image/jpeg"].iter().enumerate() {
        let view = &views[images[place]["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(view["byteLength"], picture.len());
        assert_eq!(new_bytes[0][start..start + picture.len()], picture[..]);
        assert_eq!(images[place]["mimeType"], *media_type);
        assert!(images[place].get("uri").is_none());
    }
    assert_eq!((&images[0]["name"], &images[1]["extras"]), (&json!("a"), &json!(7)));
    assert_eq!(images[3], json!({ "uri": "apart.png" }));
    // A text file keeps the addresses, and a scene without buffers gets one.
    assert_eq!(content(&written(&read, Format::Gltf)).0["images"], old["images"]);
    let alone = json!({ "asset": { "version": "2.0" }, "images": [{ "uri": uri("image/png") }] });
    let options = ReadOptions { allow_empty: true, ..ReadOptions::default() };
    let alone = Scene::read_from(&mut &serde_json::to_vec(&alone).unwrap()[..], &options).unwrap();
    let (json, buffers) = content(&written(&alone, Format::Glb));
    assert_eq!(json["images"][0]["bufferView"], 0);
    assert_eq!(buffers[0][..picture.len()], picture[..]);
}

proptest! {
    /// Colours with a range other than 0 to 1 are divided, in a model and in a scene alike, and a note says so.
    #[test]
    fn colors_of_a_scene_are_from_0_to_1(
        (kind, width, bytes) in (0..6_usize, 3..=4_usize, prop::collection::vec(prop::array::uniform4(0..=255_u8), 3..30)),
    ) {
        // The range shows in the data: full intensity is there, and few channels are almost black.
        let bytes: Vec<[u8; 4]> = bytes.into_iter().chain([[255, 128, 64, 255]]).map(|c| c.map(|v| v.max(2))).collect();
        let (component, full, normalized) =
            [(5121, 255.0, true), (5121, 255.0, false), (5123, 255.0, false), (5123, 65535.0, false), (5126, 255.0, false), (5126, 1.0, false)][kind];
        let channel = |value: u8| -> Vec<u8> {
            let value = f64::from(value) / 255.0 * full;
            match component {
                5121 => vec![value.round() as u8],
                5123 => (value.round() as u16).to_le_bytes().to_vec(),
                _ => (value as f32).to_le_bytes().to_vec(),
            }
        };
        let mut builder = Builder::new();
        let mut packed = Vec::new();
        for color in &bytes {
            packed.extend(color[..width].iter().flat_map(|&value| channel(value)));
            packed.resize(packed.len().next_multiple_of(4), 0);
        }
        let stride = packed.len() / bytes.len();
        let colors = builder.accessor(["VEC3", "VEC4"][width - 3], component, bytes.len(), &packed);
        builder.json["bufferViews"][colors]["byteStride"] = stride.into();
        if normalized {
            builder.json["accessors"][colors]["normalized"] = true.into();
        }
        let places: Vec<[f32; 3]> = (0..bytes.len()).map(|v| [v as f32, (v * v) as f32, 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (2..bytes.len() as u32).map(|v| [0, v - 1, v]).collect();
        let attributes = json!({ "POSITION": builder.positions(&places), "COLOR_0": colors });
        let primitive = json!({ "attributes": attributes, "indices": builder.indices(&triangles) });
        let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
        builder.node(json!({ "mesh": mesh }));
        let file = builder.glb();
        let read = scene(&file);
        let model = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
        let again = written(&read, Format::Glb);
        let carried = read_from(&mut &again[..], &ReadOptions::default()).unwrap();
        for model in [&model, &carried] {
            for (color, expected) in model.vertex_colors.as_ref().unwrap().iter().zip(&bytes) {
                for k in 0..width {
                    prop_assert!((color[k] - f32::from(expected[k]) / 255.0).abs() < 1e-5, "{color:?} {expected:?}");
                }
            }
        }
        let is_right = normalized || full == 1.0;
        prop_assert_eq!(read.notes().is_empty(), is_right, "{:?}", read.notes());
        prop_assert_eq!(model.notes.is_empty(), is_right, "{:?}", model.notes);
        let (json, buffers) = content(&again);
        let accessor = &json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64().unwrap() as usize];
        prop_assert!(accessor["componentType"] == 5126 || accessor["normalized"] == true, "{accessor}");
        prop_assert!(is_right == (without(&content(&file).0, &["asset", "buffers"]) == without(&json, &["asset", "buffers"])));
        // What is replaced does not stay in the file.
        let before = content(&file).1[0].len() - stride * bytes.len();
        prop_assert!(buffers[0].len() <= 16 + before + 4 * width * bytes.len());
    }
}
