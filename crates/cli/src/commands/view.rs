//! `curvmesh view`: a page with interactive 3D views of meshes.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use dcurv::{CurvatureOptions, Curvatures, VertexCurvature};
use mesh_view::{Exhibit, Field, Layout, On, Page, Precision, Up};
use serde::Serialize;

use crate::args::{is_standard, parse_elements, parse_page};
use crate::colormap::ColorOptions;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::{Loading, Seconds};
use crate::session::{Outcome, Session};
use crate::task::Report;
use crate::text::printable;
use crate::view::{self, name_of};

/// Make a page with interactive 3D views of meshes: one HTML file that opens offline
///
/// Files are shown as they are, polygons and defects included, with every property as colours, the
/// values under the pointer, materials, and lines for boundaries and for non-manifold and sharp
/// edges. Properties of integers are labels: each value has a colour of its own, unless --colormap or --range is
/// given. Several meshes share one camera. The page does not use the network.
///
///     curvmesh view scan.ply
///     curvmesh view scan.ply -o page.html
///     curvmesh view before.ply after.ply -o compare.html --layout wipe
///     curvmesh view part.stl -o part.html --curvature --color mean_curvature
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct View {
    /// The files to show; `-` is the standard input
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// The page; `-` is the standard output [default: the name of the first input with .html, shown in
    /// the browser where there is one]
    #[arg(short, long, value_name = "PAGE.html", value_parser = parse_page())]
    output: Option<PathBuf>,
    /// The title of the page [default: the names of the files]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// How several meshes are arranged at first
    #[arg(long, value_enum, default_value_t)]
    layout: LayoutName,
    /// The axis that points up: x, y, z, -x, -y, -z or auto. `auto` is y for glTF, the visible side of sheets such as
    /// terrain, z for surveys, the side on which a mesh stands if there is only one, z for other STL files, and y otherwise
    #[arg(long, value_name = "AXIS", default_value = "auto", allow_hyphen_values = true, value_parser = parse_up)]
    up: UpGiven,
    /// The property that is shown at first; `component` for a colour per component, `plain` for none
    #[arg(long, value_name = "NAME")]
    color: Option<String>,
    /// Also compute curvatures and principal directions of the vertices
    #[arg(long)]
    curvature: bool,
    /// Store positions as 32-bit numbers instead of 65,536 steps along each side
    #[arg(long)]
    exact_positions: bool,
    /// Simplify meshes with more faces than this for the page
    #[arg(long, value_name = "N", default_value_t = Page::MOST_FACES, value_parser = parse_elements)]
    most_faces: usize,
    #[command(flatten)]
    colors: ColorOptions,
    #[command(flatten)]
    loading: Loading,
}

/// The axis that points up; `None` for `auto`.
pub(crate) type UpGiven = Option<Up>;

pub(crate) fn parse_up(text: &str) -> Result<UpGiven, String> {
    let found = Up::ALL.into_iter().find(|up| up.name() == text);
    if found.is_none() && text != "auto" {
        return Err("it is one of x, y, z, -x, -y, -z and auto".into());
    }
    Ok(found)
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum LayoutName {
    /// Side by side, with one camera
    #[default]
    Side,
    /// One over the other, with a border that can be moved
    Wipe,
    /// In turns
    Blink,
    /// One of them
    One,
}

impl From<LayoutName> for Layout {
    fn from(name: LayoutName) -> Self {
        match name {
            LayoutName::Side => Self::Side,
            LayoutName::Wipe => Self::Wipe,
            LayoutName::Blink => Self::Blink,
            LayoutName::One => Self::One,
        }
    }
}

#[derive(Serialize)]
struct Results {
    meshes: usize,
    /// The files whose content is on the page.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    embedded_files: Vec<String>,
}

pub(crate) fn run(options: &View, session: &Session) -> Result<Outcome, Failure> {
    if options.inputs.iter().filter(|input| is_standard(input)).count() > 1 {
        return Err(Failure::usage("the standard input `-` can be one of the files only"));
    }
    let output = &match &options.output {
        Some(output) => output.clone(),
        None => page_beside(&options.inputs[0])?,
    };
    let console = &*session.console.beside(Some(output))?;
    let mut seconds = Seconds::default();
    let exhibits: Result<Vec<_>, Failure> = Seconds::time(&mut seconds.load, || {
        options.inputs.iter().map(|input| options.exhibit(input, console)).collect()
    });
    let page = options.page(exhibits?)?;
    let counts = |count: fn(&Exhibit) -> usize| page.exhibits.iter().map(count).sum::<usize>();
    let counts = [counts(|e| e.positions.len()), counts(|e| e.triangles.len())];
    Seconds::time(&mut seconds.save, || view::write_page(output, &page, console))?;
    let embedded_files = view::embedded_files(&page).into_iter().map(str::to_owned).collect();
    let results = Results { meshes: page.exhibits.len(), embedded_files };
    let report =
        Report::new(console, &options.inputs[0], counts, results, seconds).with_output(output);
    let text = format!("{}: {}", report.subject(), counted(report.faces, "faces"));
    report.done(console, text, String::new())?.print(console)?;
    if options.output.is_none() && has_display() {
        // The page is written and named, so a browser that does not start is not an error.
        if let Err(error) = open::that_detached(output) {
            console.message(format_args!("the browser did not start: {error}"));
        }
    }
    Ok(Outcome::Done)
}

/// A function of the curvature of a vertex.
type Quantity = fn(&VertexCurvature) -> f64;

/// Whether there may be a browser that can show a page.
fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

/// The page beside an input. Only a page made by this program is replaced.
fn page_beside(input: &Path) -> Result<PathBuf, Failure> {
    if is_standard(input) {
        return Err(Failure::usage("say where the page goes: -o PAGE.html"));
    }
    let path = input.with_extension("html");
    match view::is_page(&path) {
        Ok(true) => Ok(path),
        Ok(false) => Err(Failure::usage(format!(
            "{}: this file is no page of curvmesh; say where the page goes: -o PAGE.html",
            printable(path.display())
        ))),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(path),
        Err(error) => Err(Failure::write(&path, error)),
    }
}

impl View {
    fn exhibit(&self, path: &Path, console: &Console) -> Result<Exhibit, Failure> {
        let name = name_of(path);
        if !self.curvature {
            let model = self.loading.finite_content(path, console)?;
            return view::content(&name, path, &model, &self.loading);
        }
        let loaded = self.loading.load(path, console)?;
        let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
        let mut exhibit = view::content(&name, path, &model, &self.loading)?;
        let curvatures = Curvatures::of(&loaded.mesh, &CurvatureOptions::default());
        let quantities: [(&str, Quantity); 6] = [
            ("mean_curvature", |c| c.mean().value()),
            ("gaussian_curvature", |c| c.gaussian().value()),
            ("k1", |c| c.principal()[0].value()),
            ("k2", |c| c.principal()[1].value()),
            ("shape_index", VertexCurvature::shape_index),
            ("curvedness", |c| c.curvedness().value()),
        ];
        for (name, quantity) in quantities {
            exhibit.fields.retain(|field| field.name != name);
            let values = curvatures.map(quantity).into_vec();
            exhibit.fields.push(Field::new(name, On::Vertices, values));
        }
        view::set_units(&mut exhibit.fields);
        exhibit.directions = view::principal_directions(&loaded.mesh);
        Ok(exhibit)
    }

    fn page(&self, exhibits: Vec<Exhibit>) -> Result<Page, Failure> {
        let names = exhibits.iter().map(|e| &*e.name).collect::<Vec<_>>().join(", ");
        let mut page = Page::new(self.title.clone().unwrap_or(names), exhibits);
        page.layout = self.layout.into();
        page.start.up = self.up.unwrap_or_else(|| view::usual_up(&self.inputs[0], &page.exhibits));
        page.most_faces = self.most_faces.max(1);
        if self.exact_positions {
            page.precision = Precision::Single;
        }
        page.start.map = self.colors.colormap;
        page.start.range = self.colors.given_range();
        if let Some(color) = &self.color {
            let fields = || page.exhibits.iter().flat_map(|e| &e.fields);
            let mut key = fields().find(|field| field.name == *color).map(Field::key);
            if key.is_none() && color == "component" {
                if !page.exhibits.iter().any(Exhibit::has_components) {
                    return Err(Failure::usage("no mesh has several components"));
                }
                key = Some(Exhibit::COMPONENTS.into());
            }
            if key.is_none() && color != "plain" {
                let mut names: Vec<&str> = fields().map(|field| &*field.name).collect();
                names.sort_unstable();
                names.dedup();
                let names = if names.is_empty() { "none".into() } else { names.join(", ") };
                return Err(Failure::usage(format!(
                    "there is no property {color}; there are: {names}"
                )));
            }
            page.start.color = Some(key.unwrap_or_else(|| color.clone()));
        } else if self.curvature {
            let mean =
                |e: &Exhibit| e.fields.iter().find(|f| f.name == "mean_curvature").map(Field::key);
            page.start.color = page.exhibits.iter().find_map(mean);
        }
        Ok(page)
    }
}
