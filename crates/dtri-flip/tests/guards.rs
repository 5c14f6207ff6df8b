//! Locks, feature edges, folds and self-intersections.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::collections::BTreeMap;

use crate::common::{face_set, mesh_of, model};
use dcurv::VertexArea;
use dtri_flip::{AbsMean, CostName, FlipError, FlipOptions, feature_edges, optimise};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{EdgeId, FaceId, TriMesh, VertexId, triangles_cross};
use mesh_shapes::{Sphere, inset_cube, scramble};

#[test]
fn trap_15_locked_and_feature_edges_never_flip_and_two_flips_restore_the_mesh() {
    let mut mesh = mesh_of(&Sphere { radius: 1.0 }.random_hull(200, 3).unwrap());
    scramble(&mut mesh, 200, &mut SplitMix64::new(1), |_, _| true);
    let mut random = SplitMix64::new(2);
    let mut locked = mesh.topology().edge_map(false);
    for edge in mesh.topology().edges() {
        locked[edge] = random.uniform() < 0.3;
    }
    let features = feature_edges(&mesh, 1.0);
    let ends = |mesh: &TriMesh, e: EdgeId| mesh.topology().edge_vertices(e);
    let kept: Vec<_> = mesh
        .topology()
        .edges()
        .filter(|&e| locked[e] || features[e])
        .map(|e| (e, ends(&mesh, e)))
        .collect();
    for &cost in CostName::ALL {
        let mut copy = mesh.clone();
        let options = FlipOptions {
            locked: Some(locked.clone()),
            feature_angle: Some(1.0),
            look_ahead: 2,
            ..Default::default()
        };
        let report = cost
            .optimise(&mut copy, VertexArea::Voronoi, &options, &mut |_| {
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
        assert!(report.flips > 0);
        assert_eq!(report.locked_edges, kept.len());
        assert!(kept.iter().all(|&(e, before)| ends(&copy, e) == before));
    }
    let before: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    for edge in mesh.topology().edges().collect::<Vec<_>>() {
        for _ in 0..2 {
            if let Ok(flip) = mesh.topology().check_flip(edge) {
                mesh.flip(flip);
            }
        }
        assert!(mesh.topology().triangles().eq(before.iter().copied()));
    }
}

#[test]
fn feature_lines_of_a_cube_survive() {
    let mesh = mesh_of(&inset_cube(0.2).unwrap());
    let options = FlipOptions { feature_angle: Some(0.5), ..Default::default() };
    for &cost in CostName::ALL {
        let mut copy = mesh.clone();
        let report = cost
            .optimise(&mut copy, VertexArea::Voronoi, &options, &mut |_| {
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
        assert!(report.locked_edges >= 12);
        let corner = |v: VertexId| copy.position(v).abs().min_element() > 0.99;
        let edges = copy.topology().edges();
        let lines = edges.filter(|&e| copy.topology().edge_vertices(e).into_iter().all(corner));
        assert_eq!(lines.count(), 12, "{cost}");
    }
}

#[test]
fn bad_options_are_errors() {
    let mut mesh = mesh_of(&inset_cube(0.2).unwrap());
    let before = face_set(&mesh);
    let short = mesh_core::EdgeMap::from_vec(vec![true]);
    let options = FlipOptions { locked: Some(short), ..Default::default() };
    let error = optimise(&mut mesh, &AbsMean, &options).unwrap_err();
    assert_eq!(error, FlipError::LockedLength { given: 1, edges: 36 });
    for angle in [f64::NAN, -0.1, 4.0] {
        let options = FlipOptions { max_fold: Some(angle), ..Default::default() };
        let error = optimise(&mut mesh, &AbsMean, &options).unwrap_err();
        assert!(error.to_string().starts_with("max_fold is"), "{error}");
    }
    assert_eq!(face_set(&mesh), before);
}

#[test]
fn fold_guard_keeps_faces_near_their_quadrilateral() {
    let mut mesh = mesh_of(&Sphere { radius: 1.0 }.random_hull(150, 5).unwrap());
    scramble(&mut mesh, 40, &mut SplitMix64::new(8), |_, _| true);
    let mut refused = 0;
    for limit in [0.1, 0.3, 1.0] {
        let mut copy = mesh.clone();
        let options = FlipOptions { max_fold: Some(limit), ..Default::default() };
        let mut seen = copy.clone();
        // One flip at a time, to see each.
        for flips in 1.. {
            copy = mesh.clone();
            let one = FlipOptions { max_flips: Some(flips), ..options.clone() };
            let report = optimise(&mut copy, &AbsMean, &one).unwrap();
            if report.flips < flips {
                refused += report.rejected.fold;
                break;
            }
            let changed =
                |f: &FaceId| copy.topology().face_vertices(*f) != seen.topology().face_vertices(*f);
            let faces: Vec<FaceId> = copy.topology().faces().filter(changed).collect();
            assert_eq!(faces.len(), 2);
            let turn = |mesh: &TriMesh| {
                let n = [faces[0], faces[1]].map(|f| mesh.face_cross(f));
                n.map(|x| mesh_core::angle_between(x, n[0] + n[1])).into_iter().fold(0.0, f64::max)
            };
            assert!(turn(&copy) <= limit.max(turn(&seen)) + 1e-12);
            seen = copy.clone();
        }
    }
    assert!(refused > 0);
}

/// All pairs of faces that cross, found with a grid and independent floating-point geometry: an edge of one face passes
/// through the inside of the other.
fn crossings(mesh: &TriMesh) -> usize {
    let topology = mesh.topology();
    let count = topology.edge_count().max(1) as f64;
    let lengths = topology.edges().map(|e| {
        let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
        a.distance(b)
    });
    let cell = 2.0 * lengths.sum::<f64>() / count;
    let key = |p: DVec3| (p / cell).floor().to_array().map(|x| x as i64);
    let mut grid: BTreeMap<[i64; 3], Vec<FaceId>> = BTreeMap::new();
    let cells = |points: &[DVec3]| {
        let low = points.iter().copied().reduce(DVec3::min).unwrap();
        let high = points.iter().copied().reduce(DVec3::max).unwrap();
        let ([x0, y0, z0], [x1, y1, z1]) = (key(low), key(high));
        (x0..=x1).flat_map(move |x| (y0..=y1).flat_map(move |y| (z0..=z1).map(move |z| [x, y, z])))
    };
    for f in topology.faces() {
        for at in cells(&mesh.triangle(f)) {
            grid.entry(at).or_default().push(f);
        }
    }
    let mut found = std::collections::BTreeSet::new();
    for e in topology.edges() {
        let ends = topology.edge_vertices(e);
        let [p, q] = ends.map(|v| mesh.position(v));
        for f in cells(&[p, q]).filter_map(|at| grid.get(&at)).flatten() {
            let corners = topology.face_vertices(*f);
            if ends.iter().any(|v| corners.contains(v)) {
                continue;
            }
            if pierces(p, q, mesh.triangle(*f)) {
                found.insert((e, *f));
            }
        }
    }
    found.len()
}

/// Möller and Trumbore 1997, away from the borders by more than rounding.
fn pierces(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let (u, w, direction) = (b - a, c - a, q - p);
    let h = direction.cross(w);
    let det = u.dot(h);
    if det.abs() < 1e-14 * u.length() * w.length() * direction.length() {
        return false;
    }
    let s = (p - a) / det;
    let (x, t) = (s.dot(h), s.cross(u));
    let (y, along) = (direction.dot(t), w.dot(t));
    let margin = 1e-9;
    x > margin && y > margin && x + y < 1.0 - margin && along > margin && along < 1.0 - margin
}

#[test]
fn guard_introduces_no_self_intersection() {
    let mut without = 0;
    const ALL: &[CostName] = &[CostName::F1, CostName::F2, CostName::Gauss];
    for (name, costs) in [
        ("rocker-arm.obj", ALL),
        ("max-planck_10k.obj", ALL),
        ("fandisk.obj", ALL),
        ("elephant_40k.off", ALL),
        ("armadillo_52k.off", &[CostName::F2]),
    ] {
        let Some(mesh) = model(name) else { return };
        let before = crossings(&mesh);
        for &cost in costs {
            let run = |forbid_intersections: bool| {
                let mut copy = mesh.clone();
                let options = FlipOptions { forbid_intersections, ..Default::default() };
                let report = cost
                    .optimise(&mut copy, VertexArea::Voronoi, &options, &mut |_| {
                        std::ops::ControlFlow::Continue(())
                    })
                    .unwrap();
                (crossings(&copy), report)
            };
            let (free, _) = run(false);
            let (guarded, report) = run(true);
            println!(
                "{name} {cost}: {before} crossings before, {free} without guard, {guarded} with it, \
                 {} flips, {} refused",
                report.flips, report.rejected.intersection
            );
            assert!(guarded <= before);
            without += free;
        }
    }
    assert!(without > 0, "the meshes do not need the guard");
}

#[test]
fn guard_keeps_a_scrambled_sphere_apart() {
    // Scrambles without constraint cross themselves; embedded ones do not.
    for seed in 0..5 {
        let mut mesh = mesh_of(&Sphere { radius: 1.0 }.random_hull(100, seed).unwrap());
        let starlike = |mesh: &TriMesh, edge: EdgeId| {
            dtri_flip::Quad::around(mesh.topology(), edge).is_some_and(|quad| {
                quad.flipped_triangles().iter().all(|t| {
                    let [a, b, c] = t.map(|v| mesh.position(v));
                    a.dot(b.cross(c)) > 1e-9
                })
            })
        };
        scramble(&mut mesh, 300, &mut SplitMix64::new(seed), starlike);
        assert_eq!(crossings(&mesh), 0);
        for look_ahead in [1, 2] {
            let mut copy = mesh.clone();
            let options =
                FlipOptions { forbid_intersections: true, look_ahead, ..Default::default() };
            let report = optimise(&mut copy, &AbsMean, &options).unwrap();
            assert!(report.flips > 0);
            assert_eq!(crossings(&copy), 0);
            assert_eq!(all_crossing_pairs(&copy), 0);
        }
    }
}

/// Every pair of faces, by the exact predicate.
fn all_crossing_pairs(mesh: &TriMesh) -> usize {
    let face = |f: FaceId| (mesh.topology().face_vertices(f), mesh.triangle(f));
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let mut count = 0;
    for (i, &f) in faces.iter().enumerate() {
        count += faces[..i].iter().filter(|&&g| triangles_cross(face(f), face(g))).count();
    }
    count
}

#[test]
fn triangles_cross_in_every_way_they_can() {
    let triangle =
        |ids: [u32; 3], points: [[f64; 3]; 3]| (ids.map(VertexId::new), points.map(DVec3::from));
    let base = triangle([0, 1, 2], [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    let cases = [
        // Through the middle; beside; touching with a corner; in the plane, apart and inside.
        ([3, 4, 5], [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true),
        ([3, 4, 5], [[5.0, 5.0, -1.0], [5.0, 5.0, 1.0], [6.0, 5.0, 1.0]], false),
        ([3, 4, 5], [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true),
        ([3, 4, 5], [[5.0, 5.0, 0.0], [6.0, 5.0, 0.0], [5.0, 6.0, 0.0]], false),
        ([3, 4, 5], [[1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0, 1.5, 0.0]], true),
        // A common vertex: apart, folded through, in the plane beside and over it.
        ([0, 4, 5], [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], false),
        ([0, 4, 5], [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, 1.0, -1.0]], true),
        ([0, 4, 5], [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], false),
        ([0, 4, 5], [[0.0, 0.0, 0.0], [9.0, 1.0, 0.0], [9.0, 2.0, 0.0]], true),
        // A common edge: bent, flat, folded back.
        ([1, 0, 5], [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], false),
        ([1, 0, 5], [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, -1.0, 0.0]], false),
        ([1, 0, 5], [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]], true),
        // The same three vertices; no area.
        ([1, 0, 2], [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 4.0, 0.0]], true),
        ([3, 4, 5], [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]], false),
    ];
    for (ids, points, expected) in cases {
        for turn in 0..3 {
            let rotate = |i: usize| (i + turn) % 3;
            let other = triangle(
                [ids[rotate(0)], ids[rotate(1)], ids[rotate(2)]],
                [points[rotate(0)], points[rotate(1)], points[rotate(2)]],
            );
            assert_eq!(triangles_cross(base, other), expected, "{ids:?} {points:?}");
            assert_eq!(triangles_cross(other, base), expected, "{ids:?} {points:?}");
        }
    }
}
