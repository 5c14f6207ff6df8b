//! Files as streams give the same vertices and faces as files read whole.
#![cfg(feature = "obj")]
#![allow(clippy::unwrap_used)]

use std::ops::ControlFlow;

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_io::{
    Encoding, Format, Item, Model, ReadError, ReadErrorKind, ReadOptions, WriteOptions, read_from,
    scan_from, write_to,
};
use mesh_shapes::Torus;

/// The result of a scan: the positions of the vertices and of the corners of each face.
#[derive(Debug, Default, PartialEq)]
struct Met {
    vertices: Vec<[u64; 3]>,
    faces: Vec<Vec<[u64; 3]>>,
}

fn bits(point: DVec3) -> [u64; 3] {
    (point + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Options for content of a known length; without the length, binary STL cannot be detected.
fn known(bytes: &[u8]) -> ReadOptions {
    ReadOptions { size: Some(bytes.len() as u64), ..ReadOptions::default() }
}

fn scanned(bytes: &[u8]) -> Result<(Met, bool), ReadError> {
    let (mut met, mut faces, mut has_facets) = (Met::default(), Vec::new(), false);
    scan_from(&mut &*bytes, &known(bytes), &mut |item| {
        match item {
            Item::Vertex(point) => met.vertices.push(bits(point)),
            Item::Face(corners) => faces.push(corners.to_vec()),
            Item::Facet(corners) => {
                has_facets = true;
                met.faces.push(corners.iter().copied().map(bits).collect());
            }
        }
        ControlFlow::Continue(())
    })?;
    for face in faces {
        met.faces.push(face.iter().map(|&v| met.vertices[v as usize]).collect());
    }
    Ok((met, has_facets))
}

fn whole(soup: &PolygonSoup) -> Met {
    let vertices: Vec<[u64; 3]> = soup.positions().iter().copied().map(bits).collect();
    let faces = soup.faces().map(|face| face.iter().map(|&v| vertices[v as usize]).collect());
    Met { faces: faces.collect(), vertices }
}

/// Files of every format and encoding that can be scanned.
fn files() -> Vec<(String, Vec<u8>)> {
    let mut soup = Torus { major: 3.0, minor: 1.0 }.shifted_mesh(12, 7).unwrap();
    let first = soup.vertex_count() as u32;
    for i in 0..5_u32 {
        soup.push_vertex([f64::from(i).cos(), f64::from(i).sin(), 0.1]);
    }
    soup.push_face(&[first, first + 1, first + 2, first + 3, first + 4]).unwrap();
    let mut model = Model::from(soup);
    model.vertex_colors = Some(vec![[0.5, 0.25, 1.0, 1.0]; model.soup.vertex_count()]);
    let encodings = [Encoding::Text, Encoding::LittleEndian, Encoding::BigEndian];
    let mut files = Vec::new();
    for format in [Format::Ply, Format::Stl, Format::Obj, Format::Off, Format::Gltf, Format::Glb] {
        for encoding in encodings {
            let options = WriteOptions { encoding, ..WriteOptions::default() };
            let mut bytes = Vec::new();
            if write_to(&mut bytes, &model, format, &options).is_ok() {
                files.push((format!("{format} {encoding:?}"), bytes));
            }
        }
    }
    assert_eq!(files.len(), 10);
    files
}

#[test]
fn a_scan_meets_what_a_reader_finds() {
    for (name, bytes) in files() {
        let (met, has_facets) = scanned(&bytes).unwrap();
        let read = whole(&read_from(&mut &*bytes, &known(&bytes)).unwrap().soup);
        assert_eq!(met.faces, read.faces, "{name}");
        assert!(has_facets || met.vertices == read.vertices, "{name}");
    }
}

#[test]
fn a_visitor_can_end_a_scan() {
    for (name, bytes) in files() {
        let mut seen = 0;
        let done = scan_from(&mut &*bytes, &known(&bytes), &mut |_| {
            seen += 1;
            if seen == 30 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert!(seen == 30 && !done.unwrap().is_whole, "{name}");
    }
}

#[test]
fn indices_beyond_32_bits_are_kept_by_a_scan_and_refused_by_a_reader() {
    let text = b"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar double vertex_indices\n\
        element vertex 6000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n\
        3 0 4294967296 5999999999\n";
    let mut face = Vec::new();
    let end = |item: Item<'_>| {
        if let Item::Face(corners) = item {
            face = corners.to_vec();
        }
        ControlFlow::Break(())
    };
    scan_from(&mut &text[..], &ReadOptions::default(), &mut { end }).unwrap();
    assert_eq!(face, [0, 4_294_967_296, 5_999_999_999]);
    let error = read_from(&mut &text[..], &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("32-bit"), "{error}");
}

#[test]
fn whatever_is_in_a_file_both_agree_or_the_scan_says_why() {
    let mut random = fastrand::Rng::with_seed(9);
    for (name, bytes) in files() {
        for round in 0..400 {
            let mut changed = bytes.clone();
            for _ in 0..random.usize(1..4) {
                let place = random
                    .usize(0..changed.len().min(if round % 2 == 0 { 400 } else { usize::MAX }));
                changed[place] = if round % 3 == 0 {
                    b"0123456789 \n-f"[random.usize(0..14)]
                } else {
                    random.u8(..)
                };
            }
            if round % 5 == 0 {
                changed.truncate(random.usize(0..bytes.len()));
            }
            let read = read_from(&mut &*changed, &known(&changed));
            match (read, scanned(&changed)) {
                (Ok(model), Ok((met, _))) => {
                    assert_eq!(met.faces, whole(&model.soup).faces, "{name} {round}");
                }
                (Err(_), Err(_)) => {}
                // A scan stores nothing, so it need not refuse for lack of memory or because of materials.
                (Err(error), Ok(_)) => assert!(
                    matches!(
                        error.kind,
                        ReadErrorKind::Memory { .. } | ReadErrorKind::Malformed { .. }
                    ),
                    "{name} {round}: {error}"
                ),
                (Ok(_), Err(error)) => assert!(
                    matches!(error.kind, ReadErrorKind::Unsupported { .. }),
                    "{name} {round}: {error}"
                ),
            }
        }
    }
}

#[test]
fn formats_that_cannot_be_scanned_say_so() {
    let mut off = b"OFF BINARY\n".to_vec();
    for word in [3_u32, 1, 0] {
        off.extend(word.to_le_bytes());
    }
    for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        off.extend(number.to_le_bytes());
    }
    for word in [3_u32, 0, 1, 2, 0] {
        off.extend(word.to_le_bytes());
    }
    assert_eq!(read_from(&mut &*off, &known(&off)).unwrap().soup.face_count(), 1);
    let error = scanned(&off).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Unsupported { .. }), "{error}");
}

/// What a scan leaves out is named.
#[test]
fn a_scan_names_what_it_leaves_out() {
    let off =
        b"COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2 9 9 9\n";
    let done = scan_from(&mut &off[..], &known(off), &mut |_| ControlFlow::Continue(())).unwrap();
    let lost: Vec<&str> = done.lost.iter().map(|lost| lost.what.as_str()).collect();
    assert_eq!(lost, ["vertex colours", "face colours"]);
    for (name, bytes) in files() {
        let done = scan_from(&mut &*bytes, &known(&bytes), &mut |_| ControlFlow::Continue(()));
        let lost = done.unwrap().lost.iter().any(|lost| lost.what.contains("colour"));
        // PLY names the properties.
        assert!(lost || name.starts_with("PLY") || name.starts_with("STL"), "{name}");
    }
}

/// An accessor without bytes announces any number of vertices. A scan has the same budget as a reader.
#[test]
fn a_scan_does_not_believe_the_counts_of_gltf() {
    let text =
        br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"componentType":5126,"count":600000000,"type":"VEC3"}]}"#;
    for error in [scanned(text).unwrap_err(), read_from(&mut &text[..], &known(text)).unwrap_err()]
    {
        assert!(matches!(error.kind, ReadErrorKind::Memory { .. }), "{error}");
    }
}
