//! Random models through every format that keeps polygons and 64-bit positions.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use glam::DVec3;
use mesh_io::{Encoding, Format, Model, ReadOptions, Scalars, WriteOptions, read_from, write_to};
use proptest::prelude::*;

fn models() -> impl Strategy<Value = Model> {
    let positions = prop::collection::vec(prop::array::uniform3(-1e9..1e9_f64), 3..20);
    positions.prop_flat_map(|positions| {
        let count = positions.len();
        let faces = prop::collection::vec(prop::collection::vec(0..count as u32, 3..7), 1..20);
        let colors = prop::collection::vec(prop::array::uniform4(0..=255_u8), count);
        let scalars = prop::collection::vec(prop::num::f64::NORMAL, count);
        (faces, colors, scalars).prop_map(move |(faces, colors, values)| {
            let mut model = Model::default();
            positions.iter().for_each(|&p| model.soup.push_vertex(DVec3::from(p)));
            faces.iter().for_each(|face| model.soup.push_face(face).unwrap());
            let unit = |color: &[u8; 4]| color.map(|byte| f32::from(byte) / 255.0);
            model.vertex_colors = Some(colors.iter().map(unit).collect());
            model.vertex_scalars = vec![Scalars { name: "quality".to_owned(), values }];
            let uv = |corner| [corner as f32 / 3.0, -(corner as f32)];
            model.corner_uvs = Some((0..model.soup.corners().len()).map(uv).collect());
            model
        })
    })
}

proptest! {
    #[test]
    fn nothing_that_the_format_holds_is_lost(model in models()) {
        for (format, encoding) in [
            (Format::Obj, Encoding::Text),
            (Format::Off, Encoding::Text),
            (Format::Ply, Encoding::Text),
            (Format::Ply, Encoding::LittleEndian),
            (Format::Ply, Encoding::BigEndian),
        ] {
            let options = WriteOptions { encoding, ..WriteOptions::default() };
            let mut bytes = Vec::new();
            write_to(&mut bytes, &model, format, &options).unwrap();
            let again = read_from(&mut bytes.as_slice(), &ReadOptions::default()).unwrap();
            prop_assert_eq!(&again.soup, &model.soup);
            prop_assert_eq!(&again.vertex_colors, &model.vertex_colors);
            if format != Format::Off {
                prop_assert_eq!(&again.corner_uvs, &model.corner_uvs);
            }
            if format == Format::Ply {
                prop_assert_eq!(&again.vertex_scalars, &model.vertex_scalars);
            }
        }
    }
}

#[test]
fn numbers_that_fit_into_32_bits_come_back_from_text() {
    let number = f64::from(0.1_f32);
    let mut model = Model::default();
    for position in [[number, -3.0, 0.5], [f64::from(-3.132_106e-25_f32), 0.0, 1e9]] {
        model.soup.push_vertex(DVec3::from(position));
    }
    model.soup.push_face(&[0, 1, 0]).unwrap();
    model.vertex_scalars = vec![Scalars { name: "quality".to_owned(), values: vec![number; 2] }];
    for format in [Format::Ply, Format::Obj, Format::Off] {
        let options = WriteOptions { encoding: Encoding::Text, ..WriteOptions::default() };
        let mut bytes = Vec::new();
        write_to(&mut bytes, &model, format, &options).unwrap();
        let again = read_from(&mut bytes.as_slice(), &ReadOptions::default()).unwrap();
        assert_eq!(again.soup, model.soup, "{format}");
        if format == Format::Ply {
            assert_eq!(again.vertex_scalars, model.vertex_scalars);
        }
    }
}
