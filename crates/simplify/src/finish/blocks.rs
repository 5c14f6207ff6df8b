//! Work that is done block by block on all cores, a few blocks at a time.

use mesh_core::parallel;

/// Blocks that are made at the same time before their results are taken.
const AT_ONCE: usize = 64;

/// Makes blocks on all cores and takes them in order, a few at a time: memory is that of a few, and
/// the result that of one thread.
pub(crate) fn for_blocks_in_turn<T: Send>(
    blocks: usize,
    make: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(T),
) {
    for first in (0..blocks).step_by(AT_ONCE) {
        let count = AT_ONCE.min(blocks - first);
        let made = parallel::collect_with(count, || (), |(), block| make(first + block));
        made.into_iter().for_each(&mut take);
    }
}
