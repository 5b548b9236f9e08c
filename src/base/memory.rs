//! What the process holds of the machine's memory, and giving back what it has freed.
//!
//! A limit on memory is a limit on what the operating system cannot take back: anonymous pages. Pages of mapped files do
//! not count, since the system drops clean ones whenever it wants them.

/// Bytes of anonymous memory that this process holds now; `None` where the system does not say.
pub fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    anonymous(&status)
}

/// Bytes of anonymous memory in a `/proc/PID/status`: its `RssAnon` and `RssShmem`.
pub fn anonymous(status: &str) -> Option<u64> {
    let kibibytes = |name: &str| -> Option<u64> {
        let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
        line.trim().strip_suffix("kB")?.trim().parse().ok()
    };
    Some((kibibytes("RssAnon")? + kibibytes("RssShmem")?) << 10)
}

/// Sets up the allocator so that memory that is freed goes back to the system. To be called before there are threads.
///
/// glibc keeps what threads free, in up to eight arenas a processor, and the more the larger the blocks that were freed.
/// Set so, blocks of [`LARGE`] and above are mapped one by one and unmapped when freed, and what is kept of smaller ones
/// is little.
pub fn return_what_is_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    for (parameter, value) in [
        (libc::M_ARENA_MAX, ARENAS),
        // IMPORTANT: both thresholds, or glibc raises them to the largest block that was freed.
        (libc::M_MMAP_THRESHOLD, LARGE),
        (libc::M_TRIM_THRESHOLD, LARGE),
    ] {
        // SAFETY: mallopt sets a number in the allocator, under the allocator's own lock. It fails without effect.
        unsafe { libc::mallopt(parameter, value) };
    }
}

/// Gives back what the allocator keeps of small blocks. Cheap enough between phases, not between items.
pub fn trim() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: malloc_trim takes the allocator's locks and touches only pages that nothing lives in.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Blocks of this size, in bytes, and larger ones are the system's again once they are freed. Inference allocates many
/// smaller ones for every map, and those are worth keeping.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: libc::c_int = 1 << 20;

/// Arenas: threads that allocate small blocks at once seldom wait for each other, and each keeps little.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const ARENAS: libc::c_int = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_anonymous_pages_count() {
        let status = "VmRSS:\t  9000 kB\nRssAnon:\t   1000 kB\nRssFile:\t   7976 kB\nRssShmem:\t      24 kB\n";
        assert_eq!(anonymous(status), Some(1024 << 10));
        assert_eq!(anonymous("VmRSS:\t 9000 kB\n"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_held_is_seen() {
        let before = resident().unwrap();
        let held = std::hint::black_box(vec![1u8; 64 << 20]);
        // Other tests run beside this one and hold and free a little.
        assert!(resident().unwrap() > before + (32 << 20), "{before}");
        drop(held);
    }
}
