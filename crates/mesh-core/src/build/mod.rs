//! From a polygon soup to a half-edge mesh: input that is not an oriented 2-manifold is refused or repaired.
//!
//! [`build()`] takes these steps, each in a file of its own:
//!
//! 1. faces with indices out of range and vertices whose coordinates are not finite are dropped (`screen`);
//! 2. vertices are welded (`weld`);
//! 3. polygons are cut into triangles (`triangulate`);
//! 4. triangles that use a vertex twice are dropped;
//! 5. unused vertices are dropped.
//!
//! If the triangles do not form an oriented 2-manifold by now:
//!
//! 6. duplicate triangles are dropped (`duplicates`);
//! 7. faces are oriented consistently (`orient`);
//! 8. the surface is cut apart where it is not manifold (`cut`).
//!
//! At the end, components that are inside out are turned ([`facing`](crate::measure::facing)). A defect that
//! [`Repair`] does not allow to repair is a [`BuildError`]; all repairs are listed in the [`BuildReport`].

mod cut;
pub mod diagnose;
mod draft;
mod duplicates;
pub(crate) mod edges;
mod error;
mod fins;
mod manifold;
mod orient;
mod repair;
mod report;
mod sample;
mod screen;
mod seams;
pub mod soup;
mod touching;
mod triangulate;
mod weld;

pub use cut::cut_non_manifold;
pub use draft::{Built, Provenance};
pub use error::BuildError;
pub use repair::{Repair, Weld};
pub use report::BuildReport;
pub use sample::{Sample, VertexPair};
pub use seams::count_seam_edges;
pub use triangulate::{Triangulation, Triangulator};
pub(crate) use weld::position_key;
pub use weld::{weld_exact, weld_within};

pub use draft::has_zero_area;
pub(crate) use draft::{Draft, repeated_vertex};
pub(crate) use duplicates::find_duplicates;

use crate::build::soup::PolygonSoup;
use crate::mesh::MeshError;
use crate::topology::Topology;

/// Builds a half-edge mesh from a polygon soup.
///
/// Polygons are always cut into triangles ([`Triangulator`]); everything else that changes the
/// input happens only if `repair` allows it. The outcome depends on the input alone. Takes linear
/// time, plus `n log n` for the corners of large polygons and of vertices of large valence.
///
/// ```
/// use mesh_core::{BuildError, PolygonSoup, Repair, build};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut soup = PolygonSoup::new();
/// for position in [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
///     soup.push_vertex(position);
/// }
/// soup.push_face(&[0, 1, 2, 3])?;
/// let built = build(&soup, &Repair::strict())?;
/// assert_eq!(built.mesh.topology().face_count(), 2);
/// assert!(built.report.is_unchanged());
///
/// soup.push_vertex([1.0, 0.5, 1.0]);
/// soup.push_face(&[0, 2, 4])?;
/// let error = build(&soup, &Repair::strict()).unwrap_err();
/// assert!(matches!(error, BuildError::NonManifoldEdge { .. }));
/// let built = build(&soup, &Repair::lenient())?;
/// assert_eq!(built.report.cut_edges.count(), 1);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// A [`BuildError`] for the first kind of defect, in the order of the [steps](self), that `repair`
/// does not allow to repair. With [`Repair::lenient`] only coordinates that are not finite and
/// meshes beyond 32-bit indices remain.
pub fn build(soup: &PolygonSoup, repair: &Repair) -> Result<Built, BuildError> {
    build_and_compare(soup, repair).map(|(built, _)| built)
}

/// As [`build()`]; also returns per triangle whether it was reversed (an empty list if none was).
pub(crate) fn build_and_compare(
    soup: &PolygonSoup,
    repair: &Repair,
) -> Result<(Built, Vec<bool>), BuildError> {
    // An error names positions and lengths of the soup as it is.
    if let Some((scaled, repair)) = at_unit_size(soup, repair)
        && let Ok((mut built, reversed)) = build_and_compare(&scaled, &repair)
    {
        let sources = &built.provenance.vertex_source;
        for (position, &source) in built.mesh.positions_mut().iter_mut().zip(sources) {
            *position = soup.positions()[source as usize];
        }
        return Ok((built, reversed));
    }
    let mut draft = Draft::new(soup, repair)?;
    draft.weld()?;
    draft.triangulate();
    draft.drop_degenerate()?;
    draft.drop_unreferenced();
    match draft.pair() {
        Some(topology) => draft.finish(topology),
        None => {
            draft.make_manifold()?;
            let topology = Topology::from_triangles(draft.vertex_count(), &draft.triangles)
                .map_err(MeshError::from)?;
            draft.finish(topology)
        }
    }
}

/// A soup whose coordinates are so large or small that products of them are no numbers, and the repairs that it needs,
/// at unit size.
fn at_unit_size(soup: &PolygonSoup, repair: &Repair) -> Option<(PolygonSoup, Repair)> {
    let (scaled, factor) = soup.at_unit_size()?;
    let weld = match repair.weld {
        Weld::Distance(distance) => Weld::Distance(distance / factor),
        other => other,
    };
    Some((scaled, Repair { weld, ..*repair }))
}
