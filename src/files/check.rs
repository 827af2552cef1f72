//! Whether a file could be written, before a render of hours finds out.

use super::{FileError, create_unique, folder, is_link, is_special, partial, target};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Finds out whether the file at `path` could be written, and leaves no trace. That there will be space is
/// not promised.
///
/// # Errors
/// With the reason why it could not be: no folder, no permission, a folder or a write-protected file in its place.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let target = target(path);
    let cannot = |why: String| FileError::writing(path, why);
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
    // Neither the file nor what another process may be writing beside it is touched. A protected file could be renamed
    // over, but whoever protects it does not want that.
    match File::options().write(true).open(&target) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(cannot(error.to_string())),
        _ => {}
    }
    let partial = partial(&target);
    if is_special(&partial) {
        return Err(cannot(format!("{} is in the way", partial.display())));
    }
    let in_use = match File::options().write(true).open(&partial) {
        Err(_) if is_link(&partial) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        tried => tried.map(drop),
    };
    let tried = in_use.and_then(|()| create_unique(&target, "probe"));
    tried.and_then(|(_, probe)| fs::remove_file(probe)).map_err(|error| cannot(error.to_string()))
}

/// Finds out whether a file could take the place of one of those that it is made of, which are read before: whether
/// what is written beside it until it is whole is none of them.
///
/// # Errors
/// If it is.
pub fn check_replacing(inputs: &[PathBuf], output: &Path) -> Result<(), FileError> {
    let partial = partial(&target(output));
    match inputs.iter().find(|input| target(input) == partial) {
        Some(input) => Err(FileError::new(
            input,
            format_args!("it has the name under which {} is written", output.display()),
        )),
        None => Ok(()),
    }
}

/// Finds out whether those of `outputs` that are given could all be written, each in a place of its own and
/// none over one of `inputs`, and leaves no trace.
///
/// # Errors
/// With the reason why one could not be.
pub fn check_outputs(inputs: &[PathBuf], outputs: &[Option<&PathBuf>]) -> Result<(), FileError> {
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
            return Err(FileError::new(path, "this file is read, and cannot be an output"));
        }
        if among(&written) {
            return Err(FileError::new(path, "another output has this place"));
        }
        written.extend([target, partial]);
    }
    Ok(())
}
