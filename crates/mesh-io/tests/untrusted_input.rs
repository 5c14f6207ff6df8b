//! Misleading files: text with terminal escapes, lists that cause disproportionate work, and files that were once read
//! wrongly without an error.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use mesh_io::{
    Encoding, Format, ImageData, Model, ReadError, ReadErrorKind, ReadOptions, WriteOptions,
    read_from, read_with, write_to,
};
use std::fmt::Write;

fn parse(bytes: impl AsRef<[u8]>) -> Result<Model, ReadError> {
    let size = Some(bytes.as_ref().len() as u64);
    read_from(&mut bytes.as_ref(), &ReadOptions { size, ..ReadOptions::default() })
}

const EVIL: &str = "\u{1b}]0;owned\u{7}\u{202e}\u{9b}\u{2066}\u{feff}\u{200b}";

fn is_harmless(text: &str) -> bool {
    !text.chars().any(|c| c.is_control() || "\u{202e}\u{2066}\u{feff}\u{200b}\u{2028}".contains(c))
}

#[test]
fn nothing_that_is_quoted_from_a_file_speaks_to_the_terminal() {
    let escaped = serde_json::to_string(EVIL).unwrap();
    let asset = r#""asset":{"version":"2.0"}"#;
    let positions =
        r#""accessors":[{"componentType":5126,"count":3,"type":"VEC3"}],"nodes":[{"mesh":0}]"#;
    let files = [
        format!("{EVIL} and so on"),
        format!("ply\n{EVIL} 1\n"),
        format!("ply\nformat {EVIL} 1.0\n"),
        format!("ply\nformat ascii 1.0\nelement vertex {EVIL}\n"),
        format!("ply\nformat ascii 1.0\nelement vertex 1\nproperty float {EVIL}\nend_header\n0\n"),
        format!("ply\nformat ascii 1.0\nelement {EVIL} 99\nproperty float x\nend_header\n0\n"),
        format!(
            "ply\nformat ascii 1.0\nelement e 1\nproperty list int int {EVIL}\nend_header\n-1\n"
        ),
        format!("ply\nformat ascii 1.0\nelement e 1\nproperty float {EVIL}\nend_header\n{EVIL}\n"),
        format!("OFF\n1 0 0\n{EVIL} 0 0\n"),
        format!("nOFF\n{EVIL}\n"),
        format!("solid\nfacet {EVIL}\n{EVIL}\n"),
        format!("v 0 0 0\nf 1 {EVIL} 1\n"),
        format!("{{{asset},\"extensionsRequired\":[{escaped}]}}"),
        format!("{{{asset},\"accessors\":[{{\"type\":{escaped}}}]}}"),
        format!("{{{asset},\"buffers\":[{{\"byteLength\":1,\"uri\":{escaped}}}]}}"),
        format!("{{{asset},\"buffers\":[{{\"byteLength\":1,\"uri\":\"data:;base64,%1b\"}}]}}"),
        format!(
            "{{{asset},{positions},\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0,\"_\\u001b\\u202e\":9}}}}]}}]}}"
        ),
    ];
    for file in files {
        let error = parse(&file).expect_err(&file).to_string();
        assert!(is_harmless(&error), "{error:?}");
        assert!(error.len() < 2000, "{error:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{EVIL}.obj"));
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(&path, format!("mtllib {EVIL}.mtl\n{EVIL} 1\nusemtl {EVIL}\n{triangle}"))
        .unwrap();
    let model = read_with(&path, &ReadOptions::default()).unwrap();
    assert_eq!(model.notes.len(), 2);
    assert!(model.notes.iter().all(|note| is_harmless(note)), "{:?}", model.notes);
    // Names are data, and are not changed.
    assert_eq!(model.materials[0].name, EVIL.trim());
    std::fs::write(&path, "v 0\n").unwrap();
    let error = read_with(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(is_harmless(&error), "{error:?}");
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\nelement {EVIL} 1\nproperty int a\nend_header\n0 0 0\n0\n"
    );
    assert!(parse(ply).unwrap().notes.iter().all(|note| is_harmless(note)));
}

#[test]
fn letters_of_all_scripts_are_shown_as_they_are() {
    let error = parse("v 0 0 0\nf 1 Größe_日本 1\n").unwrap_err().to_string();
    assert!(error.contains("Größe_日本"), "{error}");
}

/// The square of this number of steps would take more than a day.
const MANY: usize = 400_000;

#[test]
fn many_names_in_an_obj_file_are_not_compared_with_each_other() {
    let mut file = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for index in 0..MANY {
        writeln!(file, "mtllib {index}\ng {index}\no {index}\nusemtl {index}").unwrap();
    }
    let model = parse(&file).unwrap();
    assert_eq!((model.material_libraries.len(), model.materials.len()), (MANY, MANY));
    // A long name is scanned once, not again with every group in it.
    let long = format!("o {}\n", "n".repeat(1 << 22));
    let file = format!("v 0 0 0\n{long}{}", "g a\ng b\n".repeat(MANY));
    assert_eq!(parse(file).unwrap().groups.len(), 3);
}

#[test]
fn many_libraries_and_materials_are_not_compared_with_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = String::from("v 0 0 0\n");
    (0..MANY).for_each(|index| writeln!(file, "mtllib {index}.mtl\nusemtl {index}").unwrap());
    file += "mtllib a.mtl\n";
    let path = folder.path().join("a.obj");
    std::fs::write(&path, &file).unwrap();
    let model = read_with(&path, &ReadOptions::default()).unwrap();
    assert!(model.notes.len() <= 101, "{}", model.notes.len());
    assert!(model.notes.iter().any(|note| note.contains("more notes")));
    let file = file.replace(".mtl\nusemtl", "\nusemtl").replace("mtllib ", "# ") + "mtllib a.mtl\n";
    std::fs::write(&path, &file).unwrap();
    let mut library = String::new();
    for index in (0..MANY).rev() {
        writeln!(library, "newmtl {index}\nKd 0 0 1\nmap_Kd {index}.png").unwrap();
    }
    std::fs::write(folder.path().join("a.mtl"), library).unwrap();
    let model = read_with(&path, &ReadOptions::default()).unwrap();
    assert_eq!(model.images.len(), MANY);
    for (index, material) in model.materials.iter().enumerate() {
        assert_eq!(material.base_color, [0.0, 0.0, 1.0, 1.0]);
        let image = material.base_color_image.unwrap() as usize;
        assert_eq!(model.images[image].data, ImageData::Uri(format!("{index}.png")));
    }
}

fn gltf(rest: &str) -> String {
    format!(r#"{{"asset":{{"version":"2.0"}},{rest}}}"#)
}

/// A triangle: the first view and accessor; then two sets of texture coordinates.
const TRIANGLE: &str = r#""buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":12,"byteLength":24}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
        {"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}]"#;

fn join(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join(",")
}

#[test]
fn many_primitives_are_not_compared_with_each_other() {
    // Each has its own vertices, because of an attribute that is not read.
    let primitives =
        join((0..100_000).map(|i| format!(r#"{{"attributes":{{"POSITION":0,"X{i}":0}}}}"#)));
    let file = gltf(&format!(
        r#"{TRIANGLE},"meshes":[{{"primitives":[{primitives}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    assert_eq!(parse(file).unwrap().soup.vertex_count(), 300_000);
}

#[test]
fn primitives_that_draw_nothing_cost_nothing_per_node() {
    let empty = r#"{"attributes":{"POSITION":0},"indices":3}"#.to_owned();
    let primitives = join(std::iter::repeat_n(empty, 50_000));
    let nodes = join(std::iter::repeat_n(r#"{"mesh":0}"#.to_owned(), 50_000));
    let no_index = r#"{"componentType":5125,"count":0,"type":"SCALAR"}]"#;
    let triangle = TRIANGLE.strip_suffix(']').unwrap();
    let file = gltf(&format!(
        r#"{triangle},{no_index},"meshes":[{{"primitives":[{primitives}]}}],"nodes":[{nodes}]"#
    ));
    let model = parse(file).unwrap();
    assert_eq!((model.soup.vertex_count(), model.soup.face_count()), (150_000, 0));
}

#[test]
fn points_beside_a_triangle_cost_nothing_per_node() {
    let points = r#"{"mode":0,"attributes":{"POSITION":0}},"#.repeat(100_000);
    let nodes = join(std::iter::repeat_n(r#"{"mesh":0}"#.to_owned(), 100_000));
    let file = gltf(&format!(
        r#"{TRIANGLE},"meshes":[{{"primitives":[{points}{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{nodes}]"#
    ));
    let model = parse(file).unwrap();
    assert_eq!((model.soup.face_count(), model.notes.len()), (100_000, 101));
}

/// A scene that is too large is refused before the values of its meshes are read.
#[test]
fn sparse_values_of_a_scene_that_is_too_large_are_not_looked_at() {
    let count = 40_000;
    let primitives =
        join((0..count).map(|i| format!(r#"{{"attributes":{{"POSITION":0,"X{i}":0}}}}"#)));
    let zeros = "AAAA".repeat(12 * count / 3);
    let file = gltf(&format!(
        r#""buffers":[{{"byteLength":{0},"uri":"data:;base64,{zeros}"}}],"bufferViews":[{{"buffer":0,"byteLength":{0}}}],
        "accessors":[{{"componentType":5126,"count":{count},"type":"VEC3","sparse":{{"count":{count},"indices":{{"bufferView":0,"componentType":5125}},"values":{{"bufferView":0}}}}}}],
        "meshes":[{{"primitives":[{primitives}]}}],"nodes":[{{"mesh":0}}]"#,
        12 * count
    ));
    let error = parse(file).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Memory { .. }), "{error}");
}

#[test]
fn sparse_indices_beyond_the_values_are_refused() {
    let file = gltf(
        r#""buffers":[{"byteLength":12,"uri":"data:;base64,BwAAAAAAAAAAAAAA"}],"bufferViews":[{"buffer":0,"byteLength":12}],
        "accessors":[{"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]"#,
    );
    let error = parse(file).unwrap_err().to_string();
    assert!(error.contains("meshes[0].primitives[0]") && error.contains("below 3"), "{error}");
}

#[test]
fn sparse_values_are_no_more_than_values() {
    let file = gltf(
        r#""buffers":[{"byteLength":12,"uri":"data:;base64,AAAAAAAAAAAAAAAA"}],"bufferViews":[{"buffer":0,"byteLength":12}],
        "accessors":[{"componentType":5126,"count":1,"type":"VEC3","sparse":{"count":12,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]"#,
    );
    assert!(parse(file).unwrap_err().to_string().contains("no more than 1 sparse values"));
}

fn close(a: [f32; 2], b: [f32; 2]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// The picture, the texture coordinates of the triangle (0, 0), (1, 0), (0, 0), and their expected values, from the
/// lower left.
#[test]
fn texture_transforms_are_applied() {
    let uvs = |info: &str| {
        let file = gltf(&format!(
            r#"{TRIANGLE},"images":[{{"uri":"a.png"}}],"textures":[{{"source":0}}],
            "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,{info}}}}}}}],
            "meshes":[{{"primitives":[{{"material":0,"attributes":{{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2}}}}]}}],"nodes":[{{"mesh":0}}]"#
        ));
        let model = parse(file).unwrap();
        assert!(model.notes.is_empty(), "{:?}", model.notes);
        model.corner_uvs.unwrap()
    };
    let transform =
        |text: &str| uvs(&format!(r#""extensions":{{"KHR_texture_transform":{{{text}}}}}"#));
    // As stored: (0, 0), (0, 1), (0, 0), from the upper left.
    let plain = uvs(r#""texCoord":0"#);
    assert!(close(plain[1], [0.0, 0.0]) && close(plain[0], [0.0, 1.0]), "{plain:?}");
    // (1, 0), (0, 0), (1, 0).
    let second = uvs(r#""texCoord":1"#);
    assert!(close(second[0], [1.0, 1.0]) && close(second[1], [0.0, 1.0]), "{second:?}");
    let same = transform(r#""texCoord":1"#);
    assert_eq!(same, second);
    let moved = transform(r#""offset":[0.25,0.5],"scale":[0.5,0.25],"texCoord":1"#);
    assert!(close(moved[0], [0.75, 0.5]) && close(moved[1], [0.25, 0.5]), "{moved:?}");
    // The example of the extension: the lower left quarter, turned clockwise by a right angle.
    let turned = transform(r#""offset":[0,1],"rotation":1.5707964,"scale":[0.5,0.5]"#);
    assert!(close(turned[0], [0.0, 0.0]) && close(turned[1], [0.5, 0.0]), "{turned:?}");
    let turned = transform(r#""offset":[0,1],"rotation":1.5707964,"scale":[0.5,0.5],"texCoord":1"#);
    assert!(close(turned[0], [0.0, 0.5]), "{turned:?}");
}

#[test]
fn texture_coordinates_that_are_not_there_are_noted() {
    let file = gltf(&format!(
        r#"{TRIANGLE},"images":[{{"uri":"a.png"}}],"textures":[{{"source":0}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,"texCoord":1}}}}}}],
        "meshes":[{{"primitives":[{{"material":0,"attributes":{{"POSITION":0,"TEXCOORD_0":1}}}}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    let model = parse(file).unwrap();
    assert!(model.corner_uvs.is_none());
    assert!(model.notes[0].contains("TEXCOORD_1"), "{:?}", model.notes);
}

#[test]
fn instances_on_the_graphics_card_are_all_there() {
    let node = |attributes: &str| {
        gltf(&format!(
            r#"{TRIANGLE},"extensionsRequired":["EXT_mesh_gpu_instancing"],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "nodes":[{{"mesh":0,"name":"n","translation":[10,0,0],"scale":[2,2,2],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{{attributes}}}}}}}}}]"#
        ))
    };
    let model = parse(node(r#""TRANSLATION":0"#)).unwrap();
    assert_eq!((model.soup.vertex_count(), model.soup.face_count()), (9, 3));
    // The second corner of each: (1, 0, 0), moved by the vertices of the triangle, scaled and moved.
    let corner = |instance: usize| model.soup.positions()[3 * instance + 1].to_array();
    assert_eq!(
        [corner(0), corner(1), corner(2)],
        [[12.0, 0.0, 0.0], [14.0, 0.0, 0.0], [12.0, 2.0, 0.0]]
    );
    assert_eq!(model.groups.len(), 1);
    let scaled = parse(node(r#""SCALE":0,"TRANSLATION":0,"_ID":0"#)).unwrap();
    assert_eq!(scaled.soup.positions()[4].to_array(), [14.0, 0.0, 0.0]);
    let file = node(r#""TRANSLATION":0,"SCALE":3"#);
    let file = file.replacen(
        r#""type":"VEC2"}]"#,
        r#""type":"VEC2"},{"componentType":5126,"count":7,"type":"VEC3"}]"#,
        1,
    );
    assert!(parse(file).unwrap_err().to_string().contains("values as in the other attributes"));
}

#[test]
fn compressed_data_without_a_fallback_are_refused_instead_of_zeros() {
    let draco = |accessor: &str| {
        gltf(&format!(
            r#""buffers":[{{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
            "extensionsUsed":["KHR_draco_mesh_compression"],"accessors":[{{{accessor}"componentType":5126,"count":3,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{"POSITION":0}}}}}}}}]}}],"nodes":[{{"mesh":0}}]"#
        ))
    };
    // Without indices, the data cannot be compressed by Draco.
    let error = parse(draco("")).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Malformed { .. }), "{error}");
    assert!(error.to_string().contains("KHR_draco_mesh_compression"), "{error}");
    let fallback = parse(draco(r#""bufferView":0,"#)).unwrap();
    assert_eq!(fallback.soup.positions()[1].x, 1.0);

    let meshopt = |uri: &str| {
        gltf(&format!(
            r#""buffers":[{{"byteLength":36,{uri}"extensions":{{"EXT_meshopt_compression":{{"fallback":true}}}}}}],
            "bufferViews":[{{"buffer":0,"byteLength":36,"extensions":{{"EXT_meshopt_compression":{{"buffer":1,"byteLength":9}}}}}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]"#
        ))
    };
    let error = parse(meshopt("")).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("an unknown mode"), "{error}");
    let uri = r#""uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA","#;
    assert_eq!(parse(meshopt(uri)).unwrap().soup.positions()[1].x, 1.0);

    let nothing = gltf(
        r#""accessors":[{"componentType":5126,"count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]"#,
    );
    assert!(parse(nothing).unwrap().notes[0].contains("all are zero"));
}

#[test]
fn looks_that_are_left_out_are_noted() {
    let file = gltf(&format!(
        r#"{TRIANGLE},"images":[{{"uri":"a.webp"}},{{"uri":"a.ktx2"}},{{"uri":"a.png"}}],
        "textures":[{{"extensions":{{"EXT_texture_webp":{{"source":0}}}}}},{{"extensions":{{"KHR_texture_basisu":{{"source":1}}}}}},
            {{"source":2,"extensions":{{"EXT_texture_webp":{{"source":0}}}}}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}},{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":1}}}}}},
            {{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":2}}}}}},
            {{"extensions":{{"KHR_materials_pbrSpecularGlossiness":{{"diffuseFactor":[0.5,0.25,0,1],"diffuseTexture":{{"index":2}}}}}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    let model = parse(file).unwrap();
    let images: Vec<_> = model.materials.iter().map(|m| m.base_color_image).collect();
    assert_eq!(images, [None, None, Some(2), Some(2)]);
    assert_eq!(model.materials[3].base_color, [0.5, 0.25, 0.0, 1.0]);
    for (note, word) in model.notes.iter().zip(["WebP", "Basis", "specular-glossiness"]) {
        assert!(note.contains(word), "{:?}", model.notes);
    }
    assert_eq!(model.notes.len(), 3);
}

#[test]
fn ply_texture_files_become_materials() {
    let header = |comments: &str, vertex: &str, face: &str| {
        format!(
            "ply\nformat ascii 1.0\n{comments}element vertex 3\nproperty float x\nproperty float y\nproperty float z\n{vertex}element face 2\nproperty list uchar int vertex_indices\n{face}end_header\n"
        )
    };
    let name = "comment TextureFile my wood.png\n";
    let body = "0 0 0\n1 0 0\n0 1 0\n";
    let with_uvs = "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n";
    let faces = "3 0 1 2\n3 0 2 1\n";
    let uvs = "property float s\nproperty float t\n";
    let model = parse(header(name, uvs, "") + with_uvs + faces).unwrap();
    assert_eq!(model.images[0].data, ImageData::Uri("my wood.png".to_owned()));
    assert_eq!(model.materials[0].base_color_image, Some(0));
    assert_eq!(model.face_materials, Some(vec![0, 0]));
    model.check().unwrap();
    let model = parse(header(name, "", "") + body + faces).unwrap();
    assert!(model.images.is_empty() && model.materials.is_empty());
    assert!(model.notes[0].contains("my wood.png"), "{:?}", model.notes);
    // Several texture files, as written by MeshLab.
    let two = format!("{name}comment TextureFile b.png\n");
    let face = "property list uchar float texcoord\nproperty int texnumber\n";
    let faces = "3 0 1 2 6 0 0 1 0 0 1 1\n3 0 2 1 6 0 0 1 0 0 1 -1\n";
    let model = parse(header(&two, "", face) + body + faces).unwrap();
    assert_eq!(model.face_materials, Some(vec![1, Model::NONE]));
    model.check().unwrap();
}

#[test]
fn carriage_returns_alone_end_lines() {
    let obj = "# made elsewhere\rv 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r";
    let model = parse(obj).unwrap();
    assert_eq!((model.soup.vertex_count(), model.soup.face_count()), (3, 1));
    let error = parse(obj.replace("f 1 2 3", "f 1 2 4")).unwrap_err();
    assert_eq!(error.location(), Some(&mesh_io::Location::Line(5)));
    for text in [
        "OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r",
        "# after a comment in the usual way\nv 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "v 0 0 0\r\r\nv 1 0 0\r\r\nv 0 1 0\r\r\nf 1 2 3",
        "solid\rfacet normal 0 0 1\router loop\rvertex 0 0 0\rvertex 1 0 0\rvertex 0 1 0\rendloop\rendfacet\rendsolid\r",
    ] {
        assert_eq!(parse(text).expect(text).soup.face_count(), 1, "{text}");
    }
    // Binary data that begins with a line feed.
    let header = "ply|format binary_little_endian 1.0|element vertex 1|property char x|property char y|property char z|end_header|";
    for ending in ["\r", "\n", "\r\n"] {
        let file = header.replace('|', ending) + "\n\r\n";
        let position = parse(file).unwrap().soup.positions()[0].to_array();
        assert_eq!(position, [10.0, 13.0, 10.0], "{ending:?}");
    }
}

#[test]
fn a_line_that_ends_at_the_edge_of_a_window() {
    let options = ReadOptions { format: Some(Format::Obj), ..ReadOptions::default() };
    for ending in ["\r", "\n", "\r\n"] {
        for padding in 65_500..65_540 {
            let file = format!("#{}{ending}v 1 2 3{ending}f 1 1 9{ending}", "x".repeat(padding));
            let error = read_from(&mut file.as_bytes(), &options).unwrap_err();
            assert_eq!(error.location(), Some(&mesh_io::Location::Line(3)), "{padding} {ending:?}");
        }
    }
}

#[test]
fn no_vertex_and_no_face_is_an_error_unless_it_may_be_empty() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (text, format) in [
        ("Dear all,\nthis is no mesh.\n", Some(Format::Obj)),
        ("# nothing\ng a\n", None),
        (ply, None),
        ("OFF\n0 0 0\n", None),
        ("solid\nendsolid\n", None),
        (r#"{"asset":{"version":"2.0"}}"#, None),
    ] {
        let mut options = ReadOptions { format, ..ReadOptions::default() };
        let error = read_from(&mut text.as_bytes(), &options).expect_err(text);
        assert!(matches!(error.kind, ReadErrorKind::Empty { .. }), "{error}");
        assert!(error.to_string().contains("--allow-empty"), "{error}");
        options.allow_empty = true;
        assert_eq!(read_from(&mut text.as_bytes(), &options).expect(text).soup.face_count(), 0);
    }
    // Points without faces are valid.
    assert_eq!(parse("v 1 2 3\n").unwrap().soup.vertex_count(), 1);
}

#[test]
fn off_binary_in_either_byte_order() {
    let mut model = Model::default();
    for index in 0..300_u32 {
        model.soup.push_vertex([f64::from(index), f64::from(index * index), -1.5]);
    }
    for index in 0..298 {
        model.soup.push_face(&[index, index + 1, index + 2]).unwrap();
    }
    model.soup.push_face(&[0, 1, 2, 3]).unwrap();
    let mut big = Vec::new();
    let options = WriteOptions { encoding: Encoding::BigEndian, ..WriteOptions::default() };
    write_to(&mut big, &model, Format::Off, &options).unwrap();
    let header = b"OFF BINARY\n".len();
    assert_eq!(&big[..header], b"OFF BINARY\n");
    let words = |bytes: &[u8]| bytes.as_chunks::<4>().0.to_vec();
    let mut little = big[..header].to_vec();
    little.extend(words(&big[header..]).iter().flat_map(|&[a, b, c, d]| [d, c, b, a]));
    // As written by OpenMesh: no number of colour components after a face.
    let mut bare = little[..header + 12 + 300 * 12].to_vec();
    let mut rest = &little[header + 12 + 300 * 12..];
    while let Some(&[corners, ..]) = rest.first_chunk::<4>() {
        let (face, after) = rest.split_at(4 + 4 * usize::from(corners));
        bare.extend(face);
        rest = &after[4..];
    }
    for (name, file) in [("big", &big), ("little", &little), ("bare", &bare)] {
        assert_eq!(parse(file).expect(name).soup, model.soup, "{name}");
    }
    // A stream of unknown length has the same order.
    for file in [&big, &little] {
        let read = read_from(&mut file.as_slice(), &ReadOptions::default()).unwrap();
        assert_eq!(read.soup, model.soup);
    }
}

/// The words of the second line were lost.
#[cfg(feature = "obj")]
#[test]
fn two_lines_of_an_obj_file_that_became_one_are_an_error() {
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (line, word) in [("vn 0 0 1 g side", "\"g\""), ("vt 0.5 1 vt 0 0", "\"vt\"")] {
        let error = parse(format!("{head}{line}\nf 1 2 3\n")).unwrap_err().to_string();
        assert!(error.contains(word) && error.contains("line 4"), "{error}");
    }
    for line in ["vn 0 0 1 # g side", "vt 0.5 1 0", "vn 0 0 1"] {
        assert!(parse(format!("{head}{line}\nf 1 2 3\n")).is_ok(), "{line}");
    }
}

/// Vertices outside of the loop became corners of the facet.
#[test]
fn vertices_beside_the_loop_of_an_stl_facet_are_an_error() {
    let vertices = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";
    let facet = |before: &str, after: &str| {
        format!(
            "solid\nfacet normal 0 0 1\n{before}outer loop\n{vertices}endloop\n{after}endfacet\nendsolid\n"
        )
    };
    assert_eq!(parse(facet("", "")).unwrap().soup.face_count(), 1);
    let second = format!("outer loop\n{vertices}endloop\n");
    for text in [facet("vertex 1 2 3\n", ""), facet("", "vertex 1 2 3\n"), facet("", &second)] {
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.contains("line"), "{error}");
    }
    // Some programs write no loops.
    let bare = format!("solid\nfacet normal 0 0 1\n{vertices}endfacet\nendsolid\n");
    assert_eq!(parse(bare).unwrap().soup.face_count(), 1);
}

#[cfg(feature = "gltf")]
#[test]
fn corners_of_an_incomplete_triangle_are_named() {
    let zeros = "A".repeat(64);
    for (count, mode, rest) in
        [(3, 4, None), (4, 4, Some(1)), (2, 4, Some(2)), (4, 5, None), (2, 5, Some(2))]
    {
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{mode}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3"}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}}],
            "buffers":[{{"byteLength":48,"uri":"data:application/octet-stream;base64,{zeros}"}}]}}"#
        );
        let model = parse(&text).unwrap();
        let lost = model.lost.iter().find(|lost| lost.what.contains("after the last triangle"));
        assert_eq!(lost.and_then(|lost| lost.count), rest, "{count} {mode}");
    }
}

/// The words after the last property were lost.
#[test]
fn a_row_of_a_ply_file_with_more_words_than_properties_is_an_error() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let with = |vertex: &str, face: &str| parse(format!("{head}0 0 0\n{vertex}\n0 1 0\n{face}\n"));
    assert!(with("1 0 0 ", "3 0 1 2\t").is_ok());
    for (vertex, face, line) in [("1 0 0 x", "3 0 1 2", 11), ("1 0 0", "3 0 1 2 3 0 2 1", 13)] {
        let error = with(vertex, face).unwrap_err().to_string();
        assert!(error.contains(&format!("line {line}")), "{error}");
    }
}
