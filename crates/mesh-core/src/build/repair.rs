//! Which repairs a build may make.

use crate::build::error::BuildError;
use crate::build::seams::weld_seams;
use crate::build::soup::PolygonSoup;
use crate::build::weld::{weld_exact, weld_within};

/// Which vertices count as one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Weld {
    /// Vertices stay as they are, even where positions coincide.
    #[default]
    None,
    /// Open edges that lie on each other become one: programs that export a surface patch by patch give each patch
    /// vertices of its own. Other vertices stay apart, even where positions coincide. Both sides of a sheet that is
    /// given once per side stay apart as well.
    Seams,
    /// Vertices with equal coordinates become one (`-0.0` equals `0.0`).
    Exact,
    /// In order of their index, each vertex merges into the first earlier vertex within this
    /// distance that did not itself merge, in model units. See [`crate::build::weld_within`].
    Distance(f64),
}

impl Weld {
    /// The vertex that every vertex of a soup merges into; `None` for [`Weld::None`].
    ///
    /// # Errors
    /// The distance is negative or not a number.
    pub fn targets(self, soup: &PolygonSoup) -> Result<Option<Vec<u32>>, BuildError> {
        let positions = soup.positions();
        match self {
            Self::None => Ok(None),
            Self::Seams => Ok(Some(weld_seams(soup))),
            Self::Exact => Ok(Some(weld_exact(positions))),
            Self::Distance(distance) if distance.is_finite() && distance >= 0.0 => {
                Ok(Some(weld_within(positions, distance)))
            }
            Self::Distance(distance) => Err(BuildError::InvalidWeldDistance { distance }),
        }
    }
}

/// Which repairs [`crate::build()`] may make, each of them off by default.
///
/// Every repair is listed in the [`BuildReport`](crate::build::BuildReport). Meshes too large for 32-bit indices are
/// never repaired.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Repair {
    /// Which vertices to merge, before all other steps.
    pub weld: Weld,
    /// Drop faces that refer to vertices that do not exist.
    pub drop_out_of_range: bool,
    /// Drop vertices whose position is infinite or not a number, and the faces at them. Depth cameras store pixels
    /// without depth that way.
    pub drop_not_finite: bool,
    /// Drop faces with fewer than three corners, and triangles that use a vertex twice. Triangles
    /// of zero area with three distinct vertices stay: dropping them would open cracks.
    pub drop_degenerate: bool,
    /// Of all triangles with the same three vertices, in any order, keep only the first. A sheet that is given
    /// twice, once per side, keeps one side. With `cut_non_manifold`, walls between closed parts that lie on each other
    /// stay: the parts come apart closed.
    pub drop_duplicates: bool,
    /// Reverse faces until neighbours agree and components face outward.
    ///
    /// Neighbours first: each part that is connected through edges of two faces keeps the orientation of the
    /// majority of its faces, or that of its first face in a tie. Then each connected component of the result is
    /// turned as a whole if it is inside out: a closed one by its volume, where nested shells alternate between
    /// solid and cavity, an open one if its back is the side that is seen from outside. A component for which
    /// neither decides, such as a flat sheet, keeps the majority. [`measure::facing`](crate::measure::facing) has the
    /// rules.
    pub reorient: bool,
    /// Cut the surface along edges of more than two faces and along edges where no orientation makes two faces
    /// agree, and separate surfaces that touch only at a vertex, by duplicating vertices. Closed surfaces that touch
    /// along an edge come apart closed. Of other surfaces as many as possible stay joined in pairs, and the rest get a
    /// boundary there.
    pub cut_non_manifold: bool,
    /// Drop vertices that no face uses.
    pub drop_unreferenced: bool,
}

impl Repair {
    /// No repair: input that is not an oriented 2-manifold is refused. The same as
    /// [`Repair::default`].
    #[must_use]
    pub fn strict() -> Self {
        Self::default()
    }

    /// Every repair but `drop_not_finite`, with an exact weld: builds a mesh from any soup whose coordinates are finite.
    ///
    /// The weld is exact because equal coordinates are how files store one vertex several times
    /// (STL always; other formats at texture seams); a distance would depend on the model's scale.
    #[must_use]
    pub fn lenient() -> Self {
        Self {
            weld: Weld::Exact,
            drop_out_of_range: true,
            drop_not_finite: false,
            drop_degenerate: true,
            drop_duplicates: true,
            reorient: true,
            cut_non_manifold: true,
            drop_unreferenced: true,
        }
    }
}
