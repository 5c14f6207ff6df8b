//! Surfaces with many small texture charts.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use glam::DVec3;
use mesh_core::Repair;
use mesh_io::{Model, Scalars};
use mesh_metric::{Surface, sample_surface};
use mesh_work::{AttributeRules, Attributes, ConstraintChoices, LevelRecord, LevelSteps, Loaded};
use proptest::prelude::*;
use simplify::{ErrorCheck, Options, Simplified, simplify};

/// The number of charts along a side of the texture.
const ALONG: usize = 64;
/// The part of its cell that a chart fills.
const PART: f64 = 0.8;

/// A sphere, made of the six sides of a cube with `cells` cells along an edge. Each chart has `size` times `size`
/// cells, fills a cell of the texture, and is rotated in it by its number.
fn patchwork(cells: usize, size: usize) -> Model {
    let (mut points, mut triangles, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    let mut numbers = BTreeMap::new();
    let per_side = cells.div_ceil(size);
    for side in 0..6 {
        for i in 0..cells {
            for j in 0..cells {
                let chart = (side * per_side + i / size) * per_side + j / size;
                let corner = |di: usize, dj: usize| {
                    let [s, t] = [i + di, j + dj].map(|k| 2 * k as i64 - cells as i64);
                    let n = if side % 2 == 0 { cells as i64 } else { -(cells as i64) };
                    let [s, t] = if side % 2 == 0 { [s, t] } else { [t, s] };
                    let key = match side / 2 {
                        0 => [n, s, t],
                        1 => [t, n, s],
                        _ => [s, t, n],
                    };
                    let local = [i % size + di, j % size + dj].map(|k| k as f64 / size as f64);
                    (key, uv(chart, local))
                };
                let square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                for three in [[0, 1, 2], [0, 2, 3]] {
                    triangles.push(three.map(|k: usize| {
                        let (key, uv) = square[k];
                        uvs.push(uv);
                        *numbers.entry(key).or_insert_with(|| {
                            points.push(DVec3::from(key.map(|x| x as f64)).normalize());
                            points.len() as u32 - 1
                        })
                    }));
                }
            }
        }
    }
    let points: Vec<[f64; 3]> = points.iter().map(DVec3::to_array).collect();
    let soup = mesh_core::PolygonSoup::from_triangles(&points, &triangles).unwrap();
    Model { corner_uvs: Some(uvs), ..Model::from(soup) }
}

fn uv(chart: usize, [s, t]: [f64; 2]) -> [f32; 2] {
    let [s, t] = if chart.is_multiple_of(2) { [s, t] } else { [t, 1.0 - s] };
    let cell = [chart % ALONG, chart / ALONG].map(|k| k as f64);
    [cell[0] + 0.1 + PART * s, cell[1] + 0.1 + PART * t].map(|x| (x / ALONG as f64) as f32)
}

/// The chart of a point of the texture; `None` between charts.
fn chart_of(uv: [f32; 2]) -> Option<usize> {
    let [u, v] = uv.map(|x| f64::from(x) * ALONG as f64);
    let inside = |x: f64| (0.0999..=0.9001).contains(&(x - x.floor()));
    (inside(u) && inside(v)).then(|| u.floor() as usize + ALONG * v.floor() as usize)
}

/// The result with attributes, and the charts before and after if some were merged.
fn simplified(model: &Model, faces: usize, merge: bool) -> (Simplified, Model, Option<[usize; 2]>) {
    let loaded = Loaded::build(model.clone(), &Repair::strict()).unwrap();
    let attributes = Attributes::find(loaded.source(), &AttributeRules::default()).unwrap();
    let mut options = Options::default().to_faces(faces);
    let merged = merge.then(|| attributes.merge_charts(&loaded.mesh, &options.target)).flatten();
    let attributes = merged.unwrap_or(attributes);
    attributes.constrain(&loaded.mesh, &mut options);
    let small = simplify(&loaded.mesh, &options).unwrap();
    let result = attributes.carry(loaded.source(), &small.mesh, &small.vertex_map).unwrap();
    (small, result, attributes.merged())
}

/// The mean distance of the unit sphere from a surface.
fn mean_distance(small: &Simplified) -> f64 {
    let samples = sample_surface(&Surface::new(&small.mesh).unwrap(), 20_000, 1);
    samples.iter().map(|s| (1.0 - s.position.length()).abs()).sum::<f64>() / samples.len() as f64
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Texture coordinates are bound to charts. Numbers, colours and normals are not: they stay where they are.
    #[test]
    fn data_of_vertices_cross_the_borders_of_merged_charts(
        cells in 6_usize..13,
        size in 1_usize..4,
        ratio in 0.1..0.4_f64,
    ) {
        let mut model = patchwork(cells, size);
        let points = model.soup.positions().to_vec();
        let coordinate = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
        model.vertex_scalars = (0..3).map(|k| Scalars::new(["x", "y", "z"][k], coordinate(k))).collect();
        let color = |p: &DVec3| [p.x, p.y, p.z, 1.0].map(|c| (0.5 + 0.5 * c) as f32);
        model.vertex_colors = Some(points.iter().map(color).collect());
        let normal = |&v: &u32| points[v as usize].as_vec3().to_array();
        model.corner_normals = Some(model.soup.corners().iter().map(normal).collect());
        let faces = (ratio * model.soup.face_count() as f64) as usize;
        let (_, result, merged) = simplified(&model, faces, true);
        prop_assume!(merged.is_some());
        let (colors, normals) = (result.vertex_colors.unwrap(), result.corner_normals.unwrap());
        for (v, at) in result.soup.positions().iter().map(|p| p.normalize()).enumerate() {
            let value = DVec3::from([0, 1, 2].map(|k| result.vertex_scalars[k].values.get(v).unwrap()));
            prop_assert!(value.distance(at) < 0.12, "{value} at {at}");
            let [r, g, b, _] = colors[v].map(|c| 2.0 * f64::from(c) - 1.0);
            prop_assert!(DVec3::new(r, g, b).distance(at) < 0.12);
        }
        // Across sharp edges of a coarse result, normals are those of its faces.
        let is_near = |&(&v, normal): &(&u32, [f32; 3])| {
            let at = result.soup.positions()[v as usize].normalize();
            DVec3::from(normal.map(f64::from)).distance(at) < 0.12
        };
        let near = result.soup.corners().iter().zip(normals).filter(is_near).count();
        prop_assert!(near * 10 > 9 * result.soup.corners().len(), "{near} normals");
    }

    /// Small charts neither stop the run nor ruin the shape, and every face shows a part of one chart.
    #[test]
    fn charts_without_room_are_merged(
        cells in 6_usize..13,
        size in 1_usize..4,
        ratio in 0.08..0.4_f64,
    ) {
        let model = patchwork(cells, size);
        let faces = (ratio * model.soup.face_count() as f64) as usize;
        let (small, result, merged) = simplified(&model, faces, true);
        prop_assert!(small.mesh.topology().face_count() <= faces);
        let uvs = result.corner_uvs.unwrap();
        for (face, corners) in uvs.chunks(3).enumerate() {
            let charts = [0, 1, 2].map(|k| chart_of(corners[k]));
            prop_assert!(charts[0].is_some() && charts[1] == charts[0] && charts[2] == charts[0],
                "face {face}: {corners:?}");
        }
        let mut bare = model.clone();
        bare.corner_uvs = None;
        let (free, ..) = simplified(&bare, faces, true);
        let (ours, best) = (mean_distance(&small), mean_distance(&free));
        prop_assert!(ours <= 3.5 * best, "{merged:?} charts: {ours} instead of {best}");
    }
}

#[test]
fn charts_with_room_stay() {
    let model = patchwork(12, 12);
    let (small, result, merged) = simplified(&model, 600, true);
    let (kept, same, _) = simplified(&model, 600, false);
    assert_eq!(merged, None);
    assert_eq!((small.mesh.positions(), result), (kept.mesh.positions(), same));
}

#[test]
fn merging_is_what_reaches_the_target() {
    let model = patchwork(12, 1);
    let (stuck, ..) = simplified(&model, 300, false);
    assert_eq!(stuck.mesh.topology().face_count(), model.soup.face_count());
    let (small, _, merged) = simplified(&model, 300, true);
    assert!(small.mesh.topology().face_count() <= 300);
    let [before, after] = merged.unwrap();
    assert_eq!(before, 6 * 12 * 12);
    assert!(after < 60, "{after}");
}

/// Levels reach their numbers of faces where charts have no room, and levels from the record are the same.
#[test]
fn levels_merge_charts_and_their_record_knows_it() {
    let loaded = Loaded::build(patchwork(12, 1), &Repair::strict()).unwrap();
    let (source, mesh) = (loaded.source(), &loaded.mesh);
    let steps = LevelSteps { faces: vec![900, 300], ..LevelSteps::default() };
    let find = || Attributes::find(source, &AttributeRules::default()).unwrap();
    let none = ConstraintChoices::default();
    let plan = |keeps_seams: bool| {
        let options = Options { target: steps.limits(), ..Options::default() };
        steps.plan(source, options, find(), (&none, keeps_seams), ErrorCheck::Sampled).unwrap()
    };
    let kept = plan(true);
    let stuck = simplify(mesh, &kept.options).unwrap();
    assert!(kept.record(mesh, stuck.log).room.is_none());
    assert_eq!(stuck.mesh.topology().face_count(), mesh.topology().face_count());
    let merged = plan(false);
    assert!(merged.attributes.merged().is_some());
    let mut record = merged.record(mesh, simplify(mesh, &merged.options).unwrap().log);
    record.limits.max_valence = Some(40);
    let mut bytes = Vec::new();
    record.write(mesh, &mut bytes).unwrap();
    let again = LevelRecord::read(mesh, &mut &bytes[..]).unwrap();
    assert_eq!((again.room, again.limits), (Some(300), record.limits));
    // Cut off anywhere, or with one bit changed in any of its bytes, the record is refused.
    for end in 0..bytes.len() {
        assert!(LevelRecord::read(mesh, &mut &bytes[..end]).is_err(), "the first {end} bytes");
        let mut changed = bytes.clone();
        changed[end] ^= 1 << (end % 8);
        assert!(LevelRecord::read(mesh, &mut &changed[..]).is_err(), "byte {end} changed");
    }
    let levels = |record: &LevelRecord, attributes: &Attributes| {
        let levels = steps.levels(record, source, attributes, ErrorCheck::Sampled).unwrap();
        levels.into_iter().map(|level| level.model).collect::<Vec<_>>()
    };
    let (first, second) =
        (levels(&record, &merged.attributes), levels(&again, &again.attributes(mesh, find())));
    assert_eq!(first, second);
    for (model, most) in first.iter().zip([900, 300]) {
        assert!(model.soup.face_count() <= most, "{} {most}", model.soup.face_count());
        for (face, corners) in model.corner_uvs.as_ref().unwrap().chunks(3).enumerate() {
            let charts = [0, 1, 2].map(|k| chart_of(corners[k]));
            assert!(
                charts[0].is_some() && charts[1] == charts[0] && charts[2] == charts[0],
                "{face}"
            );
        }
    }
}
