//! Tables and a plot of the study of curvature.

use xtask_common::plot::{Axis, Plot, Series};

use super::programs::{Missing, Program};
use super::row::{Cell, Ours, Row};

/// Errors below this value count as this value, so that exact results do not decide means of logarithms.
const FLOOR: f64 = 1e-5;

/// Geometric means of errors by program and noise, and the cells that other estimators win.
#[must_use]
pub(super) fn tables(rows: &[Row]) -> String {
    let mut levels = distinct(rows, |row| row.noise);
    levels.sort_by(f64::total_cmp);
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::ASCII_MARKDOWN);
    let heads = levels.iter().map(|noise| format!("noise {noise}: median, 95 %"));
    let rest = ["order", "unknown", "within", "vertices/s"].map(str::to_owned);
    table.set_header(std::iter::once(String::new()).chain(heads).chain(rest));
    for program in distinct(rows, |row| row.program.clone()) {
        let of_program: Vec<&Row> = rows.iter().filter(|row| row.program == program).collect();
        let mut cells = vec![program];
        for &level in &levels {
            let mean = |of: fn(&Row) -> f64| {
                let errors: Vec<f64> = of_program
                    .iter()
                    .filter(|row| row.noise == level)
                    .map(|row| of(row))
                    .filter(|error| error.is_finite())
                    .map(|error| error.max(FLOOR))
                    .collect();
                100.0 * geometric_mean(&errors)
            };
            cells.push(format!("{:.3} % {:.3} %", mean(|row| row.k_median), mean(|row| row.k_95)));
        }
        let mean = |of: fn(&Row) -> f64| {
            let values: Vec<f64> =
                of_program.iter().map(|row| of(row)).filter(|value| value.is_finite()).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        cells.push(order(&of_program).map_or_else(String::new, |order| format!("{order:.1}")));
        cells.push(format!("{:.1} %", 100.0 * mean(|row| row.unknown)));
        let within = mean(|row| row.within);
        cells.push(if within.is_nan() {
            String::new()
        } else {
            format!("{:.1} %", 100.0 * within)
        });
        cells.push(format!("{:.0}", mean(|row| row.vertices as f64 / row.seconds)));
        table.add_row(cells);
    }
    format!("{table}\n\n{}\n{}", ratios(rows), comparisons(rows))
}

/// The versions of the other programs, and the reasons why some are not there.
#[must_use]
pub(super) fn programs(there: &[Program], missing: &[Missing]) -> String {
    let mut lines: Vec<String> =
        there.iter().map(|program| format!("- {}: {}\n", program.name, program.version)).collect();
    let missing = missing
        .iter()
        .map(|missing| format!("- {}: not in the run; {}\n", missing.name, missing.reason));
    lines.extend(missing);
    format!("Other programs:\n\n{}", lines.concat())
}

/// The distinct values of a column, in their order of appearance.
fn distinct<T: PartialEq>(rows: &[Row], of: impl Fn(&Row) -> T) -> Vec<T> {
    let mut values = Vec::new();
    for row in rows {
        let value = of(row);
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// The rows of one mesh that are compared. Rows without a finite number are left out.
struct Best<'a> {
    cell: Cell,
    auto: Option<&'a Row>,
    /// The best estimator of ours, and the best other program.
    ours: Option<&'a Row>,
    others: Option<&'a Row>,
}

/// The best rows of every mesh by a number, in the order of the meshes.
fn best_of_meshes(rows: &[Row], of: Statistic) -> Vec<Best<'_>> {
    let mut cells: Vec<Cell> = rows.iter().map(Row::cell).collect();
    cells.sort();
    cells.dedup();
    let best = |cell: Cell| {
        let of_cell = || rows.iter().filter(|row| row.cell() == cell && of(row).is_finite());
        let least = |ours: bool| {
            let of_kind = of_cell().filter(|row| row.is_ours() == ours);
            of_kind.min_by(|a, b| of(a).total_cmp(&of(b)))
        };
        let auto = of_cell().find(|row| row.program == Ours::Auto.name());
        let [ours, others] = [true, false].map(least);
        Best { cell, auto, ours, others }
    };
    cells.into_iter().map(best).collect()
}

/// Ratios of median errors by sampling and noise, each as the geometric mean over the surfaces and the largest one:
/// `auto` to the best estimator of ours, and that one to the best of the other programs.
fn ratios(rows: &[Row]) -> comfy_table::Table {
    let levels = distinct(rows, |row| row.noise);
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::ASCII_MARKDOWN);
    let heads = levels.iter().flat_map(|noise| {
        [format!("noise {noise}: auto / ours"), format!("noise {noise}: ours / others")]
    });
    table.set_header(std::iter::once("mesh".to_owned()).chain(heads));
    let all = best_of_meshes(rows, |row| row.k_median);
    let ratio = |a: Option<&Row>, b: Option<&Row>| {
        a.zip(b).map(|(a, b)| a.k_median.max(FLOOR) / b.k_median.max(FLOOR))
    };
    let text = |ratios: Vec<f64>| {
        let largest = ratios.iter().copied().reduce(f64::max);
        largest.map_or_else(String::new, |largest| {
            format!("{:.2} ({largest:.2})", geometric_mean(&ratios))
        })
    };
    for sampling in distinct(rows, |row| row.sampling.clone()) {
        let mut cells = vec![sampling.clone()];
        for noise in levels.iter().map(f64::to_string) {
            let here = || all.iter().filter(|best| best.cell.1 == sampling && best.cell.3 == noise);
            cells.push(text(here().filter_map(|best| ratio(best.auto, best.ours)).collect()));
            cells.push(text(here().filter_map(|best| ratio(best.ours, best.others)).collect()));
        }
        table.add_row(cells);
    }
    table
}

/// The median error of every program against the noise.
#[must_use]
pub(super) fn plot(rows: &[Row]) -> Plot {
    let mut levels = distinct(rows, |row| row.noise);
    levels.sort_by(f64::total_cmp);
    let series = distinct(rows, |row| row.program.clone()).into_iter().map(|program| {
        let of_program = || rows.iter().filter(|row| row.program == program);
        let point = |&noise: &f64| {
            let errors: Vec<f64> = of_program()
                .filter(|row| row.noise == noise && row.k_median.is_finite())
                .map(|row| 100.0 * row.k_median.max(FLOOR))
                .collect();
            (!errors.is_empty()).then(|| [100.0 * noise, geometric_mean(&errors)])
        };
        Series {
            points: levels.iter().filter_map(point).collect(),
            dashed: !of_program().any(Row::is_ours),
            name: program.clone(),
        }
    });
    Plot {
        x: Axis::linear("noise, % of the mean edge"),
        y: Axis::log("median error of the principal curvatures, %"),
        series: series.filter(|series| !series.points.is_empty()).collect(),
    }
}

/// The order of convergence without noise: the median over surfaces and samplings, each from its smallest to its
/// largest mesh. `None` without two sizes.
fn order(rows: &[&Row]) -> Option<f64> {
    let exact = || rows.iter().filter(|row| row.noise == 0.0);
    let fine = exact().map(|row| row.vertices).max()?;
    let coarse = exact().map(|row| row.vertices).min().filter(|&coarse| coarse < fine)?;
    let steps = 0.5 * (fine as f64 / coarse as f64).ln();
    let of_cell = |row: &&Row| {
        let is_finer = |other: &&&Row| {
            other.vertices == fine && other.surface == row.surface && other.sampling == row.sampling
        };
        let finer = exact().find(is_finer)?;
        let is_exact = row.k_median < FLOOR || finer.k_median < FLOOR;
        let order = (row.k_median / finer.k_median).ln() / steps;
        (!is_exact && order.is_finite()).then_some(order)
    };
    let mut orders: Vec<f64> =
        exact().filter(|row| row.vertices == coarse).filter_map(of_cell).collect();
    orders.sort_by(f64::total_cmp);
    orders.get(orders.len() / 2).copied()
}

/// A number of a row.
type Statistic = fn(&Row) -> f64;

/// In how many cells `auto` is near the best of ours, and the best of ours ahead of all other programs.
fn comparisons(rows: &[Row]) -> String {
    let statistics: [(&str, Statistic); 2] =
        [("median", |row| row.k_median), ("95 %", |row| row.k_95)];
    statistics.map(|(name, of)| comparison(rows, name, of)).concat()
}

fn comparison(rows: &[Row], name: &str, of: Statistic) -> String {
    let error = |row: &Row| of(row).max(FLOOR);
    let (mut near, mut ahead, mut with_peers) = (0, 0, 0);
    let mut lost = String::new();
    let all = best_of_meshes(rows, of);
    for Best { cell, auto, ours, others } in &all {
        let Some(ours) = ours else { continue };
        near += usize::from(auto.is_some_and(|auto| error(auto) <= 1.3 * error(ours)));
        let Some(peer) = others else { continue };
        with_peers += 1;
        if error(ours) <= error(peer) {
            ahead += 1;
        } else {
            let (surface, sampling, vertices, noise) = cell;
            lost += &format!(
                "- {surface}, {sampling}, {vertices} vertices, noise {noise}: {} {:.3} %, ours {} {:.3} %\n",
                peer.program,
                100.0 * of(peer),
                ours.program,
                100.0 * of(ours)
            );
        }
    }
    let mut text = format!(
        "Error of {name}: `auto` is within 1.3 of the best estimator of ours in {near} of {} cells.\n",
        all.len()
    );
    if with_peers > 0 {
        text += &format!(
            "The best of ours is at most the best of the others in {ahead} of {with_peers} cells.\n"
        );
        if !lost.is_empty() {
            text += &format!("The others win:\n\n{lost}\n");
        }
    }
    text
}
