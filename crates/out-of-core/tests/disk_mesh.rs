//! Operations on meshes on disk, compared with the same operations in memory.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};

use crate::common::{open_torus, torus, write};
use glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh, VertexId, diagnose};
use mesh_io::{Format, Model, ReadOptions, WriteOptions};
use mesh_metric::{CompareOptions, Surface, compare};
use out_of_core::{DiskMesh, Error, Input, ScratchFolder, distance};

/// A memory limit at which these meshes have many regions.
const LITTLE: u64 = 31 << 20;

/// Reads a file into a folder, and applies an operation to it.
fn with_disk_mesh<T>(
    input: &Path,
    act: impl FnOnce(&DiskMesh) -> Result<T, Error>,
) -> Result<T, Error> {
    let folder = input.with_extension("mesh");
    let scratch = ScratchFolder::new(&folder, "mesh".as_ref())?;
    let reading = ReadOptions { allow_empty: true, ..ReadOptions::default() };
    let mut observer = |_| true;
    let mesh =
        DiskMesh::read(&scratch, "mesh", Input::Path(input), &reading, LITTLE, &mut observer)?;
    let done = act(&mesh);
    drop(mesh);
    drop(scratch);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
    done
}

fn save(soup: &PolygonSoup, path: &Path) -> PathBuf {
    mesh_io::write(path, &Model::from(soup.clone()), &WriteOptions::default()).unwrap();
    path.to_owned()
}

/// Random triangles over the vertices of a torus, and some of its own triangles.
fn tangle(seed: u64) -> PolygonSoup {
    let mut random = fastrand::Rng::with_seed(seed);
    let mesh = torus(60_000, seed);
    let count = mesh.positions().len() as u32;
    let mut soup = PolygonSoup::new();
    mesh.positions().iter().for_each(|&p| {
        soup.push_vertex(p);
    });
    for triangle in mesh.topology().triangles() {
        match random.u32(0..100) {
            // Holes, duplicates, and reversed faces.
            0..20 => {}
            20..23 => {
                soup.push_face(&triangle).unwrap();
                soup.push_face(&triangle).unwrap();
            }
            23..26 => soup.push_face(&[triangle[1], triangle[0], triangle[2]]).unwrap(),
            26 => {
                let [a, b, c] = triangle;
                soup.push_face(&[a, b, b]).unwrap();
                soup.push_face(&[a, b, c, (c + 1) % count]).unwrap();
            }
            27 => {
                let corners: Vec<u32> = (0..5).map(|_| random.u32(0..count)).collect();
                soup.push_face(&corners).unwrap();
            }
            28 => soup.push_face(&triangle.map(|_| random.u32(0..count))).unwrap(),
            _ => soup.push_face(&triangle).unwrap(),
        }
    }
    soup.push_vertex([1.0, 2.0, 3.0]);
    soup
}

/// Vertices at no place are dropped with their faces, in formats with and without vertices, and of loose faces.
#[test]
fn vertices_at_no_place_are_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let mut soup = torus(3000, 2).to_soup();
    for vertex in [7, 100, 1400] {
        soup.positions_mut()[vertex].y = f64::NAN;
    }
    let mut loose = PolygonSoup::new();
    for face in soup.faces() {
        let first = loose.vertex_count() as u32;
        face.iter().for_each(|&v| loose.push_vertex(soup.positions()[v as usize]));
        loose.push_face(&[first, first + 1, first + 2]).unwrap();
    }
    let (vertices, faces) = (soup.vertex_count() - 3, soup.face_count() - 18);
    for suffix in ["ply", "obj", "off", "stl"] {
        for (soup, expected) in [(&soup, vertices), (&loose, 3 * faces)] {
            let input = save(soup, &folder.path().join(format!("in.{suffix}")));
            let summary = with_disk_mesh(&input, |mesh| Ok(mesh.summary().clone())).unwrap();
            let expected = if suffix == "stl" { vertices } else { expected };
            assert_eq!(
                (summary.vertices, summary.faces),
                (expected as u64, faces as u64),
                "{suffix}"
            );
            let note = summary.notes.last().unwrap();
            assert!(note.contains("undefined positions") && note.ends_with(": 18"), "{note}");
        }
    }
}

#[test]
fn a_survey_counts_what_a_diagnosis_does() {
    let folder = tempfile::tempdir().unwrap();
    let mut soups: Vec<PolygonSoup> = (0..3).map(tangle).collect();
    soups.push(torus(60_000, 1).to_soup());
    soups.push(open_torus(60_000, 2).to_soup());
    // Many components, most of which lie in several regions.
    let mut rings = PolygonSoup::new();
    for ring in 0..40_u32 {
        let first = rings.vertex_count() as u32;
        for i in 0..500_u32 {
            let angle = f64::from(i / 2) * std::f64::consts::TAU / 250.0;
            let radius = 1.0 + 0.1 * f64::from(ring) + 0.05 * f64::from(i % 2);
            rings.push_vertex([radius * angle.cos(), radius * angle.sin(), 0.0]);
        }
        for i in 0..500 {
            let [a, b, c] = [i, (i + 1) % 500, (i + 2) % 500].map(|v| v + first);
            rings.push_face(&if i % 2 == 0 { [a, b, c] } else { [b, a, c] }).unwrap();
        }
    }
    soups.push(rings);
    soups.push(PolygonSoup::new());
    for (i, soup) in soups.iter().enumerate() {
        let input = save(soup, &folder.path().join("in.ply"));
        let statistics = with_disk_mesh(&input, |mesh| mesh.statistics(&mut |_| true)).unwrap();
        // The orientation towards the outside needs the whole mesh, so the survey does not determine it.
        let mut whole = diagnose(soup).unwrap();
        whole.inside_out = None;
        assert_eq!(statistics.diagnosis, whole, "{i}");
        let measures = soup.measure();
        assert_eq!(statistics.measures.bounds, measures.bounds);
        let area = statistics.measures.area;
        assert!((area - measures.area).abs() <= 1e-11 * measures.area, "{area}");
        if whole.is_closed() && whole.is_oriented() {
            let volume = statistics.measures.volume;
            assert!((volume - measures.volume).abs() <= 1e-11 * measures.volume, "{volume}");
        }
    }
}

#[test]
fn formats_pass_on_as_they_are_written_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let soup = tangle(3);
    for from in ["ply", "obj", "stl"] {
        let input = save(&soup, &folder.path().join("in").with_extension(from));
        let model = mesh_io::read(&input).unwrap();
        for to in [Format::Ply, Format::Obj, Format::Stl] {
            let options = WriteOptions::default();
            let mut whole = Vec::new();
            mesh_io::write_to(&mut whole, &model, to, &options).unwrap();
            let output = folder.path().join("out").with_extension(to.extension());
            with_disk_mesh(&input, |mesh| {
                let _ = mesh.stage(&output, &options, None)?.commit()?;
                let mut streamed = Vec::new();
                let _ = mesh.write_to(&mut streamed, to, &options, None)?;
                assert!(streamed == whole, "{from} to {to}");
                Ok(())
            })
            .unwrap();
            assert!(std::fs::read(&output).unwrap() == whole, "{from} to {to}");
        }
    }
}

#[test]
fn numbers_of_vertices_have_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let normals_and_angles = |mesh: &TriMesh, own: &[VertexId]| {
        let topology = mesh.topology();
        let row = |&v: &VertexId| {
            let mut sum = DVec3::ZERO;
            // In the order of the faces: another order would change the last digits.
            for face in topology.faces_of_vertex(v) {
                let [a, b, c] = mesh.triangle(face);
                sum += (b - a).cross(c - a) * 0.1;
            }
            [sum.x, sum.length(), topology.faces_of_vertex(v).count() as f64]
        };
        own.iter().flat_map(row).collect::<Vec<f64>>()
    };
    let mut meshes = vec![torus(60_000, 4), open_torus(60_000, 5)];
    let mut lonely = torus(60_000, 6).to_soup();
    lonely.push_vertex([0.0, 0.5, 0.25]);
    meshes.push(TriMesh::from_soup(&lonely).unwrap());
    for mesh in &meshes {
        let input = write(mesh, &folder.path().join("in.ply"));
        let all: Vec<VertexId> = mesh.topology().vertices().collect();
        let whole = normals_and_angles(mesh, &all);
        let output = folder.path().join("out.ply");
        let ranks = with_disk_mesh(&input, |mesh| {
            let numbers = mesh.vertex_scalars(
                3,
                1,
                &mut |mesh, own| normals_and_angles(mesh, own),
                &mut |_| true,
            )?;
            let names = ["x_sum", "length", "faces"];
            let color = |row: &[f64]| [row[2] as u8, 1, 2, 255];
            let columns = out_of_core::Columns { numbers: &numbers, names: &names, color: &color };
            let _ = mesh.stage(&output, &WriteOptions::default(), Some(columns))?.commit()?;
            let ranks = [0, 1, numbers.count() / 3, numbers.count() - 1];
            let mut found = Vec::new();
            for rank in ranks {
                found.push((rank as usize, numbers.at_rank(rank)?.unwrap()));
            }
            assert_eq!(numbers.at_rank(numbers.count())?, None);
            Ok(found)
        })
        .unwrap();
        let model = mesh_io::read(&output).unwrap();
        assert_eq!(model.soup.positions(), mesh.positions());
        for (column, scalars) in model.vertex_scalars.iter().enumerate() {
            let expected = whole.iter().skip(column).step_by(3).map(|x| x.to_bits());
            assert!(scalars.values.iter().map(f64::to_bits).eq(expected), "{}", scalars.name);
        }
        let is_used = |v| !mesh.topology().is_isolated_vertex(v);
        let used: Vec<usize> = (mesh.topology().vertices().zip(0..))
            .filter(|&(v, _)| is_used(v))
            .map(|(_, i)| i)
            .collect();
        let mut sorted: Vec<f64> = used.iter().map(|&v| whole[3 * v + 1]).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        assert!(ranks.iter().all(|&(rank, value)| sorted[rank] == value));
        assert!(model.vertex_colors.unwrap()[0][0] > 0.0);
    }
    // The error names the vertex at which the surface is not a manifold.
    let input = save(&tangle(7), &folder.path().join("tangle.ply"));
    let refused = with_disk_mesh(&input, |mesh| {
        mesh.vertex_scalars(1, 0, &mut |_, own| vec![0.0; own.len()], &mut |_| true).map(|_| ())
    });
    assert!(
        matches!(refused, Err(Error::NotManifold { .. } | Error::Degenerate { .. })),
        "{refused:?}"
    );
}

#[test]
fn distances_are_those_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let a = torus(60_000, 8).to_soup();
    let mut far = PolygonSoup::new();
    torus(50_000, 9).positions().iter().for_each(|&p| {
        far.push_vertex(0.3 * p + DVec3::new(9.0, 4.0, -2.0));
    });
    let b = torus(50_000, 9);
    b.topology().triangles().for_each(|t| far.push_face(&t).unwrap());
    // A few large faces with small ones between them, in mostly empty space.
    let mut large = PolygonSoup::new();
    for corner in [[-9.0, -9.0, 0.5], [9.0, -9.0, 0.3], [9.0, 9.0, 0.5], [-9.0, 9.0, 0.0]] {
        large.push_vertex(corner);
    }
    large.push_face(&[0, 1, 2, 3]).unwrap();
    let first = large.vertex_count() as u32;
    torus(30_000, 2).positions().iter().for_each(|&p| {
        large.push_vertex(0.1 * p + DVec3::new(8.0, 8.0, 1.0));
    });
    let small = torus(30_000, 2);
    small.topology().triangles().for_each(|t| large.push_face(&t.map(|v| v + first)).unwrap());
    let options = CompareOptions { samples: 30_000, ..CompareOptions::default() };
    let near = b.to_soup();
    for (i, [a, b]) in [[&a, &near], [&a, &far], [&a, &large], [&large, &far]].iter().enumerate() {
        let paths =
            [(a, "a.ply"), (b, "b.ply")].map(|(s, name)| save(s, &folder.path().join(name)));
        let found = with_disk_mesh(&paths[0], |first| {
            with_disk_mesh(&paths[1], |second| distance(first, second, &options, &mut |_| true))
        })
        .unwrap();
        let [a, b] = [a, b].map(|soup| surface(soup));
        let whole = compare(&a, &b, &options);
        for (here, there) in [(found.forward, whole.forward), (found.backward, whole.backward)] {
            let close = |x: f64, y: f64| (x - y).abs() <= 1e-11 * y;
            assert!(close(here.mean, there.mean), "{i}: {here:?} {there:?}");
            assert!(close(here.rms, there.rms), "{i}: {here:?} {there:?}");
            assert_eq!(here.max, there.max, "{i}");
        }
    }
    let empty = save(&PolygonSoup::new(), &folder.path().join("empty.ply"));
    let input = save(&near, &folder.path().join("b.ply"));
    let refused = with_disk_mesh(&input, |first| {
        with_disk_mesh(&empty, |second| distance(first, second, &options, &mut |_| true))
    });
    assert!(matches!(refused, Err(Error::Surface(_))), "{refused:?}");
}

fn surface(soup: &PolygonSoup) -> Surface {
    let mesh = mesh_core::build(soup, &mesh_core::Repair::strict()).unwrap().mesh;
    Surface::new(&mesh).unwrap()
}

#[test]
fn what_stops_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let input = save(&tangle(1), &folder.path().join("in.ply"));
    let scratch_folder = folder.path().join("scratch");
    for stop_at in [1, 2, 3] {
        let scratch = ScratchFolder::new(&scratch_folder, "in".as_ref()).unwrap();
        let mut left = stop_at;
        let mut observer = |_| {
            left -= 1;
            left > 0
        };
        let reading = ReadOptions::default();
        let read =
            DiskMesh::read(&scratch, "a", Input::Path(&input), &reading, LITTLE, &mut observer);
        let done = read.and_then(|mesh| mesh.statistics(&mut observer));
        assert!(matches!(done, Err(Error::Stopped)), "{stop_at}: {done:?}");
        drop(scratch);
        assert_eq!(std::fs::read_dir(&scratch_folder).unwrap().count(), 0);
    }
    let little = DiskMesh::read(
        &ScratchFolder::new(&folder.path().join("other"), "in".as_ref()).unwrap(),
        "a",
        Input::Path(&input),
        &ReadOptions::default(),
        1 << 20,
        &mut |_| true,
    );
    assert!(matches!(little.map(|_| ()), Err(Error::TooLittleMemory { .. })));
}
