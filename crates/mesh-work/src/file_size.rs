//! The largest number of faces whose file has at most a given number of bytes.

use std::io::{self, Write};

use mesh_io::{Format, Model, WriteError, WriteOptions, write_to};

/// The number of bytes of the file of a model, without companion files. The file is written, but not stored.
///
/// # Errors
/// As [`mesh_io::write_to`].
pub fn file_size(model: &Model, format: Format, options: &WriteOptions) -> Result<u64, WriteError> {
    let mut count = Count(0);
    write_to(&mut count, model, format, options)?;
    Ok(count.0)
}

/// Counts the bytes that are written.
struct Count(u64);

impl Write for Count {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A result for a wanted number of faces, and its size.
#[derive(Clone, Debug, PartialEq)]
pub struct Sized<T> {
    /// The result.
    pub result: T,
    /// The number of its faces.
    pub faces: usize,
    /// The number of bytes of its file.
    pub bytes: u64,
}

/// The result of [`largest_within`].
#[derive(Clone, Debug, PartialEq)]
pub struct Largest<T> {
    /// The result with the most faces that fits; the smallest one if none fits.
    pub found: Sized<T>,
    /// Whether it fits.
    pub fits: bool,
    /// The number of results that were made.
    pub trials: usize,
}

/// Trials by interpolation before the interval is halved instead. In most formats the size grows evenly with the
/// number of faces, and three or four trials are enough.
const INTERPOLATED: usize = 6;

/// Searches the largest number of faces whose file has at most `limit` bytes. `make` gives the result for a wanted
/// number of faces, which may have more faces only if it cannot have fewer. The size must not fall as the number of
/// faces grows.
///
/// # Errors
/// The first error of `make`.
pub fn largest_within<T, E>(
    limit: u64,
    faces: usize,
    mut make: impl FnMut(usize) -> Result<Sized<T>, E>,
) -> Result<Largest<T>, E> {
    let whole = make(faces)?;
    let (mut over, mut trials) = ((faces, whole.bytes), 1);
    if whole.bytes <= limit {
        return Ok(Largest { found: whole, fits: true, trials });
    }
    let mut smallest = whole;
    let mut under: Option<(usize, Sized<T>)> = None;
    loop {
        let (least, least_bytes) =
            under.as_ref().map_or((0, 0), |(wanted, found)| (*wanted, found.bytes));
        let between = over.0.saturating_sub(least);
        if between <= 1 {
            break;
        }
        let step = if trials <= INTERPOLATED {
            let share = (limit - least_bytes) as f64 / (over.1 - least_bytes).max(1) as f64;
            (share * between as f64) as usize
        } else {
            between / 2
        };
        let wanted = least + step.clamp(1, between - 1);
        let made = make(wanted)?;
        trials += 1;
        if made.bytes <= limit {
            under = Some((wanted, made));
            continue;
        }
        over = (wanted, made.bytes);
        let is_held = made.faces > wanted;
        smallest = made;
        if is_held {
            break;
        }
    }
    Ok(match under {
        Some((_, found)) => Largest { found, fits: true, trials },
        None => Largest { found: smallest, fits: false, trials },
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn search(limit: u64, faces: usize, floor: usize, size: impl Fn(usize) -> u64) -> Largest<()> {
        let make = |wanted: usize| {
            let faces = wanted.max(floor);
            Ok::<_, Infallible>(Sized { result: (), faces, bytes: size(faces) })
        };
        largest_within(limit, faces, make).unwrap()
    }

    #[test]
    fn the_largest_number_that_fits_is_found_for_any_growth_of_the_size() {
        let even = |faces: usize| 120 + 19 * faces as u64;
        let digits = |faces: usize| faces as u64 * (20 + faces.max(1).ilog10() as u64);
        let square = |faces: usize| (faces * faces) as u64;
        for limit in [140, 1000, 19_119, 19_120, 19_121, 900_000] {
            for size in [&even as &dyn Fn(usize) -> u64, &digits, &square] {
                let largest = search(limit, 100_000, 0, size);
                let faces = largest.found.faces;
                assert!(largest.fits && size(faces) <= limit && size(faces + 1) > limit);
                assert!(largest.trials <= 24, "{}", largest.trials);
            }
            assert!(search(limit, 100_000, 0, even).trials <= 5);
        }
    }

    #[test]
    fn a_mesh_that_fits_stays_whole_and_one_that_is_held_is_the_smallest() {
        let size = |faces: usize| 10 * faces as u64;
        let whole = search(500, 50, 0, size);
        assert_eq!((whole.found.faces, whole.fits, whole.trials), (50, true, 1));
        let held = search(200, 50, 30, size);
        assert_eq!((held.found.faces, held.fits), (30, false));
        assert_eq!(search(300, 50, 30, size).found.faces, 30);
        assert!(!search(0, 50, 0, |faces| 1 + faces as u64).fits);
    }
}
