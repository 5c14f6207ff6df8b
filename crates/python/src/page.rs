//! `curvmesh.view`: a page with interactive 3D views of meshes.

use mesh_core::glam::DVec3;
use mesh_io::{PictureOptions, Pictures};
use mesh_render::ColorMap;
use mesh_view::{Directions, Exhibit, Field, Layout, On, Page, Precision, Section, Up};
use numpy::PyReadonlyArray3;
use pyo3::prelude::*;

use crate::failure::{Ended, Failure, choose};
use crate::host::{Call, run};
use crate::mesh::MeshData;
use crate::picture::{Shown, ValuesGiven};

/// A mesh on the page, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ExhibitGiven<'py> {
    name: String,
    mesh: PyRef<'py, MeshData>,
    /// More values by name.
    values: Vec<(String, ValuesGiven<'py>)>,
    /// Two directions at every vertex.
    directions: Option<PyReadonlyArray3<'py, f64>>,
}

/// What the page starts with, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PageGiven {
    title: String,
    layout: String,
    up: String,
    color: Option<String>,
    colormap: Option<String>,
    range: Option<[f64; 2]>,
    smooth: Option<bool>,
    edges: Option<bool>,
    exact_positions: bool,
    most_faces: usize,
    /// Tables of names and values.
    report: Vec<(String, Vec<(String, String)>)>,
}

struct Told {
    name: String,
    content: std::sync::Arc<crate::content::Content>,
    values: Vec<(String, Shown)>,
    directions: Option<Vec<[Option<DVec3>; 2]>>,
}

impl ExhibitGiven<'_> {
    fn told(self) -> Result<Told, Failure> {
        let mesh = &*self.mesh;
        let field = |(name, given): &(String, ValuesGiven<'_>)| Ok((name.clone(), given.of(mesh)?));
        let values = self.values.iter().map(field).collect::<Result<Vec<_>, Failure>>()?;
        let directions = match &self.directions {
            Some(array) => Some(directions(array, mesh.model().soup.vertex_count())?),
            None => None,
        };
        Ok(Told { name: self.name, content: mesh.content(), values, directions })
    }
}

fn directions(
    array: &PyReadonlyArray3<'_, f64>,
    vertices: usize,
) -> Result<Vec<[Option<DVec3>; 2]>, Failure> {
    let array = array.as_array();
    if array.shape() != [vertices, 2, 3] {
        let message =
            format!("directions have the shape {:?}; it must be ({vertices}, 2, 3)", array.shape());
        return Err(Failure::new("ArrayError", message));
    }
    let vector = |v: usize, k: usize| {
        let vector = DVec3::new(array[[v, k, 0]], array[[v, k, 1]], array[[v, k, 2]]);
        Some(vector).filter(|vector| vector.is_finite())
    };
    Ok((0..vertices).map(|v| [vector(v, 0), vector(v, 1)]).collect())
}

/// The page as HTML.
#[pyfunction]
pub(crate) fn page(
    py: Python<'_>,
    call: &Call,
    exhibits: Vec<ExhibitGiven<'_>>,
    given: PageGiven,
) -> PyResult<String> {
    let settings = || -> Result<_, Failure> {
        let layouts = Layout::ALL.iter().map(|&layout| (layout.name(), layout)).collect::<Vec<_>>();
        let layout = choose("layout", &given.layout, &layouts)?;
        let axes = Up::ALL.map(|up| (up.name(), Some(up)));
        let up = choose("up", &given.up, &[&[("auto", None)], &axes[..]].concat())?;
        let map = given.colormap.as_deref().map(str::parse::<ColorMap>).transpose();
        let told = exhibits.into_iter().map(ExhibitGiven::told).collect::<Result<Vec<_>, _>>()?;
        Ok((layout, up, map.map_err(Failure::option)?, told))
    };
    let (layout, up, map, told) = settings().map_err(|failure| failure.raise(py))?;
    run(py, call, move |watch| {
        let exhibits = told.into_iter().map(|told| {
            watch.check()?;
            exhibit(told)
        });
        let exhibits = exhibits.collect::<Result<Vec<_>, Ended>>()?;
        let mut page = Page::new(given.title, exhibits);
        page.layout = layout;
        let shape = |shown: &Exhibit| Up::of_shape(&shown.positions, &shown.triangles);
        let of_shape = || page.exhibits.first().and_then(shape);
        page.start.up = up.or_else(of_shape).unwrap_or_default();
        page.most_faces = given.most_faces.max(1);
        if given.exact_positions {
            page.precision = Precision::Single;
        }
        page.start.map = map;
        page.start.range = given.range;
        page.start.smooth = given.smooth;
        page.start.edges = given.edges;
        page.start.color = given.color.map(|color| key(&page, color)).transpose()?;
        page.report =
            given.report.into_iter().map(|(title, rows)| Section::of_rows(&title, rows)).collect();
        let html = page.to_html_until(&|| watch.is_cancelled()).map_err(Failure::from)?;
        html.ok_or_else(Ended::interrupted)
    })
}

fn exhibit(told: Told) -> Result<Exhibit, Ended> {
    let Told { name, content, values, directions } = told;
    let pictures = Pictures::of_model(&content.model, &PictureOptions::default());
    let mut exhibit = Exhibit::of_model(name, &content.model, pictures).map_err(Failure::from)?;
    let numbers = exhibit.face_numbers.clone();
    for (name, Shown { on_vertices, is_label, values }) in values {
        exhibit.fields.retain(|field| field.name != name);
        // Values of polygons are copied to their triangles.
        let (on, values) = match (&numbers, on_vertices) {
            (_, true) => (On::Vertices, values),
            (None, false) => (On::Faces, values),
            (Some(of), false) => (On::Faces, of.iter().map(|&f| values[f as usize]).collect()),
        };
        exhibit.fields.push(match is_label {
            true => Field::labels(name, on, values),
            false => Field::new(name, on, values),
        });
    }
    if let Some(directions) = directions {
        let set = |name: &str, color, k: usize| Directions {
            name: name.into(),
            color,
            vectors: directions.iter().map(|pair| pair[k]).collect(),
            shown: false,
        };
        exhibit.directions = vec![
            set("Direction of k1", [200, 30, 40], 0),
            set("Direction of k2", [25, 80, 190], 1),
        ];
    }
    Ok(exhibit)
}

/// The key of the field with this name on the page.
fn key(page: &Page, color: String) -> Result<String, Failure> {
    let fields = || page.exhibits.iter().flat_map(|exhibit| &exhibit.fields);
    if let Some(field) = fields().find(|field| field.name == color) {
        return Ok(field.key());
    }
    if ["plain", "material", "vertexColors", "faceColors"].contains(&&*color) {
        return Ok(color);
    }
    if color == "component" && page.exhibits.iter().any(Exhibit::has_components) {
        return Ok(Exhibit::COMPONENTS.into());
    }
    let mut names: Vec<&str> = fields().map(|field| &*field.name).collect();
    names.sort_unstable();
    names.dedup();
    Err(Failure::option(format!("there is no data {color:?}; there are {names:?} and \"plain\"")))
}
