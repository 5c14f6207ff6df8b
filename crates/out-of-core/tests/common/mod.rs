//! Meshes for the tests, and runs on them.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use mesh_core::{PolygonSoup, TriMesh};
use mesh_io::{ReadOptions, WriteOptions};
use out_of_core::{Capacity, Error, Input, Outcome, Repairs, Settings, Step, Work, run};
use simplify::{Options, Preset};

/// A torus of about `faces` faces, with bumps of several sizes. `seed` selects a variant.
pub(crate) fn torus(faces: usize, seed: u64) -> TriMesh {
    let shift = seed as f64;
    let rows = ((faces as f64 / 5.0).sqrt().round() as usize).max(3);
    let columns = (faces as f64 / 2.0 / rows as f64).round().max(3.0) as usize;
    let mut soup = PolygonSoup::new();
    for column in 0..columns {
        for row in 0..rows {
            let u = TAU * row as f64 / rows as f64;
            let v = TAU * column as f64 / columns as f64;
            let mut tube = 1.0;
            for octave in 0..4 {
                let n = f64::from(1 << octave);
                let wave = (3.0 * n * u + 1.7 * n + shift).sin() * (5.0 * n * v + shift * n).cos();
                tube += 0.12 / n.powf(1.3) * wave;
            }
            let radius = 2.5 + tube * u.cos();
            soup.push_vertex([radius * v.cos(), radius * v.sin(), tube * u.sin()]);
        }
    }
    let at = |row: usize, column: usize| (column % columns * rows + row % rows) as u32;
    for column in 0..columns {
        for row in 0..rows {
            let [a, b] = [at(row, column), at(row + 1, column)];
            let [c, d] = [at(row + 1, column + 1), at(row, column + 1)];
            soup.push_face(&[a, d, c]).unwrap();
            soup.push_face(&[a, c, b]).unwrap();
        }
    }
    TriMesh::from_soup(&soup).unwrap()
}

/// An open variant: some faces at one side are missing.
pub(crate) fn open_torus(faces: usize, seed: u64) -> TriMesh {
    let whole = torus(faces, seed);
    let triangles: Vec<[u32; 3]> = whole
        .topology()
        .triangles()
        .filter(|t| t.iter().all(|&v| whole.positions()[v as usize].x < 2.6))
        .collect();
    let mut soup = PolygonSoup::new();
    whole.positions().iter().for_each(|&p| {
        soup.push_vertex(p);
    });
    triangles.iter().for_each(|t| soup.push_face(t).unwrap());
    let mut repair = mesh_core::Repair::strict();
    repair.drop_unreferenced = true;
    repair.cut_non_manifold = true;
    mesh_core::build(&soup, &repair).unwrap().mesh
}

pub(crate) fn write(mesh: &TriMesh, path: &Path) -> PathBuf {
    mesh_io::write(path, mesh, &WriteOptions::default()).unwrap();
    path.to_owned()
}

/// Settings with regions of `region_faces` faces, and this number of faces for the rest in memory.
pub(crate) fn settings(
    preset: Preset,
    faces: usize,
    region_faces: u64,
    in_memory_faces: u64,
) -> Settings {
    Settings {
        options: Options::preset(preset).to_faces(faces),
        finer_levels: Vec::new(),
        repairs: Repairs::default(),
        capacity: Capacity { region_faces, in_memory_faces, stream: 1 << 20 },
        prove: None,
    }
}

pub(crate) fn split(folder: &Path, input: &Path, settings: &Settings) -> Result<Work, Error> {
    let reading = ReadOptions::default();
    Work::split(folder, Input::Path(input), &reading, settings.clone(), &mut |_| true)
}

/// The result of a run.
#[derive(Debug)]
pub(crate) struct Done {
    pub(crate) mesh: TriMesh,
    pub(crate) levels: Vec<u64>,
    pub(crate) cells: Vec<u32>,
    pub(crate) error: Option<f64>,
}

impl From<Outcome> for Done {
    fn from(outcome: Outcome) -> Self {
        let (levels, cells, error) = (outcome.levels.clone(), outcome.cells.clone(), outcome.error);
        Self { mesh: outcome.into_mesh().unwrap(), levels, cells, error }
    }
}

pub(crate) fn simplify(folder: &Path, input: &Path, settings: &Settings) -> Result<Done, Error> {
    run(&split(folder, input, settings)?, &mut |_: Step| true).map(Done::from)
}

/// All bits of a mesh.
pub(crate) fn bits(mesh: &TriMesh) -> (Vec<[u64; 3]>, Vec<[u32; 3]>) {
    let positions = mesh.positions().iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    (positions, mesh.topology().triangles().collect())
}
