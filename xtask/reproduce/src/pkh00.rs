//! Pottmann and others 2000: the least distance, and how far from it simplified meshes are.

use clap::ValueEnum;
use simplify::FitNorm;

use super::item::Item;
use super::run::Run;
use super::step::Step;
use benches::limit_study::{Fineness, Row, Shape, of_one_triangle, plot};
use xtask_common::Failure;

pub(super) const STEPS: [Step; 1] =
    [Step { name: "Distance over the least possible one", data: &[], compute }];

/// The study, which takes long; see its first lines.
const STUDY: &str = include_str!("../../../benches/recorded/limit-study.csv");

fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Fine meshes of surfaces whose exact distance is known, simplified to 500, 2,000 and 8,000 \
         faces. The distance of the result from the exact surface, both ways, times the number of \
         faces, beside the least possible one; l1 and max are what a preset was told to make small. The \
         study is on record; a ratio of 1 cannot be had, because vertices share their places and a closed \
         surface needs vertices of other valences than 6. The fine mesh lies on both sides of the surface \
         alike. On the rounded plate, which is flat or cylindrical almost everywhere, the limit says \
         nothing.",
    );
    item.how(
        &["simplify::simplify", "simplify::RefineOptions::minimising"],
        &[
            "cargo run --release -p benches -- limit-study",
            "curvmesh simplify IN -o OUT --faces 2000 --preset extreme",
        ],
    );
    let rows = Row::all_of(STUDY);
    let mut lines = Vec::new();
    for &shape in Shape::value_variants() {
        let of_shape: Vec<&Row> = rows.iter().filter(|row| row.is_of(shape)).collect();
        if of_shape.is_empty() {
            continue;
        }
        let limit = of_one_triangle(shape, &shape.mesh(Fineness::Quick)?);
        for row in &of_shape {
            let ratios = match shape.has_limit() {
                true => {
                    let ratio = row.scaled.over(limit);
                    [ratio.mean, ratio.rms, ratio.max].map(|ratio| format!("{ratio:.3}"))
                }
                false => ["-", "-", "-"].map(str::to_owned),
            };
            let [mean, rms, max] = ratios;
            let faces = row.left.to_string();
            lines.push(vec![shape.to_string(), row.program.clone(), faces, mean, rms, max]);
        }
        let mut points: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
        // As each is without being told what to make small: more curves than these nobody tells apart.
        let has_own_norm = |row: &Row| {
            FitNorm::ALL.iter().any(|norm| row.program.ends_with(&format!(" {}", norm.name())))
        };
        for row in of_shape.into_iter().filter(|row| !has_own_norm(row)) {
            let point = [row.left as f64, row.scaled.mean];
            match points.iter_mut().find(|(name, _)| *name == row.program) {
                Some((_, points)) => points.push(point),
                None => points.push((row.program.clone(), vec![point])),
            }
        }
        let caption = format!("{shape}: the mean distance times the number of faces.");
        item.plot(&plot(shape, limit, &points), caption);
    }
    let header = ["surface", "program", "faces", "mean", "root mean square", "largest"];
    item.table("Distances over the least possible ones.", header, lines);
    Ok(())
}
