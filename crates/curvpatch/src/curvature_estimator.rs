//! Principal curvatures at a point from the normal sections through it (SN10, section 1).

use mesh_core::{EdgeId, FaceId, FaceMap, Handle, TriMesh, parallel};

use crate::curvature_error::{CurvatureError, check_radius};
use crate::direction::Direction;
use crate::disc_curvature::DiscCurvature;
use crate::disc_size::DiscSize;
use crate::local_fit::LocalFit;
use crate::local_scale::LocalScale;
use crate::local_section::LocalSection;
use crate::params::{NormalRule, Params};
use crate::principal_fit::{Principal, WeightedSection, slope_gradient};
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

    /// The default size of discs: [`CurvatureEstimator::suggested_radius`] for [`Params::paper`], because
    /// the discs of SN10 have one radius, and [`DiscSize::Local`] for all other parameters.
    #[must_use]
    pub fn default_size(&self) -> DiscSize {
        if self.params == Params::paper() {
            DiscSize::Radius(self.suggested_radius())
        } else {
            DiscSize::Local
        }
    }

    /// The curvature over a disc around a point, or around the barycentre of a face.
    ///
    /// The size is a radius in model units, or [`DiscSize::Local`].
    ///
    /// # Errors
    /// A bad radius, a face that is not in the mesh or has no area, or too few directions for the fit;
    /// see [`CurvatureError`].
    pub fn at(
        &self,
        point: impl Into<SurfacePoint>,
        size: impl Into<DiscSize>,
    ) -> Result<DiscCurvature, CurvatureError> {
        let radius = match size.into() {
            DiscSize::Local => return self.at_local_scale(point.into()),
            DiscSize::Radius(radius) => radius,
        };
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
        let disc_plane = (self.params.normal == NormalRule::Disc).then(|| {
            self.disc_plane(&face_plane, face_sections.iter().map(|s| s.weighted(radius)))
        });
        let (plane, sections) = match disc_plane.flatten() {
            Some(plane) => (plane, sections(&plane, false)),
            None => (face_plane, face_sections),
        };
        let is_any_cut_short = |is_cause: fn(WalkEnd) -> bool| {
            sections.iter().any(|section| section.is_cut_short_by(is_cause))
        };
        let weighted = sections.iter().map(|section| section.weighted(radius));
        let flags = DiscFlags {
            truncated: is_any_cut_short(|cause| cause == WalkEnd::Boundary),
            wrapped: is_any_cut_short(WalkEnd::is_closed),
            face_normal_kept: disc_plane == Some(None),
        };
        let principal = Principal::of_sections(&self.params, &self.directions, weighted);
        disc_curvature(&plane, radius, principal, flags)
    }

    /// The curvature over a disc of local size; see [`DiscSize::Local`].
    fn at_local_scale(&self, point: SurfacePoint) -> Result<DiscCurvature, CurvatureError> {
        let face_plane = TangentPlane::of_face(self.mesh, point)?;
        let face_scale = LocalScale::new(self.mesh, &face_plane);
        let face_sections = self.local_sections(&face_plane, &face_scale);
        let disc_plane = (self.params.normal == NormalRule::Disc).then(|| {
            let fit = self.local_fit(&face_sections);
            let fitted = fit.as_ref().and_then(|fit| face_plane.tilted(fit.gradient()));
            let plane = fitted.or_else(|| {
                self.disc_plane(&face_plane, face_sections.iter().map(LocalSection::weighted))
            })?;
            let scale = LocalScale::new(self.mesh, &plane);
            let scale = match fit {
                Some(fit) => scale.widened(fit.curvatures()),
                None => scale,
            };
            Some((plane, scale))
        });
        let face_normal_kept = matches!(disc_plane, Some(None));
        let (plane, sections) = match disc_plane {
            Some(Some((plane, scale))) => (plane, self.local_sections(&plane, &scale)),
            _ => (face_plane, face_sections),
        };
        let products = sections.iter().map(|local| local.section.length_product());
        let radius = (products.sum::<f64>() / sections.len() as f64).sqrt();
        let flags = DiscFlags {
            truncated: sections.iter().any(|local| local.truncated),
            wrapped: sections.iter().any(|local| local.wrapped),
            face_normal_kept,
        };
        let fitted = self.local_fit(&sections).map(|fit| fit.principal());
        let principal = fitted.or_else(|| {
            let weighted = sections.iter().map(LocalSection::weighted);
            Principal::of_sections(&self.params, &self.directions, weighted)
        });
        disc_curvature(&plane, radius, principal, flags)
    }

    /// The fit to the points of all sections, if the parameters ask for it and the points determine it.
    fn local_fit(&self, sections: &[LocalSection]) -> Option<LocalFit> {
        if self.params.fits_circles() { LocalFit::new(&self.directions, sections) } else { None }
    }

    /// The tangent plane of the disc, fitted to the slopes of sections in the plane of the face. `None` if
    /// they do not determine it.
    fn disc_plane<'s>(
        &self,
        face_plane: &TangentPlane,
        sections: impl Iterator<Item = WeightedSection<'s>>,
    ) -> Option<TangentPlane> {
        let gradient = slope_gradient(&self.directions, sections)?;
        face_plane.tilted(gradient)
    }

    /// The sections of local length in the planes through a normal.
    fn local_sections(&self, plane: &TangentPlane, scale: &LocalScale) -> Vec<LocalSection> {
        let lengths = scale.half_lengths(&self.directions);
        let section = |(direction, length): (&Direction, f64)| {
            LocalSection::measure(self.mesh, plane, &plane.section_plane(direction), length)
        };
        self.directions.iter().zip(lengths).map(section).collect()
    }

    /// The curvature at the barycentre of every face, over discs of this size.
    ///
    /// Faces are processed in parallel. Each result has the bits of [`CurvatureEstimator::at`].
    ///
    /// # Errors
    /// A bad radius. Errors of single faces are in the map.
    pub fn all_faces(
        &self,
        size: impl Into<DiscSize>,
    ) -> Result<FaceMap<Result<DiscCurvature, CurvatureError>>, CurvatureError> {
        let size = size.into();
        size.check()?;
        let capacity = self.mesh.topology().face_capacity();
        Ok(FaceMap::from_vec(parallel::collect(capacity, |index| {
            self.at(FaceId::from_index(index), size)
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
        size: impl Into<DiscSize>,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<FaceMap<Result<DiscCurvature, CurvatureError>>>, CurvatureError> {
        let size = size.into();
        size.check()?;
        let capacity = self.mesh.topology().face_capacity();
        // The placeholder is never returned, because `stops` stays true.
        let found = parallel::collect(capacity, |index| {
            let face = FaceId::from_index(index);
            if stops() { Err(CurvatureError::NotInMesh { face }) } else { self.at(face, size) }
        });
        Ok((!stops()).then(|| FaceMap::from_vec(found)))
    }
}

/// Flags of [`DiscCurvature`].
struct DiscFlags {
    truncated: bool,
    wrapped: bool,
    face_normal_kept: bool,
}

/// The result in a plane, unless there are no principal curvatures or they overflow.
fn disc_curvature(
    plane: &TangentPlane,
    radius: f64,
    principal: Option<Principal>,
    DiscFlags { truncated, wrapped, face_normal_kept }: DiscFlags,
) -> Result<DiscCurvature, CurvatureError> {
    let face = plane.face;
    let Principal { curvatures, cos_sin } =
        principal.ok_or(CurvatureError::TooFewDirections { face })?;
    let e1 = plane.tangent(cos_sin.x, cos_sin.y);
    let frame = [e1, plane.normal.cross(e1), plane.normal];
    if !(curvatures.iter().all(|k| k.is_finite()) && frame.iter().all(|e| e.is_finite())) {
        return Err(CurvatureError::Overflow { face });
    }
    let center = plane.origin;
    Ok(DiscCurvature { center, frame, curvatures, radius, truncated, wrapped, face_normal_kept })
}
