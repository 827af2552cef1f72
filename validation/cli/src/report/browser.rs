//! A test of the page in a real browser, where one is installed.

use super::sample::sample;
use std::path::PathBuf;
use std::process::Command;

/// The first browser on the path that can run headless.
fn browser() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|path| path.is_file())
}

#[test]
fn a_browser_shows_it_at_both_widths() {
    let Some(browser) = browser() else {
        println!("no browser: skipped");
        return;
    };
    let folder = std::env::temp_dir().join(format!("etalon-report-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let run = |arguments: &[String]| {
        let profile = format!("--user-data-dir={}", folder.join("profile").display());
        let fixed = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", &profile];
        let output = Command::new(&browser).args(fixed).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let address = |path: &PathBuf| format!("file://{}", path.display());
    let inner = folder.join("report.html");
    std::fs::write(&inner, sample()).unwrap();
    for width in [390, 1280] {
        // A window of a headless browser has a minimum width; a frame in it has none.
        let measure = "frame.onload=()=>{const d=frame.contentDocument,e=d.documentElement;\
             document.body.append(`width ${e.clientWidth} of ${e.scrollWidth}, ${d.querySelectorAll('button').length} buttons.`)}";
        let outer = folder.join("outer.html");
        let frame = format!(
            "<body style=\"margin:0\"><iframe id=\"frame\" style=\"border:0;width:{width}px;height:900px\"></iframe><script>{measure};frame.src='report.html'</script>"
        );
        std::fs::write(&outer, frame).unwrap();
        let allow = "--allow-file-access-from-files".to_string();
        let measured =
            run(&[allow, "--virtual-time-budget=5000".into(), "--dump-dom".into(), address(&outer)]);
        assert!(measured.contains(&format!("width {width} of {width}, 3 buttons")), "{measured}");
        let picture = folder.join("picture.png");
        let [size, shot] =
            [format!("--window-size={},900", width.max(500)), format!("--screenshot={}", picture.display())];
        run(&[size, shot, address(&outer)]);
        // An image of one colour compresses to almost nothing; text and coloured cells do not.
        let bytes = std::fs::metadata(&picture).unwrap().len();
        assert!(bytes > 15_000, "the picture has {bytes} bytes");
    }
    std::fs::remove_dir_all(folder).unwrap();
}
