//! Work in blocks on all cores, with a few blocks in memory at the same time.

use core::ops::Range;

use mesh_core::parallel;

/// The number of blocks that are computed together before their results are taken.
const AT_ONCE: usize = 64;

/// The values for the indices from 0 to `count`, computed in blocks on all cores.
pub(crate) fn values_in_turn<T: Send>(
    count: usize,
    size: usize,
    values: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut all = Vec::with_capacity(count);
    for_blocks_in_turn(count, size, values, |block| all.extend(block));
    all
}

/// Computes blocks of `size` consecutive indices, from 0 to `count`, on all cores, and takes the results in order while
/// later blocks are computed. Only a few blocks are in memory, and the result equals that of one thread.
pub(crate) fn for_blocks_in_turn<T: Send>(
    count: usize,
    size: usize,
    make: impl Fn(Range<usize>) -> T + Sync,
    mut take: impl FnMut(T) + Send,
) {
    let blocks = count.div_ceil(size);
    let make_from = |first: usize| {
        parallel::collect_each(AT_ONCE.min(blocks - first), |block| {
            let start = (first + block) * size;
            make(start..count.min(start + size))
        })
    };
    let mut made = make_from(0);
    for first in (AT_ONCE..blocks).step_by(AT_ONCE) {
        let ready = core::mem::take(&mut made);
        made = parallel::both(|| make_from(first), || ready.into_iter().for_each(&mut take)).0;
    }
    made.into_iter().for_each(take);
}
