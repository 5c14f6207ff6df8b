//! How to cover a mesh.

use crate::shape::Shape;
use crate::size::{OptionError, SizeOptions};

/// How patches are chosen from the candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum CoverMethod {
    /// Always the candidate with the largest area that is not covered yet.
    Greedy,
    /// One pass over the candidates by descending area, skipping those whose base face is covered
    /// already. Takes 10 to 90 % more patches.
    Sequential,
    /// Both; the one with fewer patches is kept.
    #[default]
    Best,
}

/// For which faces candidates are made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Seeds {
    /// For every face. Time and memory go with the number of faces times the faces of a patch.
    AllFaces,
    /// For as many faces, evenly spread by index, as it takes for a face to lie in about this many
    /// candidates; for every face of meshes with up to [`Seeds::FEW_FACES`] faces, and for those
    /// that no candidate covers. Slivers, faces less high than a fiftieth of their longest side, are
    /// tried only where nothing else covers them, and as long as that is worthwhile. Memory goes with
    /// the number of faces times this number.
    Redundancy(f64),
}

impl Seeds {
    /// Meshes with up to this many faces have a candidate for each of them.
    pub const FEW_FACES: usize = 4096;
}

impl Default for Seeds {
    fn default() -> Self {
        Self::Redundancy(48.0)
    }
}

/// How to cover a mesh.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverOptions {
    /// What a patch has to keep. Its `overhang` is on by default here.
    pub size: SizeOptions,
    /// The shapes to choose from for every seed, by the area they cover.
    pub shapes: Vec<Shape>,
    /// How patches are chosen.
    pub method: CoverMethod,
    /// For which faces candidates are made.
    pub seeds: Seeds,
}

impl CoverOptions {
    /// Defaults for a tolerance in model units: circles and ellipses that may reach over the
    /// boundary, and the smaller one of the greedy and the sequential cover.
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
