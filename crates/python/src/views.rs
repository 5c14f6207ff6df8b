//! The memory of a mesh as `numpy` arrays, without a copy; and conversion of vectors to arrays.

use bytemuck::Pod;
use glam::DVec3;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

/// A read-only array of the memory of `owner`, which keeps it alive.
///
/// # Safety
/// `values` must be memory of `owner` that is neither moved nor changed during the lifetime of `owner`.
#[allow(unsafe_code, reason = "the only way for an array to share the memory of a Rust object")]
pub(crate) unsafe fn view<'py, T: Element>(
    values: &[T],
    owner: Bound<'py, PyAny>,
) -> Bound<'py, PyArray1<T>> {
    // SAFETY: passed on to the caller.
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner) };
    drop(array.readwrite().make_nonwriteable());
    array
}

/// As [`view`], of rows of `N` numbers.
///
/// # Safety
/// As for [`view`].
#[allow(unsafe_code, reason = "as above")]
pub(crate) unsafe fn rows<'py, T: Element + Copy, const N: usize>(
    values: &[[T; N]],
    owner: Bound<'py, PyAny>,
) -> Bound<'py, PyArray2<T>> {
    // SAFETY: passed on to the caller.
    let array = unsafe { PyArray2::borrow_from_array(&ArrayView2::from(values), owner) };
    drop(array.readwrite().make_nonwriteable());
    array
}

/// Points as rows of three numbers.
pub(crate) fn points(py: Python<'_>, points: Vec<DVec3>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    matrix(py, bytemuck::allocation::cast_vec::<DVec3, [f64; 3]>(points))
}

/// Rows of numbers, without a copy.
pub(crate) fn matrix<T: Element + Pod, const N: usize>(
    py: Python<'_>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let count = rows.len();
    rows.into_flattened().into_pyarray(py).reshape([count, N])
}

/// Rows of vectors.
pub(crate) fn frames<const N: usize>(
    py: Python<'_>,
    rows: Vec<[[f64; 3]; N]>,
) -> PyResult<Bound<'_, PyArray3<f64>>> {
    let count = rows.len();
    rows.into_flattened().into_flattened().into_pyarray(py).reshape([count, N, 3])
}

/// Indices in the usual type of `numpy`: signed.
pub(crate) fn signed(indices: Vec<u32>) -> Vec<i32> {
    bytemuck::allocation::cast_vec(indices)
}
