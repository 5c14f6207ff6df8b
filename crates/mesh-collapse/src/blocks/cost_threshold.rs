//! The cost at which blocks stop, such that together they leave the wanted number of faces.

use crate::blocks::bucket_queue::{BUCKETS, bucket};
use crate::blocks::rules::Rules;

/// A cost at which all blocks of a pass stop, with a resolution of one ninth. A share of the blocks, evenly spread, may
/// go one such step higher, so that the number of faces is met more closely.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CostThreshold {
    #[cfg_attr(feature = "serde", serde(deserialize_with = "checked::bucket"))]
    bucket: usize,
    /// The share of the blocks that go up to the next bucket, as a number of 65,536.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "checked::share"))]
    higher: u32,
    /// The place of the first block in this sequence.
    #[cfg_attr(feature = "serde", serde(skip))]
    first: u32,
}

/// The number that stands for all blocks: shares are multiples of its reciprocal.
const WHOLE: u32 = 1 << 16;

/// The number of faces of a block, and the number that is removed at each cost.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Forecast {
    faces: u64,
    /// Numbers of removed faces by bucket, in ascending order.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "checked::counts"))]
    gone: Vec<(usize, u32)>,
}

/// Checks numbers from files against their ranges.
#[cfg(feature = "serde")]
mod checked {
    use serde::de::{Deserialize, Deserializer, Error};

    use super::{BUCKETS, WHOLE};

    pub(super) fn bucket<'de, D: Deserializer<'de>>(from: D) -> Result<usize, D::Error> {
        let bucket = usize::deserialize(from)?;
        let range = || D::Error::custom(format!("bucket {bucket} of a cost, beyond {BUCKETS}"));
        (bucket <= BUCKETS).then_some(bucket).ok_or_else(range)
    }

    pub(super) fn share<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
        let share = u32::deserialize(from)?;
        let range = || D::Error::custom(format!("{share} of {WHOLE} blocks"));
        (share <= WHOLE).then_some(share).ok_or_else(range)
    }

    pub(super) fn counts<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec<(usize, u32)>, D::Error> {
        let counts = Vec::<(usize, u32)>::deserialize(from)?;
        match counts.iter().find(|&&(bucket, _)| bucket >= BUCKETS) {
            None => Ok(counts),
            Some((bucket, _)) => {
                Err(D::Error::custom(format!("bucket {bucket} of a cost, beyond {BUCKETS}")))
            }
        }
    }
}

impl Forecast {
    pub(super) fn of(faces: usize) -> Self {
        Self { faces: faces as u64, gone: Vec::new() }
    }

    /// The forecast of a whole with this many faces, summed over some of its blocks.
    pub(super) fn of_all(blocks: &[Self], faces: u64) -> Self {
        let mut gone = std::collections::BTreeMap::<usize, u64>::new();
        for &(bucket, count) in blocks.iter().flat_map(|block| &block.gone) {
            *gone.entry(bucket).or_default() += u64::from(count);
        }
        let seen: u64 = blocks.iter().map(|block| block.faces).sum();
        let scale = faces as f64 / seen.max(1) as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "no more than the faces of a mesh in memory"
        )]
        let scaled = |(bucket, count)| (bucket, (scale * count as f64) as u32);
        Self { faces, gone: gone.into_iter().map(scaled).collect() }
    }

    /// The number of faces.
    #[must_use]
    pub fn face_count(&self) -> u64 {
        self.faces
    }

    /// The number of faces that are removed at any cost. Vertices that are held keep the others.
    #[must_use]
    pub fn gone_count(&self) -> u64 {
        self.gone.iter().map(|&(_, count)| u64::from(count)).sum()
    }

    pub(super) fn add(&mut self, bucket: usize, faces: u32) {
        match self.gone.last_mut() {
            Some((last, count)) if *last == bucket => *count += faces,
            _ => self.gone.push((bucket, faces)),
        }
    }
}

impl CostThreshold {
    /// No collapses.
    pub const NONE: Self = Self::of(0);
    /// All possible collapses.
    pub const ALL: Self = Self::of(BUCKETS);

    const fn of(bucket: usize) -> Self {
        Self { bucket, higher: 0, first: 0 }
    }

    /// A cost, in the unit of the quadrics: area times squared distance.
    #[must_use]
    pub fn at(cost: f64, rules: &Rules) -> Self {
        Self::of(bucket(cost * rules.scale))
    }

    /// The highest threshold that, according to these forecasts, leaves at least this share of all faces. A block that
    /// was collapsed up to a threshold gives no information about higher ones.
    #[must_use]
    pub fn leaving(share: f64, blocks: &[&Forecast]) -> Self {
        Self::of(Self::closest(share, blocks).bucket)
    }

    /// As [`CostThreshold::leaving`], with a number of blocks one step higher, such that just this share is left.
    #[must_use]
    pub fn closest(share: f64, blocks: &[&Forecast]) -> Self {
        let mut gone = vec![0_u64; BUCKETS];
        for &(bucket, faces) in blocks.iter().flat_map(|block_of| &block_of.gone) {
            gone[bucket] += u64::from(faces);
        }
        let faces: u64 = blocks.iter().map(|block_of| block_of.faces).sum();
        let allowed = ((1.0 - share) * faces as f64) as u64;
        let mut left = allowed;
        for (bucket, &faces) in gone.iter().enumerate() {
            if faces > left {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "the share is below 1"
                )]
                let higher = (left as f64 / faces as f64 * f64::from(WHOLE)) as u32;
                return Self { bucket, higher, first: 0 };
            }
            left -= faces;
        }
        Self::ALL
    }

    /// The threshold for flat mesh `number` of several: the blocks that go higher are spread evenly over all of them.
    #[must_use]
    pub fn for_sheet(self, number: u32) -> Self {
        // Steps of the golden ratio of 65,536. The sequence repeats after that number of blocks.
        Self { first: number.wrapping_mul(40_503), ..self }
    }

    /// The threshold of one of the blocks of a flat mesh.
    pub(super) fn block_of(self, block: usize) -> Self {
        // In any sequence of blocks, the right share goes higher.
        let until = |place: u64| place * u64::from(self.higher) / u64::from(WHOLE);
        let place = u64::from(self.first) + block as u64;
        Self::of(self.bucket + usize::from(until(place + 1) > until(place)))
    }

    pub(super) fn bucket(self) -> usize {
        self.bucket
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A forecast with these numbers of removed faces by bucket.
    fn forecast(faces: usize, gone: &[(usize, u32)]) -> Forecast {
        let mut forecast = Forecast::of(faces);
        gone.iter().for_each(|&(bucket, count)| forecast.add(bucket, count));
        forecast
    }

    #[test]
    fn counts_of_a_bucket_are_added_up_and_scaled_to_the_whole() {
        let one = forecast(100, &[(3, 10), (3, 2), (5, 8)]);
        assert_eq!(one.gone, [(3, 12), (5, 8)]);
        let other = forecast(60, &[(2, 6), (5, 4)]);
        let all = Forecast::of_all(&[one, other], 480);
        assert_eq!(all.face_count(), 480);
        assert_eq!(all.gone, [(2, 18), (3, 36), (5, 36)]);
        assert_eq!(Forecast::of_all(&[], 7).gone, []);
    }

    #[test]
    fn a_ceiling_leaves_at_least_the_share_and_the_closest_one_just_that() {
        let [one, other] = [forecast(100, &[(3, 20), (5, 40)]), forecast(100, &[(2, 10), (5, 40)])];
        let both = [&one, &other];
        // 30 of 200 faces are removed below bucket 5, and 80 in bucket 5.
        assert_eq!(CostThreshold::leaving(0.86, &both), CostThreshold::of(3));
        assert_eq!(CostThreshold::leaving(0.85, &both), CostThreshold::of(5));
        assert_eq!(CostThreshold::leaving(0.46, &both), CostThreshold::of(5));
        assert_eq!(CostThreshold::leaving(0.45, &both), CostThreshold::ALL);
        assert_eq!(CostThreshold::leaving(1.0, &both), CostThreshold::of(2));
        // A quarter of the blocks includes bucket 5, which removes 20 of the 80 faces.
        let closest = CostThreshold::closest(0.75, &both);
        assert_eq!((closest.bucket, closest.higher), (5, WHOLE / 4));
        for first in [0, 1, 77] {
            let higher = (0..400).filter(|&i| closest.for_sheet(first).block_of(i).bucket == 6);
            let places: Vec<usize> = higher.collect();
            assert_eq!(places.len(), 100);
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] == 4), "{places:?}");
        }
        // Other flat meshes start elsewhere, and the same share of their first blocks goes higher.
        let firsts = (0..400).filter(|&i| closest.for_sheet(i).block_of(0).bucket == 6);
        assert!((95..=105).contains(&firsts.count()));
        assert_eq!(CostThreshold::ALL.block_of(3), CostThreshold::ALL);
    }
}
