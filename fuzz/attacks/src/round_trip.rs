//! Models written in every format and read again.

use arbitrary::{Result, Unstructured};
use glam::DVec3;
use mesh_io::{
    Encoding, Format, Group, Material, Model, ReadOptions, Scalars, WriteOptions, read_from,
    write_to,
};

/// Writes a model with every attribute, names of any kind and any numbers, and reads it again: all content that the
/// format supports must be unchanged.
pub fn attack(data: &[u8]) {
    let mut u = Unstructured::new(data);
    // Too few bytes are not an error.
    let Ok(model) = model(&mut u) else { return };
    model.check().expect("the model fits together");
    let encodings = [
        (Format::Obj, Encoding::Usual),
        (Format::Ply, Encoding::Text),
        (Format::Ply, Encoding::LittleEndian),
        (Format::Ply, Encoding::BigEndian),
        (Format::Stl, Encoding::Text),
        (Format::Stl, Encoding::Usual),
        (Format::Off, Encoding::Text),
        (Format::Off, Encoding::BigEndian),
        (Format::Gltf, Encoding::Usual),
        (Format::Glb, Encoding::Usual),
    ];
    for (format, encoding) in encodings {
        let options = WriteOptions { encoding, ..WriteOptions::default() };
        let mut bytes = Vec::new();
        match write_to(&mut bytes, &model, format, &options) {
            Ok(_) => check(&model, &bytes, format, encoding),
            Err(error) => {
                let message = error.to_string();
                assert!(!message.contains(char::is_control), "control characters: {message:?}");
                let is_plain = model.soup.positions().iter().all(|p| fits(*p));
                assert!(!is_plain, "{format} refused a plain model: {message}");
            }
        }
    }
}

/// Whether every format can store a position.
fn fits(position: DVec3) -> bool {
    position.to_array().iter().all(|x| (*x as f32).is_finite())
}

fn check(model: &Model, bytes: &[u8], format: Format, encoding: Encoding) {
    let options = ReadOptions {
        format: Some(format),
        size: Some(bytes.len() as u64),
        ..ReadOptions::default()
    };
    let again = match read_from(&mut &bytes[..], &options) {
        Ok(again) => again,
        Err(error) => panic!("{format} {encoding:?}: {error}\n{}", bytes.escape_ascii()),
    };
    let is_cut = matches!(format, Format::Stl | Format::Gltf | Format::Glb);
    if is_cut {
        let triangles: usize = model.soup.faces().map(|face| face.len() - 2).sum();
        assert_eq!(again.soup.face_count(), triangles, "{format}");
        return;
    }
    assert_eq!(again.soup.corners(), model.soup.corners(), "{format} {encoding:?}");
    assert_eq!(again.soup.face_count(), model.soup.face_count(), "{format} {encoding:?}");
    assert_eq!(again.soup.vertex_count(), model.soup.vertex_count(), "{format} {encoding:?}");
    let is_exact = encoding != Encoding::BigEndian || format == Format::Ply;
    for (old, new) in model.soup.positions().iter().zip(again.soup.positions()) {
        for (old, new) in old.to_array().into_iter().zip(new.to_array()) {
            let is_same = same(old, new) || !is_exact && same(f64::from(old as f32), new);
            assert!(is_same, "{format} {encoding:?}: {old:e} became {new:e}");
        }
    }
    if format == Format::Ply {
        assert_eq!(again.vertex_colors, model.vertex_colors);
        let names =
            |model: &Model| model.vertex_scalars.iter().map(|s| s.values.len()).sum::<usize>();
        assert_eq!(names(&again), names(model), "{encoding:?}");
    }
    if format == Format::Obj {
        let count = |values: &Option<Vec<u32>>| values.as_ref().map_or(0, Vec::len);
        assert!(count(&again.face_groups) <= again.soup.face_count());
    }
}

/// Equal, or both NaN. The sign of zero does not matter.
fn same(a: f64, b: f64) -> bool {
    a == b || a.is_nan() && b.is_nan()
}

fn model(u: &mut Unstructured<'_>) -> Result<Model> {
    let mut model = Model::default();
    let vertices = u.int_in_range(1..=8_u32)?;
    for _ in 0..vertices {
        model.soup.push_vertex(DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?));
    }
    for _ in 0..u.int_in_range(1..=6)? {
        let corners = u.int_in_range(3..=6)?;
        let face: Result<Vec<u32>> =
            (0..corners).map(|_| u.int_in_range(0..=vertices - 1)).collect();
        // It cannot be too large.
        let _ = model.soup.push_face(&face?);
    }
    let (vertices, faces) = (model.soup.vertex_count(), model.soup.face_count());
    let corners = model.soup.corners().len();
    if u.arbitrary()? {
        let bytes: [u8; 4] = u.arbitrary()?;
        let color = bytes.map(|byte| f32::from(byte) / 255.0);
        model.vertex_colors = Some(vec![color; vertices]);
    }
    if u.arbitrary()? {
        model.vertex_normals = Some(vec![[u.arbitrary()?, 0.0, 1.0]; vertices]);
    }
    if u.arbitrary()? {
        model.corner_uvs = Some(vec![[u.arbitrary()?, u.arbitrary()?]; corners]);
    }
    if u.arbitrary()? {
        model.corner_normals = Some(vec![[0.0, u.arbitrary()?, 0.5]; corners]);
    }
    if u.arbitrary()? {
        let values: Vec<f64> = vec![u.arbitrary()?; vertices];
        model.vertex_scalars.push(Scalars::new(name(u)?, values));
    }
    if u.arbitrary()? {
        model.groups = vec![Group { object: name(u)?, name: name(u)? }; 2];
        model.face_groups = Some((0..faces as u32).map(|face| face % 2).collect());
    }
    if u.arbitrary()? {
        let plain = Material { name: name(u)?, ..Material::default() };
        let other = Material { name: name(u)?, base_color: [0.5, 0.25, 1.0, 0.5], ..plain.clone() };
        model.materials = vec![plain, other];
        let of_face = |face: u32| if face % 3 == 2 { Model::NONE } else { face % 3 };
        model.face_materials = Some((0..faces as u32).map(of_face).collect());
    }
    Ok(model)
}

/// Mostly small numbers, some of any size, and some NaN or infinite.
fn coordinate(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(match u.int_in_range(0..=9)? {
        0 => u.arbitrary()?,
        1 => f64::from(u.arbitrary::<f32>()?),
        2 => f64::from(u.arbitrary::<i16>()?) * 1e-3,
        _ => f64::from(u.int_in_range(-4..=4)?),
    })
}

/// Any text of a few letters.
fn name(u: &mut Unstructured<'_>) -> Result<String> {
    let length = u.int_in_range(0..=12)?;
    let bytes = u.bytes(length.min(u.len()))?;
    Ok(String::from_utf8_lossy(bytes).into_owned())
}
