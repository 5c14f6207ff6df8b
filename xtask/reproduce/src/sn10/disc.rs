//! Fig. 1 to 3: the circular neighbourhood of a face, an osculating circle, principal directions.

use core::f64::consts::{PI, TAU};

use curvpatch::{CurvatureEstimator, DiscCurvature, Params};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::{AnalyticSurface, Diagonals, Ellipsoid, Irregular, Saddle};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::drawing::{BLUE_LINE, DARK, Drawing, GREEN, ORANGE, RED_LINE};
use super::patches::{PRESETS, STYLE, estimator, face_at};
use super::statistics::median;
use xtask_common::Failure;

const ELLIPSOID: Ellipsoid = Ellipsoid { semi_axes: DVec3::new(1.5, 1.1, 0.8) };
const SADDLE: Saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
/// Where the face is, seen from the centre, and where the camera is.
const PLACE: DVec3 = DVec3::new(0.2, -0.35, 0.8);
const TOWARD: DVec3 = DVec3::new(0.45, -1.0, 0.8);
const RADIUS: f64 = 0.55;

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Planes through the normal of a face cut the mesh in polygons; followed for the length \
         r_g to either side they make up the circular neighbourhood of the face. The ends of a \
         polygon tell the radius of an osculating circle; its extremes over all planes tell the \
         principal curvatures and directions. Taken literally, \"maximal and minimal diameters\" \
         would not do: a chord is as short for a curvature as for its negative, so on a saddle \
         the longest one lies along an asymptotic direction. Extremes of the signed curvature are \
         taken instead.",
    );
    item.stand_in(
        "An irregular mesh of an ellipsoid in place of the paper's mesh, which is not named.",
    );
    item.how(
        &["curvpatch::CurvatureEstimator::at", "curvpatch::CurvatureEstimator::trace"],
        &["curvmesh curvature IN -o OUT.ply --estimator face --radius 0.5 --preset paper"],
    );
    let irregular = Irregular { jitter: 0.2, seed: 5 };
    let mesh = mesh_of(&ELLIPSOID.irregular_icosphere(3, irregular).map_err(Failure::mesh)?)?;
    let face = face_at(&mesh, PLACE, PLACE);
    for (name, params) in PRESETS {
        let disc = estimator(&mesh, params)?.at(face, RADIUS).map_err(Failure::mesh)?;
        add_errors(item, name, &disc);
    }
    draw(run, item, &mesh, face)?;
    literal_diameters(item, &mesh)
}

/// The differences between curvatures and directions of a face and of the ellipsoid.
fn add_errors(item: &mut Item, preset: &str, disc: &DiscCurvature) {
    let exact = ELLIPSOID.principal_curvatures(disc.center);
    let [k1, k2] = disc.curvatures;
    item.number(format!("{preset} preset, error of kappa 1 (%)"), 100.0 * (k1 / exact.max - 1.0));
    item.number(format!("{preset} preset, error of kappa 2 (%)"), 100.0 * (k2 / exact.min - 1.0));
    if let Some([of_max, _]) = exact.directions {
        let off = disc.frame[0].cross(of_max).length().atan2(disc.frame[0].dot(of_max).abs());
        item.number(format!("{preset} preset, directions off by (degrees)"), off.to_degrees());
    }
}

fn draw(run: &Run<'_>, item: &mut Item, mesh: &TriMesh, face: FaceId) -> Result<(), Failure> {
    let estimator = estimator(mesh, Params::paper())?;
    let disc = estimator.at(face, RADIUS).map_err(Failure::mesh)?;
    let view = view_of(mesh, TOWARD, DVec3::Z)?;
    let figure = |drawing: &Drawing, name: &str, caption: &str| {
        drawing.draw(run, &view, &STYLE, name, caption)
    };

    let mut neighbourhood = Drawing::of(mesh, &[face], ORANGE);
    let angles = (0..36).map(|i| PI * f64::from(i) / 36.0);
    let traces: Vec<_> = angles.map(|angle| estimator.trace(face, &disc, angle)).collect();
    let first = |t: &curvpatch::SectionTrace| t.points.first().copied();
    let last = |t: &curvpatch::SectionTrace| t.points.last().copied();
    let ends = traces.iter().filter_map(last).chain(traces.iter().filter_map(first));
    let mut rim: Vec<DVec3> = ends.collect();
    rim.extend(rim.first().copied());
    for trace in traces.iter().step_by(2) {
        neighbourhood.line(trace.points.clone(), BLUE_LINE, 1.6);
    }
    neighbourhood.line(rim.clone(), RED_LINE, 4.0);

    // Half of the mesh, cut open along the section, seen across it.
    let across = disc.frame[1] * disc.frame[1].dot(TOWARD).signum();
    let behind = |face: FaceId| {
        mesh.triangle(face).iter().all(|corner| (*corner - disc.center).dot(across) < 0.0)
    };
    let mut circle = Drawing::part_of(mesh, &[face], ORANGE, behind);
    let trace = estimator.trace(face, &disc, 0.0);
    circle.line(osculating_circle(&disc, 0), RED_LINE, 4.0);
    if let (Some(start), Some(end)) = (first(&trace), last(&trace)) {
        circle.line(vec![start, end], DARK, 3.0);
        circle.dot(start, 0.025, across, DARK);
        circle.dot(end, 0.025, across, DARK);
    }
    // In front of the circle, which nearly coincides with it.
    circle.line(trace.points.iter().map(|p| *p + 0.02 * across).collect(), BLUE_LINE, 6.0);
    let section_view = view.from_direction(across + 0.3 * disc.normal(), disc.normal());

    let mut directions = Drawing::of(mesh, &[face], ORANGE);
    directions.line(rim, DARK, 2.0);
    for (axis, color) in disc.frame.into_iter().zip([RED_LINE, BLUE_LINE, GREEN]) {
        directions.arrow(disc.center, 0.8 * RADIUS * axis, TOWARD, color);
    }
    let figures = [
        figure(
            &neighbourhood,
            "sn10-neighbourhood",
            "Fig. 1: the sections of length r_g to either side of a face, and their ends",
        )?,
        circle.draw(
            run,
            &section_view,
            &STYLE,
            "sn10-osculating-circle",
            "Fig. 2: a section (blue), its diameter d (black) and its osculating circle (red), the mesh cut open",
        )?,
        figure(
            &directions,
            "sn10-directions",
            "Fig. 3: principal directions T1 (red) and T2 (blue), and the normal (green)",
        )?,
    ];
    item.side_by_side(figures);
    Ok(())
}

/// The half of the osculating circle of a principal section that is nearer to the face.
fn osculating_circle(disc: &DiscCurvature, axis: usize) -> Vec<DVec3> {
    let (radius, tangent) = (1.0 / disc.curvatures[axis], disc.frame[axis]);
    let center = disc.center - radius * disc.normal();
    // The upper part of it: the rest says nothing about the face.
    let angles = (-60..=60).map(|i| 0.25 * TAU * f64::from(i) / 60.0);
    angles.map(|a| center + radius * (a.cos() * disc.normal() + a.sin() * tangent)).collect()
}

/// The errors of curvatures read from the longest and the shortest chord, beside the signed extremes: on an
/// ellipsoid, where both principal curvatures have one sign, and on a saddle.
fn literal_diameters(item: &mut Item, ellipsoid: &TriMesh) -> Result<(), Failure> {
    let saddle = mesh_of(&SADDLE.mesh(32, Diagonals::Alternating).map_err(Failure::mesh)?)?;
    let inside = |p: DVec3| p.x.abs() <= 0.45 && p.y.abs() <= 0.45;
    let on_saddle = Diameters::of(&saddle, &SADDLE, inside)?;
    let on_ellipsoid = Diameters::of(ellipsoid, &ELLIPSOID, |_| true)?;
    item.number("saddle, literal diameters, curvature error (%)", on_saddle.literal);
    item.number("saddle, literal diameters, directions off by (degrees)", on_saddle.turned);
    item.number("saddle, signed extremes, curvature error (%)", on_saddle.signed);
    item.claim(
        "principal directions from diameters",
        on_saddle.and(on_ellipsoid),
        format!(
            "from the longest and shortest chord the curvatures are {:.1} % wrong on an ellipsoid and {:.0} % \
             on a saddle, where the directions are {:.0} degrees off; from the extremes of the signed \
             curvature they are {:.1} % and {:.1} % wrong. The claim holds on a surface if the chords are at most \
             twice as wrong as the extremes (medians over faces)",
            on_ellipsoid.literal,
            on_saddle.literal,
            on_saddle.turned,
            on_ellipsoid.signed,
            on_saddle.signed
        ),
    );
    Ok(())
}

/// Medians over the faces of a mesh.
#[derive(Clone, Copy)]
struct Diameters {
    /// Error of the curvatures by chord length, in percent of the larger curvature.
    literal: f64,
    /// Angle between the longest chord and the nearer principal direction, in degrees.
    turned: f64,
    /// Error of the extremes of the signed curvature, in percent of the larger curvature.
    signed: f64,
}

impl Diameters {
    fn of(
        mesh: &TriMesh,
        surface: &impl AnalyticSurface,
        inside: impl Fn(DVec3) -> bool,
    ) -> Result<Self, Failure> {
        let radius = 2.5 * mesh.mean_edge_length().unwrap_or(0.0);
        let estimator = estimator(mesh, Params::paper())?;
        let (mut literal, mut turned, mut signed) = (Vec::new(), Vec::new(), Vec::new());
        for face in mesh.topology().faces().step_by(6) {
            let disc = estimator.at(face, radius).map_err(Failure::mesh)?;
            if disc.truncated || !inside(disc.center) {
                continue;
            }
            let exact = surface.principal_curvatures(disc.center);
            let scale = exact.max.abs().max(exact.min.abs());
            let [longest, shortest] = extreme_chords(&estimator, face, &disc);
            let error = |values: [f64; 2]| {
                let (max, min) = (values[0].max(values[1]), values[0].min(values[1]));
                100.0 * (max - exact.max).abs().max((min - exact.min).abs()) / scale
            };
            literal.push(error([longest.1, shortest.1]));
            signed.push(error(disc.curvatures));
            let off = longest.0.to_degrees() % 90.0;
            turned.push(off.min(90.0 - off));
        }
        let [literal, turned, signed] = [literal, turned, signed].map(median);
        Ok(Self { literal, turned, signed })
    }

    /// Whether the chords do, where they are at most twice as wrong as the signed extremes.
    fn is_determined(self) -> bool {
        self.literal <= 2.0 * self.signed
    }

    /// The outcome over two surfaces.
    fn and(self, other: Self) -> Outcome {
        match (self.is_determined(), other.is_determined()) {
            (true, true) => Outcome::Holds,
            (false, false) => Outcome::Fails,
            _ => Outcome::InPart,
        }
    }
}

/// The angles (from the first principal direction) and curvatures of the sections with the longest
/// and the shortest chord.
fn extreme_chords(
    estimator: &CurvatureEstimator<'_>,
    face: FaceId,
    disc: &DiscCurvature,
) -> [(f64, f64); 2] {
    let mut longest = (0.0, (0.0, 0.0));
    let mut shortest = (f64::INFINITY, (0.0, 0.0));
    for i in 0..36 {
        let angle = PI * f64::from(i) / 36.0;
        let trace = estimator.trace(face, disc, angle);
        let chord = trace.chord();
        if chord > longest.0 {
            longest = (chord, (angle, trace.curvature));
        }
        if chord < shortest.0 {
            shortest = (chord, (angle, trace.curvature));
        }
    }
    [longest.1, shortest.1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worse_chords_turn_the_verdict() {
        let good = Diameters { literal: 1.5, turned: 1.0, signed: 1.0 };
        let bad = Diameters { literal: 90.0, ..good };
        assert_eq!(good.and(good), Outcome::Holds);
        assert_eq!(bad.and(good), Outcome::InPart);
        assert_eq!(bad.and(bad), Outcome::Fails);
    }
}
