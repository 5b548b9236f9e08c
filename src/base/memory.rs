//! The memory that the process holds, and how freed memory goes back to the system.
//!
//! A limit on memory is a limit on anonymous pages, which the operating system cannot take back. Pages of mapped files do
//! not count: the system drops clean pages whenever it needs memory.

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

/// Sets up the allocator so that freed memory goes back to the system. Call it before there are threads.
///
/// glibc keeps the memory that threads free, in up to eight arenas a processor, and keeps more the larger the freed blocks
/// were. With these settings, blocks of `LARGE` bytes and above are mapped one by one and unmapped when freed, and little is
/// kept of smaller blocks.
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

/// Gives the small blocks that the allocator keeps back to the system. Cheap enough between phases, not between items.
pub fn trim() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: malloc_trim takes the allocator's locks and touches only pages that nothing lives in.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Freed blocks of this size, in bytes, and above go back to the system. Inference allocates many smaller blocks for every
/// map, which are worth keeping.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: libc::c_int = 1 << 20;

/// Number of arenas: few, so that little is kept; enough that threads seldom wait for each other.
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
