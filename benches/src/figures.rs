//! Numbers in tables.

/// A number with some digits, or a dash.
pub(crate) fn told(x: f64, digits: usize) -> String {
    if x.is_nan() { "–".to_owned() } else { format!("{x:.digits$}") }
}

/// The values of a field, in the order in which they come.
pub(crate) fn distinct<'r, R, T: PartialEq>(rows: &'r [R], field: impl Fn(&'r R) -> T) -> Vec<T> {
    let mut found = Vec::new();
    for value in rows.iter().map(field) {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// The geometric mean of numbers; NaN if there are none.
pub(crate) fn geometric_mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), x| (sum + x.ln(), count + 1.0));
    (sum / count).exp()
}
