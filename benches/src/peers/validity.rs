//! Whether a result is a sound mesh. One judge for all tools: the measures of `mesh-core` and of the postconditions.

use mesh_core::{Diagnosis, PolygonSoup, TriMesh, diagnose};
use mesh_metric::Surface;
use postconditions::Turning;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::raw_mesh::RawMesh;
use xtask_common::Failure;

/// The defects of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Defects {
    /// Faces that use a vertex twice or have zero area.
    pub(super) zero_area: usize,
    /// Faces whose height is below a thousandth of their longest side.
    pub(super) slivers: usize,
    pub(super) duplicates: usize,
    pub(super) non_manifold_edges: usize,
    pub(super) non_manifold_vertices: usize,
    /// Faces whose normal is opposite to the surface of the input near by.
    pub(super) turned: usize,
    /// Edges of one face only.
    pub(super) open_edges: usize,
}

impl Defects {
    fn new(found: &Diagnosis, turned: usize) -> Self {
        Self {
            zero_area: found.degenerate_faces(),
            slivers: found.slivers,
            duplicates: found.duplicate_faces,
            non_manifold_edges: found.non_manifold_edges,
            non_manifold_vertices: found.non_manifold_vertices,
            turned,
            open_edges: found.boundary_edges,
        }
    }

    /// Whether every edge has two faces, and there are no defects.
    pub(crate) fn is_closed_and_sound(&self) -> bool {
        let Self { turned, .. } = *self;
        *self == Self { turned, ..Self::default() }
    }

    /// The counts with their names.
    pub(super) fn named(&self) -> [(&'static str, usize); 7] {
        [
            ("zero area", self.zero_area),
            ("slivers", self.slivers),
            ("duplicates", self.duplicates),
            ("non-manifold edges", self.non_manifold_edges),
            ("non-manifold vertices", self.non_manifold_vertices),
            ("turned over", self.turned),
            ("open edges", self.open_edges),
        ]
    }
}

/// A result beside its input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Validity {
    pub(crate) input: Defects,
    pub(crate) output: Defects,
    /// The change of the area, relative to the area of the input.
    pub(crate) area: f64,
    /// The change of the volume, relative to the volume of the input; for closed inputs only.
    pub(crate) volume: Option<f64>,
}

impl Validity {
    /// The defects that the input did not have, with their names.
    pub(crate) fn new_defects(&self) -> [(&'static str, usize); 7] {
        let mut counts = self.output.named();
        for ((_, count), (_, old)) in counts.iter_mut().zip(self.input.named()) {
            *count = count.saturating_sub(old);
        }
        counts
    }
}

/// Compares results with one input.
pub(crate) struct Judge<'m> {
    input: Defects,
    area: f64,
    /// Of a closed input.
    volume: Option<f64>,
    turning: Turning<'m>,
}

impl<'m> Judge<'m> {
    /// For an input as arrays, as a mesh and as a surface.
    pub(crate) fn new(
        raw: &RawMesh,
        mesh: &'m TriMesh,
        surface: &'m Surface,
    ) -> Result<Self, Failure> {
        let soup = soup(raw)?;
        let found = diagnose(&soup).map_err(Failure::mesh)?;
        let sizes = soup.measure();
        Ok(Self {
            input: Defects::new(&found, 0),
            area: sizes.area,
            volume: found.is_closed().then_some(sizes.volume),
            turning: Turning::new(mesh, surface),
        })
    }

    /// Judges a result, whatever its defects.
    pub(crate) fn judge(&self, result: &RawMesh) -> Result<Validity, Failure> {
        let soup = soup(result)?;
        let found = diagnose(&soup).map_err(Failure::mesh)?;
        let sizes = soup.measure();
        let corners: Vec<_> = result
            .triangles
            .iter()
            .filter_map(|t| {
                let [a, b, c] = t.map(|v| result.vertices.get(v as usize).copied());
                Some([a?, b?, c?])
            })
            .filter(|corners| corners.iter().all(|p| p.is_finite()))
            .collect();
        let distance = |&face: &_| self.turning.distance(face);
        let error = corners.par_iter().map(distance).reduce(|| 0.0, f64::max);
        let turned =
            corners.par_iter().filter(|&&face| self.turning.is_turned(face, error)).count();
        let change = |new: f64, old: f64| (new - old) / old.abs();
        Ok(Validity {
            input: self.input,
            output: Defects::new(&found, turned),
            area: change(sizes.area, self.area),
            volume: self.volume.map(|volume| change(sizes.volume, volume)),
        })
    }
}

fn soup(raw: &RawMesh) -> Result<PolygonSoup, Failure> {
    PolygonSoup::from_triangles(&raw.vertices, &raw.triangles).map_err(Failure::mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A cube with sides of length one.
    fn cube() -> RawMesh {
        let vertices = (0..8_u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        RawMesh { vertices, triangles }
    }

    fn judged(change: impl FnOnce(&mut RawMesh)) -> Validity {
        let raw = cube();
        let mesh = raw.to_mesh().unwrap();
        let surface = Surface::new(&mesh).unwrap();
        let judge = Judge::new(&raw, &mesh, &surface).unwrap();
        let mut result = raw.clone();
        change(&mut result);
        judge.judge(&result).unwrap()
    }

    fn found(validity: &Validity) -> Vec<(&'static str, usize)> {
        validity.new_defects().into_iter().filter(|&(_, count)| count > 0).collect()
    }

    #[test]
    fn a_copy_has_no_defects_and_no_change() {
        let validity = judged(|_| ());
        assert_eq!(found(&validity), []);
        assert_eq!((validity.area, validity.volume), (0.0, Some(0.0)));
        assert_eq!(validity.input, Defects::default());
    }

    #[test]
    fn sizes_are_compared_with_their_formulas() {
        // A box of 1 by 1 by 2: area 10 instead of 6, volume 2 instead of 1.
        let validity = judged(|cube| cube.vertices[4..].iter_mut().for_each(|p| p.z = 2.0));
        assert!((validity.area - 4.0 / 6.0).abs() < 1e-12, "{validity:?}");
        assert!((validity.volume.unwrap() - 1.0).abs() < 1e-12, "{validity:?}");
    }

    #[test]
    fn every_defect_is_counted_under_its_name() {
        let lost = judged(|cube| cube.triangles.truncate(11));
        assert_eq!(found(&lost), [("open edges", 3)]);
        let turned = judged(|cube| cube.triangles[0].swap(1, 2));
        assert_eq!(found(&turned), [("turned over", 1)]);
        let twice = judged(|cube| cube.triangles.push(cube.triangles[0]));
        assert!(found(&twice).contains(&("duplicates", 1)), "{twice:?}");
        let flat = judged(|cube| cube.triangles.push([0, 1, 1]));
        assert_eq!(found(&flat), [("zero area", 1)]);
        let thin = judged(|cube| {
            // A fin on an edge: a third face there, two open edges, a height of 1/2000.
            cube.vertices.push(DVec3::new(0.5, -0.0005, 0.0));
            cube.triangles.push([0, 1, 8]);
        });
        let names: Vec<_> = found(&thin).into_iter().map(|(name, _)| name).collect();
        assert!(names.contains(&"slivers") && names.contains(&"non-manifold edges"), "{thin:?}");
        let pinched = judged(|cube| {
            // A second cube that touches the first one in a corner.
            let count = cube.vertices.len() as u32;
            let more: Vec<DVec3> = cube.vertices.iter().map(|p| *p + DVec3::ONE).collect();
            let rename = |v: u32| if v == 0 { 7 } else { v + count };
            let faces: Vec<_> = cube.triangles.iter().map(|t| t.map(rename)).collect();
            cube.vertices.extend(more);
            cube.triangles.extend(faces);
        });
        assert!(found(&pinched).contains(&("non-manifold vertices", 1)), "{pinched:?}");
    }
}
