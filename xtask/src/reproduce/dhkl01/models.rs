//! Fig. 7 to 9: scanned and technical models before and after minimising F2.
//!
//! The paper's own models are not public; these are of the same kinds and come from the folder
//! that `CURVMESH_MODELS` names.

use std::path::{Path, PathBuf};

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};
use glam::DVec3;
use mesh_core::{Repair, TriMesh, build};

use super::super::item::{Figure, Item, Row};
use super::super::published::Paper;
use super::{bounds, optimise, picture};
use crate::failure::Failure;
use crate::render::{Style, View};

pub(super) const NAME: &str = "Fig. 7 to 9";

/// The environment variable with the folder of the models.
const FOLDER: &str = "CURVMESH_MODELS";

struct Case {
    file: &'static str,
    name: &'static str,
    toward: DVec3,
    up: DVec3,
}

const CASES: [Case; 3] = [
    Case { file: "face_52k.obj", name: "face", toward: DVec3::new(0.3, 0.1, 1.0), up: DVec3::Y },
    Case { file: "fandisk.obj", name: "fandisk", toward: DVec3::new(0.6, 0.5, -1.0), up: DVec3::Y },
    Case { file: "casting.off", name: "casting", toward: DVec3::new(0.3, 1.0, 0.6), up: DVec3::Y },
];

/// F2 before and after, and both pictures, for every model.
pub(super) fn item(paper: &Paper, out: &Path) -> Result<Item, Failure> {
    let mut item = Item {
        paper: paper.short.clone(),
        name: NAME.into(),
        about:
            "A head, a technical part and a casting, in place of the paper's models, before and \
                after minimising F2, drawn with one normal per face. The paper shows pictures only."
                .into(),
        needs: None,
        rows: Vec::new(),
        figures: Vec::new(),
        functions: vec!["dtri_flip::optimise"],
        command: "curvmesh flip IN -o OUT --cost f2",
    };
    let paths = match std::env::var_os(FOLDER) {
        Some(folder) => CASES.map(|case| PathBuf::from(&folder).join(case.file)),
        None => {
            item.needs = Some(format!("needs a model: set {FOLDER} to the folder of the models"));
            return Ok(item);
        }
    };
    for (case, path) in CASES.iter().zip(&paths) {
        if !path.exists() {
            item.needs = Some(format!("needs a model: {FOLDER} has no {}", case.file));
            continue;
        }
        add(&mut item, paper, case, path, out)?;
    }
    Ok(item)
}

fn add(
    item: &mut Item,
    paper: &Paper,
    case: &Case,
    path: &Path,
    out: &Path,
) -> Result<(), Failure> {
    let model = mesh_io::read(path).map_err(Failure::reading(path))?;
    let mut mesh = build(&model.soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh;
    item.figures.push(figure(&mesh, case, "before", out)?);
    let options = FlipOptions::default();
    let report = optimise(&mut mesh, CostName::F2, VertexArea::Voronoi, &options)?;
    item.figures.push(figure(&mesh, case, "after", out)?);
    let numbers = [
        ("F2 before", report.cost_before),
        ("F2 after", report.cost_after),
        ("flips", report.flips as f64),
    ];
    for (quantity, value) in numbers {
        item.rows.push(Row::new(paper, NAME, &format!("{}, {quantity}", case.name), value));
    }
    Ok(())
}

fn figure(mesh: &TriMesh, case: &Case, when: &str, out: &Path) -> Result<Figure, Failure> {
    let view = View { toward: case.toward, up: case.up, bounds: bounds(mesh)? };
    let style = Style { size: [900, 760], smooth: false, edge_width: 0.0 };
    let name = format!("dhkl01-{}-{when}", case.name);
    picture(mesh, &view, &style, &name, &format!("{}, {when} minimising F2", case.name), out)
}
