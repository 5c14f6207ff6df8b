//! Constraints that name properties of the file.
#![allow(clippy::unwrap_used)]

use mesh_core::build::{Repair, Weld};
use mesh_core::{PolygonSoup, Topology};
use mesh_io::{Model, ScalarValues, Scalars};
use mesh_work::{ConstraintChoices, ConstraintError, Length, Loaded};
use simplify::{Options, Preset};

/// Two squares of two triangles that share an edge, whose ends are in the file twice.
fn split() -> Model {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    Model { soup: PolygonSoup::from_triangles(&points, &faces).unwrap(), ..Model::default() }
}

fn welded(vertices: impl Into<ScalarValues>, faces: impl Into<ScalarValues>) -> Loaded {
    let mut model = split();
    model.vertex_scalars.push(Scalars::new("mark", vertices));
    model.face_scalars.push(Scalars::new("area", faces));
    let mut repair = Repair::strict();
    repair.weld = Weld::Exact;
    Loaded::build(model, &repair).unwrap()
}

fn constrained(
    loaded: &Loaded,
    choices: &ConstraintChoices,
) -> Result<(Options, [usize; 2]), ConstraintError> {
    let mut options = Options::preset(Preset::Fast);
    let counts = choices.constrain(loaded.source(), &mut options)?;
    Ok((options, counts))
}

fn keeping(name: &str) -> ConstraintChoices {
    ConstraintChoices { keep: Some(name.into()), ..ConstraintChoices::default() }
}

fn weighing(name: &str) -> ConstraintChoices {
    ConstraintChoices { weight: Some(name.into()), ..ConstraintChoices::default() }
}

/// A vertex that the file has twice is kept if one of the copies is marked, and its importance is the greater one.
#[test]
fn marks_of_any_copy_of_a_vertex_count() {
    let loaded = welded(vec![0_u8, 0, 0, 0, 7, 0, 0, 0], vec![0_u8; 4]);
    let topology = loaded.mesh.topology();
    assert_eq!(topology.vertex_count(), 6);
    let (options, counts) = constrained(&loaded, &keeping("mark")).unwrap();
    assert_eq!(counts, [1, 0]);
    let locked = options.protect.locked.unwrap();
    for v in topology.vertices() {
        assert_eq!(locked[v], loaded.mesh.position(v) == glam::DVec3::X, "{v:?}");
    }
    let (options, _) = constrained(&loaded, &weighing("mark")).unwrap();
    let importance = options.protect.importance.unwrap();
    let sum: f64 = topology.vertices().map(|v| importance[v]).sum();
    assert!((sum - 7.0).abs() < 1e-15);
}

#[test]
fn marked_faces_keep_their_corners_and_edges() {
    let loaded = welded(vec![0_u8; 8], vec![0_i16, -3, 0, 0]);
    let topology: &Topology = loaded.mesh.topology();
    let (options, counts) = constrained(&loaded, &keeping("area")).unwrap();
    assert_eq!(counts, [0, 1]);
    let (locked, kept) = (options.protect.locked.unwrap(), options.protect.kept.unwrap());
    let face = topology.faces().nth(1).unwrap();
    for v in topology.vertices() {
        assert_eq!(locked[v], topology.face_vertices(face).contains(&v));
    }
    for e in topology.edges() {
        assert_eq!(kept[e], topology.face_edges(face).contains(&e));
    }
}

#[test]
fn properties_that_do_not_suit_are_refused() {
    let loaded = welded(vec![0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0], vec![0_u8; 4]);
    let error = |choices: &ConstraintChoices| constrained(&loaded, choices).unwrap_err();
    let unknown = error(&keeping("marks"));
    assert!(unknown.to_string().contains("mark, area"), "{unknown}");
    assert!(matches!(error(&weighing("none")), ConstraintError::Unknown(_)));
    assert!(matches!(error(&weighing("area")), ConstraintError::OfFaces(_)));
    assert!(matches!(error(&keeping("mark")), ConstraintError::Mark { .. }));
    assert!(matches!(error(&weighing("mark")), ConstraintError::Importance { vertex: 1, .. }));
    let infinite = welded(vec![f64::INFINITY; 8], vec![0_u8; 4]);
    assert!(constrained(&infinite, &weighing("mark")).is_err());
}

#[test]
fn lengths_are_in_model_units_or_shares_of_the_diagonal() {
    let loaded = welded(vec![0_u8; 8], vec![0_u8; 4]);
    let edge = |max_edge, relative| {
        let choices = ConstraintChoices {
            max_edge: Some(max_edge),
            relative,
            ..ConstraintChoices::default()
        };
        constrained(&loaded, &choices).unwrap().0.protect.limits.max_edge.unwrap()
    };
    let diagonal = 5_f64.sqrt();
    assert!((edge(Length::Plain(0.3), false) - 0.3).abs() < 1e-15);
    assert!((edge(Length::Percent(10.0), false) - 0.1 * diagonal).abs() < 1e-15);
    assert!((edge(Length::Plain(0.3), true) - 0.3 * diagonal).abs() < 1e-15);
}
