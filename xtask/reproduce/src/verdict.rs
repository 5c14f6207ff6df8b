//! How what was computed compares with what is printed, and with what was computed before.

use super::item::{Item, Number};
use super::outcome::Outcome;
use super::published::{Claim, Paper, Value};
use super::recorded::Recorded;
use super::row::{Content, Row, Verdict};

/// What makes a comparison complete.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judge<'a> {
    pub(crate) paper: &'a Paper,
    pub(crate) recorded: &'a Recorded,
    /// Whether items may leave numbers out.
    pub(crate) quick: bool,
}

impl Judge<'_> {
    /// Fills in the rows of an item: all that it computed, and all else that the paper prints.
    pub(crate) fn fill(&self, item: &mut Item) {
        let claims = self.paper.claims.iter().filter(|claim| claim.item == item.name);
        let mut rows: Vec<Row> = claims.map(|claim| self.claim_row(item, claim)).collect();
        rows.extend(item.numbers.iter().map(|number| self.number_row(&item.name, number)));
        let unknown =
            item.claims.iter().filter(|c| self.paper.claim(&item.name, &c.name).is_none());
        rows.extend(unknown.map(|claim| unknown_claim(&claim.name)));
        let values = self.paper.values.iter().filter(|value| value.item == item.name);
        let absent = values.filter(|v| item.numbers.iter().all(|n| n.quantity != v.quantity));
        rows.extend(absent.map(|value| self.absent_row(item, value)));
        item.rows = rows;
    }

    fn number_row(&self, item: &str, number: &Number) -> Row {
        let value = self.paper.value(item, &number.quantity);
        let recorded = self.recorded.value(&self.paper.short, item, &number.quantity);
        Row {
            quantity: number.quantity.clone(),
            place: value.and_then(|v| v.place.clone()),
            content: Content::Number {
                printed: value.and_then(|v| v.printed),
                ours: Some(number.value),
                reference: value.and_then(Value::reference_value),
            },
            verdict: verdict_of(value, recorded, number),
        }
    }

    /// A number that the paper prints, or that is watched, and that was not computed.
    fn absent_row(&self, item: &Item, value: &Value) -> Row {
        Row {
            quantity: value.quantity.clone(),
            place: value.place.clone(),
            content: Content::Number {
                printed: value.printed,
                ours: None,
                reference: value.reference_value(),
            },
            verdict: self.absent(item, value.needs.as_deref()),
        }
    }

    fn absent(&self, item: &Item, needs: Option<&str>) -> Verdict {
        // One of the folder is a file name; in words, a model that only the authors have.
        let lacks =
            |model: &str| model.contains(' ') || item.missing_models.iter().any(|m| m == model);
        match needs {
            Some(model) if lacks(model) => Verdict::NeedsModel(model.to_owned()),
            _ if self.quick => Verdict::Skipped,
            _ => Verdict::Drifted("was not computed".into()),
        }
    }

    fn claim_row(&self, item: &Item, claim: &Claim) -> Row {
        let result = item.claims.iter().find(|c| c.name == claim.name);
        let verdict = match result {
            None => self.absent(item, claim.needs.as_deref()),
            Some(result) if claim.outcome.is_some_and(|outcome| outcome != result.outcome) => {
                Verdict::Drifted(format!("{}, which is not what is recorded", result.outcome))
            }
            Some(result) if result.outcome == Outcome::Holds => Verdict::Agrees(String::new()),
            Some(result) => Verdict::Differs(result.outcome.to_string()),
        };
        Row {
            quantity: claim.name.clone(),
            place: claim.place.clone(),
            content: Content::Claim {
                quote: claim.quote.clone(),
                says: claim.says.clone(),
                outcome: result.map(|r| r.outcome),
                how: result.map(|r| r.how.clone()).unwrap_or_default(),
            },
            verdict,
        }
    }
}

fn unknown_claim(name: &str) -> Row {
    Row {
        quantity: name.to_owned(),
        place: None,
        content: Content::Claim {
            quote: String::new(),
            says: None,
            outcome: None,
            how: String::new(),
        },
        verdict: Verdict::Drifted("the data file has no such claim".into()),
    }
}

/// The verdict on a number. Whatever is printed, a result that has changed is a drift; so is
/// one that differs from the printed number, or else from that of an independent program,
/// without a reason on record.
fn verdict_of(value: Option<&Value>, recorded: Option<f64>, number: &Number) -> Verdict {
    let ours = number.value;
    let near = |target: f64, tolerance: f64| (ours - target).abs() <= tolerance;
    let missed = value
        .and_then(|v| Some((v, v.reference?)))
        .filter(|(_, reference)| !near(reference.value, reference.tolerance));
    let why_missed = missed.and_then(|(v, _)| v.differs_from_reference());
    if let (Some((_, reference)), None) = (missed, why_missed) {
        return Verdict::Drifted(format!("an independent program gave {}", reference.value));
    }
    match recorded {
        None => return Verdict::Drifted("not recorded yet: run with --record".into()),
        Some(recorded) if !near(recorded, number.leeway * recorded.abs()) => {
            return Verdict::Drifted(format!("{recorded} is recorded"));
        }
        Some(_) => {}
    }
    let Some((value, printed)) = value.and_then(|v| Some((v, v.printed?))) else {
        return why_missed.map_or(Verdict::NotPublished, |why| Verdict::Differs(why.to_owned()));
    };
    if let Some([low, high]) = number.range.filter(|_| value.other_data) {
        let range = format!("our 5 to 95 % range, {low:.2} to {high:.2}");
        return match (low..=high).contains(&printed) {
            true => Verdict::Agrees(format!("within {range}")),
            false => Verdict::Differs(format!("one face of another mesh, outside {range}")),
        };
    }
    match &value.differs {
        _ if near(printed, value.tolerance) && value.setup => Verdict::Setup,
        _ if near(printed, value.tolerance) && !value.other_data => Verdict::Exact,
        Some(why) => Verdict::Differs(why.clone()),
        None => Verdict::Drifted("differs from the printed number".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::item::Number;
    use super::super::published::{Reference, Value, papers};
    use super::super::recorded::Recorded;
    use super::super::row::Verdict;
    use super::verdict_of;

    fn verdict(value: &Value, recorded: Option<f64>, ours: f64) -> Verdict {
        let number = Number { quantity: String::new(), value: ours, leeway: 1e-6, range: None };
        verdict_of(Some(value), recorded, &number)
    }

    fn is_drift(verdict: &Verdict) -> bool {
        !verdict.is_expected()
    }

    #[test]
    fn a_changed_result_is_noticed_before_it_leaves_the_printed_digits() {
        let value = Value {
            printed: Some(0.2342743546),
            tolerance: 2e-7,
            reference: Some(Reference { value: 0.2342743622, tolerance: 1e-9 }),
            ..Value::default()
        };
        let recorded = Some(0.2342743622);
        assert_eq!(verdict(&value, recorded, 0.2342743622), Verdict::Exact);
        assert!(is_drift(&verdict(&value, recorded, 0.2342743546)));
        assert!(is_drift(&verdict(&value, Some(0.2342), 0.2342743622)));
        assert!(is_drift(&verdict(&value, None, 0.2342743622)));
    }

    #[test]
    fn another_result_than_that_of_an_independent_program_needs_a_reason() {
        let reference = Some(Reference { value: 2.0, tolerance: 0.1 });
        let value = Value { reference, ..Value::default() };
        assert_eq!(verdict(&value, Some(2.05), 2.05), Verdict::NotPublished);
        assert!(is_drift(&verdict(&value, Some(2.2), 2.2)));
        let why = Value { differs: Some("another rule".into()), ..value };
        assert_eq!(verdict(&why, Some(2.2), 2.2), Verdict::Differs("another rule".into()));
        assert!(is_drift(&verdict(&why, Some(2.05), 2.2)));
        // Beside a printed number the reason is for that one.
        let printed = Value { printed: Some(1.0), tolerance: 0.1, ..why };
        assert!(is_drift(&verdict(&printed, Some(2.2), 2.2)));
    }

    /// Also for models that are not here, and for items that a quick run leaves out. The record of a
    /// number of other data lacks the range that its verdict needs.
    #[test]
    fn what_is_on_record_is_no_drift() {
        let recorded = Recorded::read().unwrap();
        for paper in papers().unwrap() {
            let compared =
                paper.values.iter().filter(|value| !value.other_data).filter_map(|value| {
                    Some((value, recorded.value(&paper.short, &value.item, &value.quantity)?))
                });
            for (value, ours) in compared {
                let verdict = verdict(value, Some(ours), ours);
                assert!(!is_drift(&verdict), "{} {}: {verdict}", value.item, value.quantity);
            }
        }
    }

    #[test]
    fn a_difference_needs_a_reason() {
        let plain = Value { printed: Some(30.0), tolerance: 0.5, ..Value::default() };
        assert_eq!(verdict(&plain, Some(30.4), 30.4), Verdict::Exact);
        assert!(is_drift(&verdict(&plain, Some(33.0), 33.0)));
        let setup = Value { setup: true, ..plain.clone() };
        assert_eq!(verdict(&setup, Some(30.0), 30.0), Verdict::Setup);
        assert!(is_drift(&verdict(&setup, Some(33.0), 33.0)));
        let why = Value { differs: Some("another model".into()), ..plain };
        assert_eq!(verdict(&why, Some(33.0), 33.0), Verdict::Differs("another model".into()));
    }

    #[test]
    fn other_data_agree_if_the_printed_number_lies_in_the_range() {
        let value =
            Value { printed: Some(0.18), other_data: true, tolerance: 0.5, ..Value::default() };
        let judged = |range| {
            let number = Number { quantity: String::new(), value: 0.2, leeway: 1e-6, range };
            verdict_of(Some(&value), Some(0.2), &number)
        };
        assert_eq!(judged(Some([0.1, 0.3])).label(), "agrees");
        assert_eq!(judged(Some([0.19, 0.3])).label(), "differs");
        assert!(is_drift(&judged(None)));
    }
}
