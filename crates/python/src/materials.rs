//! Groups, materials and images of a mesh, as plain Python data.

use mesh_io::{Alpha, Group, Image, ImageData, Material, Model};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict};

use crate::failure::Failure;
use crate::mesh::MeshData;

/// The groups as pairs of object and name.
#[pyfunction]
pub(crate) fn groups(mesh: &MeshData) -> Vec<(String, String)> {
    let pair = |Group { object, name }: &Group| (object.clone(), name.clone());
    mesh.model().groups.iter().map(pair).collect()
}

/// The same mesh with other groups.
#[pyfunction]
pub(crate) fn with_groups(
    py: Python<'_>,
    mesh: &MeshData,
    groups: Vec<(String, String)>,
) -> PyResult<MeshData> {
    let groups = groups.into_iter().map(|(object, name)| Group { object, name }).collect();
    changed(py, mesh, |model| model.groups = groups)
}

/// The materials.
#[pyfunction]
pub(crate) fn materials<'py>(
    py: Python<'py>,
    mesh: &MeshData,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let item = |material: &Material| {
        let item = PyDict::new(py);
        item.set_item("name", &material.name)?;
        item.set_item("base_color", material.base_color)?;
        item.set_item("image", material.base_color_image)?;
        item.set_item("metallic", material.metallic)?;
        item.set_item("roughness", material.roughness)?;
        item.set_item("emissive", material.emissive)?;
        item.set_item("double_sided", material.double_sided)?;
        match material.alpha {
            Alpha::Opaque => item.set_item("alpha", "opaque")?,
            Alpha::Blend => item.set_item("alpha", "blend")?,
            Alpha::Mask(cutoff) => item.set_item("alpha", cutoff)?,
        }
        Ok(item)
    };
    mesh.model().materials.iter().map(item).collect()
}

/// What the opacity of a material means, as it comes from Python.
#[derive(FromPyObject)]
enum AlphaGiven {
    Cutoff(f32),
    Name(String),
}

/// The same mesh with other materials; what a dictionary does not say is as usual.
#[pyfunction]
pub(crate) fn with_materials(
    py: Python<'_>,
    mesh: &MeshData,
    materials: Vec<Bound<'_, PyDict>>,
) -> PyResult<MeshData> {
    let materials = materials.iter().map(material).collect::<PyResult<_>>()?;
    changed(py, mesh, |model| model.materials = materials)
}

fn material(given: &Bound<'_, PyDict>) -> PyResult<Material> {
    let py = given.py();
    let mut made = Material::default();
    for (key, value) in given {
        match &*key.extract::<String>()? {
            "name" => made.name = value.extract()?,
            "base_color" => made.base_color = value.extract()?,
            "image" => made.base_color_image = value.extract()?,
            "metallic" => made.metallic = value.extract()?,
            "roughness" => made.roughness = value.extract()?,
            "emissive" => made.emissive = value.extract()?,
            "double_sided" => made.double_sided = value.extract()?,
            "alpha" => {
                made.alpha = match value.extract()? {
                    AlphaGiven::Cutoff(cutoff) => Alpha::Mask(cutoff),
                    AlphaGiven::Name(name) if name == "opaque" => Alpha::Opaque,
                    AlphaGiven::Name(name) if name == "blend" => Alpha::Blend,
                    AlphaGiven::Name(name) => {
                        let message = format!(
                            "alpha is {name:?}; it must be \"opaque\", \"blend\" or a number"
                        );
                        return Err(Failure::option(message).raise(py));
                    }
                }
            }
            other => {
                let message = format!("a material has no {other:?}");
                return Err(Failure::option(message).raise(py));
            }
        }
    }
    Ok(made)
}

/// The images.
#[pyfunction]
pub(crate) fn images<'py>(py: Python<'py>, mesh: &MeshData) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let item = |image: &Image| {
        let item = PyDict::new(py);
        item.set_item("name", &image.name)?;
        item.set_item("media_type", image.media_type())?;
        match &image.data {
            ImageData::Bytes(bytes) => item.set_item("data", PyBytes::new(py, bytes))?,
            ImageData::Uri(uri) => item.set_item("uri", uri)?,
        }
        Ok(item)
    };
    mesh.model().images.iter().map(item).collect()
}

/// An image, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ImageGiven {
    name: String,
    #[pyo3(default)]
    media_type: String,
    #[pyo3(default)]
    data: Option<PyBackedBytes>,
    #[pyo3(default)]
    uri: Option<String>,
}

/// The same mesh with other images.
#[pyfunction]
pub(crate) fn with_images(
    py: Python<'_>,
    mesh: &MeshData,
    images: Vec<ImageGiven>,
) -> PyResult<MeshData> {
    let image = |ImageGiven { name, media_type, data, uri }: ImageGiven| {
        let data = match (data, uri) {
            (Some(bytes), None) => ImageData::Bytes(bytes.to_vec()),
            (None, Some(uri)) => ImageData::Uri(uri),
            _ => return Err(Failure::option("an image has either data or a uri").raise(py)),
        };
        Ok(Image { name, media_type, data })
    };
    let images = images.into_iter().map(image).collect::<PyResult<_>>()?;
    changed(py, mesh, |model| model.images = images)
}

/// The mesh with a change, unless an index then refers to nothing.
fn changed(py: Python<'_>, mesh: &MeshData, change: impl FnOnce(&mut Model)) -> PyResult<MeshData> {
    let mut model = mesh.model().clone();
    change(&mut model);
    model.check_attributes().map_err(|error| Failure::new("OutOfRangeError", error).raise(py))?;
    Ok(mesh.replaced(model))
}
