//! Costs and runs in several poses.
#![allow(clippy::unwrap_used)]

use glam::{DAffine3, DVec3};
use mesh_core::{TriMesh, VertexId};
use mesh_shapes::{Irregular, Plane, Sphere};
use simplify::{
    AttributeOptions, Cost, EdgePatch, Memoryless, Options, Posed, Poses, Preset, Scratch,
    SimplifyError, simplify,
};

/// The cost of the collapse of each edge to its midpoint and to its ends.
fn costs(mesh: &TriMesh, cost: &impl Cost) -> Vec<[f64; 3]> {
    let mut faces = Vec::new();
    let edges = mesh.topology().edges();
    edges
        .map(|edge| {
            let patch = EdgePatch::gather(mesh, edge.half_edge(), &mut faces);
            let quadric = cost.quadric(&patch);
            let [a, b] = patch.ends();
            [DVec3::ZERO, a, b]
                .map(|x| cost.cost(&patch, quadric.as_ref(), x, &mut Scratch::default()))
        })
        .collect()
}

fn uneven_ball() -> TriMesh {
    let soup = Sphere { radius: 1.0 }.irregular_icosphere(3, Irregular { jitter: 0.2, seed: 3 });
    TriMesh::from_soup(&soup.unwrap()).unwrap()
}

#[test]
fn a_mesh_that_moves_as_a_whole_costs_what_it_costs_at_rest() {
    let mesh = uneven_ball();
    let move_all = DAffine3::from_translation(DVec3::new(3.0, 0.0, 1.0));
    let turn = DAffine3::from_rotation_x(1.0) * move_all;
    let poses = Poses::new(&mesh, 2, |_, pose| [DAffine3::IDENTITY, turn][pose]);
    assert_eq!(poses.count(), 2);
    let rest = costs(&mesh, &Memoryless);
    let posed = costs(&mesh, &Posed::new(Memoryless, poses));
    for (a, b) in rest.as_flattened().iter().zip(posed.as_flattened()) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
    // In a pose that is twice as large, areas are four times as large, and so are squared distances.
    let twice = Poses::new(&mesh, 1, |_, _| DAffine3::from_scale(DVec3::splat(2.0)));
    let posed = costs(&mesh, &Posed::new(Memoryless, twice));
    for (a, b) in rest.as_flattened().iter().zip(posed.as_flattened()) {
        assert!((16.0 * a - b).abs() < 1e-9, "{a} {b}");
    }
}

/// A plane costs nothing. Folded along a line, it costs what leaves this line.
#[test]
fn a_fold_that_only_a_pose_has_costs_in_this_pose() {
    let soup = Plane { half_width: 1.0 }.mesh(8, Default::default()).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let x = |v: VertexId| mesh.position(v).x;
    let up = DAffine3::from_rotation_y(-1.5);
    let folded = |v: VertexId, _| if x(v) > 1e-9 { up } else { DAffine3::IDENTITY };
    let posed = costs(&mesh, &Posed::new(Memoryless, Poses::new(&mesh, 1, folded)));
    let mut across = 0;
    for (edge, [_, at_start, at_end]) in mesh.topology().edges().zip(posed) {
        let ends = mesh.topology().edge_vertices(edge).map(x);
        let cheaper = at_start.min(at_end);
        if ends.map(|x| x.abs() < 1e-9).iter().filter(|is_on| **is_on).count() == 1 {
            // Onto the line, and away from it.
            let dearer = at_start.max(at_end);
            assert!(dearer > 1e-3 && cheaper < 1e-9, "{ends:?} {at_start} {at_end}");
            across += 1;
        } else {
            assert!(cheaper < 1e-9, "{ends:?} {at_start} {at_end}");
        }
    }
    assert!(across > 20, "{across}");
    // A map that is not finite moves nothing.
    let broken = Poses::new(&mesh, 1, |_, _| DAffine3::from_scale(DVec3::splat(f64::NAN)));
    assert_eq!(costs(&mesh, &Posed::new(Memoryless, broken)), costs(&mesh, &Memoryless));
}

/// A ball whose upper half is pulled up in a pose.
fn pulled(mesh: &TriMesh, size: f64) -> Options {
    let map = |v: VertexId, _| {
        let z = mesh.position(v).z.max(0.0);
        DAffine3::from_translation(DVec3::Z * z * z / size)
    };
    let poses = Some(Poses::new(mesh, 1, map));
    let attributes = AttributeOptions { poses, ..AttributeOptions::default() };
    Options { attributes, ..Options::default().to_faces(200) }
}

#[test]
fn a_scaled_mesh_with_poses_gives_the_scaled_result() {
    let mesh = uneven_ball();
    let size = 2.0_f64.powi(60);
    let mut large = mesh.clone();
    large.positions_mut().iter_mut().for_each(|position| *position *= size);
    let found = simplify(&mesh, &pulled(&mesh, 1.0)).unwrap();
    let scaled = simplify(&large, &pulled(&large, size)).unwrap();
    let expected: Vec<DVec3> = found.mesh.positions().iter().map(|p| size * *p).collect();
    assert_eq!(found.mesh.topology().face_count(), 200);
    assert_eq!(scaled.mesh.positions(), expected);
    // No stage that knows one pose only redistributes faces.
    assert!(found.max_error.is_none() && found.anneal.is_none() && found.preset_kept.is_none());
}

#[test]
fn poses_need_a_cost_with_distances() {
    let mesh = uneven_ball();
    let attributes = pulled(&mesh, 1.0).attributes;
    for options in [Options::preset(Preset::PaperL1).to_faces(100), Options::default().custom()] {
        let options = Options { attributes: attributes.clone(), ..options };
        let error = simplify(&mesh, &options).unwrap_err();
        let is_it = matches!(error, SimplifyError::Conflict { option: "attributes.poses", .. });
        assert!(is_it, "{error}");
    }
}
