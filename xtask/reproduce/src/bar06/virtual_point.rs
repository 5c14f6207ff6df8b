//! Sec. 5: where the virtual points lie on the edges, which the paper leaves open.

use dcurv::{intersection_angle, total_willmore_energy};
use dtri_flip::{Change, FlipCost, FlipOptions, Quad, ShapeConstraint, Stencil, lattice_error};
use glam::DVec3;
use mesh_core::{TriMesh, VertexId};
use mesh_shapes::{SignedDistance, Torus, inset_cube};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use xtask_common::Failure;

const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };
const SIZES: [[usize; 2]; 3] = [[12, 6], [18, 9], [24, 12]];
const INSET: f64 = 0.2;
/// Lattice steps on a side of a triangle.
const SUBDIVISIONS: u32 = 20;
/// A virtual point keeps this share of the edge from either end, so that no triangle vanishes.
const MARGIN: f64 = 0.05;

/// Where the virtual point of an edge lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Point {
    /// In the middle of the edge, as in the paper.
    Midpoint,
    /// At the foot of the longer altitude of its two triangles.
    Foot,
    /// Nearest to the centroid of its two triangles, weighted by area.
    Centroid,
}

const POINTS: [(Point, &str); 3] = [
    (Point::Midpoint, "midpoint"),
    (Point::Foot, "foot of the longest altitude"),
    (Point::Centroid, "nearest to the weighted centroid"),
];

impl Point {
    /// The virtual point of the edge from a to b between the apexes c and d.
    fn of(self, [a, b, c, d]: [DVec3; 4]) -> DVec3 {
        let along = b - a;
        let share = |p: DVec3| (p - a).dot(along) / along.length_squared();
        let twice_area = |apex: DVec3| along.cross(apex - a).length();
        let [left, right] = [c, d].map(twice_area);
        let share = match self {
            Self::Midpoint => 0.5,
            // On one edge, the longer altitude is that of the larger triangle.
            Self::Foot if left >= right => share(c),
            Self::Foot => share(d),
            Self::Centroid if left + right > 0.0 => {
                share((left * (a + b + c) + right * (a + b + d)) / (3.0 * (left + right)))
            }
            Self::Centroid => 0.5,
        };
        // Of an edge without length there is no share.
        a + if share.is_nan() { 0.5 } else { share.clamp(MARGIN, 1.0 - MARGIN) } * along
    }
}

/// The rule of the paper with another virtual point, on closed meshes; see
/// [`VirtualWillmore`](dtri_flip::VirtualWillmore).
struct Placed(Point);

impl FlipCost for Placed {
    type Cache = ();

    fn prepare(&self, _: &TriMesh) {}

    fn total(&self, mesh: &TriMesh) -> f64 {
        total_willmore_energy(mesh)
    }

    fn change(&self, mesh: &TriMesh, _: &(), quad: &Quad) -> Change {
        let [a, b, c, d] = quad.corners;
        let [bc, ca, ad, db] = quad.sides.map(|side| mesh.topology().apex(side.twin()));
        Change {
            before: self.split_energy(mesh, [a, b, c, d], [bc, ca, ad, db]),
            after: self.split_energy(mesh, [d, c, a, b], [ca, ad, db, bc]),
        }
    }

    fn stencil(&self) -> Stencil {
        Stencil::AdjacentTriangles
    }

    fn length_exponent(&self) -> i32 {
        0
    }

    fn is_potential(&self) -> bool {
        false
    }
}

impl Placed {
    /// The energy of the four inner and four outer edges, with the edge from a to b split.
    fn split_energy(
        &self,
        mesh: &TriMesh,
        corners: [VertexId; 4],
        outer: [Option<VertexId>; 4],
    ) -> f64 {
        let [a, b, c, d] = corners.map(|v| mesh.position(v));
        let point = self.0.of([a, b, c, d]);
        let inner = intersection_angle(a, point, c, d)
            + intersection_angle(point, b, c, d)
            + intersection_angle(c, point, a, b)
            + intersection_angle(d, point, b, a);
        let sides = [(b, c), (c, a), (a, d), (d, b)].into_iter().zip(outer);
        let outside = sides.map(|((from, to), apex)| {
            apex.map_or(0.0, |v| intersection_angle(from, to, point, mesh.position(v)))
        });
        2.0 * (inner + outside.sum::<f64>())
    }
}

/// What one rule makes of one mesh: flips, W, area, and the mean distance from the torus.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Result4([f64; 4]);

pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The paper puts the virtual point into the middle of the edge and leaves open when another position \
         changes the outcome. Here are two more: the foot of the longest altitude of the two triangles at the edge, \
         and the point of the edge that is nearest to the centroid of both, weighted by area. Points keep 5 % of the \
         edge from its ends. Ties are broken by edge number.",
    );
    item.stand_in("The tori of DHKL01 and the cube of Fig. 4 with an inset of 0.2.");
    item.how(&["dtri_flip::FlipCost", "dtri_flip::VirtualWillmore", "dtri_flip::optimise"], &[]);
    let mut meshes = Vec::new();
    for [rings, sides] in SIZES {
        let mesh = mesh_of(&TORUS.shifted_mesh(rings, sides).map_err(Failure::mesh)?)?;
        meshes.push((format!("torus {rings} x {sides}"), mesh, true));
    }
    let cube = mesh_of(&inset_cube(INSET).map_err(Failure::mesh)?)?;
    meshes.push(("cube".into(), cube, false));
    let mut lines = Vec::new();
    let mut outcomes = Vec::new();
    for (name, mesh, is_torus) in &meshes {
        lines.push(line(name, "before", measure(mesh, 0, *is_torus)));
        let mut results = Vec::new();
        for (point, words) in POINTS {
            let mut flipped = mesh.clone();
            let options = FlipOptions {
                shape: Some(ShapeConstraint::Unrestricted),
                ..FlipOptions::default()
            };
            let report = dtri_flip::optimise(&mut flipped, &Placed(point), &options)
                .map_err(Failure::mesh)?;
            let result = measure(&flipped, report.flips, *is_torus);
            for (what, value) in ["flips", "W", "area", "mean distance"].iter().zip(result.0) {
                if *is_torus || *what != "mean distance" {
                    item.number(format!("{name}, {words}, {what}"), value);
                }
            }
            lines.push(line(name, words, result));
            results.push(result);
        }
        outcomes.push(results);
    }
    let header = ["data", "virtual point", "flips", "W", "area", "mean distance from the torus"];
    item.table("Before and after, by the position of the virtual point.", header, lines);
    let best: Vec<String> = meshes
        .iter()
        .zip(&outcomes)
        .map(|((name, ..), results)| {
            let least =
                (0..POINTS.len()).min_by(|&a, &b| results[a].0[1].total_cmp(&results[b].0[1]));
            let spread = results.iter().map(|r| format!("{:.1}", r.0[1]));
            let spread: Vec<String> = spread.collect();
            let place = least.map_or("none", |i| POINTS[i].1);
            format!("{name}: W ends at {}, least for the {place}", spread.join(", "))
        })
        .collect();
    item.claim(
        "position of virtual points",
        matters(&outcomes),
        format!(
            "for midpoint, foot and centroid in turn, {}. Holds if the results differ on all data sets, in part \
             if on some",
            best.join("; ")
        ),
    );
    Ok(())
}

fn measure(mesh: &TriMesh, flips: u64, is_torus: bool) -> Result4 {
    let distance = match is_torus {
        true => lattice_error(mesh, SUBDIVISIONS, |p| TORUS.signed_distance(p)).mean,
        false => f64::NAN,
    };
    Result4([flips as f64, total_willmore_energy(mesh), mesh.area(), distance])
}

fn line(name: &str, point: &str, Result4([flips, w, area, distance]): Result4) -> Vec<String> {
    let distance = if distance.is_nan() { "-".into() } else { format!("{distance:.4}") };
    vec![
        name.to_owned(),
        point.to_owned(),
        format!("{flips}"),
        format!("{w:.2}"),
        format!("{area:.2}"),
        distance,
    ]
}

/// Whether the position affects the outcome: on all data sets, some, or none. Results are the same
/// if flips, W and area are.
fn matters(data: &[Vec<Result4>]) -> Outcome {
    let same = |a: &Result4, b: &Result4| {
        a.0.iter().zip(b.0).take(3).all(|(x, y)| (x - y).abs() <= 1e-9 * x.abs().max(1.0))
    };
    let differs = |results: &&Vec<Result4>| {
        results.first().is_some_and(|first| results.iter().any(|other| !same(first, other)))
    };
    match data.iter().filter(differs).count() {
        0 => Outcome::Fails,
        n if n == data.len() => Outcome::Holds,
        _ => Outcome::InPart,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dtri_flip::VirtualWillmore;

    #[test]
    fn equal_results_turn_the_verdict() {
        let [one, other] = [1.0, 2.0].map(|w| Result4([3.0, w, 5.0, f64::NAN]));
        assert_eq!(matters(&[vec![one, other]]), Outcome::Holds);
        assert_eq!(matters(&[vec![one, other], vec![one, one]]), Outcome::InPart);
        assert_eq!(matters(&[vec![one, one]]), Outcome::Fails);
    }

    #[test]
    fn the_midpoint_is_the_rule_of_the_library() {
        let mesh = mesh_of(&TORUS.shifted_mesh(12, 6).unwrap()).unwrap();
        for edge in mesh.topology().edges() {
            let Some(quad) = Quad::around(mesh.topology(), edge) else { continue };
            let ours = Placed(Point::Midpoint).change(&mesh, &(), &quad);
            let library = VirtualWillmore.change(&mesh, &(), &quad);
            assert!((ours.before - library.before).abs() < 1e-12, "{edge:?}");
            assert!((ours.after - library.after).abs() < 1e-12, "{edge:?}");
        }
    }

    #[test]
    fn feet_and_centroids_lie_where_the_altitudes_fall() {
        let [a, b] = [DVec3::ZERO, 4.0 * DVec3::X];
        let [c, d] = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(3.0, -1.0, 0.0)];
        assert_eq!(Point::Foot.of([a, b, c, d]), DVec3::X);
        assert_eq!(Point::Foot.of([a, b, d, c]), DVec3::X);
        // Areas 4 and 2, centroids at x = 5/3 and 7/3.
        let x = (4.0 * 5.0 / 3.0 + 2.0 * 7.0 / 3.0) / 6.0;
        assert!(Point::Centroid.of([a, b, c, d]).distance(x * DVec3::X) < 1e-12);
        let far = DVec3::new(40.0, 9.0, 0.0);
        assert!(Point::Foot.of([a, b, far, d]).distance(3.8 * DVec3::X) < 1e-12);
    }
}
