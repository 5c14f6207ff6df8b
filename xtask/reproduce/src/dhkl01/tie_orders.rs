//! Table 1 depends on the order of flips with the same gain: how much.

use dtri_flip::{CostName, Ties};

use super::super::item::Item;
use super::super::run::Run;
use super::torus::{SETTINGS, SUBDIVISIONS, Setting, TORUS, distance_to_torus, norms, optimised};
use xtask_common::Failure;

/// How many orders are tried, from the seeds 0, 1, ...
const ORDERS: u64 = 40;
/// Norms that differ less belong to the same triangulation.
const SAME: f64 = 1e-9;

/// The share of orders that give the row of the table, for each cost.
pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "On a symmetric mesh, flips have the same gain exactly, and the order among them decides \
         which local minimum is reached. The paper does not give its order. These are the shares \
         of random orders that end in the triangulation whose errors Table 1 prints.",
    );
    item.how(
        &["dtri_flip::optimise", "dtri_flip::Ties"],
        &["curvmesh flip IN -o OUT --cost f1 --shape-constraint unrestricted --random-ties --seed 2"],
    );
    for setting in &SETTINGS {
        let Some(cost) = setting.cost else { continue };
        let share = share_of_orders(setting, cost)?;
        let quantity =
            format!("{}, share of {ORDERS} seeded orders that give the paper's row", setting.row);
        item.number(quantity, share);
    }
    Ok(())
}

/// How many orders end where the order of the setting ends.
fn share_of_orders(setting: &Setting, cost: CostName) -> Result<f64, Failure> {
    let row_of = |setting: &Setting| -> Result<_, Failure> {
        Ok(norms(&distance_to_torus(&optimised(&TORUS, setting)?, SUBDIVISIONS)))
    };
    let expected = row_of(setting)?;
    let mut same = 0;
    for seed in 0..ORDERS {
        let row = row_of(&Setting { cost: Some(cost), ties: Ties::Seeded(seed), ..*setting })?;
        same += u32::from(row.iter().zip(&expected).all(|(a, b)| (a.1 - b.1).abs() < SAME));
    }
    Ok(f64::from(same) / ORDERS as f64)
}
