//! Named data of vertices, corners and faces, as arrays.

use mesh_io::{Model, ScalarValues, Scalars};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::failure::{Failure, choose};
use crate::mesh::MeshData;
use crate::views::{rows, view};

/// The kind of element that data belongs to.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Vertices,
    Corners,
    Faces,
}

fn on(py: Python<'_>, name: &str) -> PyResult<On> {
    let choices = [("vertex", On::Vertices), ("corner", On::Corners), ("face", On::Faces)];
    choose("on", name, &choices).map_err(|failure| failure.raise(py))
}

/// Names reserved for data other than numbers.
const NORMALS: &str = "normals";
const COLORS: &str = "colors";
const UVS: &str = "uvs";
const GROUPS: &str = "groups";
const MATERIALS: &str = "materials";

/// The names of all data of vertices, corners or faces.
#[pyfunction]
pub(crate) fn data_names(py: Python<'_>, mesh: &MeshData, of: &str) -> PyResult<Vec<String>> {
    let model = mesh.model();
    let given = |is: bool, name: &str| is.then(|| name.to_owned());
    let numbers = |all: &[Scalars]| all.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
    let (fixed, numbers) = match on(py, of)? {
        On::Vertices => (
            vec![
                given(model.vertex_normals.is_some(), NORMALS),
                given(model.vertex_colors.is_some(), COLORS),
            ],
            numbers(&model.vertex_scalars),
        ),
        On::Corners => (
            vec![
                given(model.corner_normals.is_some(), NORMALS),
                given(model.corner_uvs.is_some(), UVS),
            ],
            Vec::new(),
        ),
        On::Faces => (
            vec![
                given(model.face_colors.is_some(), COLORS),
                given(model.face_groups.is_some(), GROUPS),
                given(model.face_materials.is_some(), MATERIALS),
            ],
            numbers(&model.face_scalars),
        ),
    };
    Ok(fixed.into_iter().flatten().chain(numbers).collect())
}

/// The data of this name as a view; `None` when there is none.
#[allow(unsafe_code, reason = "views of memory that the object keeps alive")]
#[pyfunction]
pub(crate) fn data<'py>(
    this: Bound<'py, MeshData>,
    of: &str,
    name: &str,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let py = this.py();
    let of = on(py, of)?;
    let content = this.get().content();
    let model = &content.model;
    let owner = || this.clone().into_any();
    // SAFETY: the content never changes, and lives as long as the object.
    let three = |values: &Vec<[f32; 3]>| unsafe { rows(values, owner()) }.into_any();
    // SAFETY: as above.
    let four = |values: &Vec<[f32; 4]>| unsafe { rows(values, owner()) }.into_any();
    // SAFETY: as above.
    let two = |values: &Vec<[f32; 2]>| unsafe { rows(values, owner()) }.into_any();
    // SAFETY: as above.
    let ids = |v: &Vec<u32>| unsafe { view::<i32>(bytemuck::cast_slice(v), owner()) }.into_any();
    // SAFETY: as above.
    let numbers = |all: &[Scalars]| {
        let found = all.iter().find(|scalars| scalars.name == name)?;
        // SAFETY: as above.
        macro_rules! typed {
            ($values:expr) => {
                unsafe { view($values, owner()) }.into_any()
            };
        }
        Some(match &found.values {
            ScalarValues::I8(values) => typed!(values),
            ScalarValues::U8(values) => typed!(values),
            ScalarValues::I16(values) => typed!(values),
            ScalarValues::U16(values) => typed!(values),
            ScalarValues::I32(values) => typed!(values),
            ScalarValues::U32(values) => typed!(values),
            ScalarValues::I64(values) => typed!(values),
            ScalarValues::U64(values) => typed!(values),
            ScalarValues::F32(values) => typed!(values),
            ScalarValues::F64(values) => typed!(values),
        })
    };
    Ok(match (of, name) {
        (On::Vertices, NORMALS) => model.vertex_normals.as_ref().map(three),
        (On::Vertices, COLORS) => model.vertex_colors.as_ref().map(four),
        (On::Vertices, _) => numbers(&model.vertex_scalars),
        (On::Corners, NORMALS) => model.corner_normals.as_ref().map(three),
        (On::Corners, UVS) => model.corner_uvs.as_ref().map(two),
        (On::Corners, _) => None,
        (On::Faces, COLORS) => model.face_colors.as_ref().map(four),
        (On::Faces, GROUPS) => model.face_groups.as_ref().map(ids),
        (On::Faces, MATERIALS) => model.face_materials.as_ref().map(ids),
        (On::Faces, _) => numbers(&model.face_scalars),
    })
}

/// The same mesh with data put in, or taken out where the array is `None`.
#[pyfunction]
pub(crate) fn with_data(
    py: Python<'_>,
    mesh: &MeshData,
    of: &str,
    items: Vec<(String, Option<Bound<'_, PyAny>>)>,
) -> PyResult<MeshData> {
    let of = on(py, of)?;
    let mut model = mesh.model().clone();
    for (name, array) in &items {
        set(&mut model, of, name, array.as_ref()).map_err(|error| match error {
            Refused::Failure(failure) => failure.raise(py),
            Refused::Error(error) => error,
        })?;
    }
    Ok(mesh.replaced(model))
}

enum Refused {
    Failure(Failure),
    Error(PyErr),
}

impl From<Failure> for Refused {
    fn from(failure: Failure) -> Self {
        Self::Failure(failure)
    }
}

impl From<PyErr> for Refused {
    fn from(error: PyErr) -> Self {
        Self::Error(error)
    }
}

fn set(
    model: &mut Model,
    of: On,
    name: &str,
    array: Option<&Bound<'_, PyAny>>,
) -> Result<(), Refused> {
    let soup = &model.soup;
    let count = match of {
        On::Vertices => soup.vertex_count(),
        On::Corners => soup.corners().len(),
        On::Faces => soup.face_count(),
    };
    match (of, name) {
        (On::Vertices, NORMALS) => model.vertex_normals = matrix(name, array, count)?,
        (On::Vertices, COLORS) => model.vertex_colors = matrix(name, array, count)?,
        (On::Vertices, _) => set_numbers(&mut model.vertex_scalars, name, array, count)?,
        (On::Corners, NORMALS) => model.corner_normals = matrix(name, array, count)?,
        (On::Corners, UVS) => model.corner_uvs = matrix(name, array, count)?,
        (On::Corners, _) => {
            let message = format!("corners have {NORMALS:?} and {UVS:?}, not {name:?}");
            return Err(Failure::option(message).into());
        }
        (On::Faces, COLORS) => model.face_colors = matrix(name, array, count)?,
        (On::Faces, GROUPS) => model.face_groups = ids(name, array, count, model.groups.len())?,
        (On::Faces, MATERIALS) => {
            model.face_materials = ids(name, array, count, model.materials.len())?;
        }
        (On::Faces, _) => set_numbers(&mut model.face_scalars, name, array, count)?,
    }
    Ok(())
}

fn matrix<const N: usize>(
    name: &str,
    array: Option<&Bound<'_, PyAny>>,
    count: usize,
) -> Result<Option<Vec<[f32; N]>>, Refused> {
    let Some(array) = array else { return Ok(None) };
    let array: PyReadonlyArray2<'_, f32> = array.extract()?;
    if array.shape() != [count, N] {
        return Err(shape(name, array.shape(), &format!("({count}, {N})")).into());
    }
    let array = array.as_array();
    let row = |i: usize| core::array::from_fn(|k| array[[i, k]]);
    Ok(Some((0..count).map(row).collect()))
}

fn set_numbers(
    all: &mut Vec<Scalars>,
    name: &str,
    array: Option<&Bound<'_, PyAny>>,
    count: usize,
) -> Result<(), Refused> {
    let place = all.iter().position(|scalars| scalars.name == name);
    let Some(array) = array else {
        place.map(|place| all.remove(place));
        return Ok(());
    };
    let scalars = Scalars::new(name, numbers_of(name, array, count)?);
    match place {
        Some(place) => all[place] = scalars,
        None => all.push(scalars),
    }
    Ok(())
}

/// The numbers of an array, in their own type.
fn numbers_of(name: &str, array: &Bound<'_, PyAny>, count: usize) -> Result<ScalarValues, Refused> {
    macro_rules! try_type {
        ($($number:ty),*) => {
            $(
                if let Ok(array) = array.extract::<PyReadonlyArray1<'_, $number>>() {
                    if array.len() != count {
                        return Err(shape(name, array.shape(), &format!("({count},)")).into());
                    }
                    return Ok(array.as_array().to_vec().into());
                }
            )*
        };
    }
    try_type!(i8, u8, i16, u16, i32, u32, i64, u64, f32);
    let array: PyReadonlyArray1<'_, f64> = array.extract()?;
    if array.len() != count {
        return Err(shape(name, array.shape(), &format!("({count},)")).into());
    }
    Ok(array.as_array().to_vec().into())
}

fn ids(
    name: &str,
    array: Option<&Bound<'_, PyAny>>,
    count: usize,
    most: usize,
) -> Result<Option<Vec<u32>>, Refused> {
    let Some(array) = array else { return Ok(None) };
    let array: PyReadonlyArray1<'_, i64> = array.extract()?;
    if array.len() != count {
        return Err(shape(name, array.shape(), &format!("({count},)")).into());
    }
    let id = |&value: &i64| match value {
        -1 => Ok(Model::NONE),
        value => u32::try_from(value).ok().filter(|&id| (id as usize) < most).ok_or_else(|| {
            Failure::new(
                "OutOfRangeError",
                format!("{name} has {value}; there are {most}, and -1 is for none"),
            )
        }),
    };
    Ok(Some(array.as_array().iter().map(id).collect::<Result<_, Failure>>()?))
}

fn shape(name: &str, found: &[usize], expected: &str) -> Failure {
    Failure::new("ArrayError", format!("{name:?} has the shape {found:?}; it must be {expected}"))
}
