//! Meshes written as a stream have the same bytes as written from a model.

#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_io::{
    Encoding, Format, Model, NO_COLOR, Passing, Precision, ScalarType, Scalars, WriteError,
    WriteOptions, WriteReport, stage_passing, write_passing, write_to,
};

/// Triangles, a quadrilateral, a concave pentagon, and a triangle without area.
fn soup(single: bool) -> PolygonSoup {
    let mut soup = PolygonSoup::new();
    let shift = if single { 0.5 } else { 0.1 };
    for i in 0..9_u32 {
        let (x, y) = (f64::from(i % 3), f64::from(i / 3));
        soup.push_vertex([x + shift, y, if i == 4 { -0.25 } else { 0.0 }]);
    }
    for face in [&[0_u32, 1, 3][..], &[1, 4, 3], &[1, 2, 5, 4], &[3, 4, 5, 7, 6], &[6, 7, 8]] {
        soup.push_face(face).unwrap();
    }
    soup
}

fn passed(
    model: &Model,
    format: Format,
    options: &WriteOptions,
) -> Result<(Vec<u8>, WriteReport), WriteError> {
    let soup = &model.soup;
    let single = |x: f64| f64::from(x as f32) == x;
    let is_single = |s: &Scalars| (s.name.clone(), s.values.scalar_type() == ScalarType::F32);
    let passing = Passing {
        vertices: soup.vertex_count() as u64,
        faces: soup.face_count() as u64,
        triangles: soup.faces().map(|face| face.len() as u64 - 2).sum(),
        longest: soup.faces().map(<[u32]>::len).max().unwrap_or(0) as u32,
        single: soup.positions().iter().flat_map(DVec3::to_array).all(single),
        colors: model.vertex_colors.is_some(),
        scalars: model.vertex_scalars.iter().map(is_single).collect(),
    };
    let mut bytes = Vec::new();
    let report = write_passing(&mut bytes, &passing, format, options, |out| {
        for (v, &at) in soup.positions().iter().enumerate() {
            let color = model
                .vertex_colors
                .as_ref()
                .map_or(NO_COLOR, |colors| colors[v].map(|c| (c * 255.0).round() as u8));
            let numbers: Vec<f64> =
                model.vertex_scalars.iter().map(|s| s.values.get(v).unwrap()).collect();
            out.vertex(at, color, &numbers)?;
        }
        for face in soup.faces() {
            let corners: Vec<DVec3> = face.iter().map(|&v| soup.positions()[v as usize]).collect();
            let vertices: Vec<u64> = face.iter().map(|&v| u64::from(v)).collect();
            out.face(&vertices, &corners)?;
        }
        Ok(())
    })?;
    Ok((bytes, report))
}

#[test]
fn the_bytes_are_those_of_a_model() {
    let mut compared = 0;
    for single in [true, false] {
        let mut model = Model::from(soup(single));
        for rich in [false, true] {
            if rich {
                let color = |v: u8| [v, 255 - v, 7, 255].map(|c| f32::from(c) / 255.0);
                model.vertex_colors = Some((0..9).map(color).collect());
                for (name, step) in [("height", 0.5), ("tenth", 0.1)] {
                    let values = (0..9).map(|v| f64::from(v) * step);
                    let single: Vec<f32> = values.clone().map(|value| value as f32).collect();
                    model.vertex_scalars.push(if name == "height" {
                        Scalars::new(name, single)
                    } else {
                        Scalars::new(name, values.collect::<Vec<f64>>())
                    });
                }
            }
            for format in [Format::Ply, Format::Stl, Format::Obj] {
                for encoding in
                    [Encoding::Usual, Encoding::Text, Encoding::LittleEndian, Encoding::BigEndian]
                {
                    for precision in [Precision::Exact, Precision::Single, Precision::Double] {
                        let options =
                            WriteOptions { encoding, precision, ..WriteOptions::default() };
                        let mut bytes = Vec::new();
                        let Ok(report) = write_to(&mut bytes, &model, format, &options) else {
                            assert!(passed(&model, format, &options).is_err());
                            continue;
                        };
                        let (here, passed) = passed(&model, format, &options).unwrap();
                        assert!(here == bytes, "{format} {encoding:?} {precision:?} {rich}");
                        assert_eq!(passed.rounding, report.rounding, "{format} {precision:?}");
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 60, "{compared}");
}

#[test]
fn what_a_format_cannot_hold_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.ply");
    let write = |name: &str, passing: &Passing, precision, at: DVec3| {
        let options = WriteOptions { precision, ..WriteOptions::default() };
        stage_passing(folder.path().join(name), passing, &options, |out| {
            out.vertex(at, NO_COLOR, &[])
        })
        .and_then(mesh_io::Staged::commit)
    };
    let one = Passing { vertices: 1, ..Passing::default() };
    let far = DVec3::splat(1e300);
    let refused = write("out.ply", &one, Precision::Single, far);
    assert!(matches!(refused, Err(WriteError::OutOfSingleRange { vertex: 0, .. })));
    assert!(matches!(
        write("out.off", &one, Precision::Exact, far),
        Err(WriteError::NoPassing(Format::Off))
    ));
    let many = Passing { vertices: 1 << 32, ..Passing::default() };
    assert!(matches!(
        write("out.ply", &many, Precision::Exact, far),
        Err(WriteError::TooLarge { .. })
    ));
    let many = Passing { triangles: 1 << 32, ..Passing::default() };
    assert!(matches!(
        write("out.stl", &many, Precision::Exact, DVec3::ONE),
        Err(WriteError::TooLarge { .. })
    ));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    assert!(write("out.ply", &one, Precision::Exact, far).is_ok() && path.exists());
}
