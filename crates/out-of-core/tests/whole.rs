//! Whole runs, compared with the same work in memory.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::f64::consts::{PI, TAU};

use crate::common::{Done, bits, open_torus, settings, simplify, split, torus, write};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_metric::{CompareOptions, Surface, compare};
use out_of_core::{
    Error, Next, Repairs, ResultMesh, Step, assemble, join, refine_cell, run, write_tiles,
};
use simplify::{Options, Preset};

/// The mean distance of two surfaces, in both directions.
fn mean(a: &TriMesh, b: &TriMesh) -> f64 {
    let [a, b] = [a, b].map(|mesh| Surface::new(mesh).unwrap());
    let options = CompareOptions { samples: 100_000, ..CompareOptions::default() };
    compare(&a, &b, &options).mean()
}

fn euler(mesh: &TriMesh) -> i64 {
    let topology = mesh.topology();
    topology.vertex_count() as i64 - topology.edge_count() as i64 + topology.face_count() as i64
}

#[test]
fn a_run_in_regions_is_as_good_as_one_in_memory() {
    let mesh = torus(60_000, 0);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    for preset in [Preset::Draft, Preset::Fast, Preset::Default] {
        let whole =
            simplify::simplify(&mesh, &Options::preset(preset).to_faces(1500)).unwrap().mesh;
        let work = folder.path().join(preset.name());
        let done = simplify(&work, &input, &settings(preset, 1500, 5000, 16_000)).unwrap();
        assert!(done.cells[0] == 16 && done.levels.len() > 1, "{:?} {:?}", done.cells, done.levels);
        let topology = done.mesh.topology();
        assert_eq!(topology.face_count(), whole.topology().face_count());
        assert!(topology.is_closed() && topology.validate().is_ok() && euler(&done.mesh) == 0);
        let [here, there] = [&done.mesh, &whole].map(|result| mean(&mesh, result));
        assert!(here < 1.03 * there, "{preset}: {here} in regions, {there} in memory");
    }
}

#[test]
fn rims_do_not_show() {
    let mesh = torus(60_000, 3);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    let given = settings(Preset::Default, 1500, 5000, 16_000);
    let work = split(&folder.path().join("work"), &input, &given).unwrap();
    let done = Done::from(run(&work, &mut |_| true).unwrap());
    let original = Surface::new(&mesh).unwrap();
    let cells = &work.manifest().cells;
    // Mean area and distance, for faces in several cells and for others.
    let mut sums = [[0.0; 3]; 2];
    for face in done.mesh.topology().faces() {
        let corners = done.mesh.triangle(face);
        let other_cells = corners.map(|corner| cells.cell_of(corner));
        let at_rim =
            usize::from(other_cells[0] != other_cells[1] || other_cells[1] != other_cells[2]);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        let add = [1.0, area, area * original.distance(middle)];
        sums[at_rim].iter_mut().zip(add).for_each(|(sum, value)| *sum += value);
    }
    let [elsewhere, rim] = sums.map(|[count, area, moved]| [area / count, moved / area, count]);
    assert!(rim[2] > 100.0, "{rim:?}");
    // Larger faces are more likely to lie across a plane.
    assert!(rim[0] > 0.9 * elsewhere[0] && rim[0] < 1.7 * elsewhere[0], "{rim:?} {elsewhere:?}");
    assert!(rim[1] < 1.25 * elsewhere[1], "{rim:?} {elsewhere:?}");
}

/// An ellipsoid by longitude and latitude, with needles at its poles.
fn ellipsoid(round: u32, up: u32, height: f64) -> TriMesh {
    let poles = [[0.0, 0.0, -height], [0.0, 0.0, height]];
    let ring = |row: u32| {
        let b = PI * (f64::from(row) / f64::from(up) - 0.5);
        let at = move |column: u32| {
            let a = TAU * f64::from(column) / f64::from(round);
            [b.cos() * a.cos(), b.cos() * a.sin(), height * b.sin()]
        };
        (0..round).map(at)
    };
    let points: Vec<[f64; 3]> = poles.into_iter().chain((1..up).flat_map(ring)).collect();
    let at = |column: u32, row: u32| 2 + (row - 1) * round + column % round;
    let column = |c: u32| {
        let walls = (1..up - 1).flat_map(move |row| {
            let [a, b] = [at(c, row), at(c + 1, row)];
            let [d, e] = [at(c, row + 1), at(c + 1, row + 1)];
            [[a, b, e], [a, e, d]]
        });
        walls.chain([[0, at(c + 1, 1), at(c, 1)], [1, at(c, up - 1), at(c + 1, up - 1)]])
    };
    let faces: Vec<[u32; 3]> = (0..round).flat_map(column).collect();
    TriMesh::from_triangles(&points, &faces).unwrap()
}

#[test]
fn long_regions_are_neither_destroyed_nor_folded() {
    let mesh = ellipsoid(240, 105, 2.3);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    let given = settings(Preset::Default, 1000, 6700, 3000);
    let done = simplify(&folder.path().join("work"), &input, &given).unwrap();
    let whole = simplify::simplify(&mesh, &given.options).unwrap().mesh;
    let [here, there] = [&done.mesh, &whole].map(|result| mean(&mesh, result));
    assert!(here < 1.1 * there, "{here} in regions, {there} in memory");
    for face in done.mesh.topology().faces() {
        let outward = done.mesh.face_centroid(face).dot(done.mesh.face_cross(face));
        assert!(outward > 0.0, "{face:?} at {:?}", done.mesh.triangle(face));
    }
}

#[test]
fn a_boundary_stays_one() {
    let mesh = open_torus(40_000, 1);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    let work = folder.path().join("work");
    let done = simplify(&work, &input, &settings(Preset::Default, 2000, 4000, 12_000)).unwrap();
    assert_eq!(euler(&done.mesh), euler(&mesh));
    let loops = |mesh: &TriMesh| mesh.topology().boundary_loops().len();
    assert_eq!(loops(&done.mesh), loops(&mesh));
    assert!(mean(&mesh, &done.mesh) < 0.02);
}

#[test]
fn threads_do_not_matter_and_formats_neither() {
    let mesh = torus(30_000, 2);
    let folder = tempfile::tempdir().unwrap();
    let given = settings(Preset::Fast, 1000, 3000, 8000);
    let inputs = ["ply", "obj", "stl"]
        .map(|extension| write(&mesh, &folder.path().join("in").with_extension(extension)));
    let mut results = Vec::new();
    for threads in 1..=3 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let work = folder.path().join(format!("threads-{threads}"));
        let done = pool.install(|| simplify(&work, &inputs[0], &given)).unwrap();
        let again: Result<Vec<String>, Error> = pool.install(|| {
            let work =
                split(&folder.path().join(format!("reduced-{threads}")), &inputs[0], &given)?;
            work.plan(0)?;
            (0..work.cells(0)?)
                .map(|cell| work.reduce(0, cell).map(|record| record.sha256))
                .collect()
        });
        let files = again.unwrap();
        results.push((bits(&done.mesh), files));
    }
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
    // STL has coordinates of 32 bits, and vertices in another order.
    for (input, faces) in inputs.iter().zip([1000, 1000, 1000]) {
        let work = input.with_extension("work");
        let done = simplify(&work, input, &given).unwrap();
        assert_eq!(done.mesh.topology().face_count(), faces);
        assert!(done.mesh.topology().is_closed(), "{}", input.display());
        std::fs::remove_dir_all(work).unwrap();
    }
}

#[test]
fn a_run_that_was_stopped_anywhere_goes_on_to_the_same_result() {
    let mesh = torus(30_000, 5);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    let given = settings(Preset::Default, 1000, 3000, 8000);
    let whole = simplify(&folder.path().join("whole"), &input, &given).unwrap();
    let mut random = fastrand::Rng::with_seed(11);
    let mut stops = 0;
    let work = folder.path().join("work");
    let done = loop {
        let mut left = random.usize(1..40);
        let observer = &mut |_: Step| {
            left = left.saturating_sub(1);
            left > 0 || stops > 20
        };
        let reading = mesh_io::ReadOptions::default();
        let source = out_of_core::Input::Path(&input);
        let done = out_of_core::Work::split(&work, source, &reading, given.clone(), observer)
            .and_then(|work| run(&work, observer));
        match done {
            Ok(done) => break Done::from(done),
            Err(Error::Stopped) => stops += 1,
            Err(error) => panic!("{error}"),
        }
        // A file that was half written at a power failure, under its own name or another.
        if let Some(path) = std::fs::read_dir(work.join("level-1")).ok().and_then(|mut all| {
            all.find_map(|entry| {
                Some(entry.ok()?.path()).filter(|p| p.extension() == Some("region".as_ref()))
            })
        }) && stops == 3
        {
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        }
    };
    assert!(stops > 0);
    assert_eq!(bits(&done.mesh), bits(&whole.mesh));
    // Another run is not confused with it.
    let other = settings(Preset::Default, 1001, 3000, 8000);
    assert!(matches!(split(&work, &input, &other), Err(Error::OtherRun { .. })));
}

#[test]
fn regions_hold_every_face_once_and_join_to_the_whole() {
    let mesh = open_torus(20_000, 4);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    let given = settings(Preset::Draft, 100, 700, 1000);
    let work = split(&folder.path().join("work"), &input, &given).unwrap();
    let cells = work.cells(0).unwrap();
    let mut owned = Vec::new();
    let mut regions = Vec::new();
    for cell in 0..cells {
        let region = work.region(0, cell).unwrap();
        let ids = |t: [u32; 3]| t.map(|v| region.vertex_ids[v as usize]);
        owned.extend(region.own_triangles().map(ids).map(rotated));
        regions.push(region);
    }
    let whole: Vec<[u64; 3]> =
        mesh.topology().triangles().map(|t| rotated(t.map(u64::from))).collect();
    let sorted = |mut all: Vec<[u64; 3]>| {
        all.sort_unstable();
        all
    };
    assert_eq!(sorted(owned), sorted(whole.clone()));
    // Level by level and all at once give the same result.
    let bits = cells.trailing_zeros();
    assert!(bits >= 4);
    let at_once = join(regions.clone(), bits).unwrap();
    let mut by_pairs = regions;
    while by_pairs.len() > 1 {
        by_pairs = by_pairs.chunks(2).map(|pair| join(pair.to_vec(), 1).unwrap()).collect();
    }
    for all in [&at_once, &by_pairs[0]] {
        assert!(all.other_cells.is_empty() && all.own == mesh.topology().vertex_count());
        assert_eq!(all.positions, mesh.positions());
        let ids = |t: &[u32; 3]| rotated(t.map(|v| all.vertex_ids[v as usize]));
        assert_eq!(sorted(all.triangles.iter().map(ids).collect()), sorted(whole.clone()));
    }
}

fn rotated([a, b, c]: [u64; 3]) -> [u64; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= a && b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[test]
fn defects_are_refused_or_cut() {
    // Two tori that share a vertex, and one face that uses a vertex twice.
    let folder = tempfile::tempdir().unwrap();
    let mut soup = torus(8000, 0).to_soup();
    let far = torus(8000, 1);
    let first = soup.vertex_count() as u32;
    for (i, &p) in far.positions().iter().enumerate() {
        let there = p + glam::DVec3::new(20.0, 0.0, 0.0);
        soup.push_vertex(if i == 0 { soup.positions()[0] } else { there });
    }
    for t in far.topology().triangles() {
        let shared = |v: u32| if v == 0 { 0 } else { v + first };
        soup.push_face(&t.map(shared)).unwrap();
    }
    let pinched = folder.path().join("pinched.ply");
    let model = mesh_io::Model::from(soup.clone());
    mesh_io::write(&pinched, &model, &mesh_io::WriteOptions::default()).unwrap();
    let mut given = settings(Preset::Draft, 2000, 1000, 6000);
    let work = folder.path().join("work");
    let refused = simplify(&work, &pinched, &given);
    assert!(matches!(refused, Err(Error::NotManifold { vertex: 0 })), "{refused:?}");
    given.repairs = Repairs { cut_non_manifold: true, ..Repairs::default() };
    let done = simplify(&work, &pinched, &given).unwrap();
    let topology = done.mesh.topology();
    assert!(topology.validate().is_ok() && topology.face_count() <= 2000 && topology.is_closed());

    soup.push_face(&[5_u32, 9, 5]).unwrap();
    let twice = folder.path().join("twice.ply");
    let model = mesh_io::Model::from(soup);
    mesh_io::write(&twice, &model, &mesh_io::WriteOptions::default()).unwrap();
    let work = folder.path().join("twice");
    assert!(matches!(simplify(&work, &twice, &given), Err(Error::Degenerate { vertex: 5 })));
    given.repairs.drop_degenerate = true;
    assert!(simplify(&work, &twice, &given).is_ok());
}

#[test]
fn plans_tell_how_many_faces_are_left() {
    let mesh = torus(60_000, 7);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    let given = settings(Preset::Draft, 500, 8000, 10_000);
    let work = split(&folder.path().join("work"), &input, &given).unwrap();
    let plan = work.plan(0).unwrap();
    let Next::Pass { aim, .. } = plan.next else { panic!("{plan:?}") };
    let left: u64 = (0..plan.cells).map(|cell| work.reduce(0, cell).unwrap().faces).sum();
    assert!(left.abs_diff(aim) < aim / 8, "{left} for {aim}");
}

#[test]
fn a_result_larger_than_memory_is_put_together_from_its_regions() {
    let mesh = open_torus(60_000, 6);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    for preset in [Preset::Fast, Preset::Default] {
        let mut given = settings(preset, 24_000, 10_000, 9000);
        given.prove = (preset == Preset::Default).then_some(1e-3);
        let work = split(&folder.path().join(preset.name()), &input, &given).unwrap();
        let done = run(&work, &mut |_| true).unwrap();
        let ResultMesh::OnDisk { level } = done.result else { panic!("{done:?}") };
        // A cell refined separately, on another machine, is the same.
        let record = refine_cell(&work, level, 1, &mut |_| true).unwrap();
        let path = work.folder().join(format!("level-{level}/cell-1.refined"));
        std::fs::remove_file(path).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let again = pool.install(|| refine_cell(&work, level, 1, &mut |_| true)).unwrap();
        assert_eq!((record.sha256, record.faces), (again.sha256, again.faces));

        let output = folder.path().join("out.ply");
        assert_eq!(assemble(&work, level, &output).unwrap(), done.faces);
        let model = mesh_io::read(&output).unwrap();
        let result = TriMesh::from_soup(&model.soup).unwrap();
        assert_eq!(result.topology().face_count() as u64, done.faces);
        assert_eq!(euler(&result), euler(&mesh));
        // Within 1 % of the target.
        assert!(done.faces.abs_diff(24_000) < 240, "{preset} {} {:?}", done.faces, done.levels);
        let options = Options::preset(preset).to_faces(done.faces as usize);
        let whole = simplify::simplify(&mesh, &options).unwrap().mesh;
        let [here, there] = [&result, &whole].map(|result| mean(&mesh, result));
        assert!(here < 1.1 * there, "{preset}: {here} in regions, {there} in memory");
        // The borders of its cells are not visible.
        let cells = &work.manifest().cells;
        let bits = cells.count().trailing_zeros() - work.cells(level).unwrap().trailing_zeros();
        let [elsewhere, at_rims] = areas(&result, |point| cells.cell_of(point) >> bits);
        let [beside, there] = areas(&whole, |point| cells.cell_of(point) >> bits);
        let (here, there) = (at_rims / elsewhere, there / beside);
        assert!(here > 0.8 * there && here < 1.25 * there, "{preset}: {here} and {there}");
        if let Some(proved) = done.error {
            let [a, b] = [&mesh, &result].map(|mesh| Surface::new(mesh).unwrap());
            assert!(compare(&a, &b, &CompareOptions::default()).hausdorff() <= proved);
        }

        // As tiles: every face exactly once, and equal coordinates on common borders.
        let tiles = write_tiles(&work, &ResultMesh::OnDisk { level }, &folder.path().join("tiles"))
            .unwrap();
        assert_eq!(tiles.faces, done.faces);
        let mut faces: Vec<[[u64; 3]; 3]> = Vec::new();
        for tile in &tiles.tiles {
            let model = mesh_io::read(folder.path().join("tiles").join(&tile.file)).unwrap();
            assert_eq!(model.soup.face_count() as u64, tile.faces);
            faces.extend(corners(&model.soup));
        }
        let mut whole = corners(&model.soup);
        faces.sort_unstable();
        whole.sort_unstable();
        assert!(faces == whole);
    }
}

/// The mean area of faces in one cell, and of faces in several.
fn areas(mesh: &TriMesh, cell_of: impl Fn(glam::DVec3) -> u32) -> [f64; 2] {
    let mut sums = [[0.0; 2]; 2];
    for face in mesh.topology().faces() {
        let [a, b, c] = mesh.triangle(face);
        let at_rim = cell_of(a) != cell_of(b) || cell_of(b) != cell_of(c);
        sums[usize::from(at_rim)][0] += 0.5 * (b - a).cross(c - a).length();
        sums[usize::from(at_rim)][1] += 1.0;
    }
    sums.map(|[area, count]| area / count)
}

/// The corners of all faces, bit for bit, each face starting from its smallest corner.
fn corners(soup: &PolygonSoup) -> Vec<[[u64; 3]; 3]> {
    let bits = |v: u32| soup.positions()[v as usize].to_array().map(f64::to_bits);
    let face = |face: &[u32]| {
        let mut corners = [bits(face[0]), bits(face[1]), bits(face[2])];
        let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
        corners.rotate_left(least);
        corners
    };
    soup.faces().map(face).collect()
}

/// Files of all formats are split alike, and files where every face has vertices of its own as well.
#[test]
fn all_formats_are_split_alike() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = torus(3000, 4);
    let (vertices, faces) = (mesh.topology().vertex_count(), mesh.topology().face_count());
    let mut loose = PolygonSoup::new();
    for triangle in mesh.topology().triangles() {
        let first = loose.vertex_count() as u32;
        triangle.iter().for_each(|&v| loose.push_vertex(mesh.positions()[v as usize]));
        loose.push_face(&[first, first + 1, first + 2]).unwrap();
    }
    let mut given = settings(Preset::Fast, 500, 300, 1000);
    for (number, suffix) in ["ply", "obj", "off", "stl", "gltf", "glb"].into_iter().enumerate() {
        for (soup, is_loose) in [(mesh.to_soup(), false), (loose.clone(), true)] {
            let name = format!("{number}-{is_loose}");
            let input = folder.path().join(format!("{name}.{suffix}"));
            let model = mesh_io::Model::from(soup);
            mesh_io::write(&input, &model, &mesh_io::WriteOptions::default()).unwrap();
            for joins in [true, false] {
                given.repairs.join_loose_faces = joins;
                let work = split(&folder.path().join(format!("{name}-{joins}")), &input, &given);
                let work = work.unwrap();
                let summary = &work.manifest().summary;
                let keeps_vertices = number < 3;
                let expected =
                    if is_loose && keeps_vertices && !joins { 3 * faces } else { vertices };
                assert_eq!(
                    (summary.vertices, summary.faces),
                    (expected as u64, faces as u64),
                    "{name}"
                );
                let is_told = summary.notes.iter().any(|note| note.contains("merged vertices"));
                assert_eq!(is_told, is_loose && keeps_vertices && joins, "{name}");
            }
        }
    }
}
