//! The content of each format, in small files written by hand.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use mesh_core::PolygonSoup;
use mesh_io::{
    Alpha, Blend, Compression, Encoding, Format, Image, ImageData, Location, Material, Model,
    ReadOptions, Scalars, WriteError, WriteOptions, read, read_from, write, write_levels, write_to,
};

fn parse(bytes: &[u8]) -> Result<Model, mesh_io::ReadError> {
    let size = Some(bytes.len() as u64);
    read_from(&mut &bytes[..], &ReadOptions { size, ..ReadOptions::default() })
}

fn again(model: &Model, format: Format, encoding: Encoding) -> Model {
    let mut bytes = Vec::new();
    let options = WriteOptions { encoding, ..WriteOptions::default() };
    write_to(&mut bytes, model, format, &options).unwrap();
    parse(&bytes).unwrap_or_else(|error| panic!("{format}: {error}"))
}

#[test]
fn trap_13_two_materials_one_mesh() {
    let text = b"mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
        usemtl a\nf 1 3 2\nf 1 2 4\nusemtl b\nf 2 3 4\nf -4 -1 -2\n";
    let model = parse(text).unwrap();
    assert_eq!(model.soup.vertex_count(), 4);
    assert_eq!(model.soup.corners(), [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]);
    assert_eq!(model.face_materials.as_deref(), Some(&[0, 0, 1, 1][..]));
    // Watertight: every edge is used once in each direction.
    let mut edges: Vec<(u32, u32)> =
        model.soup.faces().flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|pair| pair[0] != pair[1]));
    assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()));
    let back = again(&model, Format::Obj, Encoding::Text);
    assert_eq!(back.face_materials, model.face_materials);
    assert_eq!(back.material_libraries, ["gone.mtl"]);
}

#[test]
fn obj_corners_without_coordinates_stay_without() {
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 \\\n 0\nv 1 1 0\nvt 0.25 1\nvn 0 0 1\nf 1/1 2/1 3/1\nf 2//1 4//1 3//1\n";
    let model = parse(text).unwrap();
    let uvs = model.corner_uvs.clone().unwrap();
    assert_eq!(uvs[0], [0.25, 1.0]);
    assert!(uvs[3][0].is_nan());
    let normals = model.corner_normals.clone().unwrap();
    assert!(normals[0][0].is_nan());
    assert_eq!(normals[3], [0.0, 0.0, 1.0]);
    let back = again(&model, Format::Obj, Encoding::Text);
    assert_eq!(format!("{:?}", back.corner_uvs), format!("{:?}", model.corner_uvs));
    assert_eq!(format!("{:?}", back.corner_normals), format!("{:?}", model.corner_normals));
}

#[test]
fn obj_errors_name_the_line() {
    for (text, line) in [
        (&b"v 0 0 0\nv 1 0\n"[..], 2),
        (b"v 0 0 0\n\nv 1 0 x\n", 3),
        (b"v 0 0 0\nf 1 1 0\n", 2),
        (b"v 0 0 0\nf 1 1 -2\n", 2),
        (b"v 0 0 0\nf 1/1 1 1\n", 2),
        (b"v 0 0 0\nf 1 1 1/9223372036854775807\n", 2),
        (b"v 0 0 0\n# c\nvt\n", 3),
    ] {
        let error = parse(text).unwrap_err();
        assert_eq!(error.location(), Some(&Location::Line(line)), "{error}");
    }
}

#[test]
fn obj_keeps_the_numbering_of_a_mesh_larger_than_a_batch() {
    let mut text = String::new();
    for i in 0..20_000 {
        text += &format!("v {i} 0.5 {}\n", i * i);
    }
    for i in (1..19_990).rev() {
        text += &format!("f {} {} {}\n", i, i + 3, i + 7);
    }
    let model = parse(text.as_bytes()).unwrap();
    assert_eq!(model.soup.face_count(), 19_989);
    assert_eq!(model.soup.face(0), [19_988, 19_991, 19_995]);
    assert_eq!(model.soup.face(19_988), [0, 3, 7]);
    assert_eq!(model.soup.positions()[19_999].z, 19_999.0 * 19_999.0);
}

#[test]
fn off_headers() {
    let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n";
    for header in [
        "OFF\n3 1 0\n",
        "OFF 3 1 0\n",
        "# c\nOFF # c\n# d\n\n3 1 0\n",
        "nOFF\n3\n3 1 0\n",
        "nOFF 3\n3 1 3\n",
    ] {
        let model = parse(format!("{header}{body}").as_bytes()).expect(header);
        assert_eq!(model.soup.corners(), [0, 1, 2], "{header}");
        assert_eq!(model.face_colors, Some(vec![[1.0, 0.0, 0.0, 1.0]]), "{header}");
    }
    let bare = format!("3 1 0\n{body}");
    let options = ReadOptions { format: Some(Format::Off), ..ReadOptions::default() };
    assert_eq!(read_from(&mut bare.as_bytes(), &options).unwrap().soup.face_count(), 1);
    let all = "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255 0.5 1\n1 0 0 0 0 1 0 255 0 255 0 0\n0 1 0 0 0 1 0 0 51 255 1 1\n3 0 1 2\n";
    let model = parse(all.as_bytes()).unwrap();
    assert_eq!(model.vertex_normals.as_ref().unwrap()[0], [0.0, 0.0, 1.0]);
    assert_eq!(model.corner_uvs.as_ref().unwrap()[0], [0.5, 1.0]);
    let weighted = parse(b"4OFF\n1 0 0\n2 4 6 2\n").unwrap();
    assert_eq!(weighted.soup.positions()[0], glam::DVec3::new(1.0, 2.0, 3.0));
    assert!(parse(b"nOFF\n4\n1 0 0\n2 4 6 2\n").is_err());
}

#[test]
fn stl_text_and_binary() {
    let text = b"SOLID one two\n FACET normal nan nan nan\n outer loop\nvertex 0 -0.0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex -1 0 0\nendloop\nendfacet\nendsolid\nsolid\nendsolid\n";
    let model = parse(text).unwrap();
    assert_eq!(model.soup.vertex_count(), 4);
    assert_eq!(model.groups[0].name, "one two");
    let back = again(&model, Format::Stl, Encoding::LittleEndian);
    assert_eq!(back.soup.corners(), model.soup.corners());
    let mut bytes = Vec::new();
    write_to(&mut bytes, &model, Format::Stl, &WriteOptions::default()).unwrap();
    bytes[..6].copy_from_slice(b"solid ");
    assert_eq!(parse(&bytes).unwrap().soup.corners(), model.soup.corners());
    bytes.truncate(130);
    let error = parse(&bytes).unwrap_err();
    assert!(matches!(error.location(), Some(Location::Byte(_))), "{error}");
}

#[test]
fn ply_strips_lists_and_unknown_elements() {
    let text = b"ply\r\nformat ascii 1.0\r\ncomment c\r\nelement vertex 4\r\nproperty uchar red\r\nproperty double z\r\nproperty float y\r\nproperty float x\r\nproperty uchar green\r\nproperty uchar blue\r\nproperty float quality\r\nelement other 1\r\nproperty list int float a\r\nelement tristrips 1\r\nproperty list int int vertex_indices\r\nend_header\r\n255 0 0 0 0 0 7\r\n0 0 0 1 0 0 8\r\n0 0 1 0 0 0 9\r\n0 0.1 1 1 0 0 10\r\n2 1 2\r\n8 0 1 2 3 -1 0 1 2\r\n";
    let model = parse(text).unwrap();
    assert_eq!(model.soup.corners(), [0, 1, 2, 2, 1, 3, 0, 1, 2]);
    assert_eq!(model.soup.positions()[3], glam::DVec3::new(1.0, 1.0, 0.1));
    assert_eq!(model.vertex_colors.as_ref().unwrap()[0], [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(model.vertex_scalars[0].values, [7.0, 8.0, 9.0, 10.0]);
    for encoding in [Encoding::Text, Encoding::LittleEndian, Encoding::BigEndian] {
        let back = again(&model, Format::Ply, encoding);
        assert_eq!(back.soup, model.soup);
        assert_eq!(back.vertex_colors, model.vertex_colors);
        assert_eq!(back.vertex_scalars, model.vertex_scalars);
    }
    let short = b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0.25 0 0\n1.125 0\n";
    assert_eq!(parse(short).unwrap_err().location(), Some(&Location::Line(9)));
}

#[test]
fn georeferenced_coordinates_survive_gltf() {
    let text = b"v 2678000.125 1243000.5 400.1\nv 2678010.375 1243000.5 401.7\nv 2678000.125 1243010.3 402.3\nf 1 2 3\n";
    let model = parse(text).unwrap();
    for format in [Format::Gltf, Format::Glb] {
        let back = again(&model, format, Encoding::Usual);
        for (a, b) in back.soup.positions().iter().zip(model.soup.positions()) {
            assert!((*a - *b).abs().max_element() < 1e-4, "{a} {b}");
        }
    }
}

#[test]
fn seams_materials_and_scalars_survive_glb() {
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0.5\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 2/1 4/2 3/3\n";
    let mut model = parse(text).unwrap();
    model.vertex_scalars.push(Scalars::new("h", vec![1.0_f32, 2.0, 3.0, 4.0]));
    let back = again(&model, Format::Glb, Encoding::Usual);
    // Vertex 2 has one coordinate in both faces, vertex 1 has two.
    assert_eq!(back.soup.vertex_count(), 5);
    assert_eq!(back.corner_uvs, model.corner_uvs);
    assert_eq!(back.face_materials, model.face_materials);
    assert_eq!(back.materials[1].name, "b");
    assert_eq!(back.vertex_scalars[0].values, [1.0, 2.0, 3.0, 4.0, 2.0]);
    let twice = again(&back, Format::Glb, Encoding::Usual);
    assert_eq!(twice.soup, back.soup);
}

#[test]
fn reindexing_carries_attributes() {
    let model = parse(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\ng quad\nf 1/1 2/2 3/3 4/4\n").unwrap();
    let p = model.soup.positions();
    let built =
        model.reindexed(&[p[3], p[2], p[0]], &[[2, 1, 0]], &[3, 2, 0], &[0], &[[0, 2, 3]]).unwrap();
    assert_eq!(built.corner_uvs, Some(vec![[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
    assert_eq!(built.face_groups, Some(vec![0]));
    assert!(model.reindexed(p, &[[0, 1, 2]], &[0, 1, 2, 9], &[0], &[[0, 1, 2]]).is_err());
}

/// A fan from the first corner of a chevron would leave the polygon.
#[test]
fn concave_polygons_are_cut_along_diagonals_that_stay_inside() {
    let mut soup = PolygonSoup::new();
    for [x, y] in [[2.0, 0.0], [0.0, 2.0], [0.0, 0.0], [-2.0, -1.0], [4.0, -1.0]] {
        soup.push_vertex([x, y, 0.0]);
    }
    soup.push_face(&[3, 4, 0, 1, 2]).unwrap();
    let area = soup.measure().area;
    for format in [Format::Stl, Format::Glb, Format::Gltf] {
        let mut bytes = Vec::new();
        write_to(&mut bytes, &Model::from(soup.clone()), format, &WriteOptions::default()).unwrap();
        let again = read_from(&mut &bytes[..], &ReadOptions::default()).unwrap().soup;
        assert_eq!(again.face_count(), 3);
        assert!((again.measure().area - area).abs() < 1e-6, "{format}");
    }
}

/// A triangle with one material with all properties of OBJ, and one without a name.
fn painted() -> Model {
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 2/2 4/4 3/3\n";
    let mut model = parse(text).unwrap();
    let picture =
        |name: &str, data| Image { name: name.into(), media_type: "image/png".into(), data };
    model.images = vec![
        picture("embedded", ImageData::Bytes(b"\x89PNG\r\n\x1a\n".to_vec())),
        picture("", ImageData::Uri("skin.png".into())),
    ];
    model.materials[0].base_color = [0.25, 0.5, 1.0, 0.5];
    model.materials[0].alpha = Alpha::Blend;
    model.materials[0].emissive = [0.0, 0.5, 0.0];
    model.materials[0].base_color_image = Some(0);
    model.materials[1].name = String::new();
    model.materials[1].base_color_image = Some(1);
    model
}

#[test]
fn obj_comes_with_its_material_library_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("painted.obj");
    let model = painted();
    let report = write(&path, &model, &WriteOptions::default()).unwrap();
    assert!(report.lost.is_empty(), "{:?}", report.lost);
    let back = read(&path).unwrap();
    assert_eq!(back.material_libraries, ["painted.mtl"]);
    assert_eq!(back.materials[0], Material { name: "a".into(), ..model.materials[0].clone() });
    assert_eq!(back.materials[1].name, "material_1");
    let uri = |index: usize| back.images[index].data.clone();
    assert_eq!(uri(0), ImageData::Uri("painted-0.png".into()));
    assert_eq!(uri(1), ImageData::Uri("skin.png".into()));
    assert_eq!(std::fs::read(folder.path().join("painted-0.png")).unwrap(), b"\x89PNG\r\n\x1a\n");

    // An existing library is not changed.
    let library = folder.path().join("painted.mtl");
    std::fs::write(&library, "newmtl a\nKd 1 0 0\nNs 96\n").unwrap();
    write(&path, &back, &WriteOptions::default()).unwrap();
    assert!(std::fs::read_to_string(&library).unwrap().contains("Ns 96"));
}

#[test]
fn levels_of_detail_share_materials_and_name_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let fine = painted();
    let mut coarse = fine.clone();
    coarse.soup = PolygonSoup::from_triangles(&fine.soup.positions()[..3], &[[0, 1, 2]]).unwrap();
    coarse.face_materials = Some(vec![0]);
    coarse.corner_uvs.as_mut().unwrap().truncate(3);
    let path = folder.path().join("levels.gltf");
    let levels = [fine.clone(), coarse];
    write_levels(&path, &levels, &[0.5, 0.0], &WriteOptions::default()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["nodes"][0]["extensions"]["MSFT_lod"]["ids"][0], 1);
    assert_eq!(document["nodes"][0]["extras"]["MSFT_screencoverage"][0], 0.5);
    assert_eq!(document["meshes"].as_array().unwrap().len(), 2);
    assert_eq!(document["materials"].as_array().unwrap().len(), 2);
    // The scene shows the finest level.
    assert_eq!(read(&path).unwrap().soup.face_count(), 2);

    let refused = write_levels(folder.path().join("x.ply"), &levels, &[], &WriteOptions::default());
    assert!(matches!(refused, Err(WriteError::NoLevels(Format::Ply))));
}

#[test]
fn blends_are_weighted_means() {
    let model = painted();
    let middle = |a, b| Blend { sources: [a, b, b], weights: [0.25, 0.75, 0.0] };
    let corners = [[Blend::one(0), middle(0, 1), Blend::one(2)]];
    let positions: Vec<_> = model.soup.positions()[..3].to_vec();
    let vertices = [Blend::one(0), middle(0, 1), Blend::one(2)];
    let new = model.blended(&positions, &[[0, 1, 2]], &vertices, &[1], &corners).unwrap();
    assert_eq!(new.corner_uvs.unwrap(), [[0.0, 0.0], [0.75, 0.0], [0.0, 1.0]]);
    assert_eq!(new.face_materials.unwrap(), [1]);
    let beyond = [[Blend::one(0), middle(0, 99), Blend::one(2)]];
    assert!(model.blended(&positions, &[[0, 1, 2]], &vertices, &[1], &beyond).is_err());
}

/// Normals that are invalid in a glTF document.
#[test]
fn gltf_gets_unit_normals_or_none() {
    let mut model = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n").unwrap();
    let h = std::f32::consts::FRAC_1_SQRT_2;
    model.vertex_normals =
        Some(vec![[0.0, 3.0, 4.0], [h, h, 0.0], [0.0; 3], [f32::NAN, 0.0, f32::INFINITY]]);
    for format in [Format::Glb, Format::Gltf] {
        let mut bytes = Vec::new();
        let report = write_to(&mut bytes, &model, format, &WriteOptions::default()).unwrap();
        let again = parse(&bytes).unwrap();
        // Scaled; unchanged; the face normal.
        let expected = [[0.0, 0.6, 0.8], [h, h, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(again.corner_normals.unwrap(), expected);
        assert!(report.lost.iter().any(|lost| lost.what.contains("without length")), "{report:?}");
    }
    // 1e-30 has a direction, although its square underflows in 32 bits.
    model.vertex_normals = Some(vec![[0.0, 0.0, -1e-30]; 4]);
    let again_tiny = again(&model, Format::Glb, Encoding::Usual);
    assert_eq!(again_tiny.corner_normals.unwrap(), [[0.0, 0.0, -1.0]; 3]);
    model.vertex_normals = Some(vec![[0.0; 3]; 4]);
    let mut bytes = Vec::new();
    let report = write_to(&mut bytes, &model, Format::Glb, &WriteOptions::default()).unwrap();
    assert_eq!(report.lost[0].to_string(), "normals: none of them has a length");
    assert_eq!(parse(&bytes).unwrap().corner_normals, None);
}

/// Fails the test when anything is written.
struct Untouched;

impl std::io::Write for Untouched {
    fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
        panic!("written to");
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn coordinates_beyond_32_bits_are_refused_before_anything_is_written() {
    let mut model = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    model.soup.positions_mut()[2].y = -1e39;
    let single = mesh_io::Precision::Single;
    for (format, encoding, precision) in [
        (Format::Glb, Encoding::Usual, single),
        (Format::Gltf, Encoding::Usual, single),
        (Format::Stl, Encoding::Text, single),
        (Format::Stl, Encoding::LittleEndian, single),
        (Format::Off, Encoding::BigEndian, single),
        (Format::Ply, Encoding::Usual, single),
        (Format::Ply, Encoding::Text, single),
    ] {
        let options = WriteOptions { encoding, precision, ..WriteOptions::default() };
        let error = write_to(&mut Untouched, &model, format, &options).unwrap_err();
        let WriteError::OutOfSingleRange { vertex, value, .. } = error else { panic!("{error}") };
        assert_eq!((vertex, value), (2, -1e39), "{format}");
        assert!(mesh_io::check_write(&model, format, &options).is_err());
    }
    for (format, encoding) in [(Format::Off, Encoding::Text), (Format::Obj, Encoding::Text)] {
        assert_eq!(again(&model, format, encoding).soup, model.soup);
    }
    assert_eq!(again(&model, Format::Ply, Encoding::Usual).soup, model.soup);
    model.soup.positions_mut()[2].y = f64::NAN;
    for format in [Format::Glb, Format::Gltf] {
        let error = write_to(&mut Untouched, &model, format, &WriteOptions::default()).unwrap_err();
        assert!(matches!(error, WriteError::NotFinite { vertex: 2, .. }), "{error}");
    }
}

#[test]
fn what_gltf_may_not_hold_is_not_in_it() {
    let mut model = painted();
    model.materials[0].base_color = [2.0, f32::NAN, -1.0, 1.0];
    model.materials[0].alpha = Alpha::Mask(f32::NAN);
    model.materials[0].metallic = f32::INFINITY;
    model.corner_uvs.as_mut().unwrap()[0] = [f32::NAN, 0.0];
    model.corner_uvs.as_mut().unwrap()[1] = [0.0, f32::INFINITY];
    model.vertex_colors = Some(vec![[f32::NAN, 0.5, 0.0, 1.0]; 4]);
    let values = vec![1.0, f64::NAN, 1e300, 2.0];
    model.vertex_scalars = vec![Scalars::new("h", values)];
    // An image without a content, which no view can hold; the one after it moves up.
    let ImageData::Bytes(bytes) = &mut model.images[0].data else { panic!() };
    bytes.clear();
    let mut bytes = Vec::new();
    let report = write_to(&mut bytes, &model, Format::Gltf, &WriteOptions::default()).unwrap();
    let told = |what: &str| report.lost.iter().any(|lost| lost.what.contains(what));
    assert!(told("numbers that are not finite"), "{report:?}");
    let document: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    assert!(!String::from_utf8(bytes.clone()).unwrap().contains("null"));
    let views = document["bufferViews"].as_array().unwrap();
    assert!(views.iter().all(|view| view["byteLength"].as_u64().unwrap() > 0));
    let again = parse(&bytes).unwrap();
    assert_eq!(again.materials[0].base_color, [1.0, 1.0, 0.0, 1.0]);
    assert_eq!(again.materials[0].alpha, Alpha::Mask(0.5));
    assert_eq!(again.materials[0].base_color_image, None);
    assert_eq!(again.images.len(), 1);
    assert_eq!(again.materials[1].base_color_image, Some(0));
    assert!(again.corner_uvs.unwrap().as_flattened().iter().all(|value| value.is_finite()));
    assert!(again.vertex_scalars[0].values.iter().all(f64::is_finite));
}

#[test]
fn names_of_pictures_are_files_in_mtl_and_uris_in_gltf() {
    let mut model = painted();
    let name = "maps/my skin #1 100%.png";
    model.images[1].data = ImageData::Uri(name.into());
    let mut bytes = Vec::new();
    write_to(&mut bytes, &model, Format::Gltf, &WriteOptions::default()).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    assert_eq!(document["images"][1]["uri"], "maps/my%20skin%20%231%20100%25.png");
    let folder = tempfile::tempdir().unwrap();
    write(folder.path().join("x.obj"), &model, &WriteOptions::default()).unwrap();
    let library = std::fs::read_to_string(folder.path().join("x.mtl")).unwrap();
    assert!(library.lines().any(|line| line == "map_Kd maps/my skin #1 100%.png"), "{library}");
    // A name with a line break cannot be stored, and a leading hyphen would begin an option.
    model.images[1].data = ImageData::Uri("two\nlines.png".into());
    let report = write(folder.path().join("x.obj"), &model, &WriteOptions::default()).unwrap();
    assert!(report.lost.iter().any(|lost| lost.what.contains("line breaks")), "{report:?}");
    model.images[1].data = ImageData::Uri("-s.png".into());
    write(folder.path().join("x.obj"), &model, &WriteOptions::default()).unwrap();
    let library = std::fs::read_to_string(folder.path().join("x.mtl")).unwrap();
    assert!(library.contains("map_Kd ./-s.png"), "{library}");
}

#[test]
fn materials_of_equal_names_stay_apart_in_obj() {
    let mut model = painted();
    let names = ["one\nname", "one name"];
    for (material, name) in model.materials.iter_mut().zip(names) {
        material.name = name.into();
        material.base_color_image = None;
    }
    model.materials[1].base_color = [0.0, 1.0, 0.0, 1.0];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.obj");
    write(&path, &model, &WriteOptions::default()).unwrap();
    let back = read(&path).unwrap();
    assert_eq!(back.materials[0].name, "one name");
    assert_eq!(back.materials[1].name, "one name_2");
    assert_eq!(back.materials[1].base_color, [0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn numbers_in_ply_do_not_become_something_else() {
    let mut model = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let scalars = |names: &[&str], value: f64| -> Vec<_> {
        let scalars = |name: &&str| Scalars::new(*name, vec![value; 3]);
        names.iter().map(scalars).collect()
    };
    // A coordinate, a normal, a colour, texture coordinates, two of one name, two words.
    let names = ["x", "nx", "ny", "nz", "red", "green", "blue", "u", "v", "k", "k", "two words"];
    model.vertex_scalars = scalars(&names, 0.25);
    let back = again(&model, Format::Ply, Encoding::Text);
    let found: Vec<&str> = back.vertex_scalars.iter().map(|s| s.name.as_str()).collect();
    let expected = [
        "x_2",
        "nx_2",
        "ny_2",
        "nz_2",
        "red_2",
        "green_2",
        "blue_2",
        "u_2",
        "v_2",
        "k",
        "k_2",
        "two_words",
    ];
    assert_eq!(found, expected);
    assert_eq!(back.soup, model.soup);
    // Alone, they keep their meaning.
    model.vertex_scalars = scalars(&["nx", "red", "u"], 0.25);
    let back = again(&model, Format::Ply, Encoding::Text);
    assert_eq!(back.vertex_scalars, model.vertex_scalars);
}

#[test]
fn levels_need_a_coverage_each() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("levels.glb");
    let levels = [painted(), painted()];
    for coverage in [&[0.5][..], &[0.5, f64::NAN], &[0.5, -1.0]] {
        assert!(write_levels(&path, &levels, coverage, &WriteOptions::default()).is_err());
    }
    assert!(!path.exists());
    // A level without faces has no mesh, and takes its coverage with it.
    let levels = [painted(), Model::default(), painted()];
    let path = folder.path().join("levels.gltf");
    write_levels(&path, &levels, &[0.5, 0.25, 0.125], &WriteOptions::default()).unwrap();
    let document: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let coverage = &document["nodes"][0]["extras"]["MSFT_screencoverage"];
    assert_eq!(coverage, &serde_json::json!([0.5, 0.125]));
}

#[test]
fn points_that_a_format_has_no_place_for_are_told() {
    let model = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\n").unwrap();
    let told = |model: &Model, format| {
        let report =
            write_to(&mut std::io::sink(), model, format, &WriteOptions::default()).unwrap();
        report.lost.iter().any(|lost| lost.what == "vertices that no face uses")
    };
    assert!(told(&model, Format::Stl) && !told(&model, Format::Glb));
    let mut cloud = PolygonSoup::new();
    cloud.push_vertex([1.0, 2.0, 3.0]);
    let cloud = cloud.into();
    assert!(told(&cloud, Format::Stl) && !told(&cloud, Format::Glb));
}

/// Edits leave gaps; a file has no gaps.
#[test]
fn a_mesh_is_written_in_one_call_with_or_without_gaps() {
    use mesh_core::{Topology, TriMesh};
    let corners: Vec<[f64; 3]> = (0..3)
        .flat_map(|y| (0..3).map(move |x| [f64::from(x), f64::from(y), f64::from(x * y)]))
        .collect();
    let faces: Vec<[u32; 3]> =
        [0, 1, 3, 4].into_iter().flat_map(|a| [[a, a + 1, a + 4], [a, a + 4, a + 3]]).collect();
    let mut mesh = TriMesh::from_triangles(&corners, &faces).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let count = |topology: &Topology| (topology.vertex_count(), topology.face_count());
    for (name, collapses) in [("whole.ply", 0), ("gaps.obj", 1)] {
        for _ in 0..collapses {
            let topology = mesh.topology();
            let legal = topology.half_edges().find_map(|h| topology.check_collapse(h).ok());
            mesh.collapse(legal.unwrap(), glam::DVec3::splat(0.5));
        }
        let path = folder.path().join(name);
        write(&path, &mesh, &WriteOptions::default()).unwrap();
        let soup = read(&path).unwrap().soup;
        assert_eq!((soup.vertex_count(), soup.face_count()), count(mesh.topology()));
        let mut compact = mesh.clone();
        compact.compact();
        assert_eq!(soup.positions(), compact.positions());
        let faces = soup.faces().map(|face| <[u32; 3]>::try_from(face).unwrap());
        assert!(faces.eq(compact.topology().triangles()));
        // Positions and faces alone are a model too.
        assert_eq!(Model::from(&mesh).soup, soup);
        let mut bytes = Vec::new();
        write_to(&mut bytes, &soup, Format::Stl, &WriteOptions::default()).unwrap();
        write_to(&mut bytes, &mesh, Format::Glb, &WriteOptions::default()).unwrap();
        write_levels(folder.path().join("l.glb"), &[soup], &[0.0], &WriteOptions::default())
            .unwrap();
    }
    assert!(mesh.topology().vertex_capacity() > mesh.topology().vertex_count());
}

/// Two triangles; only the first one has texture coordinates.
fn half_textured() -> Model {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 0.0, 0.0], [6.0, 0.0, 0.0]];
    let soup = PolygonSoup::from_triangles(&points, &[[0, 1, 2], [2, 3, 4]]).unwrap();
    let none = [f32::NAN; 2];
    let uvs = vec![[0.0, 0.5], [1.0, 0.5], [0.25, 1.0], none, none, none];
    Model { corner_uvs: Some(uvs), ..Model::from(soup) }
}

#[test]
fn corners_without_texture_coordinates_do_not_get_what_is_no_number() {
    let model = half_textured();
    for format in [Format::Ply, Format::Off] {
        let mut bytes = Vec::new();
        let options = WriteOptions { encoding: Encoding::Text, ..WriteOptions::default() };
        write_to(&mut bytes, &model, format, &options).unwrap();
        let text = String::from_utf8(bytes).unwrap().to_lowercase();
        assert!(!text.contains("nan"), "{text}");
    }
    // Lists may be empty.
    for encoding in [Encoding::Usual, Encoding::BigEndian, Encoding::Text] {
        let uvs = again(&model, Format::Ply, encoding).corner_uvs.unwrap();
        assert_eq!(uvs[..3], model.corner_uvs.as_ref().unwrap()[..3]);
        assert!(uvs[3..].iter().all(|uv| uv[0].is_nan()));
    }
}

#[test]
fn off_tells_of_gaps_in_the_texture_coordinates() {
    let mut model = half_textured();
    // Each vertex has coordinates in all its faces or in none.
    model.soup = PolygonSoup::from_triangles(
        &[
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [5.0, 0.0, 0.0],
            [6.0, 0.0, 0.0],
            [6.0, 1.0, 0.0],
        ],
        &[[0, 1, 2], [3, 4, 5]],
    )
    .unwrap();
    for encoding in [Encoding::Text, Encoding::BigEndian] {
        let options = WriteOptions { encoding, ..WriteOptions::default() };
        let mut bytes = Vec::new();
        let report = write_to(&mut bytes, &model, Format::Off, &options).unwrap();
        assert!(report.lost.iter().any(|lost| lost.what.contains("gaps")), "{report:?}");
        let uvs = parse(&bytes).unwrap().corner_uvs.unwrap();
        assert_eq!(uvs[1], [1.0, 0.5]);
        assert_eq!(uvs[3..], [[0.0; 2]; 3]);
    }
}

#[test]
fn gaps_in_the_texture_coordinates_of_a_face_are_told() {
    let whole_faces = half_textured();
    let mut corners = half_textured();
    corners.corner_uvs.as_mut().unwrap()[1] = [f32::NAN; 2];
    for format in [Format::Ply, Format::Glb, Format::Obj] {
        for (model, told) in [
            (&whole_faces, format == Format::Glb),
            (&corners, matches!(format, Format::Ply | Format::Glb)),
        ] {
            let report = write_to(&mut Vec::new(), model, format, &WriteOptions::default());
            let report = report.unwrap();
            let tells = report.lost.iter().any(|lost| lost.what.contains("gaps"));
            assert_eq!(tells, told, "{format:?}: {report:?}");
        }
    }
}

#[test]
fn files_that_are_no_meshes_are_named() {
    for (content, word) in [
        (&b"\x1f\x8b\x08\x08"[..], "gzip: unpack it"),
        (b"PK\x03\x04\x14", "3MF"),
        (b"Kaydara FBX Binary  \x00", "export it as glTF"),
        (b"ISO-10303-21;\nHEADER;", "STEP"),
    ] {
        let error = read_from(&mut &*content, &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// A vertex without a colour is white, whatever the range of the others is.
#[test]
fn vertices_without_a_colour_are_white() {
    for range in ["255", "1", "65535"] {
        let text =
            format!("v 0 0 0 {range} 0 0\nv 1 0 0\nv 1 1 0 0 {range} 0\nv 0 1 0\nf 1 2 3 4\n");
        let options = ReadOptions { format: Some(Format::Obj), ..ReadOptions::default() };
        let model = read_from(&mut text.as_bytes(), &options).unwrap();
        let (red, green) = ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(model.vertex_colors, Some(vec![red, [1.0; 4], green, [1.0; 4]]), "{range}");
    }
}

/// Points without faces are points in glTF, with normals, colours and numbers.
#[test]
fn a_point_cloud_stays_one_in_gltf() {
    let none: &[[u32; 3]] = &[];
    let points = [[0.25, 0.5, -1.0], [3.0, 0.0, 0.125], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]];
    let cloud = Model {
        vertex_colors: Some(vec![[1.0, 0.0, 0.2, 1.0]; 4]),
        vertex_normals: Some(vec![[0.0, 0.6, 0.8]; 4]),
        vertex_scalars: vec![Scalars::new("class", vec![2.0, 6.0, 6.0, 9.0])],
        ..Model::from(PolygonSoup::from_triangles(&points, none).unwrap())
    };
    let options = ReadOptions { allow_empty: true, ..ReadOptions::default() };
    for format in [Format::Glb, Format::Gltf] {
        for compression in [Compression::None, Compression::Meshopt] {
            let settings = WriteOptions { compression, ..WriteOptions::default() };
            let mut bytes = Vec::new();
            let report = write_to(&mut bytes, &cloud, format, &settings).unwrap();
            assert!(report.lost.is_empty(), "{:?}", report.lost);
            let again = read_from(&mut &bytes[..], &options).unwrap();
            assert_eq!(again.soup.positions(), cloud.soup.positions());
            assert_eq!((again.soup.face_count(), again.lost.len()), (0, 0), "{:?}", again.lost);
            assert_eq!(again.vertex_colors, cloud.vertex_colors);
            assert_eq!(again.vertex_normals, cloud.vertex_normals);
            let numbers: Vec<f64> = again.vertex_scalars[0].values.iter().collect();
            assert_eq!(numbers, [2.0, 6.0, 6.0, 9.0]);
        }
    }
}
