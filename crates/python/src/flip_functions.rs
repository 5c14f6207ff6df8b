//! Flip costs that are Python functions of arrays.
//!
//! A cost is a sum over triangles, or over the edges between two of them, of a function of their vertices. The function
//! gets all terms of many flips per call.

use std::sync::Arc;

use dtri_flip::{Change, FlipCost, Quad, Stencil};
use mesh_core::glam::DVec3;
use mesh_core::{EdgeId, HalfEdgeId, TriMesh};
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::failure::{Failure, choose};
use crate::host::Watch;
use crate::views::frames;

/// The kind of element of the terms.
#[derive(Clone, Copy, PartialEq)]
enum Terms {
    /// Triangles: rows of three points.
    Faces,
    /// Edges between two triangles: both ends, the left and the right apex.
    Edges,
}

/// A cost that is a sum of terms.
pub(crate) struct FunctionCost {
    /// A function from rows of points to numbers.
    function: Py<PyAny>,
    terms: Terms,
    length_exponent: i32,
    watch: Arc<Watch>,
}

type Point = [f64; 3];

impl FunctionCost {
    /// Reads an object with `function`, `terms` and `length_exponent`.
    pub(crate) fn of(functions: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = functions.py();
        let terms: String = functions.getattr("terms")?.extract()?;
        let choices = [("faces", Terms::Faces), ("edges", Terms::Edges)];
        Ok(Self {
            function: functions.getattr("function")?.unbind(),
            terms: choose("terms", &terms, &choices).map_err(|failure| failure.raise(py))?,
            length_exponent: functions.getattr("length_exponent")?.extract()?,
            watch: Arc::default(),
        })
    }

    /// Sets the run to which exceptions are reported, and with which the evaluation ends.
    pub(crate) fn watched(&mut self, watch: &Arc<Watch>) {
        self.watch = Arc::clone(watch);
    }

    /// The terms of some triangles or edges; NaN once the run is cancelled.
    fn evaluate(&self, rows: Vec<[Point; 4]>) -> Vec<f64> {
        let count = rows.len();
        if count == 0 || self.watch.is_cancelled() {
            return vec![f64::NAN; count];
        }
        Python::attach(|py| self.call(py, rows)).unwrap_or_else(|error| {
            self.watch.raise(error);
            vec![f64::NAN; count]
        })
    }

    fn call(&self, py: Python<'_>, rows: Vec<[Point; 4]>) -> PyResult<Vec<f64>> {
        let count = rows.len();
        let points = match self.terms {
            Terms::Faces => frames(py, rows.into_iter().map(|[a, b, c, _]| [a, b, c]).collect())?,
            Terms::Edges => frames(py, rows)?,
        };
        let answer = self.function.bind(py).call1((points,))?;
        let answer: PyReadonlyArray1<'_, f64> = answer.extract()?;
        if answer.len() == count {
            return Ok(answer.as_array().to_vec());
        }
        let message = format!(
            "the function was given {count} rows and returned {} numbers; it must return one for each",
            answer.len()
        );
        Err(Failure::new("ArrayError", message).raise(py))
    }

    /// The terms that a flip changes, before and after.
    fn rows(&self, mesh: &TriMesh, quad: &Quad) -> [Vec<[Point; 4]>; 2] {
        let [a, b, c, d] = quad.corners.map(|v| mesh.position(v));
        if self.terms == Terms::Faces {
            return [
                vec![row([a, b, c, c]), row([b, a, d, d])],
                vec![row([a, d, c, c]), row([d, b, c, c])],
            ];
        }
        let mut rows = [vec![row([a, b, c, d])], vec![row([c, d, b, a])]];
        // For each side: its ends, and the apex inside before and after.
        let sides = [[b, c, a, d], [c, a, b, d], [a, d, b, c], [d, b, a, c]];
        for (side, [from, to, before, after]) in quad.sides.into_iter().zip(sides) {
            if let Some(outer) = outer(mesh, side) {
                rows[0].push(row([from, to, before, outer]));
                rows[1].push(row([from, to, after, outer]));
            }
        }
        rows
    }

    /// The changes by several flips.
    fn changes<'a>(&self, mesh: &TriMesh, quads: impl Iterator<Item = &'a Quad>) -> Vec<Change> {
        let (mut all, mut ends) = (Vec::new(), Vec::new());
        for quad in quads {
            for rows in self.rows(mesh, quad) {
                all.extend(rows);
                ends.push(all.len());
            }
        }
        let values = self.evaluate(all);
        let mut start = 0;
        let mut sums = ends.into_iter().map(|end| {
            let sum = values[start..end].iter().sum();
            start = end;
            sum
        });
        let mut changes = Vec::new();
        while let (Some(before), Some(after)) = (sums.next(), sums.next()) {
            changes.push(Change { before, after });
        }
        changes
    }
}

/// The apex beyond a side; `None` at the boundary.
fn outer(mesh: &TriMesh, side: HalfEdgeId) -> Option<DVec3> {
    mesh.topology().apex(side.twin()).map(|apex| mesh.position(apex))
}

fn row(points: [DVec3; 4]) -> [Point; 4] {
    points.map(|point| point.to_array())
}

impl FlipCost for FunctionCost {
    type Cache = ();

    fn prepare(&self, _: &TriMesh) {}

    fn total(&self, mesh: &TriMesh) -> f64 {
        let topology = mesh.topology();
        let rows = match self.terms {
            Terms::Faces => topology
                .faces()
                .map(|face| {
                    let [a, b, c] = mesh.triangle(face);
                    row([a, b, c, c])
                })
                .collect(),
            Terms::Edges => {
                let quads = topology.edges().filter_map(|e: EdgeId| Quad::around(topology, e));
                quads.map(|quad| row(quad.corners.map(|v| mesh.position(v)))).collect()
            }
        };
        self.evaluate(rows).iter().sum()
    }

    fn change(&self, mesh: &TriMesh, (): &(), quad: &Quad) -> Change {
        let none = Change { before: f64::NAN, after: f64::NAN };
        self.changes(mesh, core::iter::once(quad)).pop().unwrap_or(none)
    }

    fn changes_if_lower(
        &self,
        mesh: &TriMesh,
        (): &(),
        quads: &[Option<Quad>],
        changes: &mut [Option<Change>],
    ) {
        let mut found = self.changes(mesh, quads.iter().flatten()).into_iter();
        for (change, quad) in changes.iter_mut().zip(quads) {
            *change = quad.as_ref().and_then(|_| found.next());
        }
    }

    fn stencil(&self) -> Stencil {
        match self.terms {
            Terms::Faces => Stencil::Triangles,
            Terms::Edges => Stencil::AdjacentTriangles,
        }
    }

    fn length_exponent(&self) -> i32 {
        self.length_exponent
    }
}
