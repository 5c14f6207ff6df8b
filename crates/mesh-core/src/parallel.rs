//! Parallel loops over independent elements; sequential without the `rayon` feature.
//!
//! Results are bit-identical for any number of threads and without `rayon`: each value is computed by itself,
//! and sums are added in blocks of fixed size.

use core::ops::Range;

#[cfg(feature = "rayon")]
use rayon::prelude::*;
#[cfg(feature = "rayon")]
use std::sync::{Mutex, MutexGuard, PoisonError, atomic};

/// Elements per block: the unit of work of a thread and the unit of summation.
const BLOCK: usize = 2048;

/// Whether the calling thread does all portions of work itself. Handing work to another thread costs as much as
/// some thousands of elements.
#[cfg(feature = "rayon")]
fn stays_here(portions: usize) -> bool {
    portions <= 1 || rayon::current_num_threads() == 1
}

/// Runs a task for each index from 0 to `count`.
///
/// Most loops below come down to this one, which is not generic: the scheduling of rayon is a hundred times as much
/// code as a loop, and would otherwise be compiled again for each closure of each crate.
#[cfg(feature = "rayon")]
fn run(count: usize, task: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(task);
}

#[cfg(feature = "rayon")]
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a task for each part of something, with the index of the part.
#[cfg(feature = "rayon")]
fn run_parts<P: Send>(parts: impl Iterator<Item = P>, task: impl Fn(usize, P) + Sync) {
    let parts: Vec<Mutex<Option<P>>> = parts.map(|part| Mutex::new(Some(part))).collect();
    run(parts.len(), &|i| {
        if let Some(part) = parts.get(i).and_then(|part| lock(part).take()) {
            task(i, part);
        }
    });
}

/// Sets every element of a slice to a function of its index.
pub fn fill<T: Send>(out: &mut [T], value: impl Fn(usize) -> T + Sync) {
    update(out, |i, slot| *slot = value(i));
}

/// Changes every element of a slice by a function of its index.
pub fn update<T: Send>(out: &mut [T], change: impl Fn(usize, &mut T) + Sync) {
    let update_block = |block: usize, out: &mut [T]| {
        for (i, slot) in out.iter_mut().enumerate() {
            change(block * BLOCK + i, slot);
        }
    };
    #[cfg(feature = "rayon")]
    if !stays_here(out.len().div_ceil(BLOCK)) {
        return run_parts(out.chunks_mut(BLOCK), update_block);
    }
    out.chunks_mut(BLOCK).enumerate().for_each(|(block, out)| update_block(block, out));
}

/// The values of a function of the index, from 0 to `count`.
pub fn collect<T: Send>(count: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    #[cfg(feature = "rayon")]
    if !stays_here(count.div_ceil(BLOCK)) {
        let chunk_values = |chunk: usize| core::array::from_fn(|i| value(chunk * CHUNK + i));
        let mut values = collect_chunks(count, &chunk_values);
        values.extend((count / CHUNK * CHUNK..count).map(value));
        return values;
    }
    (0..count).map(value).collect()
}

/// Values per call in [`collect`].
#[cfg(feature = "rayon")]
const CHUNK: usize = 16;

/// The values of all complete chunks, with memory for all `count` values. Generic over the values only, so that it is
/// compiled once per type of value.
#[cfg(feature = "rayon")]
fn collect_chunks<T: Send>(
    count: usize,
    chunk_values: &(dyn Fn(usize) -> [T; CHUNK] + Sync),
) -> Vec<T> {
    let mut chunks = Vec::with_capacity(count.div_ceil(CHUNK));
    let indices = (0..count / CHUNK).into_par_iter().with_min_len(BLOCK / CHUNK);
    indices.map(chunk_values).collect_into_vec(&mut chunks);
    chunks.into_flattened()
}

/// The values for the indices from 0 to `count`, computed in blocks of `N` consecutive indices. The function
/// gets scratch memory and the indices of its block; values beyond `count` are dropped. Values must not depend
/// on the content of the scratch memory.
pub fn collect_blocks<S, T: Send, const N: usize>(
    count: usize,
    scratch: impl Fn() -> S + Sync + Send,
    block: impl Fn(&mut S, Range<usize>) -> [T; N] + Sync,
) -> Vec<T> {
    let values = |memory: &mut S, i: usize| block(memory, i * N..count.min((i + 1) * N));
    let blocks = count.div_ceil(N);
    #[cfg(feature = "rayon")]
    if !stays_here(count.div_ceil(BLOCK)) {
        let blocks = (0..blocks).into_par_iter().with_min_len((BLOCK / N).max(1));
        return flat(blocks.map_init(scratch, values).collect(), count);
    }
    let mut memory = scratch();
    flat((0..blocks).map(|i| values(&mut memory, i)).collect(), count)
}

/// As [`collect_blocks`], for two values of each index.
pub fn collect_block_pairs<S, T: Send, U: Send, const N: usize>(
    count: usize,
    scratch: impl Fn() -> S + Sync + Send,
    block: impl Fn(&mut S, Range<usize>) -> ([T; N], [U; N]) + Sync,
) -> (Vec<T>, Vec<U>) {
    let values = |memory: &mut S, i: usize| block(memory, i * N..count.min((i + 1) * N));
    let blocks = count.div_ceil(N);
    let (mut first, mut second) = (Vec::with_capacity(blocks), Vec::with_capacity(blocks));
    #[cfg(feature = "rayon")]
    if !stays_here(count.div_ceil(BLOCK)) {
        let blocks = (0..blocks).into_par_iter().with_min_len((BLOCK / N).max(1));
        blocks.map_init(scratch, values).unzip_into_vecs(&mut first, &mut second);
        return (flat(first, count), flat(second, count));
    }
    let mut memory = scratch();
    for i in 0..blocks {
        let (of_first, of_second) = values(&mut memory, i);
        first.push(of_first);
        second.push(of_second);
    }
    (flat(first, count), flat(second, count))
}

/// The first `count` elements of blocks.
fn flat<T, const N: usize>(blocks: Vec<[T; N]>, count: usize) -> Vec<T> {
    let mut all = blocks.into_flattened();
    all.truncate(count);
    all
}

/// Elements per portion of expensive work.
#[cfg(feature = "rayon")]
const PORTION: usize = 16;

/// The values of a function of the index, from 0 to `count`, where the function needs scratch memory that is
/// expensive to make and each value takes long. At most one scratch is made per thread. Values must not depend
/// on the content of the scratch memory.
pub fn collect_with<S: Send, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    value: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    #[cfg(feature = "rayon")]
    if !stays_here(count.div_ceil(PORTION)) {
        let spare = Mutex::new(Vec::new());
        let portion_values = |portion: usize| {
            let taken = lock(&spare).pop();
            let mut memory = taken.unwrap_or_else(&scratch);
            let indices = portion * PORTION..count.min((portion + 1) * PORTION);
            let values: Vec<T> = indices.map(|i| value(&mut memory, i)).collect();
            lock(&spare).push(memory);
            values
        };
        let mut all = Vec::with_capacity(count);
        all.extend(collect_each(count.div_ceil(PORTION), portion_values).into_iter().flatten());
        return all;
    }
    let mut memory = scratch();
    (0..count).map(|i| value(&mut memory, i)).collect()
}

/// The values of a function of the index, from 0 to `count`, where each value takes so long that it is a task
/// of its own.
pub fn collect_each<T: Send>(count: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    #[cfg(feature = "rayon")]
    if !stays_here(count) {
        let mut values: Vec<Option<T>> = (0..count).map(|_| None).collect();
        run_parts(values.iter_mut(), |i, slot| *slot = Some(value(i)));
        return values.into_iter().flatten().collect();
    }
    (0..count).map(value).collect()
}

/// As [`collect_each`] for functions that can fail. After the first error no further value is started; which
/// error is returned is not specified.
///
/// # Errors
/// One of the values is an error.
pub fn try_collect_each<T: Send, E: Send>(
    count: usize,
    value: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    #[cfg(feature = "rayon")]
    if !stays_here(count) {
        let failed = atomic::AtomicBool::new(false);
        let unless_failed = |i: usize| {
            let result = (!failed.load(atomic::Ordering::Relaxed)).then(|| value(i));
            failed.fetch_or(matches!(result, Some(Err(_))), atomic::Ordering::Relaxed);
            result
        };
        return collect_each(count, unless_failed).into_iter().flatten().collect();
    }
    (0..count).map(value).collect()
}

/// Indices in a block of [`holds_in_blocks`], [`per_block`] and [`concat_blocks`].
const FEW: usize = 1024;

/// One value for each block of 1024 consecutive indices from 0 to `count`, in order. For work where the result for
/// one index helps to find that of the next one.
pub fn per_block<T: Send>(count: usize, value: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    collect_each(count.div_ceil(FEW), |b| value(b * FEW..count.min((b + 1) * FEW)))
}

/// The vectors that [`per_block`] returns, joined in order.
pub fn concat_blocks<T: Send>(
    count: usize,
    values: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut blocks = per_block(count, values);
    if blocks.len() == 1 {
        return blocks.pop().unwrap_or_default();
    }
    let mut all = Vec::with_capacity(blocks.iter().map(Vec::len).sum());
    blocks.into_iter().for_each(|block| all.extend(block));
    all
}

/// Whether a condition holds for all blocks of consecutive indices from 0 to `count`. After the first failure
/// no further block is started.
pub fn holds_in_blocks(count: usize, holds: impl Fn(Range<usize>) -> bool + Sync) -> bool {
    let blocks = count.div_ceil(FEW);
    let block = |b: usize| holds(b * FEW..count.min((b + 1) * FEW));
    #[cfg(feature = "rayon")]
    if !stays_here(blocks) {
        let failed = atomic::AtomicBool::new(false);
        run(blocks, &|b| {
            if !failed.load(atomic::Ordering::Relaxed) && !block(b) {
                failed.store(true, atomic::Ordering::Relaxed);
            }
        });
        return !failed.into_inner();
    }
    (0..blocks).all(block)
}

/// Changes every element of a slice by a function of its index, where each element takes so long that it is a
/// task of its own.
pub fn update_each<T: Send>(out: &mut [T], change: impl Fn(usize, &mut T) + Sync) {
    #[cfg(feature = "rayon")]
    if !stays_here(out.len()) {
        return run_parts(out.iter_mut(), change);
    }
    out.iter_mut().enumerate().for_each(|(i, element)| change(i, element));
}

/// Runs two independent functions in parallel and returns both results.
pub fn both<A: Send, B: Send>(
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    if !stays_here(2) {
        return rayon::join(first, second);
    }
    (first(), second())
}

/// Stable sort; fast on partly sorted input.
pub fn sort_by<T: Send>(items: &mut [T], compare: impl Fn(&T, &T) -> core::cmp::Ordering + Sync) {
    #[cfg(feature = "rayon")]
    if !stays_here(items.len().div_ceil(BLOCK)) {
        return items.par_sort_by(compare);
    }
    items.sort_by(compare);
}

/// The number of threads that share the work.
#[must_use]
pub fn threads() -> usize {
    #[cfg(feature = "rayon")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    return 1;
}

/// Runs `here` on this thread, so that it need not be `Send`, while other threads run `there` for each element.
pub fn beside<T: Send, H, R: Send>(
    here: impl FnOnce() -> H,
    elements: &mut [T],
    there: impl Fn(&mut T) -> R + Sync,
) -> (H, Vec<R>) {
    #[cfg(feature = "rayon")]
    {
        let mut results: Vec<Option<R>> = elements.iter().map(|_| None).collect();
        let there = &there;
        let here = rayon::in_place_scope(|scope| {
            for (element, result) in elements.iter_mut().zip(&mut results) {
                scope.spawn(move |_| *result = Some(there(element)));
            }
            here()
        });
        (here, results.into_iter().flatten().collect())
    }
    #[cfg(not(feature = "rayon"))]
    (here(), elements.iter_mut().map(there).collect())
}

/// Folds the values of a function of the index, from 0 to `count`: each block from `zero` upwards,
/// then the blocks in order.
pub fn fold<T: Send + Sync + Copy>(
    count: usize,
    zero: T,
    value: impl Fn(usize) -> T + Sync,
    add: impl Fn(T, T) -> T + Sync,
) -> T {
    let block_total = |block: usize| {
        let indices = block * BLOCK..count.min((block + 1) * BLOCK);
        indices.fold(zero, |total, i| add(total, value(i)))
    };
    let blocks = count.div_ceil(BLOCK);
    #[cfg(feature = "rayon")]
    if !stays_here(blocks) {
        return collect_each(blocks, block_total).into_iter().fold(zero, &add);
    }
    (0..blocks).map(block_total).fold(zero, &add)
}

/// The sum of a function of the index, from 0 to `count`.
pub fn sum(count: usize, value: impl Fn(usize) -> f64 + Sync) -> f64 {
    fold(count, 0.0, value, |a, b| a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_blocked_in_one_fixed_way() {
        let value = |i: usize| 1.0 / (i as f64 + 1.0);
        let count = 3 * BLOCK + 17;
        let mut by_hand = 0.0;
        for block in 0..4 {
            let mut total = 0.0;
            for i in block * BLOCK..count.min((block + 1) * BLOCK) {
                total += value(i);
            }
            by_hand += total;
        }
        assert_eq!(sum(count, value).to_bits(), by_hand.to_bits());
        assert_eq!(sum(0, value), 0.0);
    }

    #[test]
    fn every_index_is_met_once() {
        let count = 5 * BLOCK + 3;
        assert!(collect(count, |i| i).into_iter().eq(0..count));
        let mut out = vec![0; count];
        fill(&mut out, |i| i * 2);
        update(&mut out, |i, value| *value += i);
        update_each(&mut out, |i, value| *value += i);
        assert!(out.into_iter().eq((0..count).map(|i| i * 4)));
        let with_scratch = collect_with(count, Vec::new, |memory: &mut Vec<usize>, i| {
            memory.clear();
            memory.push(i);
            memory[0]
        });
        assert!(with_scratch.into_iter().eq(0..count));
        let in_blocks = collect_blocks(count, Vec::new, |memory: &mut Vec<usize>, indices| {
            memory.clear();
            memory.extend(indices);
            core::array::from_fn::<_, 64, _>(|i| memory.get(i).copied())
        });
        assert!(in_blocks.into_iter().eq((0..count).map(Some)));
        assert!(collect_blocks(0, || (), |_, _| [0; 4]).is_empty());
    }

    #[test]
    fn what_holds_for_all_blocks_holds_and_one_that_does_not_is_enough() {
        let count = 5 * FEW + 3;
        assert!(holds_in_blocks(count, |mut range| range.all(|i| i < count)));
        for bad in [0, 3 * FEW, count - 1] {
            assert!(!holds_in_blocks(count, |range| !range.contains(&bad)));
        }
        assert!(holds_in_blocks(0, |_| false));
    }

    #[test]
    fn all_values_come_in_order_or_an_error_instead_of_them() {
        let below =
            |limit: usize| try_collect_each(100, move |i| if i < limit { Ok(i) } else { Err(i) });
        assert_eq!(below(100), Ok((0..100).collect()));
        assert!(below(70).is_err_and(|i| (70..100).contains(&i)));
    }

    #[test]
    fn equal_items_stay_in_order() {
        let count = 3 * BLOCK + 5;
        let mut items: Vec<(usize, usize)> = (0..count).map(|i| (i * 7 % 100, i)).collect();
        sort_by(&mut items, |a, b| a.0.cmp(&b.0));
        assert!(items.is_sorted() && items.len() == count);
    }

    #[test]
    fn one_thing_stays_on_its_thread_and_the_others_are_in_order() {
        let own = std::thread::current().id();
        let mut elements: Vec<usize> = (0..10).collect();
        let double = |element: &mut usize| {
            *element *= 2;
            *element + 1
        };
        let (here, results) = beside(|| std::thread::current().id(), &mut elements, double);
        assert_eq!(here, own);
        assert!(elements.into_iter().eq((0..10).map(|i| 2 * i)));
        assert!(results.into_iter().eq((0..10).map(|i| 2 * i + 1)));
        assert!(threads() > 0);
    }
}
