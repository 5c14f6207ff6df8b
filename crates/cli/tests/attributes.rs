//! Texture coordinates, materials and normals through `curvmesh simplify`.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::Path;

use crate::common::{json, models};
use glam::{DMat2, DVec2, DVec3};
use mesh_core::PolygonSoup;
use mesh_core::build::weld_exact;
use mesh_io::{Image, ImageData, Material, Model, WriteOptions};

/// A wavy tube, cut open along one line in the texture, with another material on its upper half.
fn tube(around: u32, along: u32) -> Model {
    let mut soup = PolygonSoup::new();
    let at = |i: u32, j: u32| j * around + i % around;
    for j in 0..=along {
        for i in 0..around {
            let (angle, z) = (TAU * f64::from(i) / f64::from(around), f64::from(j));
            let radius = 5.0 + 0.3 * (0.7 * z).sin() * (3.0 * angle).cos();
            soup.push_vertex([radius * angle.cos(), radius * angle.sin(), z]);
        }
    }
    let (mut uvs, mut materials) = (Vec::new(), Vec::new());
    for j in 0..along {
        for i in 0..around {
            let quad = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            for corners in [[0, 1, 2], [0, 2, 3]] {
                soup.push_face(&corners.map(|c| at(quad[c][0], quad[c][1]))).unwrap();
                uvs.extend(
                    corners
                        .map(|c| quad[c])
                        .map(|[i, j]| [i as f32 / around as f32, j as f32 / along as f32]),
                );
                materials.push(u32::from(2 * j >= along));
            }
        }
    }
    let picture = Image {
        name: "picture".into(),
        media_type: "image/png".into(),
        data: ImageData::Bytes(b"\x89PNG\r\n\x1a\n and so on".to_vec()),
    };
    let material = |name: &str, image| Material {
        name: name.into(),
        base_color_image: image,
        ..Material::default()
    };
    Model {
        corner_uvs: Some(uvs),
        face_materials: Some(materials),
        materials: vec![material("lower", Some(0)), material("upper", None)],
        images: vec![picture],
        ..Model::from(soup)
    }
}

/// Properties of a texture layout that are to be preserved.
#[derive(Debug, PartialEq)]
struct Layout {
    /// Connected pieces of the surface without a border of a chart or material inside.
    charts: usize,
    boundary_edges: usize,
    /// Faces with opposite orientation in the texture to most of the area of their chart.
    folded: usize,
}

/// The triangles of a model after an exact weld.
fn joined(model: &Model) -> Vec<[u32; 3]> {
    let target = weld_exact(model.soup.positions());
    let triangle = |face: &[u32]| <[u32; 3]>::try_from(face).unwrap().map(|v| target[v as usize]);
    model.soup.faces().map(triangle).collect()
}

fn layout(model: &Model) -> Layout {
    let triangles = joined(model);
    let uvs = model.corner_uvs.as_ref().unwrap().as_chunks::<3>().0;
    let material = |face: usize| model.face_materials.as_ref().map_or(0, |all| all[face]);
    let mut edges = HashMap::<[u32; 2], Vec<(usize, [[u32; 2]; 2])>>::new();
    for (face, (corners, uvs)) in triangles.iter().zip(uvs).enumerate() {
        for k in 0..3 {
            let mut ends = [k, (k + 1) % 3].map(|c| (corners[c], uvs[c].map(f32::to_bits)));
            ends.sort_unstable_by_key(|end| end.0);
            edges.entry(ends.map(|end| end.0)).or_default().push((face, ends.map(|end| end.1)));
        }
    }
    let mut chart: Vec<usize> = (0..triangles.len()).collect();
    fn root(chart: &mut [usize], mut face: usize) -> usize {
        while chart[face] != face {
            chart[face] = chart[chart[face]];
            face = chart[face];
        }
        face
    }
    for sides in edges.values() {
        if let [(f, p), (g, q)] = sides[..]
            && p == q
            && material(f) == material(g)
        {
            let (f, g) = (root(&mut chart, f), root(&mut chart, g));
            chart[f] = g;
        }
    }
    let area = |face: usize| {
        let [a, b, c] = uvs[face].map(|uv| DVec2::from(uv.map(f64::from)));
        (b - a).perp_dot(c - a)
    };
    let mut sums = HashMap::<usize, f64>::new();
    for face in 0..triangles.len() {
        *sums.entry(root(&mut chart, face)).or_default() += area(face);
    }
    let mut is_folded = |face: usize| area(face) * sums[&root(&mut chart, face)] < 0.0;
    let folded = (0..triangles.len()).filter(|&face| is_folded(face)).count();
    let boundary_edges = edges.values().filter(|sides| sides.len() == 1).count();
    Layout { charts: sums.len(), boundary_edges, folded }
}

/// The largest and the area-weighted mean number of texture units per model unit.
fn stretch(model: &Model) -> [f64; 2] {
    let uvs = model.corner_uvs.as_ref().unwrap().as_chunks::<3>().0;
    let (mut largest, mut sum, mut total) = (0.0_f64, 0.0, 0.0);
    for (face, uvs) in model.soup.faces().zip(uvs) {
        let [a, b, c] =
            <[u32; 3]>::try_from(face).unwrap().map(|v| model.soup.positions()[v as usize]);
        let normal = (b - a).cross(c - a);
        let x = (b - a).normalize_or_zero();
        let y = normal.cross(x).normalize_or_zero();
        let flat = |p: DVec3| DVec2::new((p - a).dot(x), (p - a).dot(y));
        let [p, q, r] = uvs.map(|uv| DVec2::from(uv.map(f64::from)));
        let map = DMat2::from_cols(q - p, r - p) * DMat2::from_cols(flat(b), flat(c)).inverse();
        // The larger singular value.
        let square = map.transpose() * map;
        let half = 0.5 * (square.x_axis.x + square.y_axis.y);
        let root = (half * half - square.determinant()).max(0.0).sqrt();
        let value = (half + root).sqrt();
        if value.is_finite() {
            largest = largest.max(value);
            (sum, total) = (sum + normal.length() * value, total + normal.length());
        }
    }
    [largest, sum / total]
}

fn simplified(
    input: &Path,
    output: &Path,
    ratio: &str,
    more: &[&str],
) -> (Model, serde_json::Value) {
    let [input, output] = [input, output].map(|path| path.to_str().unwrap());
    let arguments = ["simplify", input, "-o", output, "--ratio", ratio];
    let report = json(&[&arguments[..], more].concat());
    (mesh_io::read(output).unwrap(), report)
}

#[test]
fn a_textured_glb_stays_one_with_its_seams_closed() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.glb"), folder.path().join("out.glb"));
    let model = tube(48, 24);
    mesh_io::write(&input, &model, &WriteOptions::default()).unwrap();
    for more in [&[][..], &["--preset", "extreme"], &["--attribute-weight", "0"]] {
        let (result, report) = simplified(&input, &output, "0.2", more);
        let faces = report["faces_out"].as_u64().unwrap();
        assert!((460..=461).contains(&faces), "{report}");
        assert_eq!(result.images[0].data, model.images[0].data);
        assert_eq!(result.materials.len(), 2);
        let found = layout(&result);
        assert_eq!(found.charts, 2, "{more:?}: {found:?}");
        // Without any weight the texture is ignored.
        assert!(found.folded == 0 || more.contains(&"0"), "{more:?}: {found:?}");
        // Only the two ends of the tube are open.
        let open = found.boundary_edges;
        assert!((6..=96).contains(&open), "{found:?}");
        let uvs = result.corner_uvs.as_ref().unwrap();
        for (uv, &v) in uvs.iter().zip(result.soup.corners()) {
            let p = result.soup.positions()[v as usize];
            let [u, v] = uv.map(f64::from);
            let angle = (p.y.atan2(p.x) / TAU).rem_euclid(1.0);
            // At the cut, both 0 and 1 are correct.
            let off = (u - angle).abs().min((u - angle - 1.0).abs()).min((u - angle + 1.0).abs());
            assert!(off < 0.02 && (v - p.z / 24.0).abs() < 0.02, "{uv:?} at {p}");
        }
        // No face spans the whole picture from one side of the cut to the other.
        for [a, b, c] in uvs.as_chunks::<3>().0 {
            let widths = [a[0] - b[0], b[0] - c[0], c[0] - a[0]].map(f32::abs);
            assert!(widths.iter().all(|&w| w < 0.5), "{a:?} {b:?} {c:?}");
        }
        let ([most, mean], [most_before, mean_before]) = (stretch(&result), stretch(&model));
        assert!((mean / mean_before - 1.0).abs() < 0.05, "{mean} {mean_before}");
        assert!(most < 3.0 * most_before, "{most} {most_before}");
    }
}

/// The coordinates of a flat grid are its texture coordinates, before and after.
#[test]
fn texture_coordinates_that_are_linear_stay_so() {
    let cells = 24_u32;
    let mut soup = PolygonSoup::new();
    for i in 0..=cells {
        for j in 0..=cells {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(cells));
            soup.push_vertex([x, y, 0.0]);
        }
    }
    let at = |i: u32, j: u32| i * (cells + 1) + j;
    let mut uvs = Vec::new();
    for i in 0..cells {
        for j in 0..cells {
            for face in [
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ] {
                soup.push_face(&face).unwrap();
                uvs.extend(
                    face.map(|v| soup.positions()[v as usize]).map(|p| [p.x as f32, p.y as f32]),
                );
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.obj"), folder.path().join("out.obj"));
    let model = Model { corner_uvs: Some(uvs), ..Model::from(soup) };
    mesh_io::write(&input, &model, &WriteOptions::default()).unwrap();
    let (result, _) = simplified(&input, &output, "0.1", &[]);
    for (uv, &v) in result.corner_uvs.as_ref().unwrap().iter().zip(result.soup.corners()) {
        let p = result.soup.positions()[v as usize];
        // Texture coordinates have 32 bits.
        let off = (DVec2::from(uv.map(f64::from)) - p.truncate()).abs().max_element();
        assert!(off < 6.1e-8, "{uv:?} at {p}");
    }
}

/// Normals have unit length, point outward, and are discontinuous at the creases of a box.
#[test]
fn normals_follow_the_surface_and_keep_creases() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.glb"), folder.path().join("out.glb"));
    // A tube with smooth normals, closed by flat lids.
    let (around, along) = (32, 16);
    let mut model = Model::from(tube(around, along).soup);
    let side_faces = model.soup.face_count();
    let center = model.soup.vertex_count() as u32;
    model.soup.push_vertex([0.0; 3]);
    for i in 0..around {
        model.soup.push_face(&[center, (i + 1) % around, i]).unwrap();
    }
    let corners = model.soup.corners().iter().enumerate();
    let normals = corners.map(|(corner, &v)| {
        let p = model.soup.positions()[v as usize];
        let side = DVec3::new(p.x, p.y, 0.0).normalize_or_zero();
        if corner < 3 * side_faces { side } else { -DVec3::Z }.as_vec3().to_array()
    });
    model.corner_normals = Some(normals.collect());
    mesh_io::write(&input, &model, &WriteOptions::default()).unwrap();
    for more in [&[][..], &["--keep-creases"]] {
        let (result, _) = simplified(&input, &output, "0.25", more);
        let normals = result.corner_normals.as_ref().unwrap();
        let mut flat = 0;
        for (face, normals) in result.soup.faces().zip(normals.as_chunks::<3>().0) {
            let [a, b, c] =
                <[u32; 3]>::try_from(face).unwrap().map(|v| result.soup.positions()[v as usize]);
            let outward = (b - a).cross(c - a).normalize();
            for n in normals.map(|n| DVec3::from(n.map(f64::from))) {
                assert!((n.length() - 1.0).abs() < 1e-6);
                assert!(n.dot(outward) > 0.5, "{n} on a face towards {outward}");
            }
            let is_lid = outward.z < -0.99;
            flat += usize::from(is_lid && normals.iter().all(|n| n[2] < -0.99));
        }
        assert!(flat > 5, "{more:?}: {flat} faces of the lid have its normal");
    }
}

#[test]
fn real_textures_keep_their_charts() {
    let Some(folder) = models() else { return };
    let scratch = tempfile::tempdir().unwrap();
    for (name, more) in
        [("bunny10k_textured.obj", &[][..]), ("cesium_milk_truck.glb", &["--lenient"])]
    {
        let input = folder.join(name);
        let whole = scratch.path().join("whole.obj");
        let [from, to] = [&input, &whole].map(|path| path.to_str().unwrap());
        json(&["convert", from, to, "--lenient"]);
        let before = mesh_io::read(&whole).unwrap();
        let output = scratch.path().join("out.obj");
        let (after, report) = simplified(&input, &output, "0.3", more);
        let (old, new) = (layout(&before), layout(&after));
        println!("{name}: {old:?} {new:?} {:?} {:?}", stretch(&before), stretch(&after));
        assert!(
            report["faces_out"].as_f64().unwrap() <= 0.3 * before.soup.face_count() as f64 + 1.0
        );
        assert_eq!(old.charts, new.charts, "{name}");
        assert!(new.folded <= old.folded, "{name}");
        let (mean_before, mean_after) = (stretch(&before)[1], stretch(&after)[1]);
        // Noise in the distortion of small faces averages out.
        assert!((mean_after / mean_before - 1.0).abs() < 0.1, "{name}");
    }
}
