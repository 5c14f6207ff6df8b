//! Section 4.2: the distance alone and either curvature norm alone, from many faces to few.

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use rayon::prelude::*;
use simplify::{Options, PlacementRule, Preset};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use super::distances::Original;
use super::head;
use super::runs::{CHAINS, IGEA, distance_only, levels, simplified};
use super::similarity::{add_similarity_claim, list};
use xtask_common::Failure;
use xtask_common::decimals::plain;

/// The faces of Igea, and those that it is brought to: by 30 percent, to a ninth, and to the
/// paper's number.
const IGEA_ORIGINAL: usize = 268_686;
const IGEA_FACES: [usize; 3] = [188_080, 30_000, 3_000];
/// Samples in either direction: the smallest means are a few millionths of the diagonal.
const SAMPLES: usize = 400_000;
/// How far vertices are moved, in mean edge lengths, to see how much of a result is chance, and how
/// often.
const NUDGE: f64 = 1e-5;
const NUDGES: u64 = 4;

/// A way to simplify.
struct Way {
    name: &'static str,
    options: fn() -> Options,
}

const WAYS: [Way; 7] = [
    Way { name: "distance", options: distance_only },
    Way { name: "L1", options: || Options::preset(Preset::PaperL1Guarded) },
    Way { name: "L2", options: || Options::preset(Preset::PaperL2Guarded) },
    Way { name: "L1, midpoint", options: || l1_placed(PlacementRule::Midpoint) },
    Way { name: "L1, least quadric", options: || l1_placed(PlacementRule::Optimal) },
    Way { name: "L1, as published", options: || Options::preset(Preset::PaperL1) },
    Way { name: "L2, as published", options: || Options::preset(Preset::PaperL2) },
];
/// Their places in the list.
const DISTANCE: usize = 0;
const L1: usize = 1;
const L2: usize = 2;
const MIDPOINT: usize = 3;
const QUADRIC: usize = 4;
/// The ways from here on are shown and not on record: the next item records them at four face counts.
const SHOWN_ONLY: usize = 5;

/// The first norm with the new vertex elsewhere than the paper puts it.
fn l1_placed(placement: PlacementRule) -> Options {
    let mut options = Options::preset(Preset::PaperL1Guarded);
    options.placement = placement;
    options
}

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The distance alone (quadrics with optimal placement) and either curvature norm alone, with \
         the new vertex at the butterfly point: one run each, stopped at three levels. In L1 and L2 no collapse turns a face over or leaves a \
         sliver; as published, every collapse is allowed that keeps the mesh manifold. Two more runs \
         by the L1 norm put the vertex at the midpoint of the edge, and where the squared distances \
         to the planes of the faces round it are least. The paper prints no such numbers. Those of \
         an independent program, written from the same paper, are beside ours.",
    );
    item.stand_in(
        "A head of 20,480 faces made of formulas, brought to the same shares of its faces; with \
         models, Igea.",
    );
    item.how(
        &["simplify::simplify", "simplify::CurvatureNorm", "simplify::CollapseLog::replay"],
        &[
            "curvmesh simplify IN -o OUT --preset paper-l1-guarded --faces 3000",
            "curvmesh distance IN OUT",
        ],
    );
    let made = mesh_of(&head::head()?)?;
    let share = made.topology().face_count() as f64 / IGEA_ORIGINAL as f64;
    let faces = IGEA_FACES.map(|faces| (share * faces as f64).round() as usize);
    let means = Means::of(&made, faces)?;
    means.add(item, "made head");
    means.add_place_claim(item, "butterfly point");
    if run.quick {
        return Ok(());
    }
    add_chance(item, "made head", &made, faces[2])?;
    if let Some(igea) = run.model(item, IGEA)? {
        let means = Means::of(&igea, IGEA_FACES)?;
        means.add(item, "Igea");
        means.add_place_claim(item, "butterfly point, Igea");
        add_similarity_claim(item, "norms are similar, Igea", means.ratios(L2, L1));
    }
    Ok(())
}

/// Mean distances in percent of the diagonal, by way and level.
struct Means {
    faces: [usize; 3],
    by_way: Vec<[f64; 3]>,
}

impl Means {
    fn of(mesh: &TriMesh, faces: [usize; 3]) -> Result<Self, Failure> {
        let original = Original::with_samples(mesh, SAMPLES)?;
        let means_of = |way: &Way| -> Result<[f64; 3], Failure> {
            let mut means = [0.0; 3];
            for (mean, level) in means.iter_mut().zip(levels(mesh, (way.options)(), &faces)?) {
                *mean = original.mean_percent(&level)?;
            }
            Ok(means)
        };
        let by_way = WAYS.par_iter().map(means_of).collect::<Result<_, _>>()?;
        Ok(Self { faces, by_way })
    }

    fn add(&self, item: &mut Item, model: &str) {
        let distance = self.by_way[DISTANCE];
        let mut lines = Vec::new();
        for (place, (way, means)) in WAYS.iter().zip(&self.by_way).enumerate() {
            let mut line = vec![way.name.to_owned()];
            for i in 0..means.len() {
                let quantity = format!("{model}, {}, {} faces, mean in %", way.name, self.faces[i]);
                if place < SHOWN_ONLY {
                    item.number_within(quantity, means[i], CHAINS);
                }
                line.push(format!("{:.5} ({:.1})", means[i], means[i] / distance[i]));
            }
            lines.push(line);
        }
        let counts = self.faces.iter().map(|&faces| plain(faces as f64));
        item.table(
            format!(
                "{model}: mean distance in % of the diagonal, by number of faces; in brackets, how \
                 many times that by the distance alone."
            ),
            ["way".to_owned()].into_iter().chain(counts),
            lines,
        );
    }

    /// One way over another, at every level.
    fn ratios(&self, way: usize, over: usize) -> [f64; 3] {
        std::array::from_fn(|i| self.by_way[way][i] / self.by_way[over][i])
    }

    fn add_place_claim(&self, item: &mut Item, name: &str) {
        let [midpoint, quadric] = [MIDPOINT, QUADRIC].map(|way| self.ratios(L1, way));
        let is_least = |ratios: [f64; 3]| ratios.iter().all(|&ratio| ratio < 1.0);
        let outcome = match (is_least(midpoint), is_least(quadric)) {
            (true, true) => Outcome::Holds,
            (false, false) => Outcome::Fails,
            _ => Outcome::InPart,
        };
        item.claim(
            name,
            outcome,
            format!(
                "by the L1 norm the mean error at the butterfly point is {} times that at the \
                 midpoint, and {} times that where the squared distance to the planes is least (from \
                 many faces to few)",
                list(midpoint),
                list(quadric)
            ),
        );
    }
}

/// How much of the result of a norm is chance: the same mesh again, its vertices hardly moved.
fn add_chance(item: &mut Item, model: &str, mesh: &TriMesh, faces: usize) -> Result<(), Failure> {
    let original = Original::with_samples(mesh, SAMPLES)?;
    let mut lines = Vec::new();
    for way in &WAYS[..=L2] {
        let mean_of = |seed| -> Result<f64, Failure> {
            let nudged = nudged(mesh, seed);
            original.mean_percent(&simplified(&nudged, (way.options)(), faces)?.mesh)
        };
        let mut means: Vec<f64> =
            (0..NUDGES).into_par_iter().map(mean_of).collect::<Result<_, _>>()?;
        means.sort_by(f64::total_cmp);
        let mut line = vec![way.name.to_owned()];
        for (end, mean) in [("least", means.first()), ("most", means.last())] {
            let &mean = mean.unwrap_or(&f64::NAN);
            let quantity = format!("{model}, {}, {faces} faces, {end} mean in %, moved", way.name);
            item.number_within(quantity, mean, CHAINS);
            line.push(format!("{mean:.5}"));
        }
        lines.push(line);
    }
    item.table(
        format!(
            "{model}, {} faces: least and most of {NUDGES} mean distances, after all vertices were \
             moved at random by up to {NUDGE} of an edge. The collapses depend on each other like \
             links of a chain, so that results of a norm alone are to a good part chance.",
            plain(faces as f64)
        ),
        ["way", "least", "most"],
        lines,
    );
    Ok(())
}

/// The mesh with all vertices moved a little.
fn nudged(mesh: &TriMesh, seed: u64) -> TriMesh {
    let mut random = SplitMix64::new(seed);
    let faces = mesh.topology().face_count().max(1) as f64;
    let size = NUDGE * (mesh.area() / faces).sqrt();
    let mut moved = mesh.clone();
    for p in moved.positions_mut() {
        *p += size * DVec3::from_array([(); 3].map(|()| random.symmetric()));
    }
    moved
}
