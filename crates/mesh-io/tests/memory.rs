//! Files that ask for more memory than their size justifies, measured by a counting allocator.
//!
//! The tests share the allocator, so they run one after another.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use mesh_io::{
    Format, Image, ImageData, Model, ReadError, ReadErrorKind, ReadOptions, Scene, read_from,
    read_with,
};
use peak_alloc::PeakAlloc;
use std::fmt::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The largest number of bytes that a file of this size may take.
fn allowed(size: usize) -> usize {
    (64 << 20) + 60 * size
}

/// The result of reading, and the peak number of bytes.
fn measure(bytes: &[u8], options: &ReadOptions) -> (Result<Model, ReadError>, usize) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let result = read_from(&mut &bytes[..], options);
    (result, MEMORY.peak_usage() - before)
}

/// Reads a file within the memory that its size justifies, with known and with unknown size.
fn within(bytes: &[u8]) -> Result<Model, ReadError> {
    within_as(bytes, None)
}

fn within_as(bytes: &[u8], format: Option<Format>) -> Result<Model, ReadError> {
    let unknown = ReadOptions { format, ..ReadOptions::default() };
    let (_, peak) = measure(bytes, &unknown);
    assert!(peak <= allowed(bytes.len()), "{peak} for {} bytes of a stream", bytes.len());
    let (result, peak) = measure(bytes, &ReadOptions { size: Some(bytes.len() as u64), ..unknown });
    eprintln!("{} bytes: {peak} of {}", bytes.len(), allowed(bytes.len()));
    assert!(peak <= allowed(bytes.len()), "{peak} for {} bytes", bytes.len());
    if bytes.starts_with(b"glTF") || bytes.starts_with(b"{") {
        scene_within(bytes);
    }
    result
}

/// Reads a document as a scene, with all of its meshes, within the same memory.
fn scene_within(bytes: &[u8]) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let options = ReadOptions { size: Some(bytes.len() as u64), ..ReadOptions::default() };
    if let Ok(scene) = Scene::read_from(&mut &bytes[..], &options) {
        let all: Vec<usize> = (0..scene.mesh_count()).collect();
        let _content = (scene.draws(), scene.meshes(&all));
    }
    let peak = MEMORY.peak_usage() - before;
    assert!(peak <= allowed(bytes.len()), "{peak} for a scene of {} bytes", bytes.len());
}

fn too_much(result: Result<Model, ReadError>) -> u64 {
    match result.map(|model| model.soup.vertex_count()).expect_err("too much").kind {
        ReadErrorKind::Memory { needed, .. } => needed,
        other => panic!("{other}"),
    }
}

fn gltf(rest: &str) -> String {
    format!(r#"{{"asset":{{"version":"2.0"}},{rest}}}"#)
}

/// A triangle in a data URI: the first view and accessor.
const TRIANGLE: &str = r#""buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews":[{"buffer":0,"byteLength":36}]"#;
const ACCESSOR: &str = r#"{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}"#;

fn repeat(count: usize, item: impl Fn(usize) -> String) -> String {
    let mut list = String::new();
    for index in 0..count {
        list += if index > 0 { "," } else { "" };
        list += &item(index);
    }
    list
}

#[test]
fn gltf_attributes_of_zeros() {
    let _alone = alone();
    let attributes = repeat(200, |index| format!(r#""_A{index}":1"#));
    let file = gltf(&format!(
        r#""accessors":[{{"componentType":5126,"count":1048576,"type":"VEC3"}},{{"componentType":5126,"count":1048576,"type":"SCALAR"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,{attributes}}}}}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    assert!(file.len() < 4000);
    let needed = too_much(within(file.as_bytes()));
    assert!(needed > (200 * 8) << 20);
    let message = within(file.as_bytes()).unwrap_err().to_string();
    let allow = format!("--max-memory {}MiB", needed.div_ceil(1 << 20));
    assert!(message.contains(&allow), "{message}");
}

#[test]
fn obj_groups_of_an_object_with_a_long_name() {
    let _alone = alone();
    let mut file = format!("v 0 0 0\no {}\n", "n".repeat(300_000));
    (0..3000).for_each(|group| writeln!(file, "g {group}").unwrap());
    assert!(file.len() < 350_000);
    let needed = too_much(within(file.as_bytes()));
    // The memory for the rest of the file is not known yet.
    let message = within(file.as_bytes()).unwrap_err().to_string();
    let allow = format!("--max-memory {}MiB", (2 * needed).div_ceil(1 << 20));
    assert!(message.contains("more than") && message.contains(&allow), "{message}");
    // Repeating a group adds none.
    let file = format!("v 0 0 0\no {}\n{}", "n".repeat(300_000), "g a\n".repeat(50_000));
    assert_eq!(within(file.as_bytes()).unwrap().groups.len(), 2);
}

#[test]
fn gltf_notes_about_lines_in_a_mesh_that_many_nodes_share() {
    let _alone = alone();
    let file = |mode: u32| {
        let primitive = format!(r#"{{"mode":{mode},"attributes":{{"POSITION":0}}}}"#);
        let primitives = repeat(50, |_| primitive.clone());
        let nodes = repeat(100_000, |_| r#"{"mesh":0,"name":"n"}"#.to_owned());
        gltf(&format!(
            r#"{TRIANGLE},"accessors":[{ACCESSOR}],"meshes":[{{"primitives":[{primitives}]}}],"nodes":[{nodes}]"#
        ))
    };
    let error = within(file(1).as_bytes()).map(|_| ()).unwrap_err();
    assert!(matches!(&error.kind, ReadErrorKind::Empty { notes } if notes.len() == 51), "{error}");
    // Points are vertices, which the primitives share.
    let points = within(file(0).as_bytes()).map(|model| model.soup.vertex_count());
    assert_eq!(points.ok(), Some(300_000));
}

#[test]
fn gltf_primitives_without_indices_that_share_their_vertices() {
    let _alone = alone();
    // 3 x 2^18 vertices of one byte per coordinate, each drawn by 2,000 primitives.
    let primitives = repeat(2000, |_| r#"{"attributes":{"POSITION":0}}"#.to_owned());
    let json = gltf(&format!(
        r#""buffers":[{{"byteLength":2359296}}],"bufferViews":[{{"buffer":0,"byteLength":2359296}}],
        "accessors":[{{"bufferView":0,"componentType":5120,"count":786432,"type":"VEC3"}}],
        "meshes":[{{"primitives":[{primitives}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    too_much(within(&glb(&json, &vec![1; 2_359_296])));
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, bytes) in [(b"JSON", json.as_bytes()), (b"BIN\0", binary)] {
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(bytes);
    }
    file
}

#[test]
fn gltf_images_of_one_view() {
    let _alone = alone();
    let document = |views: &str, images: &str| {
        gltf(&format!(
            r#""buffers":[{{"byteLength":1000000}}],"bufferViews":[{views}],"images":[{images}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]"#
        ))
    };
    let binary = vec![0; 1_000_000];
    let whole = r#"{"buffer":0,"byteLength":1000000}"#;
    let images = repeat(2000, |_| r#"{"bufferView":0,"mimeType":"image/png"}"#.to_owned());
    let model = within(&glb(&document(whole, &images), &binary)).unwrap();
    assert_eq!(model.images.len(), 1);
    // Overlapping views are separate images, as long as they have no more bytes together than the buffer.
    let views = repeat(2000, |start| {
        format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, 1_000_000 - start)
    });
    let images = repeat(2000, |view| format!(r#"{{"bufferView":{view}}}"#));
    let model = within(&glb(&document(&views, &images), &binary)).unwrap();
    let length = |image: &Image| match &image.data {
        ImageData::Bytes(bytes) => bytes.len(),
        ImageData::Uri(_) => panic!("{image:?}"),
    };
    let lengths: Vec<usize> = model.images.iter().map(length).collect();
    assert_eq!((lengths[0], lengths.iter().sum::<usize>()), (1_000_000, 1_000_000));
    assert!(model.lost.iter().any(|lost| lost.why.contains("more bytes together")));
}

#[test]
fn gltf_buffers_of_one_file() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.bin"), vec![0; 1 << 20]).unwrap();
    let buffers = repeat(2000, |index| {
        let uri = if index % 2 == 0 { "a.bin" } else { "./a%2Ebin" };
        format!(r#"{{"byteLength":1048576,"uri":"{uri}"}}"#)
    });
    let file = gltf(&format!(
        r#""buffers":[{buffers}],"bufferViews":[{{"buffer":1999,"byteLength":36}}],"accessors":[{ACCESSOR}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, &file).unwrap();
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    assert_eq!(read_with(path, &ReadOptions::default()).unwrap().soup.face_count(), 1);
    let peak = MEMORY.peak_usage() - before;
    assert!(peak <= allowed(file.len() + (1 << 20)), "{peak}");
}

#[test]
fn gltf_nodes_of_a_mesh_with_a_long_name() {
    let _alone = alone();
    let nodes = repeat(5000, |_| r#"{"mesh":0}"#.to_owned());
    let file = gltf(&format!(
        r#"{TRIANGLE},"accessors":[{ACCESSOR}],"meshes":[{{"name":"{}","primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{nodes}]"#,
        "n".repeat(200_000)
    ));
    too_much(within(file.as_bytes()));
}

#[test]
fn gltf_attributes_that_each_primitive_names_otherwise() {
    let _alone = alone();
    let count = 10_000;
    let primitives =
        repeat(count, |index| format!(r#"{{"attributes":{{"POSITION":0,"_{index}":1}}}}"#));
    let file = gltf(&format!(
        r#"{TRIANGLE},"accessors":[{ACCESSOR},{{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR"}}],
        "meshes":[{{"primitives":[{primitives}]}}],"nodes":[{{"mesh":0}}]"#
    ));
    let needed = too_much(within(file.as_bytes()));
    assert!(needed > (count * count * 3 * 8) as u64);
}

#[test]
fn gltf_instances_on_the_graphics_card() {
    let _alone = alone();
    let file = gltf(&format!(
        r#"{TRIANGLE},"accessors":[{ACCESSOR},{{"componentType":5126,"count":4000000000,"type":"VEC3"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":1}}}}}}}}]"#
    ));
    too_much(within(file.as_bytes()));
}

/// The lists of a document are several times larger than their text.
#[test]
fn gltf_lists_of_nothing() {
    let _alone = alone();
    for list in ["nodes", "materials", "images", "scenes", "samplers"] {
        let file = gltf(&format!(r#""{list}":[{}]"#, repeat(1 << 20, |_| "{}".to_owned())));
        let _ = within(file.as_bytes());
    }
    for rest in [
        format!(r#""extensionsUsed":[{}]"#, repeat(1 << 21, |_| "\"\"".to_owned())),
        format!(r#""extensionsRequired":[{}]"#, repeat(1 << 21, |_| "\"\"".to_owned())),
        format!(r#""nodes":[{{"children":[{}]}}]"#, repeat(1 << 21, |_| "0".to_owned())),
        format!(
            r#""scenes":[{{"nodes":[{}]}}],"nodes":[{{}}]"#,
            repeat(1 << 21, |_| "0".to_owned())
        ),
        format!(r#""extras":[{}]"#, repeat(1 << 21, |_| "[]".to_owned())),
        format!(r#""animations":[{}]"#, repeat(1 << 20, |_| "{}".to_owned())),
        format!(r#""meshes":[{}]"#, repeat(1 << 18, |_| r#"{"primitives":[]}"#.to_owned())),
        format!(
            r#""meshes":[{{"primitives":[{}]}}]"#,
            repeat(1 << 18, |_| r#"{"attributes":{}}"#.to_owned())
        ),
        format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{{}}}}}]}}]"#,
            repeat(1 << 19, |_| r#""":0"#.to_owned())
        ),
    ] {
        let _ = within(gltf(&rest).as_bytes());
    }
}

#[test]
fn off_faces_of_two_corners() {
    let _alone = alone();
    let count = 500_000;
    let file = format!("OFF\n3 {count} 0\n0 0 0\n1 0 0\n0 1 0\n{}", "1 0\n".repeat(count));
    let model = within(file.as_bytes()).unwrap();
    assert_eq!(model.lost[0].count, Some(count as u64));
}

#[test]
fn obj_materials_and_their_libraries() {
    let _alone = alone();
    let mut file = String::from("mtllib a.mtl\nv 0 0 0\n");
    (0..300_000).for_each(|index| writeln!(file, "usemtl {index}").unwrap());
    assert_eq!(within(file.as_bytes()).unwrap().materials.len(), 300_000);
    let folder = tempfile::tempdir().unwrap();
    let mut library = String::new();
    (0..500_000).for_each(|index| writeln!(library, "newmtl {index}\nmap_Kd {index}").unwrap());
    std::fs::write(folder.path().join("a.mtl"), &library).unwrap();
    let path = folder.path().join("a.obj");
    for text in ["mtllib a.mtl\nv 0 0 0\n", &file] {
        std::fs::write(&path, text).unwrap();
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        read_with(&path, &ReadOptions::default()).unwrap();
        let peak = MEMORY.peak_usage() - before;
        assert!(peak <= allowed(text.len() + library.len()), "{peak}");
    }
}

/// The most memory that each kind of line can take.
#[test]
fn obj_lines_that_are_as_short_as_can_be() {
    let _alone = alone();
    let vertices = "v 0 0 0\nvt 0\nvn 0 0 0\n";
    let mut letters = String::new();
    for index in 0_u32..1 << 20 {
        let letter = |place: u32| char::from(b'0' + (index >> (5 * place) & 31) as u8);
        writeln!(letters, "g {}{}{}{}", letter(0), letter(1), letter(2), letter(3)).unwrap();
    }
    for file in [
        format!("{vertices}f 1/1/1 {}\n", "1/1/1 ".repeat(1 << 20)),
        format!("{vertices}f 1 {}\n", "1 ".repeat(1 << 21)),
        format!("{vertices}{}", "f 1 1 1\nf 1/1/1 1/1/1 1/1/1\n".repeat(1 << 17)),
        "v 0 0 0\n".repeat(1 << 19),
        "v 0 0 0 1 1 1\n".repeat(1 << 19),
        format!("{vertices}{}", "vt 0\n".repeat(1 << 20)),
        format!("{vertices}{}", "x\n".repeat(1 << 21)),
        format!("{vertices}{}", "\\\n".repeat(1 << 21)),
        format!("{vertices}{letters}"),
        format!("{vertices}{}", letters.replace("g ", "o ")),
        format!("{vertices}{}", letters.replace("g ", "mtllib ")),
    ] {
        let _ = within(file.as_bytes());
    }
}

#[test]
fn ply_headers_and_lists() {
    let _alone = alone();
    let header = |format: &str| format!("ply\nformat {format} 1.0\n");
    let xyz = "property char x\nproperty char y\nproperty char z\n";
    let wide: String = (0..20_000).map(|index| format!("property char q{index}\n")).collect();
    let many: String = (0..200_000).map(|index| format!("element e{index} 0\n")).collect();
    let faces = "element face 300000\nproperty list uchar uchar vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty char q\n";
    let binary = "binary_little_endian";
    for (head, body) in [
        (
            format!("{}element vertex 99\n{xyz}{wide}end_header\n", header(binary)),
            vec![0; 99 * 20_003],
        ),
        (
            format!("{}element vertex 99999999\n{xyz}{wide}end_header\n", header(binary)),
            vec![0; 20_003],
        ),
        (format!("{}{many}end_header\n", header("ascii")), Vec::new()),
        (
            format!(
                "{}element vertex 3\n{xyz}property char s\nproperty char t\n{faces}end_header\n",
                header(binary)
            ),
            [vec![1; 15], [3, 0, 1, 2, 9, 9, 9, 9].repeat(300_000)].concat(),
        ),
        (
            format!("{}element vertex 3\n{xyz}{faces}end_header\n", header(binary)),
            [vec![1; 9], [0, 9, 9, 9, 9].repeat(300_000)].concat(),
        ),
        (
            format!("{}element vertex 1000000\n{xyz}end_header\n", header("ascii")),
            b"0 0 0\n".repeat(1_000_000),
        ),
        (
            format!(
                "{}element vertex 3\n{xyz}element tristrips 1\nproperty list int uchar vertex_indices\nend_header\n",
                header(binary)
            ),
            [vec![1; 9], 1_000_000_u32.to_le_bytes().to_vec(), [0, 1, 2, 1].repeat(250_000)]
                .concat(),
        ),
        (
            format!(
                "{}element vertex 3\n{xyz}element x 1\nproperty list uint uchar a\nend_header\n",
                header(binary)
            ),
            [vec![1; 9], 3_000_000_u32.to_le_bytes().to_vec(), vec![0; 3_000_000]].concat(),
        ),
    ] {
        let _ = within(&[head.into_bytes(), body].concat());
    }
}

#[test]
fn stl_and_off_that_are_as_short_as_can_be() {
    let _alone = alone();
    let mut facets = vec![0; 80];
    facets.extend(100_000_u32.to_le_bytes());
    for index in 0..100_000_u32 {
        facets.extend([0; 12]);
        (0..9).for_each(|place| facets.extend(((9 * index + place) as f32).to_le_bytes()));
        facets.extend([0; 2]);
    }
    assert_eq!(within_as(&facets, Some(Format::Stl)).unwrap().soup.vertex_count(), 300_000);
    let mut text = String::from("solid\n");
    for index in 0..200_000 {
        writeln!(text, "facet vertex 0 0 {index} vertex 0 1 {index} vertex 1 0 {index} endfacet")
            .unwrap();
    }
    for file in [format!("{text}endsolid\n"), "solid\n".repeat(1 << 20) + "endsolid\n"] {
        let _ = within(file.as_bytes());
    }
    let vertices = "0 0 0\n".repeat(1 << 19);
    let _ = within(format!("OFF\n{} 0 0\n{vertices}", 1 << 19).as_bytes());
    let corners = "0 ".repeat(1 << 21);
    let _ = within(format!("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n{} {corners}\n", 1 << 21).as_bytes());
    let mut binary = b"OFF BINARY\n".to_vec();
    for count in [3_u32, 1 << 19, 0] {
        binary.extend(count.to_le_bytes());
    }
    binary.extend([0; 36]);
    binary.extend([0; 8].repeat(1 << 19));
    let _ = within(&binary);
}

#[test]
fn a_limit_of_the_caller_holds_for_every_format() {
    let _alone = alone();
    let mut model = Model::default();
    for index in 0..100_000_u32 {
        model.soup.push_vertex([f64::from(index), f64::from(index % 317), 0.0]);
    }
    for index in 0..99_998 {
        model.soup.push_face(&[index, index + 1, index + 2]).unwrap();
    }
    for &format in Format::ALL {
        let mut bytes = Vec::new();
        mesh_io::write_to(&mut bytes, &model, format, &mesh_io::WriteOptions::default()).unwrap();
        let size = Some(bytes.len() as u64);
        let options = |max_memory| ReadOptions { size, max_memory, ..ReadOptions::default() };
        let (result, peak) = measure(&bytes, &options(Some(1 << 20)));
        assert!(matches!(result.unwrap_err().kind, ReadErrorKind::Memory { .. }), "{format}");
        assert!(peak < 2 << 20, "{format}: {peak}");
        let (result, peak) = measure(&bytes, &options(Some(64 << 20)));
        assert_eq!(result.unwrap().soup.face_count(), 99_998);
        assert!(peak < 64 << 20, "{format}: {peak}");
        let (result, _) = measure(&bytes, &options(None));
        assert!(result.is_ok(), "{format}");
    }
}

/// A scene that draws a small mesh very often reports the memory it needs, and is read with that limit.
#[test]
fn an_honest_scene_is_read_with_more_memory() {
    let _alone = alone();
    let count = 600_000;
    let translations = r#"{"componentType":5126,"count":600000,"type":"VEC3"}"#;
    let file = gltf(&format!(
        r#"{TRIANGLE},"accessors":[{ACCESSOR},{translations}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}},{{"attributes":{{"POSITION":0}}}}]}}],
        "nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":1}}}}}}}}]"#
    ));
    let needed = too_much(within(file.as_bytes()));
    let options = ReadOptions { max_memory: Some(needed), ..ReadOptions::default() };
    let (result, peak) = measure(file.as_bytes(), &options);
    assert_eq!(result.unwrap().soup.face_count(), 2 * count);
    assert!(peak as u64 <= needed, "{peak} of {needed}");
    // Explicit nodes are justified by their bytes.
    let nodes = repeat(count / 6, |_| r#"{"mesh":0,"translation":[0.25,1.5,3.75]}"#.to_owned());
    let file = gltf(&format!(
        r#"{TRIANGLE},"accessors":[{ACCESSOR}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{nodes}]"#
    ));
    assert_eq!(within(file.as_bytes()).unwrap().soup.face_count(), count / 6);
}
