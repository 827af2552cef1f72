//! Files are replaced whole, or not at all.

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

#[cfg(unix)]
#[test]
fn a_file_keeps_its_mode_and_its_protection() -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("out.exr");
    let mode = |path: &Path| fs::metadata(path).map(|found| found.permissions().mode() & 0o777);
    fs::write(&path, "old")?;
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600))?;
    assert_eq!(write_file(&path, b"new"), Ok(()));
    assert_eq!((fs::read(&path)?, mode(&path)?), (b"new".to_vec(), 0o600));
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444))?;
    // Nothing is protected from root.
    let is_protected = File::options().write(true).open(&path).is_err();
    assert_eq!(check_writable(&path).is_err(), is_protected);
    assert_eq!(fs::read_dir(folder.path())?.count(), 1);
    Ok(())
}

#[test]
fn what_is_read_is_not_what_is_written_meanwhile() -> io::Result<()> {
    let folder = tempfile::tempdir()?;
    let [out, part, other] = ["out.exr", "out.exr.partial", "b.exr"].map(|name| folder.path().join(name));
    fs::write(&part, "a part of a render")?;
    assert_eq!(check_replacing(&[other.clone(), out.clone()], &out), Ok(()));
    let error = check_replacing(&[other, part.clone()], &out).unwrap_err();
    assert_eq!(error.path, part);
    assert!(error.cause.contains("is written"), "{error}");
    Ok(())
}
