//! Sec. 4.2: the norms as published, and with constraints on the faces, at four face counts.

use mesh_core::TriMesh;
use rayon::prelude::*;
use simplify::{Options, Preset};

use super::super::item::Item;
use super::super::run::{Run, mesh_of};
use super::distances::Original;
use super::head;
use super::runs::{CHAINS, IGEA, levels};
use xtask_common::Failure;
use xtask_common::decimals::plain;

/// 30 % fewer than the original as in Fig. 4 (b), the number of Fig. 6 (c), and one on either side.
const IGEA_FACES: [usize; 4] = [188_080, 5_000, 3_000, 1_000];
const MADE_FACES: [usize; 4] = [14_336, 5_000, 3_000, 1_000];
const PRESETS: [Preset; 4] =
    [Preset::PaperL1, Preset::PaperL1Guarded, Preset::PaperL2, Preset::PaperL2Guarded];

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The paper names no constraint on faces. So the presets paper-l1 and paper-l2 have none: areas are \
         a third of the adjacent faces, the new vertex is at the butterfly point, and every collapse is \
         allowed that keeps the mesh manifold. The guarded presets add what the other presets of curvmesh \
         have: a collapse is rejected if it turns a face over or leaves a sliver. A guard is no \
         improvement as such: it helps at some face counts and harms at others.",
    );
    item.stand_in("A head of 20,480 faces made of formulas; with models, Igea.");
    item.how(
        &["simplify::simplify", "simplify::CurvatureNorm"],
        &[
            "curvmesh simplify IN -o OUT --preset paper-l1 --faces 5000",
            "curvmesh simplify IN -o OUT --preset paper-l1-guarded --faces 5000",
            "curvmesh distance IN OUT",
        ],
    );
    add(item, "made head", &mesh_of(&head::head()?)?, MADE_FACES)?;
    if !run.quick
        && let Some(igea) = run.model(item, IGEA)?
    {
        add(item, "Igea", &igea, IGEA_FACES)?;
    }
    Ok(())
}

fn add(item: &mut Item, model: &str, mesh: &TriMesh, faces: [usize; 4]) -> Result<(), Failure> {
    let original = Original::new(mesh)?;
    let of_preset = |&preset: &Preset| -> Result<Vec<[f64; 2]>, Failure> {
        let levels = levels(mesh, Options::preset(preset), &faces)?;
        levels.iter().map(|level| Ok([original.mean_percent(level)?, folded(level)])).collect()
    };
    let found: Vec<Vec<[f64; 2]>> =
        PRESETS.par_iter().with_max_len(1).map(of_preset).collect::<Result<_, _>>()?;
    let mut lines = Vec::new();
    for (preset, levels) in PRESETS.iter().zip(&found) {
        let mut line = vec![preset.to_string()];
        for (faces, &[mean, folded]) in faces.iter().zip(levels) {
            item.number_within(
                format!("{model}, {preset}, {faces} faces, mean in %"),
                mean,
                CHAINS,
            );
            line.push(format!("{mean:.4} ({folded:.1} %)"));
        }
        lines.push(line);
    }
    let header = ["preset".to_owned()].into_iter().chain(faces.map(|f| plain(f as f64)));
    item.table(
        format!(
            "{model}: mean distance in % of the diagonal, by number of faces; in brackets, the share of \
             edges whose faces are folded onto each other by more than 120 degrees."
        ),
        header,
        lines,
    );
    Ok(())
}

/// The share of edges whose two normals are more than 120 degrees apart, in percent.
fn folded(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    let (mut folded, mut edges) = (0_usize, 0_usize);
    for e in topology.edges() {
        let [left, right] = [e.half_edge(), e.half_edge().twin()].map(|h| topology.face(h));
        let (Some(left), Some(right)) = (left, right) else { continue };
        edges += 1;
        folded += usize::from(mesh.face_normal(left).dot(mesh.face_normal(right)) < -0.5);
    }
    100.0 * folded as f64 / edges.max(1) as f64
}
