//! Pages that show the result of a command, as one HTML file.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use dcurv::{PrincipalFrame, principal_frames};
use glam::DVec3;
use mesh_core::{TriMesh, VertexMap};
use mesh_io::{Format, Model, PictureError, Pictures};
use mesh_metric::{Surface, SurfaceError, face_distances};
use mesh_view::{Directions, Exhibit, Field, GENERATOR, On, Page, Section, Up, ViewError};
use mesh_work::Quantity;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::args::parse_page;
use crate::console::Console;
use crate::failure::Failure;
use crate::load::Loading;
use crate::save::save_bytes;
use crate::task::Report;
use crate::text::{printable, printable_start};

/// The option of commands that can show what they did.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Look {
    /// Also make a page that shows the result: a single HTML file that opens offline
    #[arg(long, value_name = "PAGE.html", help_heading = None, value_parser = parse_page())]
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
        let [results, settings] = sections(serde_json::from_str(&signed).map_err(Failure::json)?);
        page.report.insert(0, results);
        page.report.push(settings);
        page.start.up = usual_up(report.input(), &page.exhibits);
        write_page(path, &page, console)
    }
}

/// The parts of a report that say how a result was made.
const SETTINGS: [&str; 8] =
    ["tool", "version", "command", "input", "output", "preset", "settings", "options"];

/// The results in a report, and all settings, which are folded.
fn sections(report: Map<String, Value>) -> [Section; 2] {
    let (settings, results): (Map<_, _>, Map<_, _>) =
        report.into_iter().partition(|(name, _)| SETTINGS.contains(&name.as_str()));
    let settings = Section::of_json("All settings", &Value::Object(settings));
    [Section::of_json("Report", &Value::Object(results)), Section { folded: true, ..settings }]
}

/// Whether a file is a page made by this program.
pub(crate) fn is_page(path: &Path) -> std::io::Result<bool> {
    let mut head = Vec::new();
    File::open(path)?.take(1024).read_to_end(&mut head)?;
    Ok(head.windows(GENERATOR.len()).any(|part| part == GENERATOR.as_bytes()))
}

/// The axis that points up in a file: as its format says, or its shape and place.
pub(crate) fn usual_up(path: &Path, exhibits: &[Exhibit]) -> Up {
    let shape = |exhibit: &Exhibit| Up::of_shape(&exhibit.positions, &exhibit.triangles);
    up_of(path, || exhibits.first().and_then(shape))
}

/// The axis that points up in a file: as its format says, or the given function for its shape and place.
pub(crate) fn up_of(path: &Path, of_shape: impl Fn() -> Option<Up>) -> Up {
    match Format::from_extension(path) {
        Some(Format::Gltf | Format::Glb) => Up::Y,
        Some(Format::Stl) => of_shape().unwrap_or(Up::Z),
        _ => of_shape().unwrap_or_default(),
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
    say_pictures(page, console);
    save_bytes(path, page.to_html().map_err(refused)?.as_bytes())
}

fn refused(error: ViewError) -> Failure {
    Failure::refused(error)
}

/// The name of a file, for people.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The files whose content is on a page, each name once.
pub(crate) fn embedded_files(page: &Page) -> Vec<&str> {
    let materials = page.exhibits.iter().filter_map(|exhibit| exhibit.materials.as_ref());
    let pictures = materials.flat_map(|materials| &materials.pictures);
    let mut names: Vec<&str> =
        pictures.filter(|picture| picture.is_file).map(|picture| &*picture.name).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Reports which files are on a page, and which pictures are not.
fn say_pictures(page: &Page, console: &Console) {
    let names = embedded_files(page);
    if !names.is_empty() {
        let names: Vec<String> = names.into_iter().map(printable).collect();
        console.message(format_args!("the page holds the files {}", names.join(", ")));
    }
    let materials = page.exhibits.iter().filter_map(|exhibit| exhibit.materials.as_ref());
    say_left_out(materials.flat_map(|materials| &materials.left_out), console);
}

/// Reports which pictures were omitted, each name once.
pub(crate) fn say_left_out<'p>(
    left_out: impl IntoIterator<Item = &'p (String, PictureError)>,
    console: &Console,
) {
    /// Only this number of names is printed.
    const MOST_NAMES: usize = 8;
    let mut left_out: Vec<&(String, PictureError)> = left_out.into_iter().collect();
    left_out.sort_by(|a, b| a.0.cmp(&b.0));
    left_out.dedup_by(|a, b| a.0 == b.0);
    for (name, reason) in left_out.iter().take(MOST_NAMES) {
        let (name, reason) = (printable_start(name), printable(reason));
        console.message(format_args!("left out the picture {name}: {reason}"));
    }
    if let Some(more @ 1..) = left_out.len().checked_sub(MOST_NAMES) {
        console.message(format_args!("left out {more} more pictures"));
    }
}

/// A mesh with the name of its file.
pub(crate) fn mesh(name: &str, mesh: &TriMesh) -> Exhibit {
    Exhibit::of_mesh(name, mesh)
}

/// The content of a file.
pub(crate) fn content(
    name: &str,
    path: &Path,
    model: &Model,
    loading: &Loading,
) -> Result<Exhibit, Failure> {
    let pictures = Pictures::of_model(model, &loading.pictures(path));
    Exhibit::of_model(name, model, pictures).map_err(refused)
}

/// The largest distance from a surface that each face has at its corners and inside, measured at about this many points.
pub(crate) fn largest_distances(
    exhibit: &Exhibit,
    to: &Surface,
    points: usize,
) -> Result<Field, SurfaceError> {
    let from = Surface::from_triangles(&exhibit.positions, &exhibit.triangles)?;
    let values = face_distances(&from, to, points);
    let field = Field::new("largest distance in face", On::Faces, values);
    Ok(Field { signed: false, unit: MODEL_UNITS.into(), ..field })
}

/// About this number of points measure the distances inside faces.
pub(crate) const ON_FACES: usize = 200_000;

/// Puts the distances from a surface in front of the other fields: of the vertices, and inside faces.
pub(crate) fn add_distances(exhibit: &mut Exhibit, to: &Surface) -> Result<(), SurfaceError> {
    let fields = [distance_field(exhibit, to), largest_distances(exhibit, to, ON_FACES)?];
    exhibit.fields.retain(|field| fields.iter().all(|new| new.name != field.name));
    exhibit.fields.splice(0..0, fields);
    Ok(())
}

/// The distance of every vertex from a surface.
fn distance_field(exhibit: &Exhibit, to: &Surface) -> Field {
    Field {
        signed: false,
        unit: MODEL_UNITS.into(),
        ..Field::new("distance", On::Vertices, to.distances(&exhibit.positions))
    }
}

/// The unit of lengths.
pub(crate) const MODEL_UNITS: &str = "model units";

/// Tells the units of curvatures.
pub(crate) fn set_units(fields: &mut [Field]) {
    for field in fields {
        if let Some(quantity) = Quantity::of_property(&field.name) {
            field.unit = quantity.unit().into();
        }
    }
}

/// Both principal directions of the vertices, initially hidden.
pub(crate) fn principal_directions(mesh: &TriMesh) -> Vec<Directions> {
    directions(&principal_frames(mesh))
}

/// These directions, initially hidden.
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
