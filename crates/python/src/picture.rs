//! `curvmesh.render` and `curvmesh.figure`.

use mesh_core::TriMesh;
use mesh_core::glam::DVec3;
use mesh_io::{PictureOptions, Pictures};
use mesh_render::{
    ColorMap, Drawing, Legend, Painting, Picture, Range, ScaleOptions, Scene, SheetOptions, Side,
    Style, Texture, View, draw_svg, render as draw, sheet,
};
use mesh_view::{Sight, Toward, Up, Upright};
use mesh_work::{Source, legend_title};
use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::failure::{Ended, Failure, choose};
use crate::host::{Call, run};
use crate::mesh::MeshData;
use crate::options::angle;

/// From where a mesh is seen.
#[derive(FromPyObject)]
pub(crate) enum Directions {
    Vector([f64; 3]),
    Sides(Vec<String>),
}

/// What is up in the picture.
#[derive(FromPyObject)]
pub(crate) enum UpGiven {
    Vector([f64; 3]),
    Named(String),
}

/// How a mesh is drawn, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct StyleGiven {
    direction: Option<Directions>,
    up: UpGiven,
    size: [u32; 2],
    edges: f64,
    outlines: f64,
    crease: Option<f64>,
    smooth: bool,
    occlusion: f64,
    transparent: bool,
    supersampling: u32,
    plain: bool,
    /// The title of the legend, or empty.
    label: String,
    /// The name of the values, or empty.
    name: String,
    colormap: Option<String>,
    range: String,
    log: bool,
    bar: bool,
}

/// From where a mesh is seen, and what is up.
struct Seen {
    toward: Toward,
    /// `None` stands for what the shape and the place of the mesh say.
    up: Option<Upright>,
}

impl Seen {
    fn sights(&self, mesh: &TriMesh) -> Vec<Sight> {
        let up = self.up.unwrap_or_else(|| {
            let triangles = mesh.topology().triangles().collect::<Vec<_>>();
            Upright::Axis(Up::of_shape(mesh.positions(), &triangles).unwrap_or_default())
        });
        self.toward.sights(up)
    }
}

/// The options that numbers become colours by.
pub(crate) fn scale_options(
    colormap: Option<&str>,
    range: &str,
    log: bool,
) -> Result<ScaleOptions, Failure> {
    let colors = colormap.map(str::parse::<ColorMap>).transpose().map_err(Failure::option)?;
    let range = range.parse::<Range>().map_err(Failure::option)?;
    Ok(ScaleOptions { colors, range, signed: false, log })
}

impl StyleGiven {
    fn seen(&self) -> Result<Seen, Failure> {
        let vector = |name: &str, [x, y, z]: [f64; 3]| match DVec3::new(x, y, z) {
            v if v.is_finite() && v != DVec3::ZERO => Ok(v),
            _ => {
                Err(Failure::option(format!("{name} must have three finite numbers, not all zero")))
            }
        };
        let side = |name: &String| {
            let found = Side::ALL.iter().copied().find(|side| side.name() == name);
            found.ok_or_else(|| {
                let names: Vec<_> = Side::ALL.iter().map(|side| side.name()).collect();
                Failure::option(format!(
                    "there is no side {name:?}; there are {}",
                    names.join(", ")
                ))
            })
        };
        let toward = match &self.direction {
            None => Toward::Usual,
            Some(Directions::Vector(toward)) => Toward::Given(vector("direction", *toward)?),
            Some(Directions::Sides(names)) => {
                Toward::Sides(names.iter().map(side).collect::<Result<_, _>>()?)
            }
        };
        let up = match &self.up {
            UpGiven::Vector(_) if matches!(toward, Toward::Sides(_)) => {
                let axes = "x, y, z, -x, -y, -z or auto";
                return Err(Failure::option(format!("sides turn with an axis; up is {axes}")));
            }
            UpGiven::Vector(up) => Some(Upright::Vector(vector("up", *up)?)),
            UpGiven::Named(name) => {
                let axes = Up::ALL.map(|up| (up.name(), Some(up)));
                let found = choose("up", name, &[&[("auto", None)], &axes[..]].concat())?;
                found.map(Upright::Axis)
            }
        };
        Ok(Seen { toward, up })
    }

    fn title(&self) -> String {
        if self.label.is_empty() { legend_title(&self.name) } else { self.label.clone() }
    }

    fn style(&self) -> Result<Style, Failure> {
        Ok(Style {
            size: self.size,
            smooth: self.smooth,
            edge_width: self.edges,
            silhouette_width: self.outlines,
            crease: angle("crease", self.crease)?,
            background: (!self.transparent).then_some([255; 3]),
            supersampling: self.supersampling,
            occlusion: self.occlusion,
            ..Style::default()
        })
    }
}

/// Values to be shown, as they come from Python: for each vertex or for each face, and whether they are labels.
#[derive(FromPyObject)]
pub(crate) struct ValuesGiven<'py>(String, PyReadonlyArray1<'py, f64>, bool);

/// Values that are shown as colours.
pub(crate) struct Shown {
    pub(crate) on_vertices: bool,
    pub(crate) is_label: bool,
    pub(crate) values: Vec<f64>,
}

impl ValuesGiven<'_> {
    /// The values, checked against the mesh.
    pub(crate) fn of(&self, mesh: &MeshData) -> Result<Shown, Failure> {
        let Self(on, values, is_label) = self;
        let soup = &mesh.model().soup;
        let on_vertices = choose("on", on, &[("vertex", true), ("face", false)])?;
        let expected = if on_vertices { soup.vertex_count() } else { soup.face_count() };
        let found = values.len();
        if found != expected {
            let message =
                format!("there are {found} values; one for each {on} would be {expected}");
            return Err(Failure::new("ArrayError", message));
        }
        let values = values.as_array().to_vec();
        Ok(Shown { on_vertices, is_label: *is_label, values })
    }
}

/// What is drawn, from where, and how.
struct Job {
    shown: Option<Shown>,
    seen: Seen,
    how: Style,
    scale: ScaleOptions,
    plain: bool,
}

impl Job {
    fn new(
        mesh: &MeshData,
        shown: Option<&ValuesGiven<'_>>,
        style: &StyleGiven,
    ) -> Result<Self, Failure> {
        let scale = scale_options(style.colormap.as_deref(), &style.range, style.log)?;
        let shown = shown.map(|shown| shown.of(mesh)).transpose()?;
        Ok(Self { shown, seen: style.seen()?, how: style.style()?, scale, plain: style.plain })
    }

    fn painting(&self, source: Source<'_>) -> Result<Painting, Failure> {
        let (provenance, scale) = (source.provenance, self.scale);
        Ok(match &self.shown {
            Some(Shown { on_vertices, is_label, values }) => match (on_vertices, is_label) {
                (true, true) => Painting::of_vertex_labels(provenance, values),
                (false, true) => Painting::of_face_labels(provenance, values),
                (true, false) => Painting::of_vertex_values(provenance, values, scale),
                (false, false) => Painting::of_face_values(provenance, values, scale),
            },
            None if self.plain => Painting::Plain,
            None => {
                let options = PictureOptions {
                    formats: Texture::FORMATS,
                    are_decoded: true,
                    ..PictureOptions::default()
                };
                let pictures = || Pictures::of_model(source.model, &options);
                Painting::of_content(source.model, provenance, pictures)?
            }
        })
    }
}

/// The view of a mesh from a direction.
fn view_of(source: Source<'_>, sight: &Sight) -> Result<View, Failure> {
    View::of(source.mesh, sight.toward, sight.up)
        .ok_or_else(|| Failure::cannot("the mesh has no faces"))
}

/// The values at the ends of the colours.
fn ends(legend: Option<&Legend>) -> Option<[f64; 2]> {
    legend.and_then(Legend::scale).map(|scale| [scale.low, scale.high])
}

/// The text of an SVG file, its size in pixels, its number of faces, and the values at the ends of the colours.
type Figure = (String, [u32; 2], usize, Option<[f64; 2]>);

/// A picture as vectors.
#[pyfunction]
pub(crate) fn figure(
    py: Python<'_>,
    call: &Call,
    mesh: &MeshData,
    shown: Option<ValuesGiven<'_>>,
    style: StyleGiven,
) -> PyResult<Figure> {
    let job = Job::new(mesh, shown.as_ref(), &style).and_then(|job| match &job.seen.toward {
        Toward::Sides(sides) if sides.len() != 1 => {
            Err(Failure::option("a figure has one view; give one side, or use render"))
        }
        _ => Ok(job),
    });
    let job = job.map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    run(py, call, move |_| -> Result<_, Ended> {
        let source = content.source()?;
        let painting = job.painting(source)?;
        let scene = Scene { paint: painting.paint(), ..Scene::of(source.mesh) };
        let sights = job.seen.sights(source.mesh);
        let sight = sights.first().ok_or_else(|| Failure::option("there is no side"))?;
        let legend = painting.legend();
        let title = style.title();
        let beside = legend.filter(|_| style.bar).map(|legend| (legend, &*title));
        let drawing = draw_svg(&scene, &view_of(source, sight)?, &job.how, beside);
        let Drawing { svg, size, faces, .. } = drawing.map_err(Failure::from)?;
        Ok((svg, size, faces, ends(legend)))
    })
}

/// The bytes of a PNG file, the pixels, and the values at the ends of the colours.
type Drawn<'py> = (Bound<'py, PyBytes>, Bound<'py, PyArray3<u8>>, Option<[f64; 2]>);

/// A picture, with its pixels.
#[pyfunction]
pub(crate) fn render<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    shown: Option<ValuesGiven<'py>>,
    style: StyleGiven,
) -> PyResult<Drawn<'py>> {
    let job = Job::new(mesh, shown.as_ref(), &style).map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let (png, picture, range) = run(py, call, move |_| -> Result<_, Ended> {
        let source = content.source()?;
        let (painting, how) = (job.painting(source)?, &job.how);
        let scene = Scene { paint: painting.paint(), ..Scene::of(source.mesh) };
        let from = |sight: &Sight| -> Result<Picture, Ended> {
            Ok(draw(&scene, &view_of(source, sight)?, how).map_err(Failure::from)?)
        };
        let sights = job.seen.sights(source.mesh);
        let mut picture = if let [sight] = &sights[..] {
            from(sight)?
        } else {
            let view = |sight: &Sight| Ok((from(sight)?, sight.name.to_owned()));
            let views = sights.iter().map(view).collect::<Result<Vec<_>, Ended>>()?;
            let options = SheetOptions { background: how.background, ..Default::default() };
            sheet(&views, &options).map_err(Failure::from)?
        };
        let legend = painting.legend();
        if let Some(legend) = legend.filter(|_| style.bar) {
            let whole = legend.beside(&picture, &style.title(), how.background);
            picture = whole.map_err(Failure::from)?;
        }
        let png = picture.to_png().map_err(Failure::from)?;
        Ok((png, picture, ends(legend)))
    })?;
    let shape = [picture.height() as usize, picture.width() as usize, 4];
    let pixels: Vec<u8> = picture.pixels().as_flattened().to_vec();
    let pixels = pixels.into_pyarray(py).reshape(shape)?;
    Ok((PyBytes::new(py, &png), pixels, range))
}
