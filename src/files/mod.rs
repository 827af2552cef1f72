//! Files that are either the old or the new one, never half of either.

mod check;
#[cfg(test)]
mod tests;

pub use check::{check_outputs, check_replacing, check_writable};

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Why a file could not be written or read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file concerned.
    pub path: PathBuf,
    /// What is wrong, in one sentence.
    pub cause: String,
}

impl FileError {
    /// That this is wrong with a file.
    pub fn new(path: &Path, cause: impl fmt::Display) -> FileError {
        FileError { path: path.to_owned(), cause: cause.to_string() }
    }

    fn writing(path: &Path, why: impl fmt::Display) -> FileError {
        FileError::new(path, format_args!("cannot write: {why}"))
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.path.display(), self.cause)
    }
}

impl std::error::Error for FileError {}

/// Replaces the file at `path` by one with these bytes: it is the old one or the new one, never half of
/// either.
///
/// # Errors
/// With the reason why it cannot be written; a file that was there stays as it was.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_file_with(path, |file| file.write_all(bytes))
}

/// Replaces the file at `path` by what `write` writes.
///
/// The bytes go to the sibling `path.partial`, which is flushed to the disk and then renamed. Who writes it
/// holds a lock on it, so that of several processes with the same output each leaves a whole file and the
/// last one stays. The new file has the mode of the old one. On an error the partial file is removed and an
/// existing file at `path` stays as it was. A link is followed; a device or pipe, which cannot be renamed over, is written directly.
pub(crate) fn write_file_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    write_file_unless(path, write, || Ok(()))
}

/// The same, unless `may_replace`, which is asked when all is written, has an error.
pub(crate) fn write_file_unless(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    may_replace: impl FnOnce() -> Result<(), FileError>,
) -> Result<(), FileError> {
    heed_size_limits();
    let target = target(path);
    let writing = |error| FileError::writing(path, error);
    if is_special(&target) {
        return File::create(&target).and_then(|file| buffered(&file, write)).map_err(writing);
    }
    let (file, partial) = claim(&target).map_err(writing)?;
    if let Ok(replaced) = fs::metadata(&target) {
        // Who may not change its mode at least keeps the bytes.
        let _ = file.set_permissions(replaced.permissions());
    }
    let written = buffered(&file, write).and_then(|()| file.sync_all()).map_err(writing);
    let renamed = || fs::rename(&partial, &target).map(|()| flush_folder(&target)).map_err(writing);
    written.and_then(|()| may_replace()).and_then(|()| renamed()).inspect_err(|_| {
        // The first error is the one to report; that the partial file may stay behind is secondary.
        let _ = fs::remove_file(&partial);
    })
}

/// Puts a new name on the disk, so that it outlives the machine: whoever wrote the file may now remove what it came
/// from. Not every file system can.
fn flush_folder(target: &Path) {
    let _ = File::open(folder(target)).and_then(|folder| folder.sync_all());
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
