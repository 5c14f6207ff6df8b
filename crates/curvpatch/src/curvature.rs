//! Principal curvatures of a point from the normal sections through it (SN10, section 1).

use glam::{DMat2, DMat3, DVec2, DVec3};
use mesh_core::{EdgeId, FaceId, FaceMap, Handle, TriMesh, parallel};

use crate::curvature_error::{CurvatureError, check_radius};
use crate::params::{NormalRule, Params, PrincipalRule};
use crate::section::{Section, SectionPlane, WalkEnd};
use crate::section_curvature::{section_curvature, section_slope};
use crate::sections::{self, Sections};
use crate::surface_point::SurfacePoint;
use crate::terrain::Terrain;

/// What kind of point a surface has, by its principal curvatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PointClass {
    /// |κ₁| `r_g` < 10⁻³: no curvature to speak of on the scale of the disc.
    Flat,
    /// |κ₁ - κ₂| < 0.05 |κ₁|: no principal directions.
    Umbilic,
    /// |κ₂| < 0.05 |κ₁|: curved in one direction only.
    Parabolic,
    /// κ₁ κ₂ > 0.
    Elliptic,
    /// κ₁ κ₂ < 0.
    Hyperbolic,
}

/// The principal curvatures of the mesh over the disc round a point.
///
/// Curvatures are pointwise, in one over length, and positive where the surface is convex seen
/// from the side of the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DiscCurvature {
    /// The centre of the disc.
    pub center: DVec3,
    /// The orthonormal frame e₁, e₂, e₃: the directions of κ₁ and κ₂ and the normal,
    /// right-handed. The tangents are defined up to a common sign, and arbitrary at umbilics.
    pub frame: [DVec3; 3],
    /// κ₁ and κ₂, the one of larger absolute value first. When both are exactly as large, the
    /// concave one is first.
    pub curvatures: [f64; 2],
    /// The radius `r_g` of the disc: the length of an arc of a section.
    pub radius: f64,
    /// Some arc ended at the boundary of the mesh.
    pub truncated: bool,
    /// Some section came back to its face before it was as long as asked for: the disc is too
    /// large for this component of the mesh.
    pub wrapped: bool,
    /// The slopes did not determine a disc normal, so the face normal was used.
    pub face_normal_kept: bool,
}

impl DiscCurvature {
    /// The normal.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.frame[2]
    }

    /// K = κ₁ κ₂.
    #[must_use]
    pub fn gaussian(&self) -> f64 {
        self.curvatures[0] * self.curvatures[1]
    }

    /// H = (κ₁ + κ₂) / 2.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.curvatures[0] + self.curvatures[1])
    }

    /// The kind of point: the first class of [`PointClass`] whose condition holds. Does not depend
    /// on the unit of length.
    #[must_use]
    pub fn class(&self) -> PointClass {
        let [k1, k2] = self.curvatures;
        if k1.abs() * self.radius < 1e-3 {
            PointClass::Flat
        } else if (k1 - k2).abs() < 0.05 * k1.abs() {
            PointClass::Umbilic
        } else if k2.abs() < 0.05 * k1.abs() {
            PointClass::Parabolic
        } else if self.gaussian() > 0.0 {
            PointClass::Elliptic
        } else {
            PointClass::Hyperbolic
        }
    }
}

/// One direction of the tangent plane, with the trigonometry it needs.
#[derive(Clone, Copy, Debug)]
struct Direction {
    cos: f64,
    sin: f64,
    cos_double: f64,
    sin_double: f64,
}

/// A point with a tangent plane: tangents t₀ and t₁ = n × t₀.
#[derive(Clone, Copy, Debug)]
struct TangentPlane {
    face: FaceId,
    origin: DVec3,
    tangents: [DVec3; 2],
    normal: DVec3,
}

impl TangentPlane {
    fn new(face: FaceId, origin: DVec3, normal: DVec3, tangent: DVec3) -> Self {
        Self { face, origin, tangents: [tangent, normal.cross(tangent)], normal }
    }

    fn tangent(&self, cos: f64, sin: f64) -> DVec3 {
        cos * self.tangents[0] + sin * self.tangents[1]
    }

    fn section_plane(&self, direction: &Direction) -> SectionPlane {
        SectionPlane::new(self.origin, self.normal, self.tangent(direction.cos, direction.sin))
    }
}

/// Two extreme curvatures, the angle of the one that is larger in absolute value, and it first.
struct Principal {
    curvatures: [f64; 2],
    cos_sin: DVec2,
}

impl Principal {
    /// Orders the smallest and the largest curvature by absolute value. Equal ones: the smallest,
    /// which is the concave one, stays first.
    fn ordered(min: (f64, DVec2), max: (f64, DVec2)) -> Self {
        let (first, second) = if min.0.abs() >= max.0.abs() { (min, max) } else { (max, min) };
        Self { curvatures: [first.0, second.0], cos_sin: first.1 }
    }
}

/// Estimates the curvature of a mesh from normal sections.
///
/// The circular disc of radius `r_g` round a point is what normal sections of length `r_g` to either
/// side reach. Nothing of it needs vertices nearby, or any inside the mesh at all.
///
/// With mean edge length h the error follows A (h/r)² + B r² in the radius r. A radius that is a fixed
/// multiple of h does not make it vanish under refinement; one that goes like √h does. Three to
/// five mean edges suit clean meshes, eight suit noisy ones.
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
        let direction = |i: u16| {
            let angle = core::f64::consts::PI * f64::from(i) / f64::from(params.planes);
            let (sin, cos) = angle.sin_cos();
            let (sin_double, cos_double) = (2.0 * angle).sin_cos();
            Direction { cos, sin, cos_double, sin_double }
        };
        Ok(Self { mesh, params, directions: (0..params.planes).map(direction).collect() })
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

    /// A radius that suits clean meshes: four mean edge lengths, in model units; 0 for a mesh
    /// without edges, which no disc has a use for.
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

    /// The curvature at a point, or at the barycentre of a face, over the disc of this radius.
    ///
    /// # Errors
    /// A bad radius, a face that is not in the mesh or has no area, or too few directions to fit;
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

    /// As [`CurvatureEstimator::at`], walking on a terrain of the mesh, and going on with sections of
    /// earlier radii at the same point.
    pub(crate) fn at_again(
        &self,
        terrain: &Terrain,
        sections: &mut Sections,
        point: SurfacePoint,
        radius: f64,
    ) -> Result<DiscCurvature, CurvatureError> {
        sections.start(point);
        self.at_with(point, radius, |plane, is_of_face| {
            let start = terrain.place(plane.face);
            let planes: Vec<SectionPlane> =
                self.directions.iter().map(|direction| plane.section_plane(direction)).collect();
            if is_of_face {
                sections.measure(terrain, start, &planes, plane.normal, radius)
            } else {
                sections::measure(terrain, start, &planes, plane.normal, radius)
            }
        })
    }

    /// As [`CurvatureEstimator::at`], with the sections in all directions of a plane from somewhere else,
    /// which is told whether it is that of the face.
    fn at_with(
        &self,
        point: SurfacePoint,
        radius: f64,
        mut sections: impl FnMut(&TangentPlane, bool) -> Vec<Section>,
    ) -> Result<DiscCurvature, CurvatureError> {
        check_radius(radius)?;
        let face_plane = self.face_plane(point)?;
        let of_face = sections(&face_plane, true);
        if self.params.normal == NormalRule::Face {
            return self.disc(&face_plane, radius, false, &of_face);
        }
        match self.disc_plane(&face_plane, radius, &of_face) {
            None => self.disc(&face_plane, radius, true, &of_face),
            Some(plane) => self.disc(&plane, radius, false, &sections(&plane, false)),
        }
    }

    /// The curvature that follows from the sections in the planes through a normal.
    fn disc(
        &self,
        plane: &TangentPlane,
        radius: f64,
        face_normal_kept: bool,
        sections: &[Section],
    ) -> Result<DiscCurvature, CurvatureError> {
        let is_any_ended_by = |is_cause: fn(WalkEnd) -> bool| {
            sections.iter().any(|section| section.ended_by(is_cause))
        };
        let truncated = is_any_ended_by(|cause| cause == WalkEnd::Boundary);
        let wrapped = is_any_ended_by(WalkEnd::is_round);
        let principal = match self.params.principal {
            PrincipalRule::SignedExtremes => self.signed_extremes(sections),
            PrincipalRule::EulerFit => self.euler_fit(sections, radius),
        };
        let face = plane.face;
        let Principal { curvatures, cos_sin } =
            principal.ok_or(CurvatureError::TooFewDirections { face })?;
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

    /// The curvature at the barycentre of every face, over discs of this radius; faces are worked
    /// on in parallel, and each has the same bits as [`CurvatureEstimator::at`] gives.
    ///
    /// # Errors
    /// A bad radius. What is wrong with single faces is in the map.
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

    /// As [`CurvatureEstimator::all_faces`], until `stops` says so, which is asked before each face by
    /// any thread and stays with its answer; `None` then.
    ///
    /// # Errors
    /// A bad radius. What is wrong with single faces is in the map.
    pub fn all_faces_until(
        &self,
        radius: f64,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<FaceMap<Result<DiscCurvature, CurvatureError>>>, CurvatureError> {
        check_radius(radius)?;
        let capacity = self.mesh.topology().face_capacity();
        // What is left out once it was stopped does not matter.
        let found = parallel::collect(capacity, |index| {
            let face = FaceId::from_index(index);
            if stops() { Err(CurvatureError::NotInMesh { face }) } else { self.at(face, radius) }
        });
        Ok((!stops()).then(|| FaceMap::from_vec(found)))
    }

    /// The tangent plane of the face itself, with t₀ along its first edge.
    fn face_plane(&self, point: SurfacePoint) -> Result<TangentPlane, CurvatureError> {
        let face = point.face();
        if !self.mesh.topology().contains_face(face) {
            return Err(CurvatureError::NotInMesh { face });
        }
        let [a, b, c] = self.mesh.triangle(face);
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - a).length_squared());
        // Below this, rounding alone makes the cross product.
        let has_area = cross.length() > 4.0 * f64::EPSILON * longest;
        let tangent = (b - a).try_normalize();
        let (Some(normal), Some(tangent), true) = (cross.try_normalize(), tangent, has_area) else {
            return Err(CurvatureError::DegenerateFace { face });
        };
        Ok(TangentPlane::new(face, point.position(self.mesh), normal, tangent))
    }

    /// The tangent plane of the disc: slope ≈ g·t in the least-squares sense gives the normal
    /// n - g. `None` when the slopes do not determine g.
    fn disc_plane(
        &self,
        plane: &TangentPlane,
        radius: f64,
        sections: &[Section],
    ) -> Option<TangentPlane> {
        let mut matrix = DMat2::ZERO;
        let mut right = DVec2::ZERO;
        for (direction, section) in self.directions.iter().zip(sections) {
            let weight = section.weight(radius);
            let row = DVec2::new(direction.cos, direction.sin);
            matrix += DMat2::from_cols(weight * row.x * row, weight * row.y * row);
            right += weight * section_slope(section) * row;
        }
        let trace = matrix.x_axis.x + matrix.y_axis.y;
        let solvable = matrix.determinant() > 1e-9 * trace * trace;
        let gradient = solvable.then(|| matrix.inverse() * right)?;
        let [t0, t1] = plane.tangents;
        let normal = (plane.normal - gradient.x * t0 - gradient.y * t1).try_normalize()?;
        let tangent = (t0 - t0.dot(normal) * normal).try_normalize()?;
        Some(TangentPlane::new(plane.face, plane.origin, normal, tangent))
    }

    /// The smallest and the largest section curvature, the first of equal ones.
    fn signed_extremes(&self, sections: &[Section]) -> Option<Principal> {
        let mut extremes: Option<[(f64, DVec2); 2]> = None;
        for (direction, section) in self.directions.iter().zip(sections) {
            let curvature = section_curvature(self.params.section, section);
            let here = (curvature, DVec2::new(direction.cos, direction.sin));
            let [min, max] = extremes.get_or_insert([here; 2]);
            if curvature < min.0 {
                *min = here;
            }
            if curvature > max.0 {
                *max = here;
            }
        }
        extremes.map(|[min, max]| Principal::ordered(min, max))
    }

    /// Weighted least squares for κ(φ) = p + q cos 2φ + r sin 2φ. `None` when fewer than three
    /// directions have both arcs.
    fn euler_fit(&self, sections: &[Section], radius: f64) -> Option<Principal> {
        let mut matrix = DMat3::ZERO;
        let mut right = DVec3::ZERO;
        let mut usable = 0;
        for (direction, section) in self.directions.iter().zip(sections) {
            let weight = section.weight(radius);
            if weight > 0.0 {
                usable += 1;
            }
            let row = DVec3::new(1.0, direction.cos_double, direction.sin_double);
            let weighted = weight * row;
            matrix += DMat3::from_cols(weighted, row.y * weighted, row.z * weighted);
            right += section_curvature(self.params.section, section) * weighted;
        }
        let solvable = usable >= 3 && matrix.determinant() > 1e-12 * matrix.x_axis.x.powi(3);
        let fit = solvable.then(|| matrix.inverse() * right)?;
        let amplitude = fit.y.hypot(fit.z);
        // The angle of the smallest curvature; any will do where all directions are equal. Rounding
        // must not choose between the two ends of the range, which are opposite directions.
        let sine = if fit.z.abs() > 1e-12 * amplitude { -fit.z } else { 0.0 };
        let angle = if amplitude > 0.0 { 0.5 * sine.atan2(-fit.y) } else { 0.0 };
        let (sin, cos) = angle.sin_cos();
        Some(Principal::ordered(
            (fit.x - amplitude, DVec2::new(cos, sin)),
            (fit.x + amplitude, DVec2::new(-sin, cos)),
        ))
    }
}
