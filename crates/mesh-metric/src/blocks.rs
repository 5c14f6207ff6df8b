//! Work on consecutive indices, block by block: neighbours in order are neighbours in space, so
//! that the answer to one query is a good first guess for the next.

use core::ops::Range;

use mesh_core::parallel;

/// Indices per block, whatever the number of threads.
const BLOCK: usize = 1024;

/// One value for each block of the indices below `count`, in order.
pub(crate) fn in_blocks<T: Send>(count: usize, value: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let block = |b: usize| value(b * BLOCK..count.min((b + 1) * BLOCK));
    parallel::collect_each(count.div_ceil(BLOCK), block)
}

/// Values for the indices below `count`, one each or as many as there are to tell, made block by block.
pub(crate) fn values_in_blocks<T: Send>(
    count: usize,
    values: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut blocks = in_blocks(count, values);
    if blocks.len() == 1 {
        return blocks.pop().unwrap_or_default();
    }
    let mut all = Vec::with_capacity(blocks.iter().map(Vec::len).sum());
    blocks.into_iter().for_each(|block| all.extend(block));
    all
}
