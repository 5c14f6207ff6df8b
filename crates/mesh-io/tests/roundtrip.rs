//! Random models written and read again, in every format: all content that the format keeps, according to the
//! documentation of the crate, is read back.
#![cfg(all(feature = "obj", feature = "gltf"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use glam::{DVec3, Vec3};
use mesh_io::{
    Alpha, Encoding, Format, Group, Image, ImageData, Material, Model, ReadOptions, Scalars,
    WriteOptions, read, read_from, write, write_to,
};
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
            model.vertex_scalars = vec![Scalars::new("quality", values)];
            let uv = |corner| [corner as f32 / 3.0, -(corner as f32)];
            model.corner_uvs = Some((0..model.soup.corners().len()).map(uv).collect());
            model
        })
    })
}

/// Typical names, and some that should not occur.
fn name() -> impl Strategy<Value = String> {
    prop_oneof![
        "[a-z]{1,6}",
        "[ -~]{0,8}",
        "\\PC{0,6}",
        "[a-c \\n\\r\\t\\\\#/.-]{0,5}",
        Just("red".to_owned()),
        Just("x".to_owned()),
        Just("material_0".to_owned()),
    ]
}

fn byte_color() -> impl Strategy<Value = [f32; 4]> {
    prop::array::uniform4(0..=255_u8).prop_map(|color| color.map(|byte| f32::from(byte) / 255.0))
}

fn unit_normal() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(-1.0..1.0_f32).prop_filter_map("a direction", |normal| {
        Some(Vec3::from(normal).try_normalize()?.to_array())
    })
}

fn material() -> impl Strategy<Value = Material> {
    let alpha =
        prop_oneof![Just(Alpha::Opaque), (0.0..1.0_f32).prop_map(Alpha::Mask), Just(Alpha::Blend)];
    let parts = (
        name(),
        byte_color(),
        prop::option::of(0..2_u32),
        0.0..1.0_f32,
        0.0..1.0_f32,
        prop::array::uniform3(0.0..1.0_f32),
        any::<bool>(),
        alpha,
    );
    parts.prop_map(
        |(name, base_color, image, metallic, roughness, emissive, double_sided, alpha)| Material {
            name,
            base_color,
            base_color_image: image,
            metallic,
            roughness,
            emissive,
            double_sided,
            alpha,
        },
    )
}

/// Models with every attribute, or without some of them.
fn rich_models() -> impl Strategy<Value = Model> {
    let sizes = (3..12_usize, prop::collection::vec(3..6_usize, 1..10));
    sizes.prop_flat_map(|(vertices, faces)| {
        let corners: usize = faces.iter().sum();
        let count = faces.len();
        let soup = (
            prop::collection::vec(prop::array::uniform3(-1e3..1e3_f64), vertices),
            prop::collection::vec(0..vertices as u32, corners),
        );
        let of_vertices = (
            prop::option::of(prop::collection::vec(unit_normal(), vertices)),
            prop::option::of(prop_oneof![
                prop::collection::vec(byte_color(), vertices),
                prop::collection::vec(prop::array::uniform4(0.0..1.0_f32), vertices)
            ]),
            prop::collection::vec((name(), prop::collection::vec(-1e3..1e3_f64, vertices)), 0..4),
            any::<bool>(),
        );
        let of_corners = (
            prop::option::of(prop::collection::vec(unit_normal(), corners)),
            prop::option::of(prop::collection::vec(prop::array::uniform2(-2.0..2.0_f32), corners)),
        );
        let of_faces = (
            prop::option::of(prop::collection::vec(byte_color(), count)),
            prop::collection::vec((name(), prop::collection::vec(-1e3..1e3_f64, count)), 0..4),
            prop::collection::vec(0..3_u32, count),
            prop::collection::vec(0..3_u32, count),
        );
        let looks =
            (prop::collection::vec((name(), name()), 3), prop::collection::vec(material(), 3));
        (Just(faces), soup, of_vertices, of_corners, of_faces, looks).prop_map(
            |(faces, soup, of_vertices, of_corners, of_faces, looks)| {
                let mut model = Model::default();
                soup.0.iter().for_each(|&p| model.soup.push_vertex(DVec3::from(p)));
                let mut rest = soup.1.as_slice();
                for corners in faces {
                    let (face, after) = rest.split_at(corners);
                    model.soup.push_face(face).unwrap();
                    rest = after;
                }
                let scalars = |named: Vec<(String, Vec<f64>)>| -> Vec<Scalars> {
                    named.into_iter().map(|(name, values)| Scalars::new(name, values)).collect()
                };
                (model.vertex_normals, model.vertex_colors) = (of_vertices.0, of_vertices.1);
                model.vertex_scalars = scalars(of_vertices.2);
                (model.corner_normals, model.corner_uvs) = of_corners;
                if let (true, Some(uvs)) = (of_vertices.3, &mut model.corner_uvs) {
                    // No seams.
                    let corners = model.soup.corners().iter();
                    *uvs = corners.map(|&vertex| [vertex as f32 / 8.0, 0.5]).collect();
                }
                model.face_colors = of_faces.0;
                model.face_scalars = scalars(of_faces.1);
                model.face_groups = Some(of_faces.2);
                model.face_materials = Some(of_faces.3);
                let group = |(object, name)| Group { object, name };
                model.groups = looks.0.into_iter().map(group).collect();
                model.materials = looks.1;
                let image = |name: &str, data| Image {
                    name: name.to_owned(),
                    media_type: "image/png".to_owned(),
                    data,
                };
                model.images = vec![
                    image("embedded", ImageData::Bytes(b"\x89PNG\r\n\x1a\n".to_vec())),
                    image("", ImageData::Uri("maps/my skin #1 100%.png".to_owned())),
                ];
                model
            },
        )
    })
}

fn again(model: &Model, format: Format, encoding: Encoding) -> Model {
    let options = WriteOptions { encoding, ..WriteOptions::default() };
    let mut bytes = Vec::new();
    write_to(&mut bytes, model, format, &options).unwrap();
    let options = ReadOptions { format: Some(format), ..ReadOptions::default() };
    let again = read_from(&mut bytes.as_slice(), &options).unwrap_or_else(|error| {
        panic!("{format} {encoding:?}: {error}\n{}", String::from_utf8_lossy(&bytes))
    });
    again.check().unwrap();
    again
}

/// A name as OBJ stores it: it ends with its line, and surrounding white space does not count.
fn on_a_line(name: &str) -> String {
    let line: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    line.trim_start().trim_end_matches(|c: char| c == '\\' || c.is_whitespace()).to_owned()
}

/// The triangles of a model as positions in 32 bits. (Few digits of a 32-bit number are read as
/// another 64-bit number.)
fn triangles(model: &Model) -> Vec<[Vec3; 3]> {
    let positions = model.soup.positions();
    let corners = model.soup.faces().map(|face| <[u32; 3]>::try_from(face).unwrap());
    corners.map(|face| face.map(|v| positions[v as usize].as_vec3())).collect()
}

fn near<const N: usize>(a: [f32; N], b: [f32; N], within: f32) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within)
}

/// The normals of the vertices, or of their corners if these agree.
fn normals_of_vertices(model: &Model) -> Option<Vec<[f32; 3]>> {
    let Some(corners) = model.corner_normals.as_ref().filter(|_| model.vertex_normals.is_none())
    else {
        return model.vertex_normals.clone();
    };
    let mut normals = vec![None; model.soup.vertex_count()];
    for (&vertex, &normal) in model.soup.corners().iter().zip(corners) {
        if normals[vertex as usize].replace(normal).is_some_and(|other| other != normal) {
            return None;
        }
    }
    Some(normals.into_iter().map(Option::unwrap_or_default).collect())
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
            let again = again(&model, format, encoding);
            prop_assert_eq!(&again.soup, &model.soup);
            prop_assert_eq!(&again.vertex_colors, &model.vertex_colors);
            if format != Format::Off {
                prop_assert_eq!(&again.corner_uvs, &model.corner_uvs);
            }
            if format == Format::Ply {
                let numbers = |model: &Model| -> Vec<_> {
                    let columns = model.vertex_scalars.iter();
                    columns.map(|column| (column.name.clone(), column.values.clone())).collect()
                };
                prop_assert_eq!(numbers(&again), numbers(&model));
            }
        }
    }

    #[test]
    fn obj_keeps_corners_groups_and_materials(model in rich_models()) {
        let again = again(&model, Format::Obj, Encoding::Text);
        prop_assert_eq!(&again.soup, &model.soup);
        prop_assert_eq!(&again.vertex_colors, &model.vertex_colors);
        prop_assert_eq!(&again.corner_uvs, &model.corner_uvs);
        let by_vertex = model.vertex_normals.as_ref().map(|normals| -> Vec<_> {
            model.soup.corners().iter().map(|&vertex| normals[vertex as usize]).collect()
        });
        prop_assert_eq!(&again.corner_normals, &model.corner_normals.clone().or(by_vertex));
        let of_face = |model: &Model, face: usize| {
            let group = &model.groups[model.face_groups.as_ref().unwrap()[face] as usize];
            (on_a_line(&group.object), on_a_line(&group.name))
        };
        let material = |model: &Model, face: usize| model.face_materials.as_ref().unwrap()[face];
        for face in 0..model.soup.face_count() {
            prop_assert_eq!(of_face(&again, face), of_face(&model, face));
            for other in 0..face {
                // Materials are neither merged nor split.
                let same = material(&model, face) == material(&model, other);
                prop_assert_eq!(material(&again, face) == material(&again, other), same);
            }
        }
    }

    #[test]
    fn an_obj_file_keeps_the_looks_of_its_materials(model in rich_models()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.obj");
        write(&path, &model, &WriteOptions::default()).unwrap();
        let again = read(&path).unwrap();
        let material = |model: &Model, face: usize| {
            let place = model.face_materials.as_ref().unwrap()[face];
            model.materials[place as usize].clone()
        };
        for face in 0..model.soup.face_count() {
            let (old, new) = (material(&model, face), material(&again, face));
            prop_assert_eq!(new.base_color, old.base_color);
            prop_assert_eq!(new.emissive, old.emissive);
            let expected = old.base_color_image.map(|image| {
                ImageData::Uri(["model-0.png", "maps/my skin #1 100%.png"][image as usize].into())
            });
            let found = new.base_color_image.map(|image| again.images[image as usize].data.clone());
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn ply_keeps_normals_colours_numbers_and_uvs(model in rich_models()) {
        for encoding in [Encoding::Text, Encoding::LittleEndian, Encoding::BigEndian] {
            let again = again(&model, Format::Ply, encoding);
            prop_assert_eq!(&again.soup, &model.soup);
            prop_assert_eq!(&again.vertex_normals, &normals_of_vertices(&model));
            prop_assert_eq!(&again.vertex_colors, &model.vertex_colors);
            prop_assert_eq!(&again.face_colors, &model.face_colors);
            prop_assert_eq!(&again.corner_uvs, &model.corner_uvs);
            let values = |all: &[Scalars]| -> Vec<_> {
                all.iter().map(|scalars| scalars.values.clone()).collect()
            };
            prop_assert_eq!(values(&again.vertex_scalars), values(&model.vertex_scalars));
            prop_assert_eq!(values(&again.face_scalars), values(&model.face_scalars));
        }
    }

    #[test]
    fn off_keeps_normals_and_colours(model in rich_models()) {
        let seamless = model.vertex_uvs().is_some();
        let text = again(&model, Format::Off, Encoding::Text);
        prop_assert_eq!(&text.soup, &model.soup);
        prop_assert_eq!(&text.vertex_normals, &normals_of_vertices(&model));
        prop_assert_eq!(&text.vertex_colors, &model.vertex_colors);
        prop_assert_eq!(&text.face_colors, &model.face_colors);
        let binary = again(&model, Format::Off, Encoding::BigEndian);
        prop_assert_eq!(binary.soup.corners(), model.soup.corners());
        prop_assert_eq!(&binary.vertex_normals, &normals_of_vertices(&model));
        prop_assert_eq!(&binary.vertex_colors, &model.vertex_colors);
        prop_assert_eq!(&binary.face_colors, &model.face_colors);
        if seamless {
            prop_assert_eq!(&text.corner_uvs, &model.corner_uvs);
            prop_assert_eq!(&binary.corner_uvs, &model.corner_uvs);
        }
    }

    #[test]
    fn stl_keeps_the_triangles(model in rich_models()) {
        let text = again(&model, Format::Stl, Encoding::Text);
        let binary = again(&model, Format::Stl, Encoding::LittleEndian);
        prop_assert_eq!(triangles(&text), triangles(&binary));
        let count: usize = model.soup.faces().map(|face| face.len() - 2).sum();
        prop_assert_eq!(binary.soup.face_count(), count);
        let places: Vec<_> = model.soup.positions().iter().map(|p| p.as_vec3()).collect();
        for corner in triangles(&binary).as_flattened() {
            prop_assert!(places.contains(corner));
        }
    }

    #[test]
    fn gltf_keeps_everything_but_polygons_and_data_of_faces(model in rich_models()) {
        for (format, encoding) in [(Format::Gltf, Encoding::Text), (Format::Glb, Encoding::Usual)] {
            let again = again(&model, format, encoding);
            prop_assert_eq!(&again.materials, &model.materials);
            prop_assert_eq!(&again.images, &model.images);
            // Faces are sorted by their materials, and cut.
            let cut: usize = model.soup.faces().map(|face| face.len() - 2).sum();
            prop_assert_eq!(again.soup.face_count(), cut);
            let mut first = vec![];
            for &material in model.face_materials.as_ref().unwrap() {
                if !first.contains(&material) {
                    first.push(material);
                }
            }
            let mut faces: Vec<usize> = (0..model.soup.face_count()).collect();
            let materials = model.face_materials.as_ref().unwrap();
            faces.sort_by_key(|&face| first.iter().position(|&m| m == materials[face]));
            let mut coming = 0;
            for face in faces {
                for _ in 2..model.soup.face(face).len() {
                    prop_assert_eq!(again.face_materials.as_ref().unwrap()[coming], materials[face]);
                    for corner in again.soup.corner_range(coming) {
                        let found = describe(&again, corner);
                        let range = model.soup.corner_range(face);
                        let matches = |corner: usize| same_corner(&describe(&model, corner), &found);
                        prop_assert!(range.into_iter().any(matches), "{:?}", found);
                    }
                    coming += 1;
                }
            }
        }
    }
}

/// The content of a corner in glTF.
#[derive(Debug)]
struct Corner {
    position: DVec3,
    normal: Option<[f32; 3]>,
    uv: Option<[f32; 2]>,
    color: Option<[f32; 4]>,
    scalars: Vec<f32>,
}

fn describe(model: &Model, corner: usize) -> Corner {
    let vertex = model.soup.corners()[corner] as usize;
    let of_vertex = model.vertex_normals.as_ref().map(|normals| normals[vertex]);
    Corner {
        position: model.soup.positions()[vertex],
        normal: model.corner_normals.as_ref().map(|normals| normals[corner]).or(of_vertex),
        uv: model.corner_uvs.as_ref().map(|uvs| uvs[corner]),
        color: model.vertex_colors.as_ref().map(|colors| colors[vertex]),
        scalars: {
            let mut values: Vec<f32> =
                model.vertex_scalars.iter().map(|s| s.values.get(vertex).unwrap() as f32).collect();
            values.sort_by(f32::total_cmp);
            values
        },
    }
}

fn same_corner(a: &Corner, b: &Corner) -> bool {
    let same = |a: Option<[f32; 3]>, b: Option<[f32; 3]>| match (a, b) {
        (Some(a), Some(b)) => near(a, b, 0.0),
        (a, b) => a.is_none() && b.is_none(),
    };
    (a.position - b.position).abs().max_element() <= 1e-4
        && same(a.normal, b.normal)
        && match (a.uv, b.uv) {
            // The axis is reversed.
            (Some(a), Some(b)) => near(a, b, 1e-6),
            (a, b) => a.is_none() && b.is_none(),
        }
        && a.color == b.color
        && a.scalars == b.scalars
}

#[test]
fn numbers_that_fit_into_32_bits_come_back_from_text() {
    let number = f64::from(0.1_f32);
    let mut model = Model::default();
    for position in [[number, -3.0, 0.5], [f64::from(-3.132_106e-25_f32), 0.0, 1e9]] {
        model.soup.push_vertex(DVec3::from(position));
    }
    model.soup.push_face(&[0, 1, 0]).unwrap();
    model.vertex_scalars = vec![Scalars::new("quality", vec![number; 2])];
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
