//! Which components are inside out, and the repair: nested shells, reversed faces, open surfaces.
#![allow(clippy::unwrap_used)]

use glam::{DQuat, DVec3};
use mesh_core::measure::Facing;
use mesh_core::{FaceId, PolygonSoup, Repair, SplitMix64, TriMesh, build, diagnose, glam};
use mesh_shapes::{Cylinder, Plane, RowPhase, Sphere, Torus, Wave, polyhedra};
use proptest::prelude::*;

/// Adds a shape, scaled and moved.
fn add(soup: &mut PolygonSoup, shape: &PolygonSoup, size: f64, center: DVec3) {
    let first = soup.vertex_count() as u32;
    shape.positions().iter().for_each(|&p| soup.push_vertex(center + size * p));
    for face in shape.faces() {
        soup.push_face(&face.iter().map(|&v| v + first).collect::<Vec<_>>()).unwrap();
    }
}

/// The soup with some of its faces reversed.
fn reversed(soup: &PolygonSoup, is_reversed: impl Fn(usize) -> bool) -> PolygonSoup {
    let mut result = PolygonSoup::new();
    soup.positions().iter().for_each(|&p| result.push_vertex(p));
    for (index, face) in soup.faces().enumerate() {
        let mut face = face.to_vec();
        if is_reversed(index) {
            face.reverse();
        }
        result.push_face(&face).unwrap();
    }
    result
}

fn reorient() -> Repair {
    let mut repair = Repair::strict();
    repair.reorient = true;
    repair
}

/// Signed volumes of the components, in the order of their smallest vertex.
fn volumes(mesh: &TriMesh) -> Vec<f64> {
    mesh.split_components().unwrap().iter().map(|part| part.mesh.volume()).collect()
}

fn sphere() -> PolygonSoup {
    Sphere { radius: 1.0 }.icosphere(1).unwrap()
}

#[test]
fn a_closed_mesh_faces_outward_whatever_share_of_its_faces_is_reversed() {
    let torus = Torus { major: 2.0, minor: 0.5 }.mesh(24, 12).unwrap();
    let volume = TriMesh::from_soup(&torus).unwrap().volume();
    let faces = torus.face_count();
    for share in [0.0, 0.3, 0.7, 1.0] {
        let mut random = SplitMix64::new(7);
        let is_reversed: Vec<bool> = (0..faces).map(|_| random.uniform() < share).collect();
        let given = reversed(&torus, |face| is_reversed[face]);
        let built = build(&given, &reorient()).unwrap();
        assert!((built.mesh.volume() - volume).abs() < 1e-12 * volume);
        let count = is_reversed.iter().filter(|&&reversed| reversed).count();
        assert_eq!(built.report.flipped_faces.count(), count);
        assert_eq!(built.report.turned_components.count(), usize::from(2 * count > faces));
        assert_eq!(diagnose(&given).unwrap().inside_out, Some(usize::from(2 * count > faces)));
        assert_eq!(built.mesh.facings().of_component, [Facing::Outward]);
    }
}

#[test]
fn an_inward_mesh_is_told_and_stays_without_the_repair() {
    let inward = reversed(&polyhedra::cube(), |_| true);
    let built = build(&inward, &Repair::strict()).unwrap();
    assert!(built.report.is_unchanged() && built.mesh.volume() < 0.0);
    assert_eq!(built.mesh.facings().count(Facing::InsideOut), 1);
    assert_eq!(diagnose(&inward).unwrap().inside_out, Some(1));
    let built = build(&inward, &Repair::lenient()).unwrap();
    assert_eq!(built.mesh.volume(), 8.0);
    assert_eq!(built.report.flipped_faces.count(), 12);
    assert!(!built.report.is_unchanged());
}

#[test]
fn cavities_touching_the_shell_stay_cavities() {
    // A cube in a corner of a cube: it touches three walls, and half of its vertices lie on them.
    let mut soup = polyhedra::cube();
    add(&mut soup, &reversed(&polyhedra::cube(), |_| true), 0.5, DVec3::splat(0.5));
    assert_eq!(diagnose(&soup).unwrap().inside_out, Some(0));
    // Beside the first one, touching it from outside.
    add(&mut soup, &polyhedra::cube(), 0.5, DVec3::new(1.5, 0.5, 0.0));
    let built = build(&soup, &reorient()).unwrap();
    assert!(built.report.is_unchanged());
    assert_eq!(volumes(&built.mesh), [8.0, -1.0, 1.0]);
}

#[test]
fn components_that_cross_are_not_nested() {
    let mut soup = polyhedra::cube();
    add(&mut soup, &polyhedra::cube(), 0.5, DVec3::new(0.9, 0.0, 0.0));
    let built = build(&soup, &reorient()).unwrap();
    assert_eq!(volumes(&built.mesh), [8.0, 1.0]);
}

#[test]
fn open_surfaces_show_their_larger_visible_side() {
    let tube = Cylinder { radius: 1.0, height: 4.0 }.mesh(16, 24, RowPhase::Aligned).unwrap();
    // A sphere with a hole, and a bowl of a third of a sphere.
    let sphere = Sphere { radius: 1.0 }.uv_mesh(12, 24).unwrap();
    let keep = |from: f64| {
        let mut soup = PolygonSoup::new();
        sphere.positions().iter().for_each(|&p| soup.push_vertex(p));
        for face in sphere.faces() {
            if face.iter().all(|&v| sphere.positions()[v as usize].z >= from) {
                soup.push_face(face).unwrap();
            }
        }
        soup
    };
    for (soup, name) in [(tube, "tube"), (keep(-0.95), "hole"), (keep(0.3), "bowl")] {
        for (given, wrong) in [(soup.clone(), 0), (reversed(&soup, |_| true), 1)] {
            let built = build(&given, &Repair::lenient()).unwrap();
            assert_eq!(built.report.turned_components.count(), wrong, "{name}");
            assert_eq!(built.mesh.facings().of_component, [Facing::Outward], "{name}");
            assert_eq!(diagnose(&given).unwrap().inside_out, Some(wrong), "{name}");
        }
    }
}

#[test]
fn sheets_and_what_is_hidden_are_left_alone() {
    let flat = Plane { half_width: 1.0 }.mesh(8, Default::default()).unwrap();
    let wave = Wave { amplitude: 0.1, wavelength: 1.0, half_width: 2.0 };
    let wave = wave.mesh(32, Default::default()).unwrap();
    let mut hidden = polyhedra::cube();
    add(&mut hidden, &flat, 0.5, DVec3::ZERO);
    for soup in [flat, wave, hidden] {
        for given in [soup.clone(), reversed(&soup, |face| face >= soup.face_count() - 64)] {
            let built = build(&given, &reorient()).unwrap();
            assert_eq!(built.report.turned_components.count(), 0);
            assert_eq!(built.report.undecided_components, 1);
        }
    }
    // Two faces back to back enclose nothing.
    let pillow = TriMesh::from_triangles(
        &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        &[[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]],
    );
    assert_eq!(pillow.unwrap().facings().of_component, [Facing::Undecided]);
}

/// Houses without floors stand on terrain: they hide a part of its upper side, which stays the upper side. With a panel in
/// front of a box, the side without the box is the front.
#[test]
fn terrain_under_houses_is_not_turned() {
    let wave = Wave { amplitude: 0.1, wavelength: 1.0, half_width: 2.0 };
    let terrain = wave.mesh(32, Default::default()).unwrap();
    let mut town = terrain.clone();
    let cube = polyhedra::cube();
    let mut walls = PolygonSoup::new();
    cube.positions().iter().for_each(|&p| walls.push_vertex(p));
    let is_floor = |face: &[u32]| face.iter().all(|&v| cube.positions()[v as usize].z < 0.0);
    cube.faces().filter(|face| !is_floor(face)).for_each(|face| walls.push_face(face).unwrap());
    for (x, y) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))) {
        add(&mut town, &walls, 0.25, DVec3::new(1.3 * f64::from(x), 1.3 * f64::from(y), 0.15));
    }
    let built = build(&town, &Repair::lenient()).unwrap();
    assert_eq!(built.report.turned_components.count(), 0);
    let first = built.provenance.face_source.iter().position(|&face| face == 0).unwrap();
    assert_eq!(built.mesh.face_normal(FaceId::new(first as u32)).z.signum(), up(&terrain));
    // Alone it is a sheet, and the houses face outward.
    assert_eq!(built.mesh.facings().count(Facing::Undecided), 1);
    assert_eq!(built.mesh.facings().count(Facing::Outward), 9);
    let flat = Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap();
    let turned = [flat.clone(), reversed(&flat, |_| true)].map(|panel| {
        let mut soup = panel;
        add(&mut soup, &polyhedra::cube(), 0.9, DVec3::new(0.0, 0.0, 1.0));
        build(&soup, &reorient()).unwrap().report.turned_components.count()
    });
    assert_eq!(turned.iter().sum::<usize>(), 1);
}

/// The sign of the height of the normal of the first face.
fn up(soup: &PolygonSoup) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|k| soup.positions()[soup.face(0)[k] as usize]);
    (b - a).cross(c - a).z.signum()
}

/// Many parts in a row, and shells in shells, take n log n and not n^2.
/// The pages of a book: half-planes around an axis, whose boxes overlap.
#[test]
fn among_too_many_overlapping_faces_nothing_is_decided() {
    let facings = |pages: u32| {
        let mut soup = PolygonSoup::new();
        for page in 0..pages {
            let (y, x) = (core::f64::consts::PI * f64::from(page) / f64::from(pages)).sin_cos();
            let first = 3 * page;
            for p in [DVec3::ZERO, DVec3::Z, DVec3::new(x, y, 0.5)] {
                soup.push_vertex(p);
            }
            soup.push_face(&[first, first + 1, first + 2]).unwrap();
        }
        build(&soup, &Repair::strict()).unwrap().mesh.facings()
    };
    // The first page shows its back.
    assert_eq!(facings(30).of_component[0], Facing::InsideOut);
    assert_eq!(facings(4000).count(Facing::Undecided), 4000);
}

#[test]
fn many_components_are_decided() {
    let mut soup = PolygonSoup::new();
    for i in 0..3000 {
        let center = DVec3::new(0.0, 0.0, 3.0 * f64::from(i));
        add(&mut soup, &polyhedra::cube(), 1.0, center);
        add(&mut soup, &polyhedra::tetrahedron(), 0.3, center);
    }
    let built = build(&soup, &reorient()).unwrap();
    assert_eq!(built.report.turned_components.count(), 3000);
    assert!(volumes(&built.mesh).chunks(2).all(|pair| pair[0] > 0.0 && pair[1] < 0.0));
}

/// A tree of nested shells: per shell its depth. Children lie in disjoint balls inside the ball of their parent.
fn nest(
    soup: &mut PolygonSoup,
    random: &mut SplitMix64,
    center: DVec3,
    size: f64,
    depth: u32,
) -> Vec<u32> {
    let shape = match random.bits() % 3 {
        0 => sphere(),
        1 => polyhedra::cube(),
        _ => polyhedra::octahedron(),
    };
    // The ball inside the shape has at least a third of the radius of the ball around it.
    let radius = shape.positions().iter().map(|p| p.length()).fold(0.0, f64::max);
    let turn = DQuat::from_rotation_x(random.uniform()) * DQuat::from_rotation_z(random.uniform());
    let mut turned = shape.clone();
    turned.positions_mut().iter_mut().for_each(|p| *p = turn * *p);
    add(soup, &turned, size / radius, center);
    let mut depths = vec![depth];
    if depth < 4 {
        let inner = size / 2.0;
        for i in 0..random.bits() % 3 {
            let side = if i == 0 { DVec3::X } else { -DVec3::X };
            let center = center + turn * side * (0.5 * inner);
            depths.extend(nest(soup, random, center, 0.45 * inner, depth + 1));
        }
    }
    depths
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The depth decides for any reversed faces, position and size of the model.
    #[test]
    fn nested_shells_alternate(seed: u64, place in 0..4_usize, share in 0.0..1.0_f64) {
        let mut random = SplitMix64::new(seed);
        let mut soup = PolygonSoup::new();
        let mut depths = Vec::new();
        for root in 0..3 {
            let center = DVec3::new(2.5 * f64::from(root), 0.0, 0.0);
            depths.extend(nest(&mut soup, &mut random, center, 1.0, 0));
        }
        let (scale, shift) = [(1.0, 0.0), (1.0, 1e6), (1e80, 0.0), (1e-60, 1e-60)][place];
        soup.positions_mut().iter_mut().for_each(|p| *p = *p * scale + DVec3::splat(shift));
        let draws: Vec<bool> = (0..soup.face_count()).map(|_| random.uniform() < share).collect();
        let given = reversed(&soup, |face| draws[face]);
        let built = build(&given, &reorient()).unwrap();
        let parts = built.mesh.split_components().unwrap();
        prop_assert_eq!(parts.len(), depths.len());
        for (part, depth) in parts.iter().zip(&depths) {
            let outward = part.mesh.topology().faces().map(|f| {
                let [a, b, c] = part.mesh.triangle(f).map(|p| (p - part.mesh.position(
                    part.mesh.topology().vertices().next().unwrap())) / scale);
                a.dot(b.cross(c))
            });
            prop_assert_eq!(outward.sum::<f64>() > 0.0, depth % 2 == 0);
        }
        let again = built.mesh.facings();
        prop_assert_eq!(again.count(Facing::Outward), depths.len());
        prop_assert!(build(&built.mesh.to_soup(), &reorient()).unwrap().report.is_unchanged());
    }
}
