//! Laws for every mesh: Gauss-Bonnet, scale, position, orientation, and equal bits.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use core::f64::consts::TAU;

use dcurv::{
    CurvatureOptions, Curvatures, VertexArea, VertexStar, vertex_curvature, willmore_energies,
    willmore_energy,
};
use glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::{Cylinder, Diagonals, Irregular, RowPhase, Saddle, Sphere, Torus};

const AREAS: [VertexArea; 2] = [VertexArea::Voronoi, VertexArea::Barycentric];

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

fn reversed(soup: &PolygonSoup) -> TriMesh {
    let turned: Vec<[u32; 3]> = soup.faces().map(|f| [f[0], f[2], f[1]]).collect();
    TriMesh::from_triangles(soup.positions(), &turned).unwrap()
}

fn curvatures(mesh: &TriMesh, area: VertexArea) -> Curvatures {
    Curvatures::of(mesh, &CurvatureOptions { area })
}

/// A disk, an annulus, a sphere and a torus, all irregular, with their Euler characteristics.
fn surfaces() -> [(&'static str, PolygonSoup, f64); 4] {
    let irregular = Irregular { jitter: 0.2, seed: 5 };
    let saddle = Saddle { coefficient: 0.7, half_width: 1.0 };
    let cylinder = Cylinder { radius: 1.0, height: 1.5 };
    let torus = Torus { major: 2.0, minor: 1.0 };
    [
        ("disk", saddle.irregular_mesh(40, irregular).unwrap(), 1.0),
        ("annulus", cylinder.irregular_mesh(20, 60, irregular).unwrap(), 0.0),
        ("sphere", Sphere::UNIT.irregular_icosphere(4, irregular).unwrap(), 2.0),
        ("torus", torus.irregular_mesh(60, 40, irregular).unwrap(), 0.0),
    ]
}

#[test]
fn trap_11_gauss_bonnet_on_disk_annulus_sphere_and_torus() {
    for (name, soup, euler) in surfaces() {
        let mesh = mesh(&soup);
        let topology = mesh.topology();
        let counted = topology.vertex_count() as f64 - topology.edge_count() as f64
            + topology.face_count() as f64;
        assert_eq!(counted, euler);
        let total = curvatures(&mesh, VertexArea::Voronoi).totals().gaussian.value();
        println!("{name}: sum of K and boundary turn {total:.12}, 2 pi chi {:.12}", TAU * euler);
        assert!((total - TAU * euler).abs() < 1e-10);
    }
}

#[test]
fn trap_12_curvature_of_a_sphere_does_not_depend_on_its_refinement() {
    for radius in [0.5, 1.0, 20.0] {
        for level in 2..7 {
            let mesh = mesh(&Sphere { radius }.icosphere(level).unwrap());
            for at in curvatures(&mesh, VertexArea::Voronoi).vertices().as_slice() {
                let step = 0.5_f64.powi(level as i32);
                let k = at.gaussian().value() * radius * radius;
                let h = at.mean().value() * radius;
                let error = (k - 1.0).abs().max((h - 1.0).abs());
                assert!(error < 0.5 * step * step, "{level} {error}");
                // The root of H² - K turns an error of second order into one of first order.
                let [k1, k2] = at.principal().map(|k| k.value() * radius);
                assert!((k1 - 1.0).abs().max((k2 - 1.0).abs()) < 0.5 * step);
            }
        }
    }
}

#[test]
fn areas_add_up_to_the_area_of_the_mesh() {
    for (_, soup, _) in surfaces() {
        let mesh = mesh(&soup);
        for area in AREAS {
            let total = curvatures(&mesh, area).totals().area.value();
            assert!((total - mesh.area()).abs() < 1e-12 * mesh.area());
        }
    }
}

#[test]
fn scale_multiplies_by_powers_of_itself() {
    for (_, soup, _) in surfaces() {
        let before = curvatures(&mesh(&soup), VertexArea::Voronoi).totals();
        for scale in [1e-6, 1e6, 1e-50, 1e50] {
            let mut scaled = soup.clone();
            scaled.positions_mut().iter_mut().for_each(|p| *p *= scale);
            let after = curvatures(&mesh(&scaled), VertexArea::Voronoi).totals();
            for (after, before) in [
                (after.gaussian.value(), before.gaussian.value()),
                (after.f1, before.f1),
                (after.mean.value() / scale, before.mean.value()),
                (after.f2() / scale, before.f2()),
                (after.f3 / scale, before.f3),
                (after.area.value() / scale / scale, before.area.value()),
                (after.norm_l1 * scale, before.norm_l1),
                (after.norm_l2_squared * scale * scale, before.norm_l2_squared),
            ] {
                assert!((after - before).abs() < 1e-9 * (1.0 + before.abs()), "{after} {before}");
            }
        }
    }
}

/// Moving a mesh by a million of its diagonals removes six digits from its coordinates; curvature is a second
/// difference of them. A coarse mesh keeps the other nine digits, minus the loss by its step size.
#[test]
fn place_changes_nothing_but_the_digits_of_the_coordinates() {
    let soup = Torus { major: 2.0, minor: 1.0 }.mesh(24, 16).unwrap();
    let here = curvatures(&mesh(&soup), VertexArea::Voronoi).totals();
    let mut moved = soup.clone();
    let shift = 1e6 * mesh(&soup).bounding_box().unwrap().diagonal() * DVec3::new(0.6, 0.0, 0.8);
    moved.positions_mut().iter_mut().for_each(|p| *p += shift);
    let there = curvatures(&mesh(&moved), VertexArea::Voronoi).totals();
    for (there, here) in [(there.f1, here.f1), (there.f2(), here.f2()), (there.f3, here.f3)] {
        println!("relative change {:e}", (there / here - 1.0).abs());
        assert!((there / here - 1.0).abs() < 1e-6);
    }
    // The mesh with rounded coordinates gives the same values after the exact move back.
    let mut back = moved.clone();
    back.positions_mut().iter_mut().for_each(|p| *p -= shift);
    let back = curvatures(&mesh(&back), VertexArea::Voronoi).totals();
    assert!((there.f1 / back.f1 - 1.0).abs() < 1e-12);
    assert!((there.gaussian.value() - back.gaussian.value()).abs() < 1e-12);
}

#[test]
fn reversing_the_orientation_changes_the_sign_of_mean_curvature_and_nothing_else() {
    for (_, soup, _) in surfaces() {
        let (mesh, reversed) = (mesh(&soup), reversed(&soup));
        let before = curvatures(&mesh, VertexArea::Voronoi);
        let after = curvatures(&reversed, VertexArea::Voronoi);
        for v in mesh.topology().vertices() {
            let (b, a) = (before[v], after[v]);
            let (bi, ai) = (b.integrals(), a.integrals());
            let close = |x: f64, y: f64| (x - y).abs() < 1e-12 * (1.0 + x.abs());
            assert!(close(bi.mean.value(), -ai.mean.value()));
            assert!(close(bi.abs_dihedral.value(), ai.abs_dihedral.value()));
            assert!(close(bi.angle_defect.value(), ai.angle_defect.value()));
            assert!(close(bi.area.value(), ai.area.value()));
            // Where H² is nearly K, the root magnifies the rounding.
            let ([b1, b2], [a1, a2]) = (b.principal(), a.principal());
            assert!((b1 + a2).value().abs() < 1e-5 && (b2 + a1).value().abs() < 1e-5);
        }
    }
}

#[test]
fn one_vertex_and_whole_mesh_give_the_same_bits() {
    for (_, soup, _) in surfaces() {
        let mesh = mesh(&soup);
        let energies = willmore_energies(&mesh);
        for area in AREAS {
            let all = curvatures(&mesh, area);
            let both = Curvatures::with_willmore_energies(&mesh, &CurvatureOptions { area });
            assert_eq!(both, (all.clone(), energies.clone()));
            for v in mesh.topology().vertices() {
                let ring: Vec<DVec3> =
                    mesh.topology().one_ring(v).map(|w| mesh.position(w)).collect();
                let closed = !mesh.topology().is_boundary_vertex(v);
                let star = VertexStar { center: mesh.position(v), ring: &ring, closed };
                assert_eq!(all[v], vertex_curvature(&mesh, v, area));
                assert_eq!(*all[v].integrals(), star.integrals(area));
                assert_eq!(energies[v].to_bits(), willmore_energy(&mesh, v).to_bits());
            }
        }
    }
}

/// Against one vertex after the other, as without the `rayon` feature.
#[test]
fn bits_do_not_depend_on_threads() {
    let soup = Torus { major: 2.0, minor: 1.0 }.mesh(200, 150).unwrap();
    let mesh = mesh(&soup);
    let serial: Vec<_> = mesh
        .topology()
        .vertices()
        .map(|v| vertex_curvature(&mesh, v, VertexArea::Voronoi))
        .collect();
    let evaluate = || curvatures(&mesh, VertexArea::Voronoi);
    let first = evaluate();
    assert_eq!(first.vertices().as_slice(), serial);
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (all, totals) = pool.install(|| (evaluate(), evaluate().totals()));
        assert_eq!(all, first);
        assert_eq!(totals, first.totals());
    }
}

#[test]
fn degenerate_meshes_have_values() {
    let p = DVec3::new(1.0, 2.0, 3.0);
    let q = DVec3::new(4.0, 4.0, 4.0);
    let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    // All points at one position; at two; on a line; each time with an isolated vertex.
    for points in [[p; 4], [p, q, p, q], [p, q, 0.5 * (p + q), 2.0 * q - p]] {
        let mut positions = points.to_vec();
        positions.push(q);
        let mesh = TriMesh::from_triangles(&positions, &faces).unwrap();
        for area in AREAS {
            let all = curvatures(&mesh, area);
            for at in all.vertices().as_slice() {
                let integrals = at.integrals();
                assert!(integrals.angle_defect.value().is_finite());
                assert_eq!(integrals.mean.value(), 0.0);
                assert_eq!(integrals.area.value(), 0.0);
                assert_eq!(at.principal().map(dcurv::Pointwise::value), [0.0; 2]);
                assert_eq!((at.gaussian().value(), at.shape_index()), (0.0, 0.0));
            }
            let totals = all.totals();
            assert!((totals.gaussian.value() - 2.0 * TAU).abs() < 1e-14);
            assert_eq!((totals.f1, totals.f3, totals.without_area), (0.0, 0.0, 5));
        }
        for frame in dcurv::principal_frames(&mesh).as_slice() {
            assert!(frame.is_none());
        }
        assert!(willmore_energies(&mesh).as_slice().iter().all(|w| w.is_finite()));
    }
}

#[test]
fn boundary_vertices_are_flagged_and_have_no_gaussian_curvature() {
    let soup = Saddle { coefficient: 0.7, half_width: 1.0 }.mesh(8, Diagonals::Uniform).unwrap();
    let mesh = mesh(&soup);
    let all = curvatures(&mesh, VertexArea::Voronoi);
    let (totals, interior) = (all.totals(), all.interior_totals());
    assert_eq!((totals.boundary, interior.boundary), (32, 0));
    assert!(interior.gaussian.value() < 0.0);
    for v in mesh.topology().vertices() {
        assert_eq!(all[v].is_boundary(), mesh.topology().is_boundary_vertex(v));
        if all[v].is_boundary() {
            assert_eq!((all[v].gaussian().value(), willmore_energy(&mesh, v)), (0.0, 0.0));
        }
    }
}

#[test]
fn shape_index_names_the_shape() {
    let shape = |soup: &PolygonSoup| {
        let all = curvatures(&mesh(soup), VertexArea::Voronoi);
        let inner = all.vertices().as_slice().iter().find(|at| !at.is_boundary()).unwrap();
        (inner.shape_index(), inner.curvedness().value())
    };
    let cylinder = Cylinder { radius: 0.5, height: 1.0 }.mesh(64, 128, RowPhase::Aligned).unwrap();
    let (ridge, curvedness) = shape(&cylinder);
    assert!((ridge - 0.5).abs() < 1e-6 && (curvedness - 2.0_f64.sqrt()).abs() < 1e-3);
    let (cap, curvedness) = shape(&Sphere::UNIT.icosphere(5).unwrap());
    assert!((cap - 1.0).abs() < 0.05 && (curvedness - 1.0).abs() < 1e-2);
}

#[test]
fn vertices_without_faces_have_no_curvature() {
    // Vertices are evaluated in blocks; here whole blocks of them have no faces.
    let points: Vec<DVec3> = (0..5000).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    let mut corners = points.clone();
    corners.extend([DVec3::ZERO, DVec3::X, DVec3::Y]);
    for (positions, triangles) in
        [(points.clone(), vec![]), (corners, vec![[5000, 5001, 5002]]), (vec![], vec![])]
    {
        let mesh = TriMesh::from_triangles(&positions, &triangles).unwrap();
        for area in [VertexArea::Voronoi, VertexArea::Barycentric] {
            let all = curvatures(&mesh, area);
            let abs_means = all.map(|at| at.abs_dihedral().value());
            assert_eq!(abs_means.as_slice(), vec![0.0; positions.len()]);
            let totals = all.totals();
            assert_eq!([totals.f1, totals.f2(), totals.f3], [0.0; 3]);
        }
    }
}
