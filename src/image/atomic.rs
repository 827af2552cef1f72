//! Files that are either the old or the new one, never half of either.

use super::ImageError;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Replaces the file at `path` by one with these bytes: it is the old one or the new one, never half of
/// either.
///
/// # Errors
/// With the reason why it cannot be written; a file that was there stays as it was.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    write_file_with(path, |file| file.write_all(bytes))
}

/// Replaces the file at `path` by what `write` writes.
///
/// The bytes go to the sibling `path.partial`, which is flushed to the disk and then renamed. Who writes it
/// holds a lock on it, so that of several processes with the same output each leaves a whole file and the
/// last one stays. On an error the partial file is removed and an existing file at `path` stays as it was. A
/// link is followed; a device or pipe, which cannot be renamed over, is written directly.
pub(crate) fn write_file_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), ImageError> {
    heed_size_limits();
    let target = target(path);
    let result = if is_special(&target) {
        File::create(&target).and_then(|file| buffered(&file, write))
    } else {
        replace(&target, write)
    };
    result.map_err(|error| ImageError::new(format!("cannot write: {error}")).at(path))
}

/// Makes a write beyond the largest file that the process may write an error like that of a full disk: the
/// system would end the process by a signal, if that had no handler.
fn heed_size_limits() {
    #[cfg(unix)]
    {
        use std::sync::{Arc, Once};
        static HEEDED: Once = Once::new();
        // Without the handler such a write has no message, but still harms no file.
        HEEDED.call_once(|| drop(signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())));
    }
}

/// Finds out whether the file at `path` could be written, and leaves no trace. That there will be space is
/// not promised.
///
/// # Errors
/// With the reason why it could not be: no folder, no permission, a folder in its place.
pub fn check_writable(path: &Path) -> Result<(), ImageError> {
    let target = target(path);
    let cannot = |why: String| ImageError::new(format!("cannot write: {why}")).at(path);
    if target.is_dir() {
        return Err(cannot("it is a folder".into()));
    }
    let folder = folder(&target);
    if !folder.is_dir() {
        return Err(cannot(format!("there is no folder {}", folder.display())));
    }
    if is_special(&target) {
        return Ok(());
    }
    // Neither the file nor what another process may be writing beside it is touched.
    let partial = partial(&target);
    let in_use = match File::options().write(true).open(&partial) {
        Err(_) if is_link(&partial) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        tried => tried.map(drop),
    };
    let tried = in_use.and_then(|()| create_unique(&target, "probe"));
    tried.and_then(|(_, probe)| fs::remove_file(probe)).map_err(|error| cannot(error.to_string()))
}

/// Finds out whether those of `outputs` that are given could all be written, each in a place of its own and
/// none over one of `inputs`, and leaves no trace.
///
/// # Errors
/// With the reason why one could not be.
pub fn check_outputs(inputs: &[PathBuf], outputs: &[Option<&PathBuf>]) -> Result<(), ImageError> {
    outputs.iter().flatten().try_for_each(|path| check_writable(path))?;
    let read: Vec<PathBuf> = inputs.iter().map(|path| target(path)).collect();
    let mut written = vec![];
    for path in outputs.iter().flatten() {
        let target = target(path);
        // Streams and devices take everything that is written to them.
        if is_special(&target) {
            continue;
        }
        let partial = partial(&target);
        let among = |taken: &[PathBuf]| taken.contains(&target) || taken.contains(&partial);
        if among(&read) {
            return Err(ImageError::new("this file is read, and cannot be an output").at(path));
        }
        if among(&written) {
            return Err(ImageError::new("another output has this place").at(path));
        }
        written.extend([target, partial]);
    }
    Ok(())
}

/// Links that lead to one another in a row, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// The file that a path leads to, which may not exist yet.
fn target(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    // What leads to a pipe has a name that is no path.
    if fs::metadata(&path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return path;
    }
    for _ in 0..MOST_LINKS {
        match (fs::canonicalize(&path), fs::read_link(&path)) {
            (Ok(found), _) => return found,
            (Err(_), Ok(next)) => path = folder(&path).join(next),
            (Err(_), Err(_)) => break,
        }
    }
    let in_folder = || Some(fs::canonicalize(folder(&path)).ok()?.join(path.file_name()?));
    in_folder().unwrap_or(path)
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn is_special(target: &Path) -> bool {
    fs::metadata(target).is_ok_and(|metadata| !metadata.is_file())
}

fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_symlink())
}

fn partial(target: &Path) -> PathBuf {
    beside(target, ".partial")
}

/// A new file beside `target` that nobody else has.
fn create_unique(target: &Path, ending: &str) -> io::Result<(File, PathBuf)> {
    static NUMBERS: AtomicU64 = AtomicU64::new(0);
    loop {
        let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
        let path = beside(target, &format!(".{}-{number}.{ending}", std::process::id()));
        match File::create_new(&path) {
            // It is that of a process with the same number, at another time or in another container.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            created => return created.map(|file| (file, path)),
        }
    }
}

fn beside(target: &Path, ending: &str) -> PathBuf {
    let mut name = target.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

fn buffered(file: &File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 20, file);
    write(&mut writer)?;
    writer.flush()
}

fn replace(target: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let (file, partial) = claim(target)?;
    let written = buffered(&file, write).and_then(|()| file.sync_all());
    written.and_then(|()| fs::rename(&partial, target)).inspect_err(|_| {
        // The first error is the one to report; that the partial file may stay behind is secondary.
        let _ = fs::remove_file(&partial);
    })
}

/// How long another process may take to write the same file.
const PATIENCE: Duration = Duration::from_secs(60);

/// Opens a partial file, empty, for this process alone; the lock ends when the file is closed. If another
/// process holds it too long, or the file system has no locks, the file gets a name of its own: a complete
/// render must not be lost because of a lock. So it does where a link has the name, which may lead anywhere.
fn claim(target: &Path) -> io::Result<(File, PathBuf)> {
    let (begin, path) = (Instant::now(), partial(target));
    loop {
        if is_link(&path) {
            return create_unique(target, "partial");
        }
        let file = File::options().write(true).create(true).truncate(false).open(&path)?;
        match file.try_lock() {
            // Whoever had the lock may have renamed the file since it was opened: then it is the output, and
            // not to be emptied.
            Ok(()) if is_at(&file, &path) => return file.set_len(0).map(|()| (file, path)),
            Ok(()) => {}
            Err(TryLockError::WouldBlock) if begin.elapsed() < PATIENCE => {
                std::thread::sleep(Duration::from_millis(10));
            }
            Err(_) => return create_unique(target, "partial"),
        }
    }
}

/// Whether an open file is the one that has this name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |metadata: &fs::Metadata| (metadata.dev(), metadata.ino());
    matches!((file.metadata(), fs::symlink_metadata(path)), (Ok(a), Ok(b)) if place(&a) == place(&b))
}

/// On other systems a file that is open cannot be renamed, so it is the one if there is one of this name.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("out.exr");
        for content in ["first, longer", "second"] {
            assert_eq!(write_file(&path, content.as_bytes()), Ok(()));
            assert_eq!(fs::read_to_string(&path)?, content);
        }
        assert_eq!(fs::read_dir(folder.path())?.count(), 1);
        Ok(())
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_pipe_is_written_directly() -> io::Result<()> {
        use std::os::fd::AsRawFd;
        let (mut reader, writer) = io::pipe()?;
        let path = PathBuf::from(format!("/proc/self/fd/{}", writer.as_raw_fd()));
        assert_eq!(check_outputs(&[], &[Some(&path), Some(&path)]), Ok(()));
        assert_eq!(write_file(&path, b"what is seen"), Ok(()));
        drop(writer);
        let mut seen = String::new();
        io::Read::read_to_string(&mut reader, &mut seen)?;
        assert_eq!(seen, "what is seen");
        Ok(())
    }

    #[test]
    fn an_error_leaves_the_old_file() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("out.exr");
        fs::write(&path, "old")?;
        // A folder in the place of the partial file makes its creation fail.
        fs::create_dir(folder.path().join("out.exr.partial"))?;
        let error = write_file(&path, b"new").expect_err("the partial file cannot be made");
        assert!(error.to_string().contains("out.exr: cannot write"), "{error}");
        assert_eq!(fs::read_to_string(&path)?, "old");
        Ok(())
    }

    #[test]
    fn of_many_writers_each_leaves_a_whole_file() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("out.exr");
        let content = |byte: u8| vec![byte; 1 << 16];
        std::thread::scope(|threads| {
            for byte in 0..8 {
                let path = &path;
                threads.spawn(move || {
                    for _ in 0..20 {
                        assert_eq!(check_writable(path), Ok(()));
                        assert_eq!(write_file(path, &content(byte)), Ok(()));
                        let found = fs::read(path).unwrap();
                        assert!(found == content(found[0]), "{} bytes", found.len());
                    }
                });
            }
        });
        assert_eq!(fs::read_dir(folder.path())?.count(), 1);
        Ok(())
    }

    #[test]
    fn half_a_file_is_taken_back() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("out.exr");
        fs::write(&path, "old")?;
        let error = write_file_with(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(error.is_err_and(|e| e.to_string().contains("out.exr: cannot write")));
        assert_eq!(fs::read_to_string(&path)?, "old");
        assert_eq!(fs::read_dir(folder.path())?.count(), 1);
        Ok(())
    }

    #[test]
    fn whether_a_file_could_be_written_is_found_out_without_a_trace() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        assert_eq!(check_writable(&folder.path().join("new")), Ok(()));
        assert_eq!(fs::read_dir(folder.path())?.count(), 0);
        assert!(check_writable(folder.path()).is_err_and(|e| e.cause.contains("it is a folder")));
        let missing = folder.path().join("no").join("out.exr");
        assert!(check_writable(&missing).is_err_and(|e| e.cause.contains("there is no folder")));
        Ok(())
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error() {
        let error = write_file(Path::new("/dev/full"), b"new").expect_err("the device is full");
        assert!(error.to_string().starts_with("/dev/full: cannot write: "), "{error}");
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        assert!(write_file(Path::new("/nonexistent/out.exr"), b"").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_beside_the_file_leads_nowhere() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let (path, other) = (folder.path().join("out.exr"), folder.path().join("precious"));
        fs::write(&other, "precious")?;
        std::os::unix::fs::symlink(&other, folder.path().join("out.exr.partial"))?;
        assert_eq!(check_writable(&path), Ok(()));
        assert_eq!(write_file(&path, b"new"), Ok(()));
        assert_eq!([&other, &path].map(|file| fs::read_to_string(file).unwrap()), ["precious", "new"]);
        assert!(!fs::symlink_metadata(&path)?.is_symlink());
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_are_written_through() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let (path, link) = (folder.path().join("out.exr"), folder.path().join("link.exr"));
        fs::write(&path, "old")?;
        std::os::unix::fs::symlink(&path, &link)?;
        assert_eq!(write_file(&link, b"new"), Ok(()));
        assert_eq!(fs::read_to_string(&path)?, "new");
        assert!(fs::symlink_metadata(&link)?.is_symlink());
        let (dangling, later) = (folder.path().join("dangling.exr"), folder.path().join("later.exr"));
        std::os::unix::fs::symlink("later.exr", &dangling)?;
        assert_eq!(write_file(&dangling, b"new"), Ok(()));
        assert_eq!(fs::read_to_string(&later)?, "new");
        assert!(fs::symlink_metadata(&dangling)?.is_symlink());
        let null = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null)?;
        assert_eq!(write_file(&null, b"new"), Ok(()));
        assert!(!fs::metadata(&null)?.is_file());
        Ok(())
    }
}
