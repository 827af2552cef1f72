//! Files that are either the old or the new one, never half of either.

use super::ImageError;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Replaces the file at `path` by one with these bytes.
///
/// The bytes go to the sibling `path.partial`, which is flushed to the disk and then renamed. On an error the partial file
/// is removed and an existing file at `path` stays as it was. A link is followed; a device or pipe, which cannot
/// be renamed over, is written directly.
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    // Fails where nothing exists yet, and then `path` itself is the target.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let special = fs::metadata(&target).is_ok_and(|metadata| !metadata.is_file());
    let result = if special { fs::write(&target, bytes) } else { replace(&target, bytes) };
    result.map_err(|error| ImageError::new(format!("cannot write: {error}")).at(path))
}

fn replace(target: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut partial = target.as_os_str().to_owned();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    File::create(&partial).and_then(|mut file| {
        let synced = file.write_all(bytes).and_then(|()| file.sync_all());
        synced.and_then(|()| fs::rename(&partial, target)).inspect_err(|_| {
            // The first error is the one to report; that the partial file may stay behind is secondary.
            let _ = fs::remove_file(&partial);
        })
    })
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
    fn a_missing_folder_is_an_error() {
        assert!(write_file(Path::new("/nonexistent/out.exr"), b"").is_err());
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
        let null = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null)?;
        assert_eq!(write_file(&null, b"new"), Ok(()));
        assert!(!fs::metadata(&null)?.is_file());
        Ok(())
    }
}
