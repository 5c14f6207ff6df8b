//! Adding and removing faces, and filling holes.
#![allow(clippy::unwrap_used, clippy::panic)]

use mesh_core::SplitMix64;
use mesh_core::edit::{FaceRefusal, RemovalRefusal};
use mesh_core::fill::{FillMethod, FillOptions, FillRefusal, FilledHole};
use mesh_core::glam::DVec3;
use mesh_core::{FaceId, HalfEdgeId, PolygonSoup, Repair, Topology, TriMesh, VertexId, build};
use mesh_shapes::{Sphere, Torus};
use proptest::prelude::*;

fn octahedron() -> TriMesh {
    TriMesh::from_soup(&mesh_shapes::polyhedra::octahedron()).unwrap()
}

fn vertices<const N: usize>(indices: [u32; N]) -> [VertexId; N] {
    indices.map(VertexId::new)
}

/// Removes faces while that is possible, then adds them again; returns how many were added again.
fn take_apart_and_rebuild(topology: &mut Topology, order: &[usize]) -> usize {
    let mut removed = Vec::new();
    for &i in order {
        let face = FaceId::new((i % topology.face_capacity()) as u32);
        if let Ok(removal) = topology.check_remove_face(face) {
            let corners = topology.face_vertices(face);
            let edges = topology.edge_count();
            let done = topology.remove_face(removal);
            assert_eq!(done.face, face);
            assert_eq!(edges - topology.edge_count(), done.removed_edges.iter().flatten().count());
            for vertex in done.isolated.into_iter().flatten() {
                assert!(topology.is_isolated_vertex(vertex));
            }
            topology.validate().unwrap();
            removed.push(corners);
        }
    }
    let count = removed.len();
    for corners in removed.into_iter().rev() {
        let face = topology.check_add_face(corners).unwrap();
        let added = topology.add_face(face);
        assert_eq!(topology.face_vertices(added.face), corners);
        topology.validate().unwrap();
    }
    count
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn what_was_removed_can_be_added_in_reverse(order in prop::collection::vec(any::<usize>(), 1..60)) {
        let torus = TriMesh::from_soup(&Torus { major: 2.0, minor: 1.0 }.mesh(5, 4).unwrap()).unwrap();
        for mesh in [torus, octahedron()] {
            let mut topology = mesh.topology().clone();
            let removed = take_apart_and_rebuild(&mut topology, &order);
            prop_assert!(removed > 0);
            prop_assert_eq!(topology.canonical_triangles(), mesh.topology().canonical_triangles());
        }
    }

    /// Every face that may be added keeps the mesh sound, and every refusal has its reason.
    #[test]
    fn random_faces_are_added_or_refused_rightly(corners in prop::collection::vec([0..8_u32, 0..8, 0..8], 1..60)) {
        let mut topology = Topology::from_triangles(8, &[] as &[[u32; 3]]).unwrap();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for given in corners {
            let with: Vec<[u32; 3]> = triangles.iter().copied().chain([given]).collect();
            let is_pillow = |t: &[u32; 3]| given.iter().all(|v| t.contains(v));
            let possible = Topology::from_triangles(8, &with).is_ok()
                && !triangles.iter().any(is_pillow);
            match topology.check_add_face(vertices(given)) {
                Ok(face) => {
                    topology.add_face(face);
                    topology.validate().unwrap();
                    triangles = with;
                    prop_assert!(possible, "{given:?}");
                }
                Err(refusal) => prop_assert!(!possible, "{given:?}: {refusal}"),
            }
        }
        let built = Topology::from_triangles(8, &triangles).unwrap();
        prop_assert_eq!(topology.canonical_triangles(), built.canonical_triangles());
    }
}

#[test]
fn refusals_name_their_reason() {
    let mut mesh = octahedron();
    let [a, b, c] = mesh.topology().face_vertices(FaceId::new(0));
    let topology = mesh.topology();
    assert!(matches!(topology.check_add_face([a, b, c]), Err(FaceRefusal::SideTaken(_))));
    assert!(
        matches!(topology.check_add_face([a, b, b]), Err(FaceRefusal::RepeatedVertex(v)) if v == b)
    );
    let far = VertexId::new(77);
    assert!(
        matches!(topology.check_add_face([a, far, b]), Err(FaceRefusal::VertexNotInMesh(v)) if v == far)
    );
    let face = FaceId::new(77);
    assert!(
        matches!(topology.check_remove_face(face), Err(RemovalRefusal::NotInMesh(f)) if f == face)
    );
    let new = mesh.add_vertex([2.0_f32, 2.0, 2.0]).unwrap();
    let other = mesh.add_vertex([2, 2, 3]).unwrap();
    let refused = mesh.topology().check_add_face([a, new, other]).unwrap_err();
    assert_eq!(refused, FaceRefusal::InteriorVertex(a));
    assert_eq!(mesh.remove_isolated_vertices(), 2);
    mesh.topology().validate().unwrap();
    assert_eq!(mesh.compact_and_count(), 6);

    let two = TriMesh::from_triangles(&[[0, 0, 0], [1, 0, 0], [0, 1, 0]], &[[0, 1, 2]]).unwrap();
    let pillow = two.topology().check_add_face(vertices([0, 2, 1])).unwrap_err();
    assert_eq!(pillow, FaceRefusal::Pillow(FaceId::new(0)));
    // A fan of three: without the middle one, two faces touch in the hub.
    let fan = Topology::from_triangles(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]).unwrap();
    let pinched = fan.check_remove_face(FaceId::new(1)).unwrap_err();
    assert_eq!(pinched, RemovalRefusal::Pinches(VertexId::new(0)));
}

trait CompactAndCount {
    fn compact_and_count(&mut self) -> usize;
}

impl CompactAndCount for TriMesh {
    fn compact_and_count(&mut self) -> usize {
        self.compact();
        self.topology().validate().unwrap();
        self.positions().len()
    }
}

#[test]
#[should_panic(expected = "another mesh")]
fn faces_checked_on_one_mesh_are_refused_by_another() {
    let (first, mut second) = (octahedron(), octahedron());
    let removal = first.topology().check_remove_face(FaceId::new(0)).unwrap();
    second.remove_face(removal);
}

#[test]
#[should_panic(expected = "another mesh")]
fn flips_checked_on_one_mesh_are_refused_by_another() {
    let (first, mut second) = (octahedron(), octahedron());
    let edge = first.topology().edges().next().unwrap();
    let flip = first.topology().check_flip(edge);
    // An octahedron refuses flips: its vertices have four edges, so use the flip that is legal there.
    let flip = flip.unwrap();
    second.flip(flip);
}

#[test]
fn a_clone_accepts_what_was_checked_on_the_original_until_either_is_edited() {
    let original = octahedron();
    let edge = original.topology().edges().next().unwrap();
    let mut copy = original.clone();
    let flip = original.topology().check_flip(edge).unwrap();
    copy.flip(flip);
    copy.topology().validate().unwrap();
    let stale = original.topology().check_flip(edge).unwrap();
    let mut edited = copy.clone();
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| edited.flip(stale)));
    assert!(result.is_err());
}

/// A sphere without the faces whose centroids satisfy `open`.
fn sphere_with_holes(level: u32, open: impl Fn(DVec3) -> bool) -> TriMesh {
    let soup = Sphere::UNIT.icosphere(level).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let topology = mesh.topology();
    let kept: Vec<[u32; 3]> = topology
        .faces()
        .filter(|&f| !open(mesh.face_centroid(f)))
        .map(|f| topology.face_vertices(f).map(VertexId::get))
        .collect();
    let soup = PolygonSoup::from_triangles(mesh.positions(), &kept).unwrap();
    build(&soup, &Repair::lenient()).unwrap().mesh
}

#[test]
fn holes_of_a_sphere_are_filled_and_the_volume_returns() {
    // Concave, not planar, of different sizes.
    let whole = sphere_with_holes(4, |_| false).volume();
    let wavy = |p: DVec3| p.z > 0.8 + 0.1 * (5.0 * p.y.atan2(p.x)).sin();
    let strip = |p: DVec3| p.z.abs() < 0.1 && p.x > 0.3;
    let cap = |p: DVec3| p.x < -0.9;
    let mut mesh = sphere_with_holes(4, |p| wavy(p) || strip(p) || cap(p));
    assert_eq!(mesh.topology().boundary_loops().len(), 3);
    for optimal_edges in [96, 0] {
        let mut mesh = mesh.clone();
        let report = mesh.fill_holes(&FillOptions { optimal_edges, ..FillOptions::default() });
        assert_eq!((report.filled.len(), report.left.len()), (3, 0));
        let edges: usize = report.filled.iter().map(|hole| hole.edges).sum();
        assert_eq!(report.new_faces(), edges - 2 * 3 + 2 * report.new_vertices());
        mesh.topology().validate().unwrap();
        assert!(mesh.topology().is_closed());
        assert_eq!(mesh.topology().euler_characteristic(), 2);
        let volume = mesh.volume();
        println!("optimal up to {optimal_edges}: {volume} of {whole}");
        assert!(volume > 0.85 * whole && volume < whole);
        if optimal_edges > 0 {
            assert!(report.filled.iter().all(|hole| hole.method == FillMethod::Optimal));
        } else {
            assert!(report.filled.iter().all(|hole| hole.method != FillMethod::Optimal));
        }
        for hole in &report.filled {
            assert!(hole.faces.contains(&mesh.topology().face(hole.half_edge).unwrap()));
        }
    }
    let report = mesh.fill_holes(&FillOptions { max_edges: Some(40), ..FillOptions::default() });
    assert_eq!(report.filled.len() + report.left.len(), 3);
    assert!(!report.left.is_empty());
    let too_long = |left: &(HalfEdgeId, FillRefusal)| {
        matches!(left.1, FillRefusal::TooManyEdges { limit: 40, .. })
    };
    assert!(report.left.iter().all(too_long));
}

#[test]
fn a_flat_concave_hole_is_filled_within_its_outline() {
    // A square frame around an L-shaped hole; the fill has exactly the area of the L.
    let at = |x: u32, y: u32| 7 * y + x;
    let points: Vec<[f64; 3]> =
        (0..49).map(|i| [f64::from(i % 7), f64::from(i / 7), 0.0]).collect();
    let is_open = |x: u32, y: u32| (1..5).contains(&x) && (1..5).contains(&y) && (x < 2 || y < 2);
    let cells = (0..36).map(|i| (i % 6, i / 6)).filter(|&(x, y)| !is_open(x, y));
    let faces: Vec<[u32; 3]> = cells
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    for optimal_edges in [96, 0] {
        let mut mesh = TriMesh::from_triangles(&points, &faces).unwrap();
        let hole = mesh.topology().boundaries().find(|l| l.clone().count() == 16).unwrap();
        let start = hole.clone().next().unwrap();
        let options = FillOptions { optimal_edges, ..FillOptions::default() };
        let filled = mesh.fill_hole(start, &options).unwrap();
        mesh.topology().validate().unwrap();
        let areas: f64 = filled.faces.iter().map(|&f| mesh.face_area(f)).sum();
        assert!((areas - 7.0).abs() < 1e-12, "{areas} {:?}", filled.method);
        assert!(filled.faces.iter().all(|&f| mesh.face_cross(f).z > 0.0));
    }
}

#[test]
fn holes_whose_diagonals_exist_get_a_new_vertex() {
    // The outline of two triangles: one diagonal exists, the other closes a tetrahedron.
    let square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]];
    let mut mesh = TriMesh::from_triangles(&square, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let report = mesh.fill_holes(&FillOptions::default());
    assert_eq!((report.new_faces(), report.new_vertices()), (2, 0));
    assert!(mesh.topology().is_closed());
    mesh.topology().validate().unwrap();
    // The torus of seven vertices, each joined to all others, without the star of one of them.
    let faces = (0..7).flat_map(|i| [[i, (i + 1) % 7, (i + 3) % 7], [i, (i + 3) % 7, (i + 2) % 7]]);
    let faces: Vec<[u32; 3]> = faces.filter(|face| !face.contains(&0)).collect();
    let points: Vec<[u32; 3]> = (0..7).map(|i| [i, i * i, i * i * i]).collect();
    let mut mesh = TriMesh::from_triangles(&points, &faces).unwrap();
    let report = mesh.fill_holes(&FillOptions::default());
    assert_eq!((report.new_faces(), report.new_vertices()), (6, 1));
    mesh.topology().validate().unwrap();
    assert_eq!((mesh.topology().is_closed(), mesh.topology().genus()), (true, 1));
}

#[test]
fn single_faces_and_wrong_half_edges_are_refused() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut mesh = TriMesh::from_triangles(&points, &[[0, 1, 2]]).unwrap();
    let hole = mesh.topology().boundary_loops()[0];
    let options = FillOptions::default();
    assert_eq!(mesh.fill_hole(hole, &options), Err(FillRefusal::Pillow(FaceId::new(0))));
    assert_eq!(mesh.fill_hole(hole.twin(), &options), Err(FillRefusal::NotAHole(hole.twin())));
    let far = HalfEdgeId::new(99);
    assert_eq!(mesh.fill_hole(far, &options), Err(FillRefusal::NotInMesh(far)));
    assert_eq!(mesh.topology().face_count(), 1);
}

#[test]
fn holes_without_room_for_faces_stay_open() {
    // A tetrahedron of which one side of an edge has a vertex more: the hole is a slit without area.
    let points = [[0, 0, 0], [2, 0, 0], [1, 2, 0], [1, 1, 2], [1, 0, 0]];
    let slit = [[0, 2, 1], [1, 2, 3], [2, 0, 3], [0, 4, 3], [4, 1, 3]];
    for optimal_edges in [96, 0] {
        let whole = |[x, y, z]: [i32; 3]| DVec3::new(x.into(), y.into(), z.into());
        let mut mesh = TriMesh::from_triangles(&points.map(whole), &slit).unwrap();
        let before = mesh.topology().face_count();
        let report = mesh.fill_holes(&FillOptions { optimal_edges, ..FillOptions::default() });
        assert!(report.filled.is_empty(), "{report:?}");
        assert!(matches!(report.left[..], [(_, FillRefusal::NoArea)]), "{report:?}");
        assert_eq!(mesh.topology().face_count(), before);
        // With some room, it is filled.
        let mut open = points;
        open[4] = [1, 1, 1];
        let mut mesh = TriMesh::from_triangles(&open.map(whole), &slit).unwrap();
        assert_eq!(mesh.fill_holes(&FillOptions::default()).new_faces(), 1);
        assert!(mesh.topology().is_closed());
    }
}

#[test]
fn any_surface_with_holes_can_be_filled() {
    // Random faces are taken from random triangulations; all methods must leave sound meshes.
    let mut random = SplitMix64::new(5);
    let mut methods = [0_usize; 4];
    for round in 0..60 {
        let level = 1 + round % 3;
        let share = 0.1 + 0.6 * random.uniform();
        let picks: Vec<bool> = (0..2000).map(|_| random.uniform() < share).collect();
        let soup = Sphere::UNIT.icosphere(level).unwrap();
        let kept: Vec<[u32; 3]> = soup
            .faces()
            .enumerate()
            .filter(|(i, _)| !picks[*i])
            .map(|(_, f)| [f[0], f[1], f[2]])
            .collect();
        let soup = PolygonSoup::from_triangles(soup.positions(), &kept).unwrap();
        let mut mesh = build(&soup, &Repair::lenient()).unwrap().mesh;
        // Positions that make loops cross themselves in every view.
        if round % 2 == 0 {
            for p in mesh.positions_mut() {
                *p = DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
            }
        }
        let optimal_edges = if round % 4 < 2 { 96 } else { 0 };
        let report = mesh.fill_holes(&FillOptions { optimal_edges, ..FillOptions::default() });
        mesh.topology().validate().unwrap();
        assert_eq!(mesh.positions().len(), mesh.topology().vertex_capacity());
        assert!(mesh.positions().iter().all(|p| p.is_finite()));
        let doubles =
            |left: &FillRefusal| matches!(left, FillRefusal::Pillow(_) | FillRefusal::Duplicate(_));
        assert!(report.left.iter().all(|left| doubles(&left.1)), "{:?}", report.left);
        assert_eq!(mesh.topology().boundary_loops().len(), report.left.len());
        for hole in report.filled {
            methods[hole.method as usize] += 1;
            methods[3] += usize::from(hole.new_vertex.is_some());
        }
    }
    println!("optimal, polygon, shortest edge, with a new vertex: {methods:?}");
    assert!(methods[..3].iter().all(|&count| count > 0), "{methods:?}");
}

/// The corners of the unit cube at a corner, as pairs of triangles.
fn cube_at(corner: [u32; 3]) -> impl Iterator<Item = [[u32; 3]; 3]> {
    let side = move |axis: usize, far: u32| {
        let at = |u: u32, v: u32| {
            let mut p = corner;
            p[axis] += far;
            p[(axis + 1) % 3] += u;
            p[(axis + 2) % 3] += v;
            p
        };
        let quad = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        let [a, b, c, d] = if far == 1 { quad } else { [quad[0], quad[3], quad[2], quad[1]] };
        [[a, b, c], [a, c, d]]
    };
    (0..3).flat_map(move |axis| [side(axis, 0), side(axis, 1)].concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Cubes that touch at walls, edges and corners are cut there. No face of a filled hole is where another face is,
    /// and no edge of it is where another edge is. Loops that touch themselves are the exception.
    #[test]
    fn filling_doubles_nothing_where_parts_touch(
        cells in proptest::collection::vec([0_u32..2, 0_u32..2, 0_u32..2], 1..4),
        dropped in proptest::collection::vec(0_usize..1000, 1..5),
        optimal_edges in prop_oneof![Just(0), Just(64)],
    ) {
        let mut triangles: Vec<[[u32; 3]; 3]> = cells.into_iter().flat_map(cube_at).collect();
        for i in dropped {
            triangles.swap_remove(i % triangles.len());
        }
        let index = |p: [u32; 3]| p[0] + 3 * p[1] + 9 * p[2];
        let points: Vec<[f64; 3]> =
            (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(f64::from)).collect();
        let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(index)).collect();
        let soup = PolygonSoup::from_triangles(&points, &faces).unwrap();
        let mut mesh = build(&soup, &Repair::lenient()).unwrap().mesh;
        let key = |v: VertexId, mesh: &TriMesh| mesh.position(v).to_array().map(f64::to_bits);
        let places = |mesh: &TriMesh, faces: &[FaceId]| {
            let mut all: Vec<_> = faces
                .iter()
                .map(|&f| mesh.topology().face_vertices(f).map(|v| key(v, mesh)))
                .map(|mut corners| { corners.sort_unstable(); corners })
                .collect();
            all.sort_unstable();
            all
        };
        let before = places(&mesh, &mesh.topology().faces().collect::<Vec<_>>());
        let sides = |corners: &[[u64; 3]; 3]| {
            let [a, b, c] = *corners;
            [[a, b], [a, c], [b, c]]
        };
        let rims: Vec<[[u64; 3]; 2]> = before.iter().flat_map(sides).collect();
        let report = mesh.fill_holes(&FillOptions { optimal_edges, ..FillOptions::default() });
        mesh.topology().validate().unwrap();
        let is_simple = |hole: &&FilledHole| {
            let topology = mesh.topology();
            let sides = hole.faces.iter().flat_map(|&f| topology.face_half_edges(f));
            let is_rim = |h: &HalfEdgeId| {
                topology.face(h.twin()).is_none_or(|other| !hole.faces.contains(&other))
            };
            let mut keys: Vec<_> =
                sides.filter(is_rim).map(|h| key(topology.origin(h), &mesh)).collect();
            keys.sort_unstable();
            keys.windows(2).all(|pair| pair[0] != pair[1])
        };
        let simple: Vec<&FilledHole> = report.filled.iter().filter(is_simple).collect();
        let new: Vec<FaceId> = simple.iter().flat_map(|hole| hole.faces.clone()).collect();
        let new = places(&mesh, &new);
        for (i, corners) in new.iter().enumerate() {
            prop_assert!(!before.contains(corners) && !new[i + 1..].contains(corners), "{corners:?}");
        }
        for hole in simple {
            let inner = hole.faces.iter().flat_map(|&f| mesh.topology().face_half_edges(f));
            let inner = inner.filter(|h| {
                mesh.topology().face(h.twin()).is_some_and(|other| hole.faces.contains(&other))
            });
            for h in inner {
                let mut ends = [h, h.twin()].map(|h| key(mesh.topology().origin(h), &mesh));
                ends.sort_unstable();
                prop_assert!(!rims.contains(&ends), "{ends:?}");
            }
        }
    }
}

/// A closed surface without the faces at some places of its list, leaving out those that share an edge with an earlier
/// one. Also the number of faces that are missing.
fn with_single_faces_missing(soup: &PolygonSoup, places: &[usize]) -> (PolygonSoup, usize) {
    let whole = TriMesh::from_soup(soup).unwrap();
    let topology = whole.topology();
    let mut is_missing = vec![false; topology.face_count()];
    for place in places {
        let face = FaceId::new((place % topology.face_count()) as u32);
        let beside = topology.face_neighbours(face);
        is_missing[face.index()] |= !beside.into_iter().flatten().any(|f| is_missing[f.index()]);
    }
    let kept: Vec<[u32; 3]> =
        topology.triangles().zip(&is_missing).filter(|(_, gone)| !*gone).map(|(t, _)| t).collect();
    let missing = is_missing.iter().filter(|gone| **gone).count();
    (PolygonSoup::from_triangles(soup.positions(), &kept).unwrap(), missing)
}

/// The faces as positions, in an order that does not depend on their numbers.
fn faces_by_position(mesh: &TriMesh) -> Vec<[[u64; 3]; 3]> {
    let key = |v: VertexId| mesh.position(v).to_array().map(f64::to_bits);
    let mut faces: Vec<_> = mesh
        .topology()
        .faces()
        .map(|f| {
            let mut corners = mesh.topology().face_vertices(f).map(key);
            let first = (0..3).min_by_key(|&i| corners[i]).unwrap();
            corners.rotate_left(first);
            corners
        })
        .collect();
    faces.sort_unstable();
    faces
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Missing faces that share vertices, but no edges, come back as they were.
    #[test]
    fn holes_that_meet_in_vertices_are_filled_each_by_itself(
        shape in 0_usize..4,
        places in proptest::collection::vec(0_usize..10_000, 1..24),
    ) {
        let soup = match shape {
            0 => mesh_shapes::polyhedra::octahedron(),
            1 => Sphere::UNIT.icosphere(1).unwrap(),
            2 => Torus { major: 2.0, minor: 1.0 }.mesh(8, 6).unwrap(),
            _ => Sphere::UNIT.icosphere(2).unwrap(),
        };
        let whole = faces_by_position(&TriMesh::from_soup(&soup).unwrap());
        let (holed, missing) = with_single_faces_missing(&soup, &places);
        let mut mesh = build(&holed, &Repair::lenient()).unwrap().mesh;
        let report = mesh.fill_holes(&FillOptions::default());
        mesh.topology().validate().unwrap();
        prop_assert_eq!(report.filled.len(), missing);
        prop_assert!(mesh.topology().is_closed());
        prop_assert_eq!(faces_by_position(&mesh), whole);
    }
}

#[test]
fn a_hole_of_many_edges_takes_no_quadratic_time() {
    // A cone without its base, of 300,000 faces.
    let n = 300_000_u32;
    let rim = (0..n).map(|i| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        [angle.cos(), angle.sin(), 0.3 * (7.0 * angle).sin()]
    });
    let points: Vec<[f64; 3]> = rim.chain([[0.0, 0.0, 1.0]]).collect();
    let faces: Vec<[u32; 3]> = (0..n).map(|i| [i, (i + 1) % n, n]).collect();
    let mut mesh = TriMesh::from_triangles(&points, &faces).unwrap();
    let report = mesh.fill_holes(&FillOptions::default());
    assert_eq!(report.new_faces(), n as usize - 2);
    assert!(mesh.topology().is_closed());
}
