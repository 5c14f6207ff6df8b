//! Dyn, Hormann, Kim, Levin 2001: the torus of Table 1 and Fig. 5, and what they share with the
//! other figures.

mod look_ahead;
mod models;
mod seven_points;
mod subdivided;
mod tie_orders;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions, FlipReport, LatticeError, Ties, lattice_error};
use glam::DVec3;
use mesh_core::shapes::{SignedDistance, Torus};
use mesh_core::{BoundingBox, PolygonSoup, Repair, TriMesh, build};
use mesh_io::{Model, WriteOptions};

use super::Step;
use super::item::{Figure, Item, Row};
use super::published::Paper;
use crate::failure::Failure;
use crate::render::{Style, View, render};

pub(super) const STEPS: [Step; 6] = [
    ("Table 1", table_1),
    (tie_orders::NAME, tie_orders::item),
    (look_ahead::NAME, look_ahead::item),
    (seven_points::NAME, seven_points::item),
    (subdivided::NAME, subdivided::item),
    (models::NAME, models::item),
];

/// The paper's torus: m = 12, n = 6, R = 5, r = 2.
const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };
/// Steps of the lattice on each side of a triangle, recovered from the initial row of the table.
const SUBDIVISIONS: u32 = 100;

/// One row of Table 1 and the setting that gives it.
struct Setting {
    row: &'static str,
    /// `None` leaves the initial triangulation.
    cost: Option<CostName>,
    area: VertexArea,
    ties: Ties,
    how: &'static str,
}

const SETTINGS: [Setting; 4] = [
    Setting {
        row: "initial",
        cost: None,
        area: VertexArea::Voronoi,
        ties: Ties::EdgeId,
        how: "as given",
    },
    Setting {
        row: "F1",
        cost: Some(CostName::F1),
        area: VertexArea::Voronoi,
        // Exact ties decide which of two local minima is reached; this order reaches the paper's.
        ties: Ties::Seeded(F1_TIE_SEED),
        how: "F1: integral of H², Voronoi areas",
    },
    Setting {
        row: "F2",
        cost: Some(CostName::F2),
        area: VertexArea::Voronoi,
        ties: Ties::EdgeId,
        how: "F2: integral of |H|",
    },
    Setting {
        row: "F3",
        cost: Some(CostName::F3),
        area: VertexArea::Barycentric,
        ties: Ties::EdgeId,
        how: "F3: integral of |k1| + |k2|, barycentric areas",
    },
];

/// The smallest seed whose order of ties leads F1 to the minimum that the paper prints.
const F1_TIE_SEED: u64 = 2;

/// Table 1 and Fig. 5: the distance to the torus before and after optimisation.
fn table_1(paper: &Paper, out: &Path) -> Result<Item, Failure> {
    let mut rows = Vec::new();
    let mut figures = Vec::new();
    for setting in &SETTINGS {
        let mesh = optimised(setting)?;
        for (norm, value) in norms(&distance_to_torus(&mesh, SUBDIVISIONS)) {
            rows.push(Row::new(paper, "Table 1", &format!("{}, {norm}", setting.row), value));
        }
        figures.push(figure(&mesh, setting, out)?);
    }
    Ok(Item {
        paper: paper.short.clone(),
        name: "Table 1".into(),
        about: "72 points of a torus with radii 5 and 2, triangulated as in the paper and after \
                edge flips: mean, root mean square and maximum distance to the torus, over the \
                points of a lattice of 100 steps per side on every triangle, each point counted \
                once."
            .into(),
        needs: None,
        rows,
        figures,
        functions: vec!["dtri_flip::optimise", "dtri_flip::lattice_error"],
        command: "curvmesh flip IN -o OUT --cost f2",
    })
}

/// The initial torus, or the optimised one.
fn optimised(setting: &Setting) -> Result<TriMesh, Failure> {
    let mut mesh = paper_torus()?;
    if let Some(cost) = setting.cost {
        let options = FlipOptions { ties: setting.ties, ..FlipOptions::default() };
        optimise(&mut mesh, cost, setting.area, &options)?;
    }
    Ok(mesh)
}

fn paper_torus() -> Result<TriMesh, Failure> {
    mesh_of(&TORUS.shifted_mesh(12, 6).map_err(Failure::mesh)?)
}

fn mesh_of(soup: &PolygonSoup) -> Result<TriMesh, Failure> {
    Ok(build(soup, &Repair::strict()).map_err(Failure::mesh)?.mesh)
}

fn optimise(
    mesh: &mut TriMesh,
    cost: CostName,
    area: VertexArea,
    options: &FlipOptions,
) -> Result<FlipReport, Failure> {
    let go_on = &mut |_| ControlFlow::Continue(());
    cost.optimise(mesh, area, options, go_on).map_err(Failure::mesh)
}

/// The three norms of the paper's table, by their names there.
fn norms(error: &LatticeError) -> [(&'static str, f64); 3] {
    [("L1", error.mean), ("L2", error.rms), ("Linf", error.max)]
}

fn distance_to_torus(mesh: &TriMesh, subdivisions: u32) -> LatticeError {
    lattice_error(mesh, subdivisions, |p| TORUS.signed_distance(p))
}

/// Draws the torus with its edges, from the same side each time.
fn figure(mesh: &TriMesh, setting: &Setting, out: &Path) -> Result<Figure, Failure> {
    let style = Style { size: [900, 760], smooth: false, edge_width: 2.0 };
    let name = format!("dhkl01-torus-{}", setting.row.to_lowercase());
    picture(mesh, &torus_view(mesh)?, &style, &name, setting.how, out)
}

fn torus_view(mesh: &TriMesh) -> Result<View, Failure> {
    Ok(View { toward: DVec3::new(0.0, -0.75, 1.0), up: DVec3::Y, bounds: bounds(mesh)? })
}

fn bounds(mesh: &TriMesh) -> Result<BoundingBox, Failure> {
    mesh.bounding_box().ok_or(Failure::Usage("the mesh has no faces".into()))
}

/// Draws a mesh to `name.png` and keeps it as `name.ply`.
fn picture(
    mesh: &TriMesh,
    view: &View,
    style: &Style,
    name: &str,
    caption: &str,
    out: &Path,
) -> Result<Figure, Failure> {
    let file = PathBuf::from(name).with_extension("png");
    let path = out.join(&file);
    render(mesh, None, view, style)
        .save(&path)
        .map_err(|source| Failure::Picture { path, source: Box::new(source) })?;
    let mesh_file = PathBuf::from(name).with_extension("ply");
    save_mesh(mesh, &out.join(&mesh_file))?;
    Ok(Figure { caption: caption.into(), file, mesh: mesh_file })
}

fn save_mesh(mesh: &TriMesh, path: &Path) -> Result<(), Failure> {
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let soup = PolygonSoup::from_triangles(mesh.positions(), &triangles).map_err(Failure::mesh)?;
    mesh_io::write(path, &Model::from(soup), &WriteOptions::default()).map_err(Failure::mesh)?;
    Ok(())
}
