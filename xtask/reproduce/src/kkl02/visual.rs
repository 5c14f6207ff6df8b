//! Fig. 6: a head without thin parts, by distance alone and with the curvature.

use glam::DVec3;
use mesh_core::TriMesh;

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::distances::{NOISE, Original};
use super::head;
use super::runs::{CHAINS, IGEA, distance_only, simplified, with_curvature};
use mesh_render::Style;
use xtask_common::Failure;
use xtask_common::decimals::plain;

/// The faces of the figure's original and of its results.
const FACES: usize = 3_000;
/// The made head is simplified to the same share of its faces, but not below what shows a face.
const MADE_FACES: usize = 1_000;
/// The commands that give the results of the made head, whose file is beside the page.
const COMMANDS: [&str; 3] = [
    "curvmesh simplify kkl02-made-head-original.ply -o distance.ply --faces 1000 --preset quadrics",
    "curvmesh simplify kkl02-made-head-original.ply -o both.ply --faces 1000 --preset quadrics --curvature-weight 1",
    "curvmesh distance kkl02-made-head-original.ply both.ply --samples 100k",
];

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "A head by the distance alone and by distance and curvature together. Where the curvature \
         is high is told by the original: the tenth of its surface that is most curved.",
    );
    item.stand_in("A head of 20,480 faces made of formulas, to 1,000; with models, Igea to 3,000 as in the paper.");
    item.how(
        &["simplify::simplify", "simplify::CurvatureFactor", "mesh_metric::compare"],
        &COMMANDS,
    );
    let made = mesh_of(&head::head()?)?;
    let shares = add_model(run, item, "made head", &made, MADE_FACES, DVec3::new(0.35, 0.1, 1.0))?;
    claim(item, "more triangles where it is curved", shares);
    if let Some(igea) = run.model(item, IGEA)? {
        item.number("faces of Igea", igea.topology().face_count() as f64);
        let shares = add_model(run, item, "Igea", &igea, FACES, DVec3::new(0.0, 0.0, 1.0))?;
        claim(item, "more triangles where it is curved, Igea", shares);
    }
    Ok(())
}

fn claim(item: &mut Item, name: &str, [distance, both]: [f64; 2]) {
    item.claim(
        name,
        more_triangles(distance, both),
        format!(
            "of the triangles {:.1} % lie on the most curved tenth of the surface by the distance \
             alone, {:.1} % with the curvature",
            100.0 * distance,
            100.0 * both
        ),
    );
}

/// Whether the share of triangles on the most curved part rises by more than chance.
fn more_triangles(distance: f64, both: f64) -> Outcome {
    Outcome::of(both > (1.0 + NOISE) * distance)
}

/// Both ways on one model; returns the share of triangles on its most curved tenth.
fn add_model(
    run: &Run<'_>,
    item: &mut Item,
    name: &str,
    mesh: &TriMesh,
    faces: usize,
    toward: DVec3,
) -> Result<[f64; 2], Failure> {
    let original = Original::new(mesh)?;
    let curved = MostCurved::of(mesh);
    let view = view_of(mesh, toward, DVec3::Y)?;
    let style = Style { size: [620, 720], edge_width: 0.7, ..Style::DEFAULT };
    let file = |what: &str| file_of(name, what);
    let count = |mesh: &TriMesh| plain(mesh.topology().face_count() as f64);
    let caption = format!("{name}, original, {} faces", count(mesh));
    let smooth = Style { edge_width: 0.0, ..style.clone() };
    let mut figures = vec![run.picture(mesh, &view, &smooth, &file("original"), &caption)?];
    let mut shares = [0.0; 2];
    let ways =
        [("distance only", distance_only()), ("distance and curvature", with_curvature(1.0))];
    for ((way, options), share) in ways.into_iter().zip(&mut shares) {
        let result = simplified(mesh, options, faces)?.mesh;
        *share = curved.share_of_faces(&original, &result);
        item.number_within(
            format!("{name}, {way}, share of triangles on the most curved tenth"),
            *share,
            CHAINS,
        );
        let result_faces = result.topology().face_count() as f64;
        item.number(format!("{name}, {way}, faces"), result_faces);
        let mean = original.mean_percent(&result)?;
        item.number_within(format!("{name}, {way}, mean distance in %"), mean, CHAINS);
        let caption = format!("{way}, {} faces, mean distance {mean:.4} %", count(&result));
        let file = file(&way.replace(' ', "-"));
        figures.push(run.picture(&result, &view, &style, &file, &caption)?);
    }
    item.side_by_side(figures);
    Ok(shares)
}

/// The name of the files of a model or of a result, without extension.
fn file_of(model: &str, what: &str) -> String {
    format!("kkl02-{}-{what}", model.to_lowercase().replace(' ', "-"))
}

/// The faces of a mesh that make up the tenth of its area with the highest curvature.
struct MostCurved(Vec<bool>);

impl MostCurved {
    const SHARE: f64 = 0.1;

    fn of(mesh: &TriMesh) -> Self {
        let curvatures = dcurv::Curvatures::of(mesh, &dcurv::CurvatureOptions::default());
        let topology = mesh.topology();
        let mut faces: Vec<(f64, f64, usize)> = topology
            .faces()
            .enumerate()
            .map(|(i, face)| {
                let corners = topology.face_vertices(face);
                let of = |v| curvatures.vertices()[v].abs_principal_sum().value();
                (corners.map(of).iter().sum(), mesh.face_area(face), i)
            })
            .collect();
        faces.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        let limit = Self::SHARE * mesh.area();
        let mut is_curved = vec![false; faces.len()];
        let mut area = 0.0;
        for (_, face_area, face) in faces {
            area += face_area;
            if area > limit {
                break;
            }
            is_curved[face] = true;
        }
        Self(is_curved)
    }

    /// The share of the faces of another mesh whose centre is nearest to such a face.
    fn share_of_faces(&self, original: &Original, mesh: &TriMesh) -> f64 {
        let centers: Vec<DVec3> = mesh
            .topology()
            .faces()
            .map(|face| mesh.triangle(face).into_iter().sum::<DVec3>() / 3.0)
            .collect();
        let nearest = original.surface.closest_points(&centers);
        let curved = nearest.iter().filter(|p| self.0.get(p.triangle as usize) == Some(&true));
        curved.count() as f64 / centers.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::{read_in, run_in};
    use crate::recorded::Recorded;
    use mesh_render::Paint;

    #[test]
    fn the_commands_give_the_recorded_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let run = Run { out: folder.path(), models: None, quick: true };
        let mesh = mesh_of(&head::head().unwrap()).unwrap();
        run.keep(&file_of("made head", "original"), &mesh, Paint::Clay).unwrap();
        COMMANDS.iter().for_each(|command| run_in(folder.path(), command));
        let (original, recorded) = (Original::new(&mesh).unwrap(), Recorded::read().unwrap());
        let curved = MostCurved::of(&mesh);
        for (file, way) in
            [("distance.ply", "distance only"), ("both.ply", "distance and curvature")]
        {
            let result = read_in(folder.path(), file);
            let values = [
                ("mean distance in %", original.mean_percent(&result).unwrap()),
                (
                    "share of triangles on the most curved tenth",
                    curved.share_of_faces(&original, &result),
                ),
            ];
            for (what, value) in values {
                let quantity = format!("made head, {way}, {what}");
                let expected = recorded.value("KKL02", "Fig. 6", &quantity).unwrap();
                assert!((value / expected - 1.0).abs() < 1e-6, "{quantity}: {value}, {expected}");
            }
        }
    }

    #[test]
    fn a_larger_share_of_triangles_turns_the_verdict() {
        assert_eq!(more_triangles(0.2, 0.19), Outcome::Fails);
        assert_eq!(more_triangles(0.19, 0.2), Outcome::Holds);
    }
}
