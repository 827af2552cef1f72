//! Whether a render fits into memory, checked before it begins.

mod control_group;

use super::Settings;
use crate::film::{BLOCK, ChannelAccumulator};
use std::fs;

/// What a render keeps for its pixels.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    pub channels: usize,
    /// Whether it is rendered in passes ([`super::passes`]).
    pub passes: bool,
    /// Light paths for each sample number; a pass has no fewer samples than a block.
    pub light_paths: u64,
    /// Whether samples count for several pixels ([`super::spread`]).
    pub spreads: bool,
}

/// Bytes of the pixels of a render at its peak, which is when the file is made, and of the splats of light
/// paths in a pass. The scene and what threads need besides are not counted.
pub fn estimate(settings: &Settings, Needs { channels, passes, light_paths, spreads }: Needs) -> u64 {
    const MOMENTS: u64 = 2 * size_of::<f32>() as u64;
    const SUMS: u64 = size_of::<ChannelAccumulator>() as u64;
    // What is left of the tiles, or their sums; the image, with sums of its own if it is a shard; and the
    // bytes of the file.
    let kept = match settings.shard {
        true => 2 * SUMS,
        false if passes || spreads => SUMS,
        false => MOMENTS,
    };
    // One sample of every pixel.
    let kept = if spreads { kept + size_of::<f64>() as u64 } else { kept };
    let file = if settings.shard { MOMENTS + SUMS } else { MOMENTS };
    let of_channel = (kept + MOMENTS + file).saturating_mul(settings.window.pixels() as u64);
    // About one splat per light path, before and after they are sorted: the sample, the pixel, and values.
    let splat = 2 * (size_of::<[u32; 2]>() + channels * size_of::<f64>()) as u64;
    let splats = light_paths.saturating_mul(BLOCK).saturating_mul(splat);
    of_channel.saturating_mul(channels as u64).saturating_add(splats)
}

/// Bytes that this process may still take, where the system tells: the least of the machine's free memory and
/// what the control group (a container, a batch job) and the limit of the address space (`ulimit -v`) leave.
pub fn available() -> Option<u64> {
    let read = |path: &str| fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| kilobytes(&text, "MemAvailable:"));
    let taken = read("/proc/self/status").and_then(|text| kilobytes(&text, "VmSize:"));
    let space = read("/proc/self/limits").and_then(|text| address_space(&text));
    let space = space.map(|limit| limit.saturating_sub(taken.unwrap_or(0)));
    machine.into_iter().chain(control_group::available()).chain(space).min()
}

/// The most memory that this process has held, in bytes, where the system tells.
pub fn peak() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Bytes, from a line such as `MemAvailable:   23068672 kB`.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// The limit that is in force; none if it says `unlimited`.
fn address_space(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Refuses a render whose pixels do not fit into the memory that is available.
///
/// # Errors
/// With a sentence that says what is needed, what there is, and what to do.
pub fn check(settings: &Settings, needs: Needs, available: Option<u64>) -> Result<(), String> {
    let needed = estimate(settings, needs);
    match available {
        Some(available) if needed > available => {
            let gigabytes = |bytes: u64| bytes as f64 / (1u64 << 30) as f64;
            let splats = estimate(settings, Needs { light_paths: 0, ..needs }) <= needed / 2;
            Err(format!(
                "a film of {} × {} pixels with {} channels{} needs about {:.1} GiB, and {:.1} GiB are available; {}",
                settings.window.width,
                settings.window.height,
                needs.channels,
                if splats { " and so many light paths" } else { "" },
                gigabytes(needed),
                gigabytes(available),
                if splats { "ask for fewer (--light-paths)" } else { "render crops (--crop) and merge them" }
            ))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Window;

    fn settings(shard: bool) -> Settings {
        let window = Window { x: 0, y: 0, width: 1000, height: 1000 };
        Settings { samples: 0..4, seed: 0, window, threads: 1, shard, kernel: None }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        // A million pixels of three channels: 24 bytes a channel in one go.
        let at_once = Needs { channels: 3, passes: false, light_paths: 0, spreads: false };
        let in_passes = Needs { passes: true, ..at_once };
        assert_eq!(estimate(&settings(false), at_once), 72_000_000);
        assert!(estimate(&settings(false), in_passes) > 200_000_000);
        let spread = estimate(&settings(false), Needs { spreads: true, ..at_once });
        assert_eq!(spread, estimate(&settings(false), in_passes) + 24_000_000);
        assert!(estimate(&settings(true), in_passes) > estimate(&settings(false), in_passes));
        assert_eq!(check(&settings(false), at_once, Some(72_000_000)), Ok(()));
        assert_eq!(check(&settings(false), at_once, None), Ok(()));
        let refused = check(&settings(false), at_once, Some(71_999_999));
        assert!(refused.is_err_and(|e| e.contains("needs about 0.1 GiB") && e.contains("--crop")));
    }

    #[test]
    fn light_paths_beyond_memory_are_refused() {
        let needs = Needs { channels: 3, passes: true, light_paths: 64_000_000, spreads: false };
        let refused = check(&settings(false), needs, Some(1 << 33));
        assert!(
            refused.is_err_and(|e| e.contains("--light-paths")),
            "{:?}",
            estimate(&settings(false), needs)
        );
        assert_eq!(check(&settings(false), Needs { light_paths: 1_000_000, ..needs }, Some(1 << 33)), Ok(()));
    }

    #[test]
    fn the_systems_figure_is_read() {
        let text = "MemTotal:       24 kB\nMemFree: 1 kB\nMemAvailable:   23068672 kB\nBuffers: 1 kB\n";
        let mem_available = |text| kilobytes(text, "MemAvailable:");
        assert_eq!(mem_available(text), Some(23_068_672 * 1024));
        assert_eq!(mem_available("MemTotal: 1 kB\n"), None);
        assert_eq!(mem_available("MemAvailable: x kB\n"), None);
    }

    #[test]
    fn the_limit_of_the_address_space_is_read() {
        let limits = |soft: &str| {
            format!(
                "Limit       Soft Limit   Hard Limit   Units\nMax cpu time  9  9  seconds\nMax address space  {soft}  unlimited  bytes\n"
            )
        };
        assert_eq!(address_space(&limits("409600000")), Some(409_600_000));
        assert_eq!(address_space(&limits("unlimited")), None);
        assert_eq!(address_space(""), None);
    }
}
