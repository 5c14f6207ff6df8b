//! The memory of this process, as reported by Linux.

/// Resets the peak memory; returns the memory in use, if the system reports it.
pub(crate) fn start() -> Option<u64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    bytes("VmRSS:")
}

/// The peak since then, minus the memory in use before.
pub(crate) fn beyond(before: u64) -> Option<u64> {
    Some(bytes("VmHWM:")?.saturating_sub(before))
}

fn bytes(field: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(field))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}
