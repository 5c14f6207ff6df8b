//! Options for covers.

use crate::shape::Shape;
use crate::size_options::{OptionError, SizeOptions};

/// The method that selects patches from the candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum CoverMethod {
    /// Repeatedly selects the candidate with the largest area that is not covered yet.
    Greedy,
    /// One pass over the candidates by descending area. Candidates whose base face is already covered are
    /// skipped. Needs 10 to 90 % more patches than [`CoverMethod::Greedy`] on most meshes.
    Sequential,
    /// Both; the cover with fewer patches is the result.
    #[default]
    Best,
}

/// The faces that are tried as base face of a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Seeds {
    /// Every face. Time and memory are proportional to the number of faces times the faces of a patch.
    AllFaces,
    /// Enough faces, evenly spaced by index, that about this many candidates cover each face.
    ///
    /// Every face is tried if the mesh has at most [`Seeds::FEW_FACES`] faces, and every face that no
    /// candidate covers. A sliver, whose height is less than a fiftieth of its longest side, is tried only
    /// if no candidate covers it, and only while slivers still yield candidates. Memory is proportional to
    /// the number of faces times this number.
    Redundancy(f64),
}

impl Seeds {
    /// In meshes with at most this many faces, every face is tried.
    pub const FEW_FACES: usize = 4096;
}

impl Default for Seeds {
    fn default() -> Self {
        Self::Redundancy(48.0)
    }
}

/// Options for a cover.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverOptions {
    /// The conditions for a patch. `overhang` is true by default here.
    pub size: SizeOptions,
    /// The shapes tried at every base face. The shape that covers the largest area is used.
    pub shapes: Vec<Shape>,
    /// The method that selects patches.
    pub method: CoverMethod,
    /// The faces that are tried as base face of a candidate.
    pub seeds: Seeds,
}

impl CoverOptions {
    /// Defaults for a tolerance in model units: circles and ellipses with overhang, and the smaller one of
    /// the greedy and the sequential cover.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self {
            size: SizeOptions { overhang: true, ..SizeOptions::new(tolerance) },
            shapes: vec![Shape::Circle, Shape::Ellipse],
            method: CoverMethod::default(),
            seeds: Seeds::default(),
        }
    }

    pub(super) fn check(&self) -> Result<(), OptionError> {
        self.size.check()?;
        let rules = [
            (
                "the redundancy of the seeds",
                match self.seeds {
                    Seeds::AllFaces => 1.0,
                    Seeds::Redundancy(redundancy) => redundancy,
                },
            ),
            ("the number of shapes", self.shapes.len() as f64),
        ];
        for (what, value) in rules {
            if !(value > 0.0 && value < f64::INFINITY) {
                return Err(OptionError { what, value, above: 0.0, below: f64::INFINITY });
            }
        }
        Ok(())
    }
}
