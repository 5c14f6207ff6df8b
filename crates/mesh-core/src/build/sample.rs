//! A count of elements with the first few of them.

use core::fmt;

/// A count of elements together with the first few of them.
///
/// Errors and reports use it, so that a mesh with a million defects does not make a report with a
/// million lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sample<T> {
    first: Vec<T>,
    count: usize,
}

impl<T> Sample<T> {
    /// Number of elements that are kept; further ones are only counted.
    pub const CAPACITY: usize = 8;

    /// How many elements there are in all.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The first of them, at most [`Sample::CAPACITY`].
    #[must_use]
    pub fn first(&self) -> &[T] {
        &self.first
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// A sample from its parts; `None` if the number of kept elements does not fit the count.
    #[cfg(feature = "serde")]
    pub(crate) fn from_parts(first: Vec<T>, count: usize) -> Option<Self> {
        (first.len() == count.min(Self::CAPACITY)).then_some(Self { first, count })
    }

    pub(crate) fn push(&mut self, element: T) {
        if self.first.len() < Self::CAPACITY {
            self.first.push(element);
        }
        self.count += 1;
    }
}

impl<T> Default for Sample<T> {
    fn default() -> Self {
        Self { first: Vec::new(), count: 0 }
    }
}

impl<T> Extend<T> for Sample<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, elements: I) {
        for element in elements {
            self.push(element);
        }
    }
}

impl<T> FromIterator<T> for Sample<T> {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        let mut sample = Self::default();
        sample.extend(elements);
        sample
    }
}

impl<T: fmt::Display> Sample<T> {
    /// `4, 8, 15`, with `...` where more elements were counted than kept.
    pub(crate) fn listed(&self) -> String {
        let mut names: Vec<String> = self.first.iter().map(T::to_string).collect();
        if self.count > names.len() {
            names.push("...".to_owned());
        }
        names.join(", ")
    }
}

/// `3 (4, 8, 15)`, with `...` where more elements were counted than kept.
impl<T: fmt::Display> fmt::Display for Sample<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            0 => f.write_str("0"),
            count => write!(f, "{count} ({})", self.listed()),
        }
    }
}

/// An edge of a polygon soup, named by its two vertices with the smaller index first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VertexPair(pub u32, pub u32);

impl fmt::Display for VertexPair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.0, self.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_first_and_counts_all() {
        let sample: Sample<u32> = (0..20).collect();
        assert_eq!((sample.count(), sample.first()), (20, &[0, 1, 2, 3, 4, 5, 6, 7][..]));
        assert_eq!(sample.to_string(), "20 (0, 1, 2, 3, 4, 5, 6, 7, ...)");
        assert_eq!(Sample::<u32>::default().to_string(), "0");
        assert_eq!(Sample::from_iter([VertexPair(3, 9)]).to_string(), "1 (3-9)");
    }
}
