//! Corrupted, lying and hostile files; writes that fail.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use mesh_io::{
    Encoding, Format, Model, ReadOptions, WriteError, WriteOptions, read_from, write_to,
};
use std::io::Write;
use std::time::{Duration, Instant};

fn parse(bytes: &[u8], format: Option<Format>) -> Result<Model, mesh_io::ReadError> {
    let size = Some(bytes.len() as u64);
    read_from(&mut &bytes[..], &ReadOptions { format, size, ..ReadOptions::default() })
}

/// A tetrahedron and a quad with every attribute.
fn rich_model() -> Model {
    let obj = "mtllib none.mtl\no body\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1.25 1 1 1\n\
        v 1 1 0.1 0 0 0\nvt 0 0\nvt 1 0\nvt 0.5 1\nvn 0 0 1\nvn 1 0 0\ng a\nusemtl red\n\
        f 1/1/1 2/2/1 3/3/1\nf 1/1/2 4/2/2 2/3/2\ng b\nusemtl blue\nf 2/1/1 5/2/1 3/3/1 4/1/2\n";
    let mut model = parse(obj.as_bytes(), None).unwrap();
    let values = vec![0.5, 1.5, 2.5, 0.1, 1e9];
    model.vertex_scalars.push(mesh_io::Scalars::new("quality", values));
    model
}

/// glTF content that the reader supports but the writer does not produce: sparse values, strips, instances on the
/// graphics card, transforms of textures, compressed data with a fallback.
const RICH_SCENE: &str = r#"{"asset":{"version":"2.0"},"extensionsRequired":["EXT_mesh_gpu_instancing"],
"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"},{"byteLength":8,"extensions":{"EXT_meshopt_compression":{"fallback":true}}}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":12,"byteLength":24,"byteStride":8,"extensions":{"EXT_meshopt_compression":{"buffer":0}}}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},{"componentType":5123,"count":9,"type":"SCALAR"},{"bufferView":1,"componentType":5120,"normalized":true,"count":3,"type":"VEC4"}],
"images":[{"uri":"a%20b.png"},{"bufferView":0,"mimeType":"image/png"},{"bufferView":0}],
"textures":[{"source":0},{"extensions":{"EXT_texture_webp":{"source":1}}}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"offset":[0,1],"rotation":1.5,"scale":[2,3]}}}}},
{"alphaMode":"MASK","extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseTexture":{"index":1}}}}],
"meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":0,"NORMAL":0,"TEXCOORD_0":1,"TEXCOORD_1":1,"COLOR_0":3},"material":0},
{"attributes":{"POSITION":0,"NORMAL":0},"indices":2,"mode":5,"material":1},{"attributes":{"POSITION":0,"_A":0},"mode":6},{"mode":1,"attributes":{"POSITION":0}}]}],
"nodes":[{"mesh":0,"scale":[1,2,-3],"children":[1]},{"mesh":0,"name":"n","extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0,"ROTATION":3}}}},{"skin":0}],
"scene":0,"scenes":[{"nodes":[0,2]}],"animations":[{}]}"#;

const TEXTURED_PLY: &str = "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile b.png\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1 1\n3 0 2 1 6 0 0 1 0 0 1 0\n";

#[test]
fn the_samples_are_sound() {
    for (format, bytes) in samples() {
        let model = parse(&bytes, None).unwrap_or_else(|error| panic!("{format}: {error}"));
        model.check().unwrap();
        assert!(model.soup.face_count() > 0, "{format}");
    }
}

fn samples() -> Vec<(Format, Vec<u8>)> {
    let model = rich_model();
    let plain = Model::from(model.soup.clone());
    let mut normals = plain.clone();
    normals.vertex_normals = Some(vec![[0.0, 0.0, 1.0]; 5]);
    let of = |model: &Model, format, encoding| {
        let mut bytes = Vec::new();
        let options = WriteOptions { encoding, ..WriteOptions::default() };
        write_to(&mut bytes, model, format, &options).unwrap();
        (format, bytes)
    };
    vec![
        of(&model, Format::Obj, Encoding::Text),
        of(&model, Format::Ply, Encoding::Text),
        of(&model, Format::Ply, Encoding::BigEndian),
        of(&plain, Format::Ply, Encoding::LittleEndian),
        of(&model, Format::Stl, Encoding::Text),
        of(&plain, Format::Stl, Encoding::LittleEndian),
        of(&model, Format::Off, Encoding::Text),
        of(&normals, Format::Off, Encoding::BigEndian),
        of(&model, Format::Gltf, Encoding::Text),
        of(&model, Format::Glb, Encoding::Usual),
        (Format::Gltf, RICH_SCENE.into()),
        (
            Format::Obj,
            String::from_utf8_lossy(&of(&model, Format::Obj, Encoding::Text).1)
                .replace('\n', "\r")
                .into(),
        ),
        (Format::Ply, TEXTURED_PLY.into()),
        (
            Format::Off,
            b"OFF BINARY\n\x03\0\0\0\x01\0\0\0\0\0\0\0"
                .iter()
                .chain(&[0; 36])
                .chain(b"\x03\0\0\0\0\0\0\0\x01\0\0\0\x02\0\0\0")
                .copied()
                .collect(),
        ),
    ]
}

fn corrupt(random: &mut fastrand::Rng, samples: &[(Format, Vec<u8>)], which: usize) -> Vec<u8> {
    let mut bytes = samples[which].1.clone();
    match random.u8(0..4) {
        0 => {
            for _ in 0..random.usize(1..9) {
                let place = random.usize(..bytes.len());
                bytes[place] ^= 1 << random.u8(..8);
            }
        }
        1 => bytes.truncate(random.usize(..bytes.len())),
        2 => {
            let other = &samples[random.usize(..samples.len())].1;
            bytes.truncate(random.usize(..bytes.len()));
            bytes.extend_from_slice(&other[random.usize(..other.len())..]);
        }
        // Digits become other digits: wrong counts and indices.
        _ => {
            for _ in 0..random.usize(1..5) {
                let place = random.usize(..bytes.len());
                if let Some(digit) = bytes[place..].iter_mut().find(|byte| byte.is_ascii_digit()) {
                    *digit = random.u8(b'0'..=b'9');
                }
            }
        }
    }
    bytes
}

/// Peak memory of this process in kilobytes, if the system reports it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

#[test]
fn ten_thousand_corrupted_files_neither_panic_nor_hang() {
    let samples = samples();
    let mut random = fastrand::Rng::with_seed(20_020_612);
    let before = peak_memory();
    let (mut sound, mut slowest) = (0, Duration::ZERO);
    for round in 0..10_000 {
        let which = round % samples.len();
        let bytes = corrupt(&mut random, &samples, which);
        // In half of the runs the format is given, to bypass detection.
        let format = random.bool().then_some(samples[which].0);
        let start = Instant::now();
        if let Ok(model) = parse(&bytes, format) {
            model.check().unwrap_or_else(|error| panic!("variant {round}: {error}"));
            sound += 1;
        }
        slowest = slowest.max(start.elapsed());
    }
    assert!(slowest < Duration::from_secs(1), "{slowest:?}");
    assert!(sound < 9_000, "corruption goes unnoticed in {sound} of 10,000 files");
    if let (Some(before), Some(after)) = (before, peak_memory()) {
        assert!(after - before < 100_000, "{} kB more", after - before);
    }
}

#[test]
fn headers_that_promise_too_much_are_refused() {
    let cases: &[(&[u8], Option<Format>)] = &[
        (b"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n", None),
        (b"ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n", None),
        (b"ply\nformat ascii 1.0\nelement vertex 5\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n3 0 1 2\n", None),
        (b"OFF\n4000000000 4000000000 0\n0 0 0\n", None),
        (b"OFF BINARY\n\xff\xff\xff\xff\xff\xff\xff\xff\0\0\0\0", None),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n", None),
        (&[&[0; 80][..], &[0xff; 4]].concat(), Some(Format::Stl)),
        (b"glTF\x02\0\0\0\0\0\0\0\xff\xff\xff\xffJSON{}", None),
        (br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":99999999999,"uri":"data:;base64,AAAA"}]}"#, None),
        (br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"count":99999999999,"componentType":5126,"type":"VEC3"}]}"#, None),
        (br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":7}}]}]}"#, None),
        (br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0,"_A":1},"indices":1}]}],"accessors":[{"count":18446744073709551615,"componentType":5126,"type":"VEC3"},{"count":18446744073709551615,"componentType":5125,"type":"SCALAR"}]}"#, None),
        (br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"SCALE":0}}}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"count":18446744073709551615,"componentType":5126,"type":"VEC3"}]}"#, None),
        (br#"{"asset":{"version":"2.0"},"extensionsRequired":["ACME_mesh_compression"]}"#, None),
        (br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"missing.bin"}]}"#, None),
    ];
    for (bytes, format) in cases {
        let start = Instant::now();
        let error = parse(bytes, *format).expect_err(&bytes.escape_ascii().to_string());
        assert!(start.elapsed() < Duration::from_secs(1), "{error}");
        assert!(error.location().is_some(), "{error}");
    }
}

fn nested(nodes: usize, last_child: Option<usize>) -> String {
    let node = |index: usize| match (index + 1 < nodes, last_child) {
        (true, _) => format!(r#"{{"children":[{}]}}"#, index + 1),
        (false, Some(child)) => format!(r#"{{"children":[{child}]}}"#),
        (false, None) => "{}".to_owned(),
    };
    let nodes: Vec<String> = (0..nodes).map(node).collect();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{}]}}"#,
        nodes.join(",")
    )
}

#[test]
fn cyclic_and_deeply_nested_nodes_are_refused_within_a_second() {
    for document in [nested(3, Some(0)), nested(1, Some(0)), nested(100_000, None)] {
        let start = Instant::now();
        let error = parse(document.as_bytes(), None).unwrap_err();
        assert!(error.to_string().contains("nodes["), "{error}");
        assert!(start.elapsed() < Duration::from_secs(1));
    }
    let brackets = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":{}"#, "[".repeat(100_000));
    assert!(parse(brackets.as_bytes(), None).is_err());
}

/// Fails after this number of bytes.
struct FailingWriter {
    room: usize,
}

impl Write for FailingWriter {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.room == 0 {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        let step = bytes.len().min(self.room);
        self.room -= step;
        Ok(step)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_writer_that_fails_at_any_byte_fails_the_write() {
    let model = rich_model();
    for &format in Format::ALL {
        let mut whole = Vec::new();
        write_to(&mut whole, &model, format, &WriteOptions::default()).unwrap();
        for room in (0..whole.len()).step_by(7) {
            let result =
                write_to(&mut FailingWriter { room }, &model, format, &WriteOptions::default());
            assert!(matches!(result, Err(WriteError::Io { .. })), "{format} at byte {room}");
        }
    }
}

#[test]
fn a_failed_write_leaves_the_old_file_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.glb");
    std::fs::write(&path, "old").unwrap();
    let mut model = rich_model();
    // Refused half-way, when the temporary file exists.
    model.soup.positions_mut()[0].x = f64::NAN;
    assert!(mesh_io::write(&path, &model, &WriteOptions::default()).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    let mut permissions = std::fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).unwrap();
    let error = mesh_io::write(&path, &rich_model(), &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::ReadOnly(_)), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let options = WriteOptions { format: Some(Format::Ply), ..WriteOptions::default() };
    let error = mesh_io::write("/dev/full", &rich_model(), &options).unwrap_err();
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
}

#[cfg(unix)]
#[test]
fn replacing_keeps_the_mode_and_follows_links() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("mesh.ply"), folder.path().join("link.ply"));
    std::fs::write(&file, "old").unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("mesh.ply", &link).unwrap();
    mesh_io::write(&link, &rich_model(), &WriteOptions::default()).unwrap();
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(std::fs::read(&file).unwrap().starts_with(b"ply"));
    assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
}
