//! What a control group (a container, a batch job) lets a process take, on Linux.
//!
//! `/proc/self/cgroup` names the group in each hierarchy, one a line: `0::/path` in the unified one
//! (version 2), `number:memory:/path` in that of memory alone (version 1); see cgroups(7). Every group above
//! sets a limit as well.

use std::fs;
use std::path::{Path, PathBuf};

/// Where hierarchies are mounted.
const MOUNT: &str = "/sys/fs/cgroup";

/// Names of the files and of a line of `memory.stat`, version by version.
struct Version {
    limit: &'static str,
    usage: &'static str,
    /// Name of the line for cached files, whose memory the system frees before it refuses any.
    inactive_file: &'static str,
}

const UNIFIED: Version =
    Version { limit: "memory.max", usage: "memory.current", inactive_file: "inactive_file" };
const MEMORY_ALONE: Version = Version {
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    inactive_file: "total_inactive_file",
};

/// Bytes that the groups of this process leave; `None` if none limits it.
pub fn available() -> Option<u64> {
    least(Path::new(MOUNT), &fs::read_to_string("/proc/self/cgroup").ok()?)
}

fn least(mount: &Path, membership: &str) -> Option<u64> {
    membership.lines().filter_map(|line| hierarchy(mount, line)).filter_map(left_in).min()
}

/// Where a line's hierarchy is, the group's path in it, and its version; `None` if it is not one of memory.
fn hierarchy<'a>(mount: &Path, line: &'a str) -> Option<(PathBuf, &'a Path, Version)> {
    let mut fields = line.splitn(3, ':');
    let (_, controllers, path) = (fields.next()?, fields.next()?, fields.next()?);
    let path = Path::new(path.trim_start_matches('/'));
    match controllers {
        "" => Some((mount.to_path_buf(), path, UNIFIED)),
        some if some.split(',').any(|name| name == "memory") => Some((mount.join(some), path, MEMORY_ALONE)),
        _ => None,
    }
}

/// The least that a group and those above leave. A process that sees only a part of the hierarchy may not
/// find its own group, but the ones above that it sees.
fn left_in((root, path, version): (PathBuf, &Path, Version)) -> Option<u64> {
    path.ancestors().filter_map(|group| left(&root.join(group), &version)).min()
}

fn left(group: &Path, version: &Version) -> Option<u64> {
    let read = |name: &str| fs::read_to_string(group.join(name)).ok();
    let number = |name: &str| read(name)?.trim().parse::<u64>().ok();
    let limit = number(version.limit)?;
    let statistics = read("memory.stat").unwrap_or_default();
    let inactive = statistics.lines().find_map(|line| {
        let (name, bytes) = line.split_once(' ')?;
        (name == version.inactive_file).then(|| bytes.parse::<u64>().ok())?
    });
    let taken = number(version.usage).unwrap_or(0).saturating_sub(inactive.unwrap_or(0));
    Some(limit.saturating_sub(taken))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(group: &Path, files: &[(&str, &str)]) {
        fs::create_dir_all(group).unwrap();
        files.iter().for_each(|(name, content)| fs::write(group.join(name), content).unwrap());
    }

    #[test]
    fn every_group_above_limits() {
        let mount = tempfile::tempdir().unwrap();
        let slice = mount.path().join("system.slice");
        let statistics = "anon 100\ninactive_file 500\n";
        write(&slice, &[("memory.max", "5000\n"), ("memory.current", "2000\n"), ("memory.stat", statistics)]);
        write(&slice.join("job"), &[("memory.max", "max\n"), ("memory.current", "10\n")]);
        assert_eq!(least(mount.path(), "0::/system.slice/job\n"), Some(3500));
        write(&slice.join("job"), &[("memory.max", "1000\n")]);
        assert_eq!(least(mount.path(), "0::/system.slice/job\n"), Some(990));
        // One that is not seen, and none at all.
        assert_eq!(least(mount.path(), "0::/system.slice/gone\n"), Some(3500));
        assert_eq!(least(mount.path(), "0::/\n"), None);
    }

    #[test]
    fn memory_may_have_a_hierarchy_of_its_own() {
        let mount = tempfile::tempdir().unwrap();
        let files = [("memory.limit_in_bytes", "700\n"), ("memory.usage_in_bytes", "300\n")];
        write(&mount.path().join("memory/batch/1"), &files);
        let membership = "4:memory:/batch/1\n3:cpuset:/\n0::/\n";
        assert_eq!(least(mount.path(), membership), Some(400));
    }
}
