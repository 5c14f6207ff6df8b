//! Triangulation of a patch within a tolerance.

use core::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::patch::Patch;

/// The triangles of a patch.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tessellation {
    /// The vertices, on the patch.
    pub positions: Vec<DVec3>,
    /// The unit normals of the patch at the vertices.
    pub normals: Vec<DVec3>,
    /// Index triples, counter-clockwise seen from the side of the patch's normal.
    pub triangles: Vec<[u32; 3]>,
}

/// The reason why a patch is not triangulated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TessellationError {
    /// The tolerance is not positive.
    #[error("the tolerance of a tessellation is {tolerance}, but it must be positive")]
    BadTolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// The tolerance needs more triangles than one patch may have.
    #[error(
        "tolerance {tolerance} needs about {triangles:.0} triangles for one patch, more than the limit of {MAX_TRIANGLES}; use a larger tolerance"
    )]
    TooFine {
        /// The tolerance.
        tolerance: f64,
        /// The necessary number of triangles.
        triangles: f64,
    },
    /// The patches of a cover have more vertices than 32-bit indices can address.
    #[error(
        "the cover needs {vertices} vertices, more than 32-bit indices can address; use a larger tolerance"
    )]
    TooManyVertices {
        /// The necessary number of vertices.
        vertices: usize,
    },
    /// The triangles of a cover do not fit into memory.
    #[error(
        "there is not enough memory for the {triangles} triangles of the cover; use a larger tolerance, or export splats or a record"
    )]
    TooLittleMemory {
        /// The necessary number of triangles.
        triangles: usize,
    },
}

/// The largest number of triangles of one patch.
const MAX_TRIANGLES: u32 = 1 << 22;

impl Patch {
    /// Triangulates the patch: a fan around its centre, then rings of triangles.
    ///
    /// The distance between triangles and patch is at most about `tolerance` (model units; largest
    /// measured ratio: 1.02).
    ///
    /// # Errors
    /// A tolerance that is not positive, or that needs more than 4,194,304 triangles.
    pub fn tessellate(&self, tolerance: f64) -> Result<Tessellation, TessellationError> {
        let [rings, sectors] = self.cuts(tolerance)?;
        Ok(self.rings(rings, sectors))
    }

    /// Numbers of vertices and triangles of [`Patch::tessellate`].
    pub(crate) fn tessellation_size(
        &self,
        tolerance: f64,
    ) -> Result<[usize; 2], TessellationError> {
        let [rings, sectors] = self.cuts(tolerance)?.map(|count| count as usize);
        Ok([1 + rings * sectors, (2 * rings - 1) * sectors])
    }

    /// The numbers of rings and sectors.
    fn cuts(&self, tolerance: f64) -> Result<[u32; 2], TessellationError> {
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(TessellationError::BadTolerance { tolerance });
        }
        let (rings, sectors) = self.ring_counts(0.5 * tolerance);
        let triangles = (2.0 * rings - 1.0) * sectors;
        if triangles > f64::from(MAX_TRIANGLES) {
            return Err(TessellationError::TooFine { tolerance, triangles });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole numbers whose product is limited"
        )]
        let counts = [rings, sectors].map(|count| count as u32);
        Ok(counts)
    }

    /// The numbers of rings and sectors for sagittas below `sagitta`.
    fn ring_counts(&self, sagitta: f64) -> (f64, f64) {
        let [k1, k2] = self.curvatures();
        let [l1, l2] = self.arcs();
        let along = |k: f64, l: f64| (l * (k.abs() / (8.0 * sagitta)).sqrt()).ceil();
        let rings = along(k1, l1).max(along(k2, l2)).max(2.0);
        // Sectors around the ellipse, and along the wave of the boundary of height |H₁ - H₂|.
        let round = |turn: f64, radius: f64| {
            let cos = 1.0 - sagitta / radius;
            if cos > 0.0 { (turn / cos.acos()).ceil() } else { 0.0 }
        };
        let [a1, a2] = self.semi_axes();
        let wave = (self.local_point(1.0, 0.0).z - self.local_point(1.0, 0.5 * PI).z).abs();
        let sectors = round(PI, a1.max(a2)).max(round(TAU, 0.5 * wave)).max(8.0);
        (rings, 4.0 * (sectors / 4.0).ceil())
    }

    fn rings(&self, rings: u32, sectors: u32) -> Tessellation {
        let mut out = Tessellation {
            positions: vec![self.point(0.0, 0.0)],
            normals: vec![self.frame()[2]],
            triangles: Vec::with_capacity(((2 * rings - 1) * sectors) as usize),
        };
        for ring in 1..=rings {
            let u = f64::from(ring) / f64::from(rings);
            for sector in 0..sectors {
                let phi = TAU * f64::from(sector) / f64::from(sectors);
                out.positions.push(self.point(u, phi));
                out.normals.push(self.normal(u, phi));
            }
        }
        let vertex = |ring: u32, sector: u32| 1 + (ring - 1) * sectors + sector % sectors;
        for j in 0..sectors {
            out.triangles.push([0, vertex(1, j), vertex(1, j + 1)]);
        }
        for i in 1..rings {
            for j in 0..sectors {
                let outer = vertex(i + 1, j + 1);
                out.triangles.push([vertex(i, j), vertex(i + 1, j), outer]);
                out.triangles.push([vertex(i, j), outer, vertex(i, j + 1)]);
            }
        }
        out
    }
}
