//! Fig. 6: a scanned face whose triangulation has vertical creases.

use dtri_flip::lattice_error;
use glam::DVec3;
use mesh_core::{TriMesh, VertexId};

use super::super::item::{Figure, Item};
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::face_shape;
use super::measures::Measures;
use super::rules::RULES;
use mesh_render::Style;
use xtask_common::Failure;

/// An edge is vertical if it is steeper than this against the horizontal, in radians.
const VERTICAL: f64 = 75.0 * core::f64::consts::PI / 180.0;
/// Lattice steps on a side of a triangle.
const SUBDIVISIONS: u32 = 6;
/// The real face.
const MODEL: &str = "face_52k.obj";

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Points of a face, joined by Delaunay triangulation of their parameters. The parameters are \
         squeezed in the vertical, so that vertical edges are preferred and the surface gets \
         vertical creases, as in the paper's figure.",
    );
    item.stand_in(
        "A face made of formulas with 3,551 points, in place of the paper's scan, which is not \
         public; with models also a real one, with the triangulation it comes with.",
    );
    item.how(
        &["dtri_flip::VirtualWillmore", "dtri_flip::Willmore", "dtri_flip::lattice_error"],
        &["curvmesh flip IN -o OUT --cost willmore --shape-constraint unrestricted"],
    );
    let mut lines = Vec::new();
    let initial = mesh_of(&face_shape::scan()?)?;
    let results = add_face(item, &mut lines, "made face", &initial, Some(face_shape::height))?;
    add_claims(item, &initial, &results[0]);
    let toward = DVec3::new(-0.35, 0.12, 1.0);
    for (edge_width, what) in [(0.7, "edges"), (0.0, "shaded")] {
        let draw = |mesh, name: &str, caption| {
            picture(run, mesh, toward, edge_width, &format!("made-{what}-{name}"), caption)
        };
        item.side_by_side([
            draw(&initial, "before", "initial")?,
            draw(&results[0], "after", "after the printed rule")?,
            draw(&results[3], "f2", "after F2, for comparison")?,
        ]);
    }
    if !run.quick
        && let Some(face) = run.model(item, MODEL)?
    {
        let results = add_face(item, &mut lines, "real face", &face, None)?;
        let toward = DVec3::new(0.3, 0.1, 1.0);
        let draw = |mesh, name, caption| picture(run, mesh, toward, 0.0, name, caption);
        item.side_by_side([
            draw(&face, "real-before", "real face, initial")?,
            draw(&results[0], "real-printed", "after the printed rule")?,
            draw(
                &results[1],
                "real-no-folds",
                "after the printed rule with a guard against folds",
            )?,
        ]);
        add_real_claim(item, &face, &results);
    }
    item.table(
        "Vertical edges: share of the edges that are steeper than 75°, seen from the front. Height \
         error: between the triangles and the formula, where there is one; the face is 2.5 high. \
         Folded: faces that look backward.",
        Measures::header(
            &["mesh", "rule", "flips"],
            &["vertical edges", "mean height error", "folded"],
        ),
        lines,
    );
    Ok(())
}

/// All rules on one face; returns what they make of it.
fn add_face(
    item: &mut Item,
    lines: &mut Vec<Vec<String>>,
    name: &str,
    initial: &TriMesh,
    height: Option<fn(f64, f64) -> f64>,
) -> Result<[TriMesh; RULES.len()], Failure> {
    add_line(item, lines, [name, "initial"], initial, 0, height);
    let mut results = RULES.map(|_| initial.clone());
    for (rule, mesh) in RULES.iter().zip(&mut results) {
        let flips = rule.optimise(mesh)?.flips;
        add_line(item, lines, [name, rule.name], mesh, flips, height);
    }
    Ok(results)
}

fn add_line(
    item: &mut Item,
    lines: &mut Vec<Vec<String>>,
    [name, rule]: [&str; 2],
    mesh: &TriMesh,
    flips: u64,
    height: Option<fn(f64, f64) -> f64>,
) {
    let of = format!("{name}, {rule}");
    let measures = Measures::of(mesh);
    measures.add(item, &of);
    item.number(format!("{of}, flips"), flips as f64);
    let vertical = vertical_share(mesh);
    item.number(format!("{of}, share of vertical edges"), vertical);
    let mut line = vec![name.to_owned(), rule.to_owned(), flips.to_string()];
    line.extend(measures.cells());
    line.push(format!("{:.1} %", 100.0 * vertical));
    line.push(height.map_or_else(String::new, |height| {
        let error = height_error(mesh, height);
        item.number(format!("{of}, mean height error"), error);
        format!("{error:.5}")
    }));
    line.push(height.map_or_else(String::new, |_| {
        let folded = folded_faces(mesh);
        item.number(format!("{of}, folded faces"), folded as f64);
        folded.to_string()
    }));
    lines.push(line);
}

/// The mean difference in height between the triangles and the surface they stand for.
fn height_error(mesh: &TriMesh, height: fn(f64, f64) -> f64) -> f64 {
    lattice_error(mesh, SUBDIVISIONS, |p| p.z - height(p.x, p.y)).mean
}

fn vertical_share(mesh: &TriMesh) -> f64 {
    vertical_edges(mesh).len() as f64 / mesh.topology().edge_count().max(1) as f64
}

/// The ends of the edges that are vertical, seen from the front.
fn vertical_edges(mesh: &TriMesh) -> Vec<[VertexId; 2]> {
    let ends = mesh.topology().edges().map(|edge| mesh.topology().edge_vertices(edge));
    let is_vertical = |ends: &[VertexId; 2]| {
        let [a, b] = ends.map(|v| mesh.position(v));
        (b - a).y.abs().atan2((b - a).x.abs()) > VERTICAL
    };
    ends.filter(is_vertical).collect()
}

fn add_claims(item: &mut Item, initial: &TriMesh, printed: &TriMesh) {
    let vertical = vertical_edges(initial);
    let gone = vertical.iter().filter(|[a, b]| printed.topology().find_half_edge(*a, *b).is_none());
    let share = gone.count() as f64 / vertical.len().max(1) as f64;
    item.number("share of the vertical edges that are flipped", share);
    let [before, after] = [initial, printed].map(vertical_share);
    let outcome = match (share > 0.5, after < before) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    };
    item.claim(
        "vertical edges",
        outcome,
        format!(
            "{:.0} % of them are flipped; {:.0} % of all edges are vertical before, {:.0} % after",
            100.0 * share,
            100.0 * before,
            100.0 * after
        ),
    );
    let [before, after] = [initial, printed].map(|mesh| height_error(mesh, face_shape::height));
    let [f2_before, f2_after] = [initial, printed].map(|mesh| Measures::of(mesh).f2);
    let folded = folded_faces(printed);
    let outcome = match (after < before, folded) {
        (true, 0) => Outcome::Holds,
        (true, _) => Outcome::InPart,
        (false, _) => Outcome::Fails,
    };
    item.claim(
        "creases",
        outcome,
        format!(
            "the mean difference in height from the face goes from {before:.5} to {after:.5}; {folded} \
             triangles fold over, and F2 goes from {f2_before:.1} to {f2_after:.1}. Holds if the difference \
             falls and no triangle folds over, in part if some do"
        ),
    );
}

/// Faces that look away from the viewer of a height field.
fn folded_faces(mesh: &TriMesh) -> usize {
    mesh.topology().faces().filter(|&face| mesh.face_cross(face).z < 0.0).count()
}

fn add_real_claim(item: &mut Item, initial: &TriMesh, results: &[TriMesh; RULES.len()]) {
    let f2 = |mesh| Measures::of(mesh).f2;
    let [before, printed, guarded] = [f2(initial), f2(&results[0]), f2(&results[1])];
    let outcome = match (printed < before, guarded < before) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    };
    item.claim(
        "creases, real face",
        outcome,
        format!(
            "on a scan of 51,712 faces F2 goes from {before:.0} to {printed:.0} by the printed rule, \
             which folds the surface, and to {guarded:.0} with a guard against folds"
        ),
    );
}

fn picture(
    run: &Run<'_>,
    mesh: &TriMesh,
    toward: DVec3,
    edge_width: f64,
    name: &str,
    caption: &str,
) -> Result<Figure, Failure> {
    let view = view_of(mesh, toward, DVec3::Y)?;
    let style = Style { size: [560, 660], edge_width, ..Style::DEFAULT };
    run.picture(mesh, &view, &style, &format!("bar06-face-{name}"), caption)
}
