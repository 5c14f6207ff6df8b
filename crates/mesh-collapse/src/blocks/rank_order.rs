//! Bitmap sort: sorting of distinct numbers without comparisons.

/// Sorts pairs by their first numbers, which must all be different. A bit set over the numbers gives the rank of each.
pub(super) fn in_order(pairs: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let largest = pairs.iter().map(|pair| pair.0).max().unwrap_or(0);
    let place = |number: u32| (number as usize / 64, 1_u64 << (number % 64));
    let mut bits = vec![0; place(largest).0 + 1];
    for &(number, _) in pairs {
        let (word, bit) = place(number);
        bits[word] |= bit;
    }
    let mut before = Vec::with_capacity(bits.len());
    let mut count = 0;
    for &word in &bits {
        before.push(count);
        count += u64::count_ones(word);
    }
    let mut sorted = vec![(0, 0); pairs.len()];
    for &(number, other) in pairs {
        let (word, bit) = place(number);
        let rank = before[word] + (bits[word] & (bit - 1)).count_ones();
        sorted[rank as usize] = (number, other);
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::in_order;

    #[test]
    fn pairs_come_in_the_order_of_their_numbers() {
        // All numbers up to a prime, and every third: gaps, whole words, and numbers at the ends of words.
        for (count, step) in [(1009_u64, 1), (1009, 3), (127, 64), (1, 1)] {
            let pairs: Vec<(u32, u32)> =
                (0..count).map(|i| ((step * (i * 77 % count)) as u32, i as u32)).collect();
            let mut sorted = pairs.clone();
            sorted.sort_unstable();
            assert_eq!(in_order(&pairs), sorted);
        }
        assert_eq!(in_order(&[]), []);
    }
}
