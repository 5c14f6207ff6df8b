//! A helicopter with thin rotor blades, made of closed parts that are cut so as to have as many
//! faces together as the paper's: 34,708.

use core::f64::consts::TAU;

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_shapes::Sphere;

use xtask_common::Failure;

/// The craft, and which of its vertices belong to a rotor blade.
pub(super) struct Rotorcraft {
    pub(super) soup: PolygonSoup,
    pub(super) blade_vertices: Vec<usize>,
}

/// The craft: nose along x, up along y, about ten units long.
pub(super) fn rotorcraft() -> Result<Rotorcraft, Failure> {
    let mut craft = Builder::default();
    craft.ellipsoid([60, 80], DVec3::ZERO, DVec3::new(1.9, 1.0, 0.95))?;
    craft.tube(&Tube {
        sides: 24,
        rings: 59,
        ..Tube::round([-1.2, 0.25, 0.0], [-5.6, 0.75, 0.0], 0.42, 0.13)
    })?;
    craft.tube(&Tube {
        sides: 16,
        rings: 11,
        ..Tube::round([0.0, 0.8, 0.0], [0.0, 1.55, 0.0], 0.12, 0.09)
    })?;
    craft.ellipsoid([17, 24], DVec3::new(0.0, 1.55, 0.0), DVec3::new(0.24, 0.13, 0.24))?;
    craft.main_rotor()?;
    craft.tail_rotor()?;
    craft.skids()?;
    craft.fins()?;
    craft.tube(&Tube {
        sides: 10,
        rings: 16,
        ..Tube::round([0.7, 0.8, 0.3], [0.4, 1.3, 0.3], 0.02, 0.012)
    })?;
    Ok(Rotorcraft { soup: craft.soup, blade_vertices: craft.blade_vertices })
}

/// Panels, windows and seams: how far the skin stands out in a direction.
fn panels(direction: DVec3) -> f64 {
    let (longitude, latitude) = (direction.y.atan2(direction.z), direction.x.asin());
    0.02 * (16.0 * longitude).sin() * (21.0 * latitude).cos() * latitude.cos()
}

#[derive(Default)]
struct Builder {
    soup: PolygonSoup,
    blade_vertices: Vec<usize>,
}

/// A closed tube with an elliptic section, from one point to another.
struct Tube {
    /// Corners of the section, and rings between the ends.
    sides: usize,
    rings: usize,
    from: DVec3,
    to: DVec3,
    /// The half-axes of the section at the start, and what they shrink to at the end.
    half_axes: [DVec3; 2],
    taper: f64,
}

impl Tube {
    fn round(from: [f64; 3], to: [f64; 3], radius: f64, end_radius: f64) -> Self {
        let (from, to) = (DVec3::from(from), DVec3::from(to));
        let (u, v) = (to - from).normalize_or(DVec3::X).any_orthonormal_pair();
        let half_axes = [radius * u, radius * v];
        Self { sides: 12, rings: 10, from, to, half_axes, taper: end_radius / radius }
    }

    /// A thin plate along `to - from`: `chord` is half its width, `thickness` half its height.
    fn plate(from: DVec3, to: DVec3, chord: DVec3, thickness: f64) -> Self {
        let normal = (to - from).cross(chord).normalize_or(DVec3::Y);
        Self { sides: 10, rings: 119, from, to, half_axes: [chord, thickness * normal], taper: 0.6 }
    }
}

impl Builder {
    /// Bands of latitude and sectors of longitude: 2 (bands - 1) sectors faces.
    fn ellipsoid(
        &mut self,
        [bands, sectors]: [usize; 2],
        center: DVec3,
        half: DVec3,
    ) -> Result<(), Failure> {
        let sphere = Sphere::UNIT.uv_mesh(bands, sectors).map_err(Failure::mesh)?;
        let first = self.soup.vertex_count() as u32;
        for &p in sphere.positions() {
            self.soup.push_vertex(center + half * p * (1.0 + panels(p)));
        }
        for face in sphere.faces() {
            self.face([face[0], face[1], face[2]].map(|v| first + v))?;
        }
        Ok(())
    }

    /// 2 sides (rings + 1) faces: rings + 1 bands of quadrilaterals less the two caps' fans.
    fn tube(&mut self, tube: &Tube) -> Result<(), Failure> {
        let first = self.soup.vertex_count() as u32;
        let (sides, rings) = (tube.sides, tube.rings);
        let along = tube.to - tube.from;
        // The section turns counter-clockwise about the way it goes.
        let [u, v] = tube.half_axes;
        let v = if u.cross(v).dot(along) < 0.0 { -v } else { v };
        for ring in 0..=rings {
            let t = ring as f64 / rings as f64;
            let scale = 1.0 + t * (tube.taper - 1.0);
            for side in 0..sides {
                let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
                self.soup.push_vertex(tube.from + t * along + scale * (cos * u + sin * v));
            }
        }
        self.soup.push_vertex(tube.from);
        self.soup.push_vertex(tube.to);
        let vertex = |ring: usize, side: usize| first + (ring * sides + side % sides) as u32;
        let [start, end] = [0, 1].map(|i| vertex(rings + 1, 0) + i);
        for side in 0..sides {
            for ring in 0..rings {
                let [a, b] = [vertex(ring, side), vertex(ring, side + 1)];
                let [c, d] = [vertex(ring + 1, side + 1), vertex(ring + 1, side)];
                self.face([a, b, c])?;
                self.face([a, c, d])?;
            }
            self.face([vertex(0, side + 1), vertex(0, side), start])?;
            self.face([vertex(rings, side), vertex(rings, side + 1), end])?;
        }
        Ok(())
    }

    fn blade(&mut self, tube: &Tube) -> Result<(), Failure> {
        let first = self.soup.vertex_count();
        self.tube(tube)?;
        self.blade_vertices.extend(first..self.soup.vertex_count());
        Ok(())
    }

    fn main_rotor(&mut self) -> Result<(), Failure> {
        for blade in 0..4 {
            let (sin, cos) = (TAU * (f64::from(blade) / 4.0 + 0.07)).sin_cos();
            let (out, side) = (DVec3::new(cos, 0.0, sin), DVec3::new(-sin, 0.06, cos));
            let hub = DVec3::new(0.0, 1.58, 0.0);
            self.blade(&Tube::plate(hub + 0.2 * out, hub + 5.0 * out, 0.08 * side, 0.006))?;
        }
        Ok(())
    }

    fn tail_rotor(&mut self) -> Result<(), Failure> {
        let hub = DVec3::new(-5.55, 0.78, 0.22);
        self.ellipsoid([9, 16], hub, DVec3::new(0.09, 0.09, 0.06))?;
        for blade in 0..3 {
            let (sin, cos) = (TAU * (f64::from(blade) / 3.0 + 0.1)).sin_cos();
            let (out, side) = (DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.1));
            let plate = Tube::plate(hub + 0.07 * out, hub + 0.95 * out, 0.03 * side, 0.004);
            self.blade(&Tube { sides: 8, rings: 59, ..plate })?;
        }
        Ok(())
    }

    fn skids(&mut self) -> Result<(), Failure> {
        for side in [-1.0, 1.0] {
            let z = 0.85 * side;
            let skid = Tube::round([1.7, -1.35, z], [-1.6, -1.35, z], 0.06, 0.06);
            self.tube(&Tube { sides: 12, rings: 69, ..skid })?;
            for x in [-0.8, 0.8] {
                let strut = Tube::round([x, -0.75, 0.5 * side], [x, -1.35, z], 0.045, 0.04);
                self.tube(&Tube { sides: 10, rings: 23, ..strut })?;
            }
        }
        Ok(())
    }

    fn fins(&mut self) -> Result<(), Failure> {
        let fin = |from: [f64; 3], to: [f64; 3], chord: f64| {
            let plate = Tube::plate(from.into(), to.into(), DVec3::new(chord, 0.0, 0.0), 0.025);
            Tube { sides: 12, rings: 39, ..plate }
        };
        self.tube(&fin([-4.6, 0.62, 0.1], [-4.6, 0.62, 1.1], 0.25))?;
        self.tube(&fin([-4.6, 0.62, -0.1], [-4.6, 0.62, -1.1], 0.25))?;
        self.tube(&fin([-5.4, 0.8, 0.0], [-5.9, 1.9, 0.0], 0.32))
    }

    fn face(&mut self, corners: [u32; 3]) -> Result<(), Failure> {
        self.soup.push_face(&corners).map_err(Failure::mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::mesh_of;

    #[test]
    fn every_part_is_closed_and_the_faces_are_as_many_as_the_papers() {
        let craft = rotorcraft().unwrap();
        assert_eq!(craft.soup.face_count(), 34_708);
        let mesh = mesh_of(&craft.soup).unwrap();
        assert!(mesh.topology().is_closed());
        assert_eq!(mesh.topology().components().count, 22);
        assert!(mesh.volume() > 0.0);
        let count = 4 * (10 * 120 + 2) + 3 * (8 * 60 + 2);
        assert_eq!(craft.blade_vertices.len(), count);
    }
}
