//! Labels to colours: a colour for each of a few values that are names rather than amounts.

use crate::scale::MISSING;

/// The colours of labels. The first seven can be told apart without colour vision (Okabe and Ito 2008); each further
/// one is as far as possible from all before it, from [`MISSING`] and from uncoloured surfaces, in the space CIELAB.
pub const LABEL_COLORS: [[u8; 3]; 20] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
    [0, 0, 255],
    [0, 255, 0],
    [255, 0, 221],
    [85, 17, 136],
    [255, 0, 102],
    [85, 85, 0],
    [68, 170, 17],
    [119, 0, 34],
    [34, 119, 255],
    [0, 255, 170],
    [0, 68, 51],
    [255, 170, 136],
    [204, 238, 153],
];

/// The different values of a property that holds labels.
///
/// If all are whole numbers from 0 to 19, each has the colour of its number, in every picture. Otherwise the colours
/// follow the order of the values, and repeat after twenty.
///
/// ```
/// use mesh_render::{LABEL_COLORS, Labels, MISSING};
///
/// let labels = Labels::of([7.0, 2.0, f64::NAN, 7.0]);
/// assert_eq!(labels.values(), [2.0, 7.0]);
/// assert_eq!(labels.color(7.0), LABEL_COLORS[7]);
/// assert_eq!(Labels::of([700.0, 2.0]).color(700.0), LABEL_COLORS[1]);
/// assert_eq!(labels.color(3.5), MISSING);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    values: Vec<f64>,
    by_number: bool,
}

impl Labels {
    /// The different finite values, in order.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        // Adding zero turns -0 into 0.
        let mut values: Vec<f64> =
            values.into_iter().filter(|x| x.is_finite()).map(|x| x + 0.0).collect();
        values.sort_unstable_by(f64::total_cmp);
        values.dedup();
        let is_number =
            |&x: &f64| x.fract() == 0.0 && (0.0..LABEL_COLORS.len() as f64).contains(&x);
        Self { by_number: values.iter().all(is_number), values }
    }

    /// The different values, in order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether several labels have the same colour, because there are more labels than colours.
    #[must_use]
    pub fn is_repeating(&self) -> bool {
        self.values.len() > LABEL_COLORS.len()
    }

    /// The colour of a label; [`MISSING`] for values that are not among the labels.
    #[must_use]
    pub fn color(&self, value: f64) -> [u8; 3] {
        let found = self.values.binary_search_by(|other| other.total_cmp(&(value + 0.0)));
        match found {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 19")]
            Ok(_) if self.by_number => LABEL_COLORS[value as usize % LABEL_COLORS.len()],
            Ok(place) => LABEL_COLORS[place % LABEL_COLORS.len()],
            Err(_) => MISSING,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lightness and the two opponent colours of CIELAB, with the white of sRGB.
    fn lab(color: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = color.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let root = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let x = root((0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b) / 0.950_47);
        let y = root(0.212_672_9 * r + 0.715_152_2 * g + 0.072_175 * b);
        let z = root((0.019_333_9 * r + 0.119_192 * g + 0.950_304_1 * b) / 1.088_83);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn no_two_labels_look_alike() {
        let mut all = LABEL_COLORS.to_vec();
        all.push(MISSING);
        for (i, &a) in all.iter().enumerate() {
            for &b in &all[..i] {
                let [a_lab, b_lab] = [a, b].map(lab);
                let squares: f64 = a_lab.iter().zip(b_lab).map(|(p, q)| (p - q).powi(2)).sum();
                // A difference of about 2 is just visible.
                assert!(squares.sqrt() > 20.0, "{a:?} {b:?}: {}", squares.sqrt());
            }
        }
    }

    #[test]
    fn every_value_has_one_colour() {
        let few = Labels::of([3.0, -0.0, 0.0, 19.0]);
        assert_eq!(few.values(), [0.0, 3.0, 19.0]);
        assert_eq!([0.0, -0.0, 19.0].map(|x| few.color(x)), [0, 0, 19].map(|i| LABEL_COLORS[i]));
        assert!(!few.is_repeating());
        let many = Labels::of((0..45).map(|i| f64::from(i) - 1.0));
        assert!(many.is_repeating());
        assert_eq!(many.color(-1.0), LABEL_COLORS[0]);
        assert_eq!(many.color(19.0), LABEL_COLORS[0], "the colours repeat after twenty");
        assert_eq!(many.color(0.5), MISSING);
        for odd in [f64::NAN, f64::INFINITY] {
            assert_eq!(Labels::of([odd]).values(), [0.0; 0]);
            assert_eq!(many.color(odd), MISSING);
        }
    }
}
