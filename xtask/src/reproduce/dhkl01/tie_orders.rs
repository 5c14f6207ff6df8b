//! Table 1 depends on the order of flips with the same gain: how much.

use std::path::Path;

use dtri_flip::{CostName, Ties};

use super::super::item::{Item, Row};
use super::super::published::Paper;
use super::{SETTINGS, SUBDIVISIONS, Setting, distance_to_torus, norms, optimised};
use crate::failure::Failure;

pub(super) const NAME: &str = "Table 1, order of ties";

/// How many orders are tried, from the seeds 0, 1, ...
const ORDERS: u64 = 40;

/// The share of orders that give the row of the table, for each cost.
pub(super) fn item(paper: &Paper, _: &Path) -> Result<Item, Failure> {
    let mut rows = Vec::new();
    for setting in &SETTINGS {
        let Some(cost) = setting.cost else { continue };
        let share = share_of_orders(paper, setting, cost)?;
        let quantity =
            format!("{}, share of {ORDERS} seeded orders that give the paper's row", setting.row);
        rows.push(Row::new(paper, NAME, &quantity, share));
    }
    Ok(Item {
        paper: paper.short.clone(),
        name: NAME.into(),
        about: "On a symmetric mesh, flips have the same gain exactly, and the order among them \
                decides which local minimum is reached. The paper does not give its order."
            .into(),
        needs: None,
        rows,
        figures: Vec::new(),
        functions: vec!["dtri_flip::optimise", "dtri_flip::Ties"],
        command: "curvmesh flip IN -o OUT --cost f1",
    })
}

fn share_of_orders(paper: &Paper, setting: &Setting, cost: CostName) -> Result<f64, Failure> {
    let mut same = 0;
    for seed in 0..ORDERS {
        let setting = Setting { cost: Some(cost), ties: Ties::Seeded(seed), ..*setting };
        let error = distance_to_torus(&optimised(&setting)?, SUBDIVISIONS);
        let is_printed = |(norm, value): (&str, f64)| {
            let printed = paper.value("Table 1", &format!("{}, {norm}", setting.row));
            let near = |printed: f64, tolerance: f64| (value - printed).abs() <= tolerance;
            printed.is_some_and(|v| v.printed.is_some_and(|p| near(p, v.tolerance)))
        };
        same += u32::from(norms(&error).into_iter().all(is_printed));
    }
    Ok(f64::from(same) / ORDERS as f64)
}
