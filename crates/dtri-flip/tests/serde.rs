//! Options and reports are unchanged after a round trip through JSON.
#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

use crate::common;
use core::fmt::Debug;
use core::time::Duration;

use dtri_flip::{AbsMean, Anneal, CostName, FlipOptions, Rebuild, Ties, optimise};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn assert_survives<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(serde_json::from_str::<T>(&text).unwrap(), *value, "{text}");
}

#[test]
fn options_and_reports_survive() {
    let mut mesh = common::paper_torus();
    let options = FlipOptions {
        look_ahead: 2,
        rebuild: Some(Rebuild { effort: 1, ..Rebuild::default() }),
        anneal: Some(Anneal { rounds: 1, ..Anneal::default() }),
        locked: Some(mesh.topology().edge_map(false)),
        ties: Ties::Seeded(7),
        time_limit: Some(Duration::from_millis(123_456)),
        ..FlipOptions::default()
    };
    assert_survives(&options);
    assert_survives(&optimise(&mut mesh, &AbsMean, &options).unwrap());
    for cost in CostName::ALL {
        assert_survives(cost);
    }
}
