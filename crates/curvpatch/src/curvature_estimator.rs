//! Principal curvatures at a point from the normal sections through it (SN10, section 1).

use mesh_core::{EdgeId, FaceId, FaceMap, Handle, TriMesh, parallel};

use crate::curvature_error::{CurvatureError, check_radius};
use crate::disc_curvature::DiscCurvature;
use crate::params::{NormalRule, Params};
use crate::principal_fit::{Direction, Principal, slope_gradient};
use crate::reusable_sections::{self, ReusableSections};
use crate::section::Section;
use crate::section_arc::WalkEnd;
use crate::section_plane::SectionPlane;
use crate::soa_mesh::SoaMesh;
use crate::surface_point::SurfacePoint;
use crate::tangent_plane::TangentPlane;

/// Estimates the curvature of a mesh from normal sections.
///
/// The circular disc of radius `r_g` around a point is the part of the surface that normal sections of
/// length `r_g` to either side reach. No vertices need to be near the point.
///
/// With mean edge length h the error is A (h/r)² + B r² in the radius r. If the radius is a fixed
/// multiple of h, the error does not vanish under refinement; with r ~ √h it does. Three to five mean
/// edge lengths suit clean meshes, eight suit noisy meshes.
#[derive(Clone, Debug)]
pub struct CurvatureEstimator<'a> {
    mesh: &'a TriMesh,
    params: Params,
    directions: Vec<Direction>,
}

impl<'a> CurvatureEstimator<'a> {
    /// An estimator for the points of a mesh.
    ///
    /// # Errors
    /// [`CurvatureError::TooFewPlanes`].
    pub fn new(mesh: &'a TriMesh, params: Params) -> Result<Self, CurvatureError> {
        if params.planes < 3 {
            return Err(CurvatureError::TooFewPlanes { planes: params.planes });
        }
        Ok(Self { mesh, params, directions: Direction::evenly_spaced(params.planes) })
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// The parameters.
    #[must_use]
    pub fn params(&self) -> Params {
        self.params
    }

    /// Four mean edge lengths, in model units: a radius that suits clean meshes with edges of similar
    /// length. 0 for a mesh without edges.
    #[must_use]
    pub fn suggested_radius(&self) -> f64 {
        let topology = self.mesh.topology();
        let total = parallel::sum(topology.edge_capacity(), |index| {
            let edge = EdgeId::from_index(index);
            if !topology.contains_edge(edge) {
                return 0.0;
            }
            let [a, b] = self.mesh.segment(edge);
            a.distance(b)
        });
        4.0 * total / topology.edge_count().max(1) as f64
    }

    /// The curvature over the disc of this radius at a point, or at the barycentre of a face.
    ///
    /// # Errors
    /// A bad radius, a face that is not in the mesh or has no area, or too few directions for the fit;
    /// see [`CurvatureError`].
    pub fn at(
        &self,
        point: impl Into<SurfacePoint>,
        radius: f64,
    ) -> Result<DiscCurvature, CurvatureError> {
        self.at_with(point.into(), radius, |plane, _| {
            let section = |direction: &Direction| {
                let section_plane = plane.section_plane(direction);
                Section::measure(self.mesh, plane.face, &section_plane, plane.normal, radius)
            };
            self.directions.iter().map(section).collect()
        })
    }

    /// As [`CurvatureEstimator::at`], on the flat copy of the mesh, and with reuse of the sections of
    /// earlier radii at the same point.
    pub(crate) fn at_again(
        &self,
        soa: &SoaMesh,
        sections: &mut ReusableSections,
        point: SurfacePoint,
        radius: f64,
    ) -> Result<DiscCurvature, CurvatureError> {
        sections.start(point);
        self.at_with(point, radius, |plane, is_face_plane| {
            let start = soa.index_of(plane.face);
            let planes: Vec<SectionPlane> =
                self.directions.iter().map(|direction| plane.section_plane(direction)).collect();
            if is_face_plane {
                sections.measure(soa, start, &planes, plane.normal, radius)
            } else {
                reusable_sections::measure(soa, start, &planes, plane.normal, radius)
            }
        })
    }

    /// As [`CurvatureEstimator::at`], with sections that a closure measures.
    ///
    /// The closure returns the sections in all directions of a plane. Its second argument tells whether
    /// the plane is the plane of the face.
    fn at_with(
        &self,
        point: SurfacePoint,
        radius: f64,
        mut sections: impl FnMut(&TangentPlane, bool) -> Vec<Section>,
    ) -> Result<DiscCurvature, CurvatureError> {
        check_radius(radius)?;
        let face_plane = TangentPlane::of_face(self.mesh, point)?;
        let face_sections = sections(&face_plane, true);
        if self.params.normal == NormalRule::Face {
            return self.disc(&face_plane, radius, false, &face_sections);
        }
        let gradient = slope_gradient(&self.directions, &face_sections, radius);
        match gradient.and_then(|gradient| face_plane.tilted(gradient)) {
            None => self.disc(&face_plane, radius, true, &face_sections),
            Some(plane) => self.disc(&plane, radius, false, &sections(&plane, false)),
        }
    }

    /// The curvature from the sections in the planes through one normal.
    fn disc(
        &self,
        plane: &TangentPlane,
        radius: f64,
        face_normal_kept: bool,
        sections: &[Section],
    ) -> Result<DiscCurvature, CurvatureError> {
        let is_any_cut_short = |is_cause: fn(WalkEnd) -> bool| {
            sections.iter().any(|section| section.is_cut_short_by(is_cause))
        };
        let truncated = is_any_cut_short(|cause| cause == WalkEnd::Boundary);
        let wrapped = is_any_cut_short(WalkEnd::is_closed);
        let face = plane.face;
        let Principal { curvatures, cos_sin } =
            Principal::of_sections(&self.params, &self.directions, sections, radius)
                .ok_or(CurvatureError::TooFewDirections { face })?;
        let e1 = plane.tangent(cos_sin.x, cos_sin.y);
        let frame = [e1, plane.normal.cross(e1), plane.normal];
        if !(curvatures.iter().all(|k| k.is_finite()) && frame.iter().all(|e| e.is_finite())) {
            return Err(CurvatureError::Overflow { face });
        }
        let center = plane.origin;
        Ok(DiscCurvature {
            center,
            frame,
            curvatures,
            radius,
            truncated,
            wrapped,
            face_normal_kept,
        })
    }

    /// The curvature at the barycentre of every face, over discs of this radius.
    ///
    /// Faces are processed in parallel. Each result has the bits of [`CurvatureEstimator::at`].
    ///
    /// # Errors
    /// A bad radius. Errors of single faces are in the map.
    pub fn all_faces(
        &self,
        radius: f64,
    ) -> Result<FaceMap<Result<DiscCurvature, CurvatureError>>, CurvatureError> {
        check_radius(radius)?;
        let capacity = self.mesh.topology().face_capacity();
        Ok(FaceMap::from_vec(parallel::collect(capacity, |index| {
            self.at(FaceId::from_index(index), radius)
        })))
    }

    /// As [`CurvatureEstimator::all_faces`], until `stops` returns true; then `None`.
    ///
    /// Any thread calls `stops` before each face. Once true, it must stay true.
    ///
    /// # Errors
    /// A bad radius. Errors of single faces are in the map.
    pub fn all_faces_until(
        &self,
        radius: f64,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<FaceMap<Result<DiscCurvature, CurvatureError>>>, CurvatureError> {
        check_radius(radius)?;
        let capacity = self.mesh.topology().face_capacity();
        // The placeholder is never returned, because `stops` stays true.
        let found = parallel::collect(capacity, |index| {
            let face = FaceId::from_index(index);
            if stops() { Err(CurvatureError::NotInMesh { face }) } else { self.at(face, radius) }
        });
        Ok((!stops()).then(|| FaceMap::from_vec(found)))
    }
}
