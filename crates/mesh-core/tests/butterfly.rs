//! The one-to-four split and the butterfly rules: orders, invariances, small and irregular meshes.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use core::ops::{Add, Mul};
use core::sync::atomic::{AtomicUsize, Ordering};

use glam::{DAffine3, DVec2, DVec3};
use mesh_core::butterfly::{Butterfly, ButterflyError, ButterflyOptions, IrregularRule, subdivide};
use mesh_core::subdivide_1_to_4::{EdgeOrigin, VertexOrigin};
use mesh_core::{EdgeId, PolygonSoup, Topology, TriMesh, VertexId};
use mesh_shapes::*;

const ZORIN: ButterflyOptions =
    ButterflyOptions { tension: 1.0 / 16.0, irregular: IrregularRule::Zorin };
const EIGHT_POINT: ButterflyOptions =
    ButterflyOptions { tension: 1.0 / 16.0, irregular: IrregularRule::EightPoint };

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

fn edge(topology: &Topology, a: u32, b: u32) -> EdgeId {
    topology.find_half_edge(VertexId::new(a), VertexId::new(b)).unwrap().edge()
}

/// All weights of an edge, per vertex.
fn summed_weights(topology: &Topology, edge: EdgeId, options: &ButterflyOptions) -> Vec<f64> {
    let mut weights = vec![0.0; topology.vertex_capacity()];
    options.weights(topology, edge, |v, weight| weights[v.index()] += weight);
    weights
}

fn samples() -> Vec<TriMesh> {
    let irregular = Irregular::default();
    vec![
        mesh(&polyhedra::tetrahedron()),
        mesh(&polyhedra::octahedron()),
        mesh(&polyhedra::cube()),
        mesh(&inset_cube(0.3).unwrap()),
        mesh(&seven_points::given()),
        mesh(&Sphere::UNIT.uv_mesh(6, 20).unwrap()),
        mesh(&Torus { major: 5.0, minor: 2.0 }.irregular_mesh(9, 7, irregular).unwrap()),
        mesh(&Cylinder { radius: 1.0, height: 1.0 }.mesh(1, 3, RowPhase::Aligned).unwrap()),
        mesh(&Saddle { coefficient: 0.5, half_width: 1.0 }.irregular_mesh(5, irregular).unwrap()),
        mesh(&Plane { half_width: 1.0 }.mesh(1, Diagonals::Uniform).unwrap()),
        TriMesh::from_triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]).unwrap(),
    ]
}

#[test]
fn a_split_keeps_the_surface_and_knows_where_everything_came_from() {
    for coarse in samples() {
        let before = coarse.topology();
        let (after, origin) = before.subdivide_1_to_4().unwrap();
        after.validate().unwrap();
        assert_eq!(after.vertex_count(), before.vertex_count() + before.edge_count());
        assert_eq!(after.edge_count(), 2 * before.edge_count() + 3 * before.face_count());
        assert_eq!(after.face_count(), 4 * before.face_count());
        assert_eq!(after.euler_characteristic(), before.euler_characteristic());
        assert_eq!(after.boundary_loops().len(), before.boundary_loops().len());
        for edge in before.edges() {
            let middle = origin.midpoint(edge);
            assert_eq!(origin.vertex_origin(middle), VertexOrigin::Edge(edge));
            for (half, end) in origin.halves(edge).into_iter().zip(before.edge_vertices(edge)) {
                assert_eq!(origin.edge_origin(half), EdgeOrigin::Edge(edge));
                let ends = after.edge_vertices(half);
                assert!(ends.contains(&end) && ends.contains(&middle));
            }
        }
        for face in before.faces() {
            let corners = before.face_vertices(face);
            let middles = before.face_half_edges(face).map(|h| origin.midpoint(h.edge()));
            let [at_a, at_b, at_c, center] = origin.quarters(face);
            assert_eq!(after.face_vertices(center), middles);
            assert_eq!(after.face_vertices(at_a), [corners[0], middles[0], middles[2]]);
            assert_eq!(after.face_vertices(at_b), [corners[1], middles[1], middles[0]]);
            assert_eq!(after.face_vertices(at_c), [corners[2], middles[2], middles[1]]);
            for h in after.face_half_edges(center) {
                assert_eq!(origin.edge_origin(h.edge()), EdgeOrigin::Face(face));
            }
            assert!(origin.quarters(face).iter().all(|&f| origin.parent_face(f) == face));
        }
    }
}

#[test]
fn removed_elements_leave_removed_children() {
    let mut coarse = mesh(&Torus { major: 5.0, minor: 2.0 }.mesh(9, 7).unwrap());
    for e in [3, 40, 90, 120] {
        let h = EdgeId::new(e).half_edge();
        if let Ok(collapse) = coarse.topology().check_collapse(h) {
            let at = coarse.position(collapse.kept());
            coarse.collapse(collapse, at);
        }
    }
    assert!(!coarse.topology().is_compact());
    let fine = subdivide(&coarse, 2, &ZORIN).unwrap().mesh;
    fine.topology().validate().unwrap();
    assert_eq!(fine.topology().face_count(), 16 * coarse.topology().face_count());
    assert_eq!(fine.topology().euler_characteristic(), 0);

    coarse.compact();
    let mut compacted = fine;
    compacted.compact();
    let expected = subdivide(&coarse, 2, &ZORIN).unwrap().mesh;
    assert_eq!(compacted.topology().vertex_count(), expected.topology().vertex_count());
    assert!((compacted.area() - expected.area()).abs() < 1e-9 * expected.area());
}

/// On a regular grid, away from its border, the mask is exact for cubics with w = 1/16, not for higher degrees, and for
/// linear functions with any w.
#[test]
fn the_mask_reproduces_cubics_on_a_regular_grid() {
    let grid = mesh(&Plane { half_width: 4.0 }.mesh(8, Diagonals::Uniform).unwrap());
    let topology = grid.topology();
    // Largest error over all monomials x^i y^j of a degree and over all inner edges.
    let error = |degree: i32, tension: f64| {
        let options = ButterflyOptions { tension, ..EIGHT_POINT };
        let inner = |e: &EdgeId| {
            let ends = topology.edge_vertices(*e).map(|v| grid.position(v));
            ends.iter().all(|p| p.x.abs() < 3.0 && p.y.abs() < 3.0)
        };
        let mut worst = 0.0_f64;
        for i in 0..=degree {
            let f = |p: DVec3| p.x.powi(i) * p.y.powi(degree - i);
            let values: Vec<f64> = grid.positions().iter().map(|&p| f(p)).collect();
            for e in topology.edges().filter(inner) {
                let [a, b] = topology.edge_vertices(e).map(|v| grid.position(v));
                let exact = f(0.5 * (a + b));
                worst = worst.max((options.interpolate(topology, e, &values) - exact).abs());
            }
        }
        worst
    };
    for degree in 0..=3 {
        assert!(error(degree, 1.0 / 16.0) < 1e-13, "degree {degree}");
    }
    assert!(error(4, 1.0 / 16.0) > 0.1);
    for tension in [0.0, 0.05, 0.1] {
        assert!(error(1, tension) < 1e-13);
        assert!(error(2, tension) > 1e-2);
    }
}

/// Reflected wings and the four-point rule are exact for linear functions up to the border, the
/// latter for cubics along it.
#[test]
fn the_border_of_a_regular_grid_reproduces_linear_functions() {
    let grid = mesh(&Plane { half_width: 3.0 }.mesh(6, Diagonals::Uniform).unwrap());
    let topology = grid.topology();
    let at_corner = |e: EdgeId| {
        let corner = |p: DVec3| p.x.abs() == 3.0 && p.y.abs() == 3.0;
        topology.edge_vertices(e).iter().any(|&v| corner(grid.position(v)))
    };
    for e in topology.edges() {
        let [a, b] = topology.edge_vertices(e).map(|v| grid.position(v));
        let middle = 0.5 * (a + b);
        if !(topology.is_boundary_edge(e) && at_corner(e)) {
            let point = EIGHT_POINT.interpolate(topology, e, grid.positions());
            assert!((point - middle).length() < 1e-15, "{middle}");
        }
        if topology.is_boundary_edge(e) && !at_corner(e) {
            let cubes: Vec<f64> = grid.positions().iter().map(|p| (p.x + p.y).powi(3)).collect();
            let value = EIGHT_POINT.interpolate(topology, e, &cubes);
            assert!((value - (middle.x + middle.y).powi(3)).abs() < 1e-13);
        }
    }
}

#[test]
fn a_missing_wing_is_the_reflected_point() {
    // a = 0, b = 1 and apexes 2, 3; the only wing is 4 across (1, 2).
    let topology = Topology::from_triangles(5, &[[0, 1, 2], [1, 0, 3], [2, 1, 4]]).unwrap();
    let e = edge(&topology, 0, 1);
    let butterfly = Butterfly::around(&topology, e).unwrap();
    assert_eq!(butterfly.ends.map(VertexId::get), [0, 1]);
    assert_eq!(butterfly.apexes.map(VertexId::get), [2, 3]);
    assert_eq!(butterfly.wings, [Some(VertexId::new(4)), None, None, None]);
    assert!(Butterfly::around(&topology, edge(&topology, 1, 4)).is_none());

    let (a, b, c, d) = (DVec2::ZERO, DVec2::X, DVec2::new(0.3, 0.8), DVec2::new(0.6, -1.1));
    let e_wing = DVec2::new(1.4, 0.9);
    let [f, g, h] = [c + a - b, d + b - a, a + d - b];
    let expected = (a + b) / 2.0 + (c + d) / 8.0 - (e_wing + f + g + h) / 16.0;
    let point = EIGHT_POINT.interpolate(&topology, e, &[a, b, c, d, e_wing]);
    assert!((point - expected).length() < 1e-15);
}

#[test]
fn weights_sum_to_one_and_have_the_published_values() {
    for sample in samples() {
        for options in [ZORIN, EIGHT_POINT, ButterflyOptions { tension: 0.03, ..ZORIN }] {
            for e in sample.topology().edges() {
                let sum: f64 = summed_weights(sample.topology(), e, &options).iter().sum();
                assert!((sum - 1.0).abs() < 1e-14);
            }
        }
    }
    // A wheel in a second ring: the hub has the valence asked for, its neighbours have six.
    for k in [3_u32, 4, 5, 7, 12] {
        let wheel = wheel(k);
        let weights = summed_weights(&wheel, edge(&wheel, 0, 1), &ZORIN);
        assert_eq!(weights[0], 0.75);
        for j in 0..k {
            let angle = std::f64::consts::TAU * f64::from(j) / f64::from(k);
            let expected = match (k, j) {
                (3, 0) => 5.0 / 12.0,
                (3, _) => -1.0 / 12.0,
                (4, 0) => 0.375,
                (4, 2) => -0.125,
                (4, _) => 0.0,
                _ => (0.25 + angle.cos() + 0.5 * (2.0 * angle).cos()) / f64::from(k),
            };
            assert!((weights[1 + j as usize] - expected).abs() < 1e-15, "{k} {j}");
        }
        assert!(weights[1 + k as usize..].iter().all(|&weight| weight == 0.0));
        assert_eq!(wheel.valence(VertexId::new(1)), 6);
    }
    // A vertex with six neighbours is regular and takes the eight-point mask.
    let wheel = wheel(6);
    let regular = summed_weights(&wheel, edge(&wheel, 0, 1), &ZORIN);
    assert_eq!(regular, summed_weights(&wheel, edge(&wheel, 0, 1), &EIGHT_POINT));
    assert_eq!(regular[0], 0.5);
}

/// A hub (vertex 0) with `k` neighbours (1 to k) of valence six, and two rings around them.
fn wheel(k: u32) -> Topology {
    let ring = |r: u32, i: u32| 1 + k * r * (r - 1) / 2 + i % (k * r);
    let mut faces = Vec::new();
    for i in 0..k {
        faces.push([0, ring(1, i), ring(1, i + 1)]);
    }
    for r in 1..3 {
        for sector in 0..k {
            for j in 0..=r {
                let outer = sector * (r + 1) + j;
                let inner = sector * r + j;
                faces.push([ring(r, inner), ring(r + 1, outer), ring(r + 1, outer + 1)]);
                if j < r {
                    faces.push([ring(r, inner), ring(r + 1, outer + 1), ring(r, inner + 1)]);
                }
            }
        }
    }
    Topology::from_triangles(1 + 6 * k as usize, &faces).unwrap()
}

/// A number that counts the products it takes part in.
#[derive(Clone, Copy, Default)]
struct Counted(f64);

static PRODUCTS: AtomicUsize = AtomicUsize::new(0);

impl Mul<f64> for Counted {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        PRODUCTS.fetch_add(1, Ordering::Relaxed);
        Self(self.0 * factor)
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

#[test]
fn the_edges_of_a_crowded_vertex_share_their_sums() {
    for (valence, is_crowded) in [(1000, false), (1500, true)] {
        let mut topologies = vec![wheel(valence)];
        // Two crowded vertices joined by edges: a closed cone with one edge of the rim flipped.
        let bipyramid = (0..valence).flat_map(|i| {
            let [a, b] = [2 + i, 2 + (i + 1) % valence];
            [[0, a, b], [1, b, a]]
        });
        let bipyramid: Vec<_> = bipyramid.collect();
        topologies.push(Topology::from_triangles(2 + valence as usize, &bipyramid).unwrap());
        let mut joined = topologies[1].clone();
        let rim = edge(&joined, 2, 3);
        let flip = joined.check_flip(rim).unwrap();
        joined.flip(flip);
        topologies.push(joined);
        for topology in topologies {
            let count = topology.vertex_capacity();
            let values: Vec<_> = (0..count).map(|i| Counted((i as f64).sin())).collect();
            PRODUCTS.store(0, Ordering::Relaxed);
            let refined = ZORIN.refine(&topology, &values);
            let products = PRODUCTS.load(Ordering::Relaxed);
            assert!(!is_crowded || products < 50 * topology.edge_count(), "{products}");
            for e in topology.edges().step_by(7).chain([rim]) {
                let [fast, slow] =
                    [refined[count + e.index()], ZORIN.interpolate(&topology, e, &values)];
                assert!((fast.0 - slow.0).abs() < 1e-12, "{e:?}: {} {}", fast.0, slow.0);
                assert!(is_crowded || fast.0.to_bits() == slow.0.to_bits());
            }
        }
    }
}

#[test]
fn both_ends_irregular_take_the_mean_of_both_rules() {
    let tetrahedron = mesh(&polyhedra::tetrahedron());
    let topology = tetrahedron.topology();
    let e = edge(topology, 0, 1);
    let weights = summed_weights(topology, e, &ZORIN);
    for (weight, expected) in weights.iter().zip([7.0, 7.0, -1.0, -1.0]) {
        assert!((weight - expected / 12.0).abs() < 1e-15);
    }
    // The wings are the apexes themselves and cancel them.
    assert_eq!(summed_weights(topology, e, &EIGHT_POINT), [0.5, 0.5, 0.0, 0.0]);
}

#[test]
fn single_triangle_and_pair_of_triangles() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let triangle = TriMesh::from_triangles(&corners, &[[0, 1, 2]]).unwrap();
    let e = edge(triangle.topology(), 0, 1);
    let point = ZORIN.interpolate(triangle.topology(), e, &corners);
    assert_eq!(point, (9.0 * (corners[0] + corners[1]) - 2.0 * corners[2]) / 16.0);

    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.5), DVec3::Y];
    let pair = TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    // All four wings are reflected, and all but the ends cancels.
    let point = ZORIN.interpolate(pair.topology(), edge(pair.topology(), 0, 2), &corners);
    assert!((point - 0.5 * (corners[0] + corners[2])).length() < 1e-16);
    for sample in [triangle, pair] {
        let fine = subdivide(&sample, 3, &ZORIN).unwrap().mesh;
        fine.topology().validate().unwrap();
        assert_eq!(fine.topology().euler_characteristic(), 1);
        assert_eq!(fine.topology().boundary_loops().len(), 1);
    }
}

#[test]
fn vertices_stay_and_affine_maps_commute() {
    let map = DAffine3::from_cols(
        DVec3::new(1.0, 0.2, -0.3),
        DVec3::new(0.5, 2.0, 0.1),
        DVec3::new(0.0, -0.7, 1.5),
        DVec3::new(3.0, -4.0, 5.0),
    );
    for sample in samples() {
        for options in [ZORIN, EIGHT_POINT] {
            let fine = subdivide(&sample, 2, &options).unwrap();
            let before = sample.positions();
            assert_eq!(&fine.mesh.positions()[..before.len()], before);
            assert_eq!(fine.steps.len(), 2);

            let mut moved = sample.clone();
            moved.positions_mut().iter_mut().for_each(|p| *p = map.transform_point3(*p));
            let moved = subdivide(&moved, 2, &options).unwrap().mesh;
            for (p, q) in fine.mesh.positions().iter().zip(moved.positions()) {
                assert!((map.transform_point3(*p) - q).length() < 1e-12);
            }
        }
    }
}

#[test]
fn the_boundary_depends_on_the_boundary_only() {
    // A bumpy disk with a flat border.
    let wave = Wave { amplitude: 0.3, wavelength: 2.0, half_width: 1.5 };
    let mut bumpy = mesh(&wave.mesh(9, Diagonals::Alternating).unwrap());
    let flat: Vec<bool> =
        bumpy.topology().vertices().map(|v| bumpy.topology().is_boundary_vertex(v)).collect();
    for (p, flat) in bumpy.positions_mut().iter_mut().zip(flat) {
        p.z = if flat { 0.0 } else { p.z + 1.0 };
    }
    let fine = subdivide(&bumpy, 3, &ZORIN).unwrap().mesh;
    let topology = fine.topology();
    assert_eq!(topology.boundary_loops().len(), 1);
    assert_eq!(topology.edges().filter(|&e| topology.is_boundary_edge(e)).count(), 36 * 8);
    for v in topology.vertices().filter(|&v| topology.is_boundary_vertex(v)) {
        assert_eq!(fine.position(v).z, 0.0);
    }
}

/// Largest distance of the new vertices of one step from the surface.
fn error_of_one_step(soup: &PolygonSoup, surface: &dyn SignedDistance) -> f64 {
    let coarse = mesh(soup);
    let fine = subdivide(&coarse, 1, &ZORIN).unwrap().mesh;
    let new = &fine.positions()[coarse.positions().len()..];
    new.iter().map(|&p| surface.signed_distance(p).abs()).fold(0.0, f64::max)
}

#[test]
fn new_vertices_are_of_fourth_order_on_a_regular_torus() {
    let torus = Torus { major: 5.0, minor: 2.0 };
    let errors = [1, 2, 4].map(|n| error_of_one_step(&torus.mesh(24 * n, 12 * n).unwrap(), &torus));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((3.8..4.2).contains(&order), "order {order}");
    }
}

#[test]
fn new_vertices_approach_the_sphere() {
    // Only of second order, because of the twelve vertices with five edges.
    let errors: Vec<f64> = (2..7)
        .map(|level| error_of_one_step(&Sphere::UNIT.icosphere(level).unwrap(), &Sphere::UNIT))
        .collect();
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.26 * pair[0], "{errors:?}");
    }
    // The middles of the edges are several times as far away.
    let linear = ButterflyOptions { tension: 0.0, irregular: IrregularRule::EightPoint };
    let coarse = mesh(&Sphere::UNIT.icosphere(3).unwrap());
    let flat = subdivide(&coarse, 1, &linear).unwrap().mesh;
    let away = flat.positions().iter().map(|p| 1.0 - p.length()).fold(0.0, f64::max);
    assert!(5.0 * errors[1] < away, "{away} against {}", errors[1]);
}

#[test]
fn random_valences_are_no_trouble() {
    let coarse = mesh(&Sphere::UNIT.random_hull(200, 4).unwrap());
    for options in [ZORIN, EIGHT_POINT] {
        let fine = subdivide(&coarse, 2, &options).unwrap().mesh;
        fine.topology().validate().unwrap();
        assert_eq!(fine.topology().euler_characteristic(), 2);
        assert!(fine.topology().is_closed());
    }
}

#[test]
fn attributes_follow_by_hand() {
    let sample = mesh(
        &Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(6, Diagonals::Alternating).unwrap(),
    );
    let mut topology = sample.topology().clone();
    let mut x: Vec<f64> = sample.positions().iter().map(|p| p.x).collect();
    for _ in 0..2 {
        let (fine, _) = topology.subdivide_1_to_4().unwrap();
        x = ZORIN.refine(&topology, &x);
        topology = fine;
    }
    let whole = subdivide(&sample, 2, &ZORIN).unwrap().mesh;
    assert!(whole.positions().iter().map(|p| p.x).eq(x));
    assert!(whole.topology().triangles().eq(topology.triangles()));
}

#[test]
fn bad_input_is_refused() {
    let sample = mesh(&polyhedra::tetrahedron());
    let nan = ButterflyOptions { tension: f64::NAN, ..ZORIN };
    assert!(matches!(subdivide(&sample, 1, &nan), Err(ButterflyError::Tension(_))));
    assert_eq!(subdivide(&sample, 0, &ZORIN).unwrap().mesh.positions(), sample.positions());
    let mut huge = sample.clone();
    huge.positions_mut().iter_mut().for_each(|p| *p *= f64::MAX);
    huge.positions_mut()[2] *= -1.0;
    let strong = ButterflyOptions { tension: 10.0, irregular: IrregularRule::EightPoint };
    let step = TriMesh::from_triangles(huge.positions(), &[[0, 1, 2]]).unwrap();
    let overflow = subdivide(&step, 1, &strong).unwrap_err();
    assert!(matches!(overflow, ButterflyError::Overflow { step: 1, .. }));
    assert!(overflow.to_string().contains("not finite"));
}
