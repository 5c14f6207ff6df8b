//! Pages to look at: what a command did, as one HTML file.

use std::io::Read;
use std::path::{Path, PathBuf};

use dcurv::{PrincipalFrame, principal_frames};
use glam::DVec3;
use mesh_core::{TriMesh, VertexMap};
use mesh_io::{External, Model};
use mesh_metric::Surface;
use mesh_view::{Directions, Exhibit, Field, On, Page, Section, ViewError};
use serde::Serialize;

use crate::console::Console;
use crate::failure::Failure;
use crate::save::save_bytes;
use crate::task::Report;

/// The option of commands that can show what they did.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Look {
    /// Also make a page on which one can see what was done: a single HTML file that opens offline
    #[arg(long, value_name = "PAGE.html", help_heading = None)]
    view: Option<PathBuf>,
}

impl Look {
    /// Whether a page is wanted.
    pub(crate) fn is_wanted(&self) -> bool {
        self.view.is_some()
    }

    /// Refuses a page for many files.
    pub(crate) fn check(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let is_single = matches!(inputs, [input] if !input.is_dir());
        if self.is_wanted() && !is_single {
            return Err(Failure::usage("--view makes the page of one file; name a single one"));
        }
        Ok(())
    }

    /// Writes the page, with the report of the command on it.
    pub(crate) fn write<T: Serialize>(
        &self,
        mut page: Page,
        report: &Report<T>,
        console: &Console,
    ) -> Result<(), Failure> {
        let Some(path) = &self.view else { return Ok(()) };
        let signed = console.signed(report)?;
        let document = serde_json::from_str(&signed).map_err(Failure::json)?;
        page.report.insert(0, Section::of_json("Report", &document));
        write_page(path, &page, console)
    }
}

/// Writes a page, whole or not at all.
pub(crate) fn write_page(path: &Path, page: &Page, console: &Console) -> Result<(), Failure> {
    for exhibit in &page.exhibits {
        if exhibit.triangles.len() > page.most_faces {
            let (name, faces, most) = (&exhibit.name, exhibit.triangles.len(), page.most_faces);
            console.message(format_args!(
                "{name}: {faces} faces are too many for a page; it shows at most {most}, and says so"
            ));
        }
    }
    save_bytes(path, page.to_html().map_err(refused)?.as_bytes())
}

fn refused(error: ViewError) -> Failure {
    Failure::refused(error)
}

/// The name of a file, for people.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The bytes of a picture that a file names: only of files beside it.
pub(crate) fn picture_beside(path: &Path) -> impl Fn(&str) -> Option<Vec<u8>> + '_ {
    move |name: &str| {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut bytes = Vec::new();
        External::default().open(folder, name).ok()?.read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }
}

/// A mesh with the name of its file.
pub(crate) fn mesh(name: &str, mesh: &TriMesh) -> Exhibit {
    Exhibit::of_mesh(name, mesh)
}

/// What a file holds.
pub(crate) fn content(name: &str, path: &Path, model: &Model) -> Result<Exhibit, Failure> {
    Exhibit::of_model(name, model, picture_beside(path)).map_err(refused)
}

/// The distance of every vertex from a surface.
pub(crate) fn distance_field(exhibit: &Exhibit, to: &Surface) -> Field {
    Field {
        signed: false,
        ..Field::new("distance", On::Vertices, to.distances(&exhibit.positions))
    }
}

/// Both principal directions of the vertices, not seen at first.
pub(crate) fn principal_directions(mesh: &TriMesh) -> Vec<Directions> {
    directions(&principal_frames(mesh))
}

/// The directions of these frames, not seen at first.
pub(crate) fn directions(frames: &VertexMap<Option<PrincipalFrame>>) -> Vec<Directions> {
    let vectors = |of: fn(&PrincipalFrame) -> DVec3| {
        frames.as_slice().iter().map(|frame| frame.as_ref().map(of)).collect()
    };
    let set =
        |name: &str, color, vectors| Directions { name: name.into(), color, vectors, shown: false };
    vec![
        set("Direction of k1", [200, 30, 40], vectors(|f| f.direction_max)),
        set("Direction of k2", [25, 80, 190], vectors(|f| f.direction_min)),
    ]
}
