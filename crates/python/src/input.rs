//! Conversion of `numpy` arrays with any strides to the arrays of a mesh.

use glam::DVec3;
use mesh_core::{PolygonSoup, as_u32};
use numpy::PyReadonlyArray2;
use numpy::ndarray::{ArrayView1, ArrayView2};
use pyo3::prelude::*;

use crate::failure::Failure;

/// Rows of coordinates.
#[derive(FromPyObject)]
pub(crate) enum Coordinates<'py> {
    Double(PyReadonlyArray2<'py, f64>),
    Single(PyReadonlyArray2<'py, f32>),
}

/// Rows of vertex indices.
#[derive(FromPyObject)]
pub(crate) enum Triangles<'py> {
    I32(PyReadonlyArray2<'py, i32>),
    I64(PyReadonlyArray2<'py, i64>),
    U32(PyReadonlyArray2<'py, u32>),
    U64(PyReadonlyArray2<'py, u64>),
}

/// Rows of coordinates, for work without the interpreter.
pub(crate) enum PointRows<'a> {
    Double(ArrayView2<'a, f64>),
    Single(ArrayView2<'a, f32>),
}

/// Rows of vertex indices, for work without the interpreter.
pub(crate) enum IndexRows<'a> {
    I32(ArrayView2<'a, i32>),
    I64(ArrayView2<'a, i64>),
    U32(ArrayView2<'a, u32>),
    U64(ArrayView2<'a, u64>),
}

impl Coordinates<'_> {
    pub(crate) fn rows(&self) -> PointRows<'_> {
        match self {
            Self::Double(array) => PointRows::Double(array.as_array()),
            Self::Single(array) => PointRows::Single(array.as_array()),
        }
    }
}

impl Triangles<'_> {
    pub(crate) fn rows(&self) -> IndexRows<'_> {
        match self {
            Self::I32(array) => IndexRows::I32(array.as_array()),
            Self::I64(array) => IndexRows::I64(array.as_array()),
            Self::U32(array) => IndexRows::U32(array.as_array()),
            Self::U64(array) => IndexRows::U64(array.as_array()),
        }
    }
}

impl PointRows<'_> {
    pub(crate) fn points(&self) -> Result<Vec<DVec3>, Failure> {
        match self {
            Self::Double(array) => points(array),
            Self::Single(array) => points(array),
        }
    }
}

fn points<T: Copy + Into<f64>>(array: &ArrayView2<'_, T>) -> Result<Vec<DVec3>, Failure> {
    check_width("vertices", array)?;
    let point = |i: usize| DVec3::from_array([0, 1, 2].map(|k| array[[i, k]].into()));
    Ok((0..array.nrows()).map(point).collect())
}

impl IndexRows<'_> {
    /// The corners of the triangles. Values that are never indices, such as -1, are refused; indices that are too large
    /// for the mesh are not.
    pub(crate) fn corners(&self) -> Result<Vec<u32>, Failure> {
        match self {
            Self::I32(array) => corners(array, |i| u32::try_from(i).ok()),
            Self::I64(array) => corners(array, |i| u32::try_from(i).ok()),
            Self::U32(array) => corners(array, Some),
            Self::U64(array) => corners(array, |i| u32::try_from(i).ok()),
        }
    }
}

fn corners<T: Copy + std::fmt::Display>(
    array: &ArrayView2<'_, T>,
    index: impl Fn(T) -> Option<u32>,
) -> Result<Vec<u32>, Failure> {
    check_width("faces", array)?;
    let mut corners = Vec::with_capacity(array.len());
    for (face, row) in array.rows().into_iter().enumerate() {
        for &value in row {
            let found = index(value);
            corners.push(found.ok_or_else(|| {
                let message =
                    format!("face {face} refers to vertex {value}, which no index can be");
                Failure::new("OutOfRangeError", message).ids("faces", vec![as_u32(face)]).count(1)
            })?);
        }
    }
    Ok(corners)
}

fn check_width<T>(what: &str, array: &ArrayView2<'_, T>) -> Result<(), Failure> {
    if array.ncols() == 3 {
        return Ok(());
    }
    let [rows, columns] = [array.nrows(), array.ncols()];
    let message = format!("{what} have the shape ({rows}, {columns}); it must be (n, 3)");
    Err(Failure::new("ArrayError", message))
}

/// A soup of triangles.
pub(crate) fn triangles(points: Vec<DVec3>, corners: Vec<u32>) -> Result<PolygonSoup, Failure> {
    let count = u32::try_from(corners.len()).map_err(|_| {
        Failure::new(
            "TooLargeError",
            format!("{} corners are too many: their numbers have 32 bits", corners.len()),
        )
    })?;
    let ends = (1..=count / 3).map(|face| 3 * face).collect();
    PolygonSoup::from_parts(points, corners, ends)
        .map_err(|error| Failure::new("TooLargeError", error))
}

/// A soup of polygons: corners face by face, and the end of each face.
pub(crate) fn polygons(
    points: Vec<DVec3>,
    corners: &ArrayView1<'_, i64>,
    ends: &ArrayView1<'_, i64>,
) -> Result<PolygonSoup, Failure> {
    let whole = |what: &str, array: &ArrayView1<'_, i64>| -> Result<Vec<u32>, Failure> {
        let values: Result<Vec<u32>, _> = array.iter().map(|&i| u32::try_from(i)).collect();
        values.map_err(|_| {
            Failure::new("OutOfRangeError", format!("{what} have an entry that no index can be"))
        })
    };
    PolygonSoup::from_parts(points, whole("corners", corners)?, whole("ends", ends)?)
        .map_err(|error| Failure::new("ArrayError", error))
}

/// Refuses indices out of range and positions that are not finite.
pub(crate) fn check(soup: &PolygonSoup) -> Result<(), Failure> {
    const MOST: usize = 8;
    let count = soup.vertex_count();
    let is_bad = |face: &[u32]| face.iter().any(|&v| v as usize >= count);
    if soup.corners().iter().any(|&v| v as usize >= count) {
        let bad = || soup.faces().enumerate().filter(|(_, face)| is_bad(face));
        let first: Vec<u32> = bad().take(MOST).map(|(face, _)| as_u32(face)).collect();
        let message = format!(
            "face {} refers to a vertex that is not there: there are {count}; \
             `curvmesh.repair(mesh, drop_out_of_range=True)` drops such faces",
            first[0]
        );
        return Err(Failure::new("OutOfRangeError", message)
            .ids("faces", first)
            .count(bad().count())
            .text("repair", "drop_out_of_range"));
    }
    let not_finite = || soup.positions().iter().enumerate().filter(|(_, p)| !p.is_finite());
    if let Some((vertex, position)) = not_finite().next() {
        let message = format!(
            "vertex {vertex} is at {position}, which is not finite; \
             `curvmesh.repair(mesh, drop_not_finite=True)` drops such vertices with their faces"
        );
        return Err(Failure::new("NotFiniteError", message)
            .ids("vertices", not_finite().take(MOST).map(|(v, _)| as_u32(v)).collect())
            .count(not_finite().count())
            .text("repair", "drop_not_finite"));
    }
    Ok(())
}
