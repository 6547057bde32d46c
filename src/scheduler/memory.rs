//! What this machine has left.

/// Bytes of memory that can be used without swapping, as the kernel estimates it; no limit where
/// it does not say.
pub fn free() -> u64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    available(&text).unwrap_or(u64::MAX)
}

fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_read_from_its_line() {
        let text = "MemTotal:       24000000 kB\nMemAvailable:   16000001 kB\nBuffers: 3 kB\n";
        assert_eq!(available(text), Some(16_000_001 * 1024));
        assert_eq!(available("MemTotal: 1 kB\n"), None);
    }
}
