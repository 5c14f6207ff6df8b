//! Fig. 7 to 9: scanned and technical models before and after minimising F2.
//!
//! The paper's own models are not public; these are of the same kinds.

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};
use glam::DVec3;
use mesh_core::TriMesh;

use super::super::item::{Figure, Item};
use super::super::run::{Run, view_of};
use super::optimise;
use crate::failure::Failure;
use crate::render::Style;

struct Case {
    file: &'static str,
    name: &'static str,
    toward: DVec3,
    up: DVec3,
}

const CASES: [Case; 4] = [
    Case { file: "face_52k.obj", name: "face", toward: DVec3::new(0.3, 0.1, 1.0), up: DVec3::Y },
    Case { file: "fandisk.obj", name: "fandisk", toward: DVec3::new(0.6, 0.5, -1.0), up: DVec3::Y },
    Case { file: "casting.off", name: "casting", toward: DVec3::new(0.3, 1.0, 0.6), up: DVec3::Y },
    Case {
        file: "anchor_dense.off",
        name: "anchor",
        toward: DVec3::new(0.5, 0.6, 1.0),
        up: DVec3::Y,
    },
];

/// F2 before and after, and both pictures, for every model.
pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "A head, a technical part and a casting before and after minimising F2, drawn with one \
         normal per face. The paper shows pictures only.",
    );
    item.stand_in(
        "In place of the paper's head, technical part and tank cap, which are not public.",
    );
    item.how(&["dtri_flip::optimise"], &["curvmesh flip IN -o OUT --cost f2"]);
    for case in &CASES {
        if let Some(mesh) = run.model(item, case.file)? {
            add(run, item, case, mesh)?;
        }
    }
    Ok(())
}

fn add(run: &Run<'_>, item: &mut Item, case: &Case, mut mesh: TriMesh) -> Result<(), Failure> {
    let before = figure(run, &mesh, case, "before")?;
    let options = FlipOptions::default();
    let report = optimise(&mut mesh, CostName::F2, VertexArea::Voronoi, &options)?;
    item.side_by_side([before, figure(run, &mesh, case, "after")?]);
    let numbers = [
        ("F2 before", report.cost_before),
        ("F2 after", report.cost_after),
        ("flips", report.flips as f64),
    ];
    for (quantity, value) in numbers {
        item.number(format!("{}, {quantity}", case.name), value);
    }
    Ok(())
}

fn figure(run: &Run<'_>, mesh: &TriMesh, case: &Case, when: &str) -> Result<Figure, Failure> {
    let view = view_of(mesh, case.toward, case.up)?;
    let style = Style { size: [720, 600], smooth: false, edge_width: 0.0 };
    let name = format!("dhkl01-{}-{when}", case.name);
    run.picture(mesh, &view, &style, &name, &format!("{}, {when} minimising F2", case.name))
}
