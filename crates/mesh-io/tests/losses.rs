//! Content survives if the format has a place for it, and is reported as lost otherwise.

#![allow(clippy::panic, clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_io::{
    Encoding, Format, Group, Lost, Material, Model, NO_COLOR, Passing, Precision, ReadOptions,
    ScalarValues, Scalars, StlColors, WriteOptions, read_from, write_passing, write_to,
};
use proptest::prelude::*;

fn parsed(bytes: &[u8]) -> Model {
    read_from(&mut &*bytes, &ReadOptions::default()).unwrap()
}

fn written_with(model: &Model, format: Format, options: &WriteOptions) -> (Vec<u8>, Vec<Lost>) {
    let mut bytes = Vec::new();
    let report = write_to(&mut bytes, model, format, options).unwrap();
    (bytes, report.lost)
}

fn written(model: &Model, format: Format) -> (Vec<u8>, Vec<Lost>) {
    written_with(model, format, &WriteOptions::default())
}

fn is_named(lost: &[Lost], word: &str) -> bool {
    lost.iter().any(|lost| lost.what.contains(word))
}

fn count_of(model: &Model, word: &str) -> Option<u64> {
    let lost = model.lost.iter().find(|lost| lost.what.contains(word));
    lost.unwrap_or_else(|| panic!("{word} in {:?}", model.lost)).count
}

fn square() -> PolygonSoup {
    let mut soup = PolygonSoup::new();
    for p in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        soup.push_vertex(p);
    }
    soup.push_face(&[0, 1, 2]).unwrap();
    soup.push_face(&[0, 2, 3]).unwrap();
    soup
}

/// A model with every kind of content.
fn everything() -> Model {
    Model {
        vertex_normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
        vertex_colors: Some(vec![[0.2, 0.4, 0.6, 1.0]; 4]),
        vertex_scalars: vec![Scalars::new("heat", vec![0.1, 0.2, 0.3, 0.4])],
        corner_uvs: Some(vec![[0.25, 0.5]; 6]),
        more_corner_uvs: vec![vec![[0.5, 0.75]; 6]],
        face_colors: Some(vec![[1.0, 0.0, 0.0, 1.0]; 2]),
        face_scalars: vec![Scalars::new("label", vec![3_i32, 7])],
        face_smoothing: Some(vec![1, 2]),
        face_groups: Some(vec![0, 1]),
        groups: ["a", "b"].map(|n| Group { object: String::new(), name: n.into() }).into(),
        face_materials: Some(vec![0, 0]),
        materials: vec![Material { name: "red".into(), ..Material::default() }],
        ..Model::from(square())
    }
}

/// The content of the model, by distinct names.
fn content(model: &Model) -> Vec<&'static str> {
    let has_smoothing = model.face_smoothing.is_some();
    let all = [
        (model.vertex_normals.is_some() || model.corner_normals.is_some(), "normals"),
        (model.vertex_colors.is_some(), "vertex colours"),
        (!model.vertex_scalars.is_empty(), "numbers per vertex"),
        (model.corner_uvs.is_some(), "texture coordinates"),
        (!model.more_corner_uvs.is_empty(), "further sets"),
        (model.face_colors.is_some(), "face colours"),
        (!model.face_scalars.is_empty(), "numbers per face"),
        (has_smoothing, "smoothing groups"),
        (model.groups.iter().any(|g| *g != Group::default()), "groups"),
        (!model.materials.is_empty(), "materials"),
    ];
    all.iter().filter(|(there, _)| *there).map(|(_, name)| *name).collect()
}

#[test]
fn whatever_does_not_come_back_was_named() {
    let model = everything();
    for &format in Format::ALL {
        for encoding in [Encoding::Usual, Encoding::Text] {
            let options = WriteOptions { encoding, ..WriteOptions::default() };
            let mut bytes = Vec::new();
            let Ok(report) = write_to(&mut bytes, &model, format, &options) else { continue };
            let again = parsed(&bytes);
            let kept = content(&again);
            for what in content(&model) {
                let named = report.lost.iter().any(|lost| lost.what.contains(what));
                assert!(kept.contains(&what) || named, "{format}: {what}: {:?}", report.lost);
            }
            for lost in &report.lost {
                assert!(!lost.why.is_empty() && lost.count.is_none_or(|count| count > 0));
                assert!(!lost.why.contains("GLB has no place") || !lost.what.contains("normal"));
            }
        }
    }
}

#[test]
fn further_texture_coordinates_survive_gltf() {
    let mut model = Model::from(square());
    model.corner_uvs = Some((0..6).map(|i| [i as f32 / 8.0, 0.5]).collect());
    let set = |k: f32| (0..6).map(|i| [k, i as f32 / 8.0]).collect::<Vec<[f32; 2]>>();
    model.more_corner_uvs = vec![set(0.25), set(0.75)];
    for format in [Format::Glb, Format::Gltf] {
        let (bytes, lost) = written(&model, format);
        assert!(lost.is_empty(), "{lost:?}");
        let again = parsed(&bytes);
        assert_eq!(again.corner_uvs, model.corner_uvs);
        assert_eq!(again.more_corner_uvs, model.more_corner_uvs);
    }
    let (_, lost) = written(&model, Format::Obj);
    assert!(is_named(&lost, "further sets"));
}

proptest! {
    #[test]
    fn stl_facet_colours_survive_both_conventions(
        colors in proptest::collection::vec(proptest::option::of([0_u8..32, 0..32, 0..32]), 2),
        magics in any::<bool>(),
    ) {
        let mut model = Model::from(square());
        let eight = |five: u8| (f32::from(five) * 255.0 / 31.0).round() / 255.0;
        let color = |c: &Option<[u8; 3]>| c.map_or([f32::NAN; 4], |[r, g, b]| {
            [eight(r), eight(g), eight(b), 1.0]
        });
        model.face_colors = Some(colors.iter().map(color).collect());
        let stl_colors = if magics { StlColors::Magics } else { StlColors::Viscam };
        let options = WriteOptions { stl_colors, ..WriteOptions::default() };
        let (bytes, _) = written_with(&model, Format::Stl, &options);
        prop_assert!(!bytes.starts_with(b"solid"));
        let again = parsed(&bytes);
        let found = again.face_colors.unwrap_or_else(|| vec![[f32::NAN; 4]; 2]);
        for (found, color) in found.iter().zip(model.face_colors.iter().flatten()) {
            if color[0].is_nan() {
                // Magics colours all other facets white.
                prop_assert!(found[0].is_nan() || *found == [1.0; 4]);
            } else {
                prop_assert_eq!(found, color);
            }
        }
    }

    #[test]
    fn colours_of_any_range_come_out_from_0_to_1(
        bytes in proptest::collection::vec(any::<[u8; 3]>(), 3),
        scale in prop_oneof![Just(1.0_f64), Just(255.0), Just(65535.0)],
    ) {
        let mut bytes = bytes;
        bytes[0][0] = 255;
        let exact = |b: u8| f64::from(b) / 255.0;
        let row = |b: &[u8; 3]| b.map(|b| exact(b) * scale);
        let mut obj = String::new();
        let mut ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nproperty float red\nproperty float green\nproperty float blue\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n".to_owned();
        let mut off = "COFF\n3 1 0\n".to_owned();
        for (i, color) in bytes.iter().enumerate() {
            let [r, g, b] = row(color);
            obj += &format!("v {i} {} 0 {r} {g} {b}\n", i * i);
            ply += &format!("{i} {} 0 {r} {g} {b}\n", i * i);
            off += &format!("{i} {} 0 {r:?} {g:?} {b:?}\n", i * i);
        }
        obj += "f 1 2 3\n";
        ply += "3 0 1 2\n";
        off += "3 0 1 2\n";
        for text in [obj, ply, off] {
            let model = parsed(text.as_bytes());
            for (found, color) in model.vertex_colors.iter().flatten().zip(&bytes) {
                for (found, byte) in found.iter().zip(color) {
                    prop_assert!((f64::from(*found) - exact(*byte)).abs() < 1e-4, "{text}");
                }
                prop_assert_eq!(found[3], 1.0);
            }
            let is_noted = model.notes.iter().any(|note| note.contains("divided"));
            prop_assert_eq!(is_noted, scale > 1.0, "{:?}", model.notes);
        }
    }
}

/// Faces of a survey are smaller than the steps of single precision so far from the origin. The faces that the file has
/// without an area are counted, when a model is written and when it is streamed.
#[test]
fn faces_that_rounding_flattens_are_counted() {
    for (offset, cell) in [(5e6, 0.05), (5e6, 5.0), (0.0, 0.05), (1e4, 5e-4)] {
        let mut soup = PolygonSoup::new();
        for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
            let at = DVec3::new(f64::from(row), f64::from(column), f64::from(row * column % 3));
            soup.push_vertex(offset + at * cell);
        }
        for corner in (0..35_u32).filter(|v| v % 6 < 5 && v + 6 < 36) {
            soup.push_face(&[corner, corner + 6, corner + 7]).unwrap();
            soup.push_face(&[corner, corner + 7, corner + 1]).unwrap();
        }
        let model = Model::from(soup);
        let single = WriteOptions { precision: Precision::Single, ..WriteOptions::default() };
        for format in [Format::Stl, Format::Ply] {
            let (bytes, lost) = written_with(&model, format, &single);
            let read = parsed(&bytes);
            let flat = read.soup.faces().filter(|face| {
                let [a, b, c] = [0, 1, 2].map(|k| read.soup.positions()[face[k] as usize]);
                (b - a).cross(c - a) == DVec3::ZERO
            });
            let count = flat.count() as u64;
            let named = lost.iter().find(|lost| lost.what == "the area of faces");
            assert_eq!(named.and_then(|lost| lost.count), (count > 0).then_some(count), "{format}");
            assert_eq!(count > 0, offset / cell > 1e7, "{format} {offset} {cell}");
            let passing = Passing {
                vertices: model.soup.vertex_count() as u64,
                faces: model.soup.face_count() as u64,
                triangles: model.soup.face_count() as u64,
                longest: 3,
                single: false,
                colors: false,
                scalars: Vec::new(),
            };
            let report = write_passing(&mut Vec::new(), &passing, format, &single, |out| {
                for &at in model.soup.positions() {
                    out.vertex(at, NO_COLOR, &[])?;
                }
                for face in model.soup.faces() {
                    let corners = face.iter().map(|&v| model.soup.positions()[v as usize]);
                    let vertices: Vec<u64> = face.iter().map(|&v| u64::from(v)).collect();
                    out.face(&vertices, &corners.collect::<Vec<_>>())?;
                }
                Ok(())
            });
            assert_eq!(report.unwrap().lost, lost);
        }
        let (_, lost) = written(&model, Format::Glb);
        assert!(!is_named(&lost, "area"));
    }
}

/// Colours from a renderer go beyond white. Divided by 255, they would be black. Averages of bytes are fractions too, but
/// few of them are below 1.
#[test]
fn light_beyond_white_is_kept_and_said() {
    let ply = |colors: &[f32]| {
        let head = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nproperty float red\nproperty float green\nproperty float blue\n\
             end_header\n",
            colors.len()
        );
        colors.iter().fold(head, |text, c| text + &format!("0 0 0 {c} {c} 0\n"))
    };
    let light = [0.25, 0.5, 0.75, 1.0, 2.5, 12.0];
    let model = parsed(ply(&light).as_bytes());
    let reds: Vec<f32> = model.vertex_colors.iter().flatten().map(|color| color[0]).collect();
    assert_eq!(reds, light);
    assert!(model.notes.iter().any(|note| note.contains("beyond white")), "{:?}", model.notes);
    for (format, keeps) in
        [(Format::Ply, true), (Format::Obj, true), (Format::Off, true), (Format::Glb, false)]
    {
        let mut model = model.clone();
        model.soup.push_face(&[0, 1, 2]).unwrap();
        model.soup.push_face(&[3, 4, 5]).unwrap();
        let (bytes, lost) = written(&model, format);
        assert_eq!(is_named(&lost, "beyond white"), !keeps, "{format}: {lost:?}");
        let most = parsed(&bytes).vertex_colors.unwrap().iter().fold(0.0, |m, c| c[0].max(m));
        assert_eq!(most, if keeps { 12.0 } else { 1.0 }, "{format}");
    }
    let averages: Vec<f32> = (0..40).map(|step| 0.5 + 6.25 * step as f32).collect();
    let model = parsed(ply(&averages).as_bytes());
    for (color, average) in model.vertex_colors.unwrap().iter().zip(averages) {
        assert!((color[0] - average / 255.0).abs() < 1e-6);
    }
}

/// Scanners write their name and the size of their grid into the header.
#[test]
fn comments_of_ply_survive_ply_and_are_counted_elsewhere() {
    let text = "ply\nformat ascii 1.0\ncomment made by VCGLIB\nobj_info num_cols 512\n\
        comment crs  EPSG:25832 # 1\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let model = parsed(text.as_bytes());
    let as_text = WriteOptions { encoding: Encoding::Text, ..WriteOptions::default() };
    let (bytes, lost) = written_with(&model, Format::Ply, &as_text);
    assert_eq!((String::from_utf8(bytes).unwrap(), lost), (text.to_owned(), Vec::new()));
    for (format, left) in [(Format::Obj, 3), (Format::Off, 3), (Format::Stl, 2), (Format::Glb, 3)] {
        let (_, lost) = written(&model, format);
        let comments = lost.iter().find(|lost| lost.what == "comments").unwrap();
        assert!(comments.count == Some(left) && comments.why.contains("PLY"), "{comments}");
    }
    let same: Vec<u32> = (0..3).collect();
    let rebuilt =
        model.reindexed(model.soup.positions(), &[[0, 1, 2]], &same, &[0], &[[0, 1, 2]]).unwrap();
    assert_eq!(rebuilt.comments, model.comments);
    // A comment of another origin stays on its line.
    let mut other = model;
    other.comments = vec!["a\nend_header".to_owned()];
    let (bytes, _) = written_with(&other, Format::Ply, &as_text);
    assert_eq!(parsed(&bytes).comments, ["a end_header"]);
}

/// Programs for printers write the name of the part into the header.
#[test]
fn the_text_of_a_header_survives_stl_and_ply() {
    let mut model = parsed(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    model.comments = vec!["bracket 7".to_owned()];
    for colors in [StlColors::Viscam, StlColors::Magics] {
        let options = WriteOptions { stl_colors: colors, ..WriteOptions::default() };
        for face_colors in [None, Some(vec![[1.0, 0.0, 0.0, 1.0]])] {
            model.face_colors = face_colors;
            let (bytes, lost) = written_with(&model, Format::Stl, &options);
            assert_eq!(lost, []);
            let again = parsed(&bytes);
            assert_eq!(again.comments, model.comments);
            assert_eq!(again.face_colors, model.face_colors);
            let (bytes, lost) = written(&again, Format::Ply);
            assert_eq!((parsed(&bytes).comments, lost), (model.comments.clone(), Vec::new()));
        }
    }
}

#[test]
fn facets_without_a_colour_stay_so_or_are_counted() {
    let mut model = parsed(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
    model.face_colors = Some(vec![[1.0, 0.0, 0.0, 1.0], [f32::NAN; 4]]);
    for format in [Format::Stl, Format::Off] {
        let (bytes, lost) = written(&model, format);
        assert_eq!(lost, [], "{format}");
        let colors = parsed(&bytes).face_colors.unwrap();
        assert!(colors[0] == [1.0, 0.0, 0.0, 1.0] && colors[1][0].is_nan(), "{format}");
    }
    let (bytes, lost) = written(&model, Format::Ply);
    assert_eq!(parsed(&bytes).face_colors, Some(vec![[1.0, 0.0, 0.0, 1.0], [1.0; 4]]));
    assert!(lost[0].what.contains("gaps") && lost[0].count == Some(1), "{lost:?}");
}

#[test]
fn digits_of_double_attributes_are_counted() {
    for binary in [false, true] {
        let format = if binary { "binary_little_endian" } else { "ascii" };
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
             property float z\nproperty double nx\nproperty double ny\nproperty double nz\n\
             property double s\nproperty double t\nend_header\n"
        )
        .into_bytes();
        for row in [[0.6, 0.8, 0.0, 0.5, 0.25], [1.0, 0.0, 0.0, 0.1, f64::NAN]] {
            if binary {
                bytes.extend([0.0_f32; 3].iter().flat_map(|x| x.to_le_bytes()));
                bytes.extend(row.iter().flat_map(|x| x.to_le_bytes()));
            } else {
                let words: Vec<String> = row.iter().map(f64::to_string).collect();
                bytes.extend(format!("0 0 0 {}\n", words.join(" ")).into_bytes());
            }
        }
        let model = parsed(&bytes);
        assert_eq!(count_of(&model, "digits of the normals"), Some(2));
        assert_eq!(count_of(&model, "digits of the texture coordinates"), Some(1));
    }
}

/// `ZBrush` writes the colours of vertices into comments, with a mask each.
#[test]
fn polypaint_is_read_as_colours_and_a_mask() {
    let text = |masks: [&str; 3], more: &str| {
        let [a, b, c] = masks;
        format!(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB {a}ff0000{b}00ff00\n#MRGB {c}0000ff\n{more}f 1 2 3\n"
        )
    };
    let colors = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    let model = parsed(text(["ff"; 3], "").as_bytes());
    assert_eq!((model.vertex_colors.as_deref(), model.lost.len()), (Some(&colors[..]), 0));
    assert!(model.vertex_scalars.is_empty());
    let model = parsed(text(["ff", "80", "00"], "").as_bytes());
    assert_eq!(model.vertex_scalars, [Scalars::new("mask", vec![255_u8, 128, 0])]);
    for more in ["#MRGB ff112233\n", "#MRGB ff11\n", "#MRGB nonsense\n"] {
        let model = parsed(text(["ff"; 3], more).as_bytes());
        assert!(model.vertex_colors.is_none() && count_of(&model, "#MRGB") >= Some(3), "{more}");
    }
    let own = "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\n#MRGB ff000000ff000000\n";
    assert_eq!(count_of(&parsed(own.as_bytes()), "#MRGB"), Some(2));
}

#[test]
fn whole_colours_of_a_wide_type_are_divided() {
    for kind in ["int", "uint", "short", "ushort", "double"] {
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
             property float z\nproperty {kind} red\nproperty {kind} green\nproperty {kind} blue\n\
             end_header\n0 0 0 255 51 0\n"
        );
        assert_eq!(parsed(ply.as_bytes()).vertex_colors.unwrap(), [[1.0, 0.2, 0.0, 1.0]], "{kind}");
    }
}

#[test]
fn smoothing_groups_become_normals_and_stay_in_obj() {
    // A ridge: two faces in one group, then in two groups.
    let ridge = |a: &str, b: &str| {
        let text = format!(
            "v 0 0 0\nv 0 1 0\nv 1 0 1\nv 1 1 1\nv 2 0 0\nv 2 1 0\n\
             s {a}\nf 1 3 4 2\ns {b}\nf 3 5 6 4\n"
        );
        parsed(text.as_bytes())
    };
    let smooth = parsed(&written(&ridge("1", "1"), Format::Glb).0);
    let normals = smooth.corner_normals.unwrap();
    for (corner, &vertex) in smooth.soup.corners().iter().enumerate() {
        let [x, _, z] = normals[corner];
        if smooth.soup.positions()[vertex as usize].x == 1.0 {
            assert!(x.abs() < 1e-6 && (z - 1.0).abs() < 1e-6, "{:?}", normals[corner]);
        }
    }
    for (a, b) in [("1", "2"), ("off", "4"), ("0", "1")] {
        let model = ridge(a, b);
        let (bytes, lost) = written(&model, Format::Glb);
        assert!(!is_named(&lost, "smoothing"), "{lost:?}");
        let hard = parsed(&bytes);
        let sharp = std::f32::consts::FRAC_1_SQRT_2;
        for normal in hard.corner_normals.unwrap() {
            assert!((normal[0].abs() - sharp).abs() < 1e-6, "{normal:?}");
        }
        assert_eq!(parsed(&written(&model, Format::Obj).0).face_smoothing, model.face_smoothing);
        assert!(is_named(&written(&model, Format::Ply).1, "smoothing"));
        assert!(is_named(&written(&model, Format::Stl).1, "smoothing"));
    }
    // With one group, all corners of a vertex have the same normal, which PLY and OFF can store.
    for format in [Format::Ply, Format::Off] {
        let (bytes, lost) = written(&ridge("3", "3"), format);
        assert!(parsed(&bytes).vertex_normals.is_some() && !is_named(&lost, "smoothing"));
    }
    // Faces that are flat everywhere need no normals.
    assert!(ridge("off", "off").face_smoothing.is_none());
}

#[test]
fn obj_elements_that_are_no_faces_are_counted() {
    let model = parsed(
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3 1\np 1 2\nvp 0 0\ncurv 0 1 1 2\nf 1 2 3\nf 1 2\nwhat 1\n",
    );
    assert_eq!(count_of(&model, "lines"), Some(2));
    assert_eq!(count_of(&model, "points"), Some(1));
    assert_eq!(count_of(&model, "free-form"), Some(1));
    assert_eq!(count_of(&model, "fewer than three corners"), Some(1));
    assert_eq!(count_of(&model, "what"), Some(1));
}

#[test]
fn third_texture_coordinates_are_counted() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0 0\nvt 1 0 .5\nvt 0 1\nf 1/1 2/2 3/3\n";
    let model = parsed(text.as_bytes());
    assert_eq!(count_of(&model, "third texture coordinates"), Some(1));
    assert_eq!(model.corner_uvs, Some(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
}

#[test]
fn ply_names_the_pictures_of_textures() {
    // As MeshLab writes them, read and written again: nothing is lost, and nothing changes.
    let text = "ply\nformat ascii 1.0\ncomment TextureFile a wood.png\ncomment TextureFile b.png\n\
        element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 3\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
        property int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n\
        3 0 1 2 6 0 0 1 0 0 1 1\n3 0 2 1 6 0 0 1 0 0 1 0\n3 0 2 1 0 -1\n";
    let model = parsed(text.as_bytes());
    let as_text = WriteOptions { encoding: Encoding::Text, ..WriteOptions::default() };
    let (bytes, lost) = written_with(&model, Format::Ply, &as_text);
    assert_eq!((String::from_utf8(bytes).unwrap(), lost), (text.to_owned(), Vec::new()));
    // Materials of another format are more.
    let mut other = model.clone();
    other.materials[1].name = "varnish".to_owned();
    let (bytes, lost) = written_with(&other, Format::Ply, &as_text);
    assert_eq!(String::from_utf8(bytes).unwrap(), text);
    assert!(
        matches!(&lost[..], [one] if one.what.contains("names") && one.count == Some(1)),
        "{lost:?}"
    );
    // One picture for all faces needs no numbers.
    let one = Model { face_materials: Some(vec![0; 3]), ..model.clone() };
    let (bytes, lost) = written_with(&one, Format::Ply, &as_text);
    assert!(lost.is_empty() && !String::from_utf8(bytes.clone()).unwrap().contains("texnumber"));
    assert_eq!(parsed(&bytes).face_materials, Some(vec![0; 3]));
    // A material without a picture has no place.
    let mut plain = model;
    plain.materials[0].base_color_image = None;
    assert!(is_named(&written(&plain, Format::Ply).1, "materials"));
}

#[test]
fn numbers_of_faces_keep_the_names_that_only_vertices_need() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nproperty float nx\nproperty float ny\n\
        property float nz\nproperty float s\nproperty float t\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0 0 1 5 6\n";
    let as_text = WriteOptions { encoding: Encoding::Text, ..WriteOptions::default() };
    let (bytes, _) = written_with(&parsed(text.as_bytes()), Format::Ply, &as_text);
    assert_eq!(String::from_utf8(bytes).unwrap(), text);
}

#[test]
fn ply_elements_and_lists_that_are_not_read_are_counted() {
    let model = parsed(
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
          property list uchar float w\nelement face 1\nproperty list uchar int vertex_indices\n\
          property list uchar int marks\nelement edge 2\nproperty int a\nend_header\n\
          0 0 0 1 5\n1 0 0 0\n0 1 0 1 2\n3 0 1 2 2 4 4\n0\n1\n",
    );
    assert_eq!(count_of(&model, "\"w\""), Some(3));
    assert_eq!(count_of(&model, "marks"), Some(1));
    assert_eq!(count_of(&model, "edge"), Some(2));
}

#[test]
fn what_a_scene_has_besides_meshes_is_counted() {
    let model = parsed(
        br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]},{"nodes":[]}],
        "buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
          {"componentType":5126,"count":3,"type":"VEC4"}],
        "extensionsUsed":["KHR_lights_punctual","VENDOR_thing"],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}},
        "cameras":[{"type":"perspective"}],"skins":[{"joints":[1]}],"animations":[{}],"samplers":[{}],
        "nodes":[{"name":"root","children":[1,2,3],"extras":{"a":1}},{"mesh":0,"name":"left"},
          {"mesh":0,"name":"right","translation":[1,0,0]},{"camera":0,"name":"eye"}],
        "meshes":[{"extras":5,"primitives":[{"attributes":{"POSITION":0,"TANGENT":1,"JOINTS_0":1,"COLOR_1":1,"_PAIR":1},
          "targets":[{"POSITION":0}]},{"mode":1,"attributes":{"POSITION":0}}]},
          {"primitives":[{"attributes":{"POSITION":0}}]}]}"#,
    );
    for (word, count) in [
        ("cameras", 1),
        ("skins", 1),
        ("animations", 1),
        ("lights", 1),
        ("extras", 2),
        ("hierarchy", 4),
        ("names of nodes", 2),
        ("scenes besides", 1),
        ("share", 1),
        ("no node draws", 1),
        ("tangents", 1),
        ("joints", 1),
        ("further sets of colours", 1),
        ("_PAIR", 1),
        ("morph targets", 1),
        ("samplers", 1),
        ("VENDOR_thing", 1),
    ] {
        assert_eq!(count_of(&model, word), Some(count), "{word}");
    }
    assert!(model.lost.iter().any(|lost| lost.what.contains("points or lines")));
    // Every loss is in the notes, too.
    for lost in &model.lost {
        assert!(model.notes.iter().any(|note| note.contains(&lost.what)), "{lost}");
    }
}

#[test]
fn off_words_of_every_spelling() {
    let plain = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    for head in ["OFF 4 2 0\n", "OFF4 2 0\n", "OFF\n4 2 0\n", "off\n4 2 0\n", "OFF4 2\n", "4 2 0\n"]
    {
        let model = parsed_off(&format!("{head}{plain}"));
        assert_eq!((model.soup.vertex_count(), model.soup.face_count()), (4, 2), "{head}");
        assert!(model.notes.is_empty(), "{:?}", model.notes);
    }
    let rich = |v: &str| format!("{v} 0 0 1 255 0 51 255\n");
    for word in ["NCOFF", "CNOFF", "ncoff", "CNOFF4"] {
        let counts = if word.ends_with('4') { " 2 0\n" } else { "\n4 2 0\n" };
        let rows: String = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].map(rich).concat();
        let model = parsed_off(&format!("{word}{counts}{rows}3 0 1 2\n3 0 2 3\n"));
        assert_eq!(model.vertex_normals.unwrap(), [[0.0, 0.0, 1.0]; 4], "{word}");
        assert_eq!(model.vertex_colors.unwrap(), [[1.0, 0.0, 0.2, 1.0]; 4], "{word}");
    }
}

#[test]
fn off_indices_into_a_colour_map_are_whole_numbers_in_range() {
    let text = "OFF\n4 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
        3 0 1 2 5\n3 0 2 3 3000000000\n3 0 1 3 1.5\n3 1 2 3 -3\n";
    let model = parsed_off(text);
    assert_eq!(model.face_scalars[0].values.to_f64()[..], [5.0, -1.0, -1.0, -1.0]);
}

#[test]
fn content_after_the_end_is_named() {
    let torus = mesh_shapes::Torus { major: 3.0, minor: 1.0 }.shifted_mesh(8, 5).unwrap();
    let model = Model::from(torus);
    let kinds = [
        (Format::Ply, Encoding::Text, "PLY record"),
        (Format::Ply, Encoding::LittleEndian, "PLY record"),
        (Format::Ply, Encoding::BigEndian, "PLY record"),
        (Format::Off, Encoding::Text, "OFF face"),
        (Format::Off, Encoding::BigEndian, "OFF face"),
        (Format::Stl, Encoding::LittleEndian, "STL facet"),
        (Format::Glb, Encoding::Usual, "GLB container"),
    ];
    for (format, encoding, end) in kinds {
        let mut bytes = Vec::new();
        let options = WriteOptions { encoding, ..WriteOptions::default() };
        write_to(&mut bytes, &model, format, &options).unwrap();
        let read = |bytes: &[u8]| {
            let options = ReadOptions { format: Some(format), ..ReadOptions::default() };
            read_from(&mut &*bytes, &options).unwrap_or_else(|error| panic!("{format}: {error}"))
        };
        let names_it = |model: &Model| model.lost.iter().any(|lost| lost.what.contains(end));
        let whole = read(&bytes);
        assert!(!names_it(&whole), "{format}");
        for more in [&b"x"[..], b"\0\0\0\0\0\0\0\0\0\0\0", b"3 0 1 2\n"] {
            let longer = read(&[&bytes, more].concat());
            assert!(names_it(&longer), "{format} {encoding:?}: {:?}", longer.lost);
            assert_eq!(longer.soup, whole.soup, "{format} {encoding:?}");
        }
    }
}

#[test]
fn text_may_start_with_a_byte_order_mark() {
    let files = [
        (Format::Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        (Format::Off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        (
            Format::Stl,
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
             vertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
        ),
    ];
    for (format, text) in files {
        let marked = format!("\u{feff}{text}");
        for options in [
            ReadOptions::default(),
            ReadOptions {
                format: Some(format),
                size: Some(marked.len() as u64),
                ..ReadOptions::default()
            },
        ] {
            let model = read_from(&mut marked.as_bytes(), &options).unwrap();
            assert_eq!(model.soup.face_count(), 1, "{format}");
        }
    }
}

fn parsed_off(text: &str) -> Model {
    let options = ReadOptions { format: Some(Format::Off), ..ReadOptions::default() };
    read_from(&mut text.as_bytes(), &options).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn off_words_that_promise_what_is_not_there() {
    let rows = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    for word in ["COFF", "NOFF", "CNOFF", "NCOFF", "STOFF", "STCNOFF"] {
        let model = parsed_off(&format!("{word}\n4 2 0\n{rows}3 0 1 2\n3 0 2 3\n"));
        assert_eq!((model.soup.vertex_count(), model.soup.face_count()), (4, 2), "{word}");
        assert!(model.vertex_colors.is_none() && model.vertex_normals.is_none(), "{word}");
        assert!(model.corner_uvs.is_none());
        assert!(model.notes.iter().any(|note| note.contains("announces")), "{:?}", model.notes);
    }
    // With one of two promised numbers.
    let with = |tail: &str| rows.replace('\n', &format!(" {tail}\n"));
    let model = parsed_off(&format!("CNOFF\n4 1 0\n{}3 0 1 2\n", with("0 0 1")));
    assert!(model.vertex_normals.is_some() && model.vertex_colors.is_none());
    let model = parsed_off(&format!("CNOFF\n4 1 0\n{}3 0 1 2\n", with("255 128 0 255")));
    assert!(model.vertex_normals.is_none() && model.vertex_colors.is_some());
    // The numbers of a vertex may be on two lines.
    let split = "0 0 0\n0 0 1\n1 0 0\n0 0 1\n0 1 0\n0 0 1\n";
    let model = parsed_off(&format!("NOFF\n3 1 0\n{split}3 0 1 2\n"));
    assert_eq!(model.vertex_normals.unwrap(), [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn places_in_a_colour_map_are_labels() {
    let model = parsed_off("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 7\n3 0 2 3 9\n");
    assert!(model.face_colors.is_none());
    assert_eq!(model.face_scalars[0].values, ScalarValues::I32(vec![7, 9]));
    assert!(model.face_scalars[0].is_label);
    assert!(model.notes.iter().any(|note| note.contains("colour map")), "{:?}", model.notes);
}

/// Coordinates below the range of single precision become zero. The faces are counted in every format that rounds.
#[test]
fn faces_that_are_too_small_for_single_precision_are_counted() {
    let single = WriteOptions { precision: Precision::Single, ..WriteOptions::default() };
    for exponent in [-900, -300, -170, -160, -100] {
        let mut soup = PolygonSoup::new();
        for corner in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.7, 0.6, 0.3]] {
            soup.push_vertex(DVec3::from(corner) * f64::from(exponent).exp2());
        }
        soup.push_face(&[0, 1, 2]).unwrap();
        soup.push_face(&[0, 1, 3]).unwrap();
        let model = Model::from(soup);
        for format in [Format::Stl, Format::Ply, Format::Glb, Format::Gltf] {
            let (_, lost) = written_with(&model, format, &single);
            let named = lost.iter().find(|lost| lost.what == "the area of faces");
            let expected = (exponent < -149).then_some(2);
            assert_eq!(named.and_then(|lost| lost.count), expected, "{format} 2^{exponent}");
        }
    }
}
