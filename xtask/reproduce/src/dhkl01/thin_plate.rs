//! Sec. 3: the thin-plate energy, which flips lower exactly if they lower F1.

use dcurv::{CurvatureOptions, Curvatures, VertexArea};
use dtri_flip::{CostName, FlipOptions};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::seven_points;

use super::super::flips::optimise;
use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use super::torus::{TORUS, paper_mesh};
use xtask_common::Failure;

/// The parameters a and b.
const PARAMETERS: [[f64; 2]; 3] = [[1.0, 0.0], [0.5, 0.5], [1.0, -1.0]];
/// The rest is constant if it changes by at most this share of the energy.
const ROUNDING: f64 = 1e-12;
/// Faces that are left out of the torus to make a boundary.
const LEFT_OUT: usize = 2;

pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The thin-plate energy is 4a times the integral of H², which is F1, and 2 (1 - a - b) times the integral of \
         K. Here it is summed over the vertices from |H| and the angle defects, before and after flips by F1. What is \
         left after 4a F1 must be 2 (1 - a - b) times 2π χ, by Gauss-Bonnet.",
    );
    item.how(
        &["dcurv::Totals::thin_plate_energy", "dtri_flip::CostName::total"],
        &["curvmesh flip IN -o OUT --cost f1 --shape-constraint unrestricted"],
    );
    let torus = paper_mesh(&TORUS)?;
    let meshes = [
        ("torus", torus.clone()),
        ("open torus", without_faces(&torus)?),
        ("seven points", mesh_of(&seven_points::given())?),
    ];
    let (mut lines, mut rests) = (Vec::new(), Vec::new());
    for (name, mesh) in &meshes {
        let mut flipped = mesh.clone();
        let options = FlipOptions { look_ahead: 2, ..FlipOptions::default() };
        let flips = optimise(&mut flipped, CostName::F1, VertexArea::Voronoi, &options)?.flips;
        for [a, b] in PARAMETERS {
            let [before, after] = [mesh, &flipped].map(|mesh| Rest::of(mesh, a, b));
            for (when, rest) in [("before", before), ("after", after)] {
                item.number(format!("{name}, a = {a}, b = {b}, energy {when}"), rest.energy);
            }
            let values = [before.energy, after.energy, before.rest, after.rest, before.expected];
            // Adding zero turns -0 into 0.
            let cells = values.map(|value| format!("{:.6}", (1e6 * value).round() / 1e6 + 0.0));
            let names = [(*name).to_owned(), format!("{a}, {b}"), flips.to_string()];
            lines.push(names.into_iter().chain(cells).collect());
            rests.extend([before, after]);
        }
    }
    let header = [
        "mesh",
        "a, b",
        "flips",
        "energy before",
        "energy after",
        "rest before",
        "rest after",
        "2 (1 - a - b) 2π χ",
    ];
    item.table("The rest is the energy less 4a F1.", header, lines);
    let off = rests.iter().map(Rest::off).fold(0.0, f64::max);
    item.claim(
        "constant integral of K",
        is_constant(&rests),
        format!(
            "on a closed torus, on one with boundary and on the seven points the rest is off by at most {off:.0e} of \
             the energy. Holds if that is rounding, at most {ROUNDING:.0e}"
        ),
    );
    Ok(())
}

/// The thin-plate energy of a mesh, and what is left of it after 4a F1.
#[derive(Clone, Copy, Debug)]
struct Rest {
    energy: f64,
    rest: f64,
    /// By Gauss-Bonnet.
    expected: f64,
    /// 4a F1, and the size of the sums.
    size: f64,
}

impl Rest {
    fn of(mesh: &TriMesh, a: f64, b: f64) -> Self {
        let curvatures = Curvatures::of(mesh, &CurvatureOptions::default());
        let k_factor = 2.0 * (1.0 - a - b);
        let energy = curvatures.vertices().as_slice().iter().map(|curvature| {
            let integrals = curvature.integrals();
            let h = curvature.abs_dihedral().value();
            4.0 * a * h * h * integrals.area.value() + k_factor * integrals.angle_defect.value()
        });
        let energy: f64 = energy.sum();
        let bending = 4.0 * a * CostName::F1.total(mesh, VertexArea::Voronoi);
        let topology = mesh.topology();
        let euler = topology.vertex_count() as f64 - topology.edge_count() as f64
            + topology.face_count() as f64;
        let expected = k_factor * core::f64::consts::TAU * euler;
        Self { energy, rest: energy - bending, expected, size: bending.abs() + expected.abs() }
    }

    /// How far the rest is from the constant, over the energy.
    fn off(&self) -> f64 {
        (self.rest - self.expected).abs() / self.size
    }
}

/// Whether the rest is what Gauss-Bonnet says on all meshes, on some, or on none.
fn is_constant(rests: &[Rest]) -> Outcome {
    match rests.iter().filter(|rest| rest.off() <= ROUNDING).count() {
        0 => Outcome::Fails,
        n if n == rests.len() => Outcome::Holds,
        _ => Outcome::InPart,
    }
}

/// A mesh without its first faces, so that it has a boundary.
fn without_faces(mesh: &TriMesh) -> Result<TriMesh, Failure> {
    let faces: Vec<[u32; 3]> = mesh.topology().triangles().skip(LEFT_OUT).collect();
    mesh_of(&PolygonSoup::from_triangles(mesh.positions(), &faces).map_err(Failure::mesh)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rest_that_changes_turns_the_verdict() {
        let same = Rest { energy: 5.0, rest: 2.0, expected: 2.0, size: 5.0 };
        let other = Rest { rest: 2.0 + 1e-9, ..same };
        assert_eq!(is_constant(&[same, same]), Outcome::Holds);
        assert_eq!(is_constant(&[same, other]), Outcome::InPart);
        assert_eq!(is_constant(&[other]), Outcome::Fails);
    }
}
