//! A program that renders a picture, with the times that it took.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::mpsc::channel;
use std::thread::spawn;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use validation::converge::Picture;
use validation::image;
use validation::peer::{ends_or_is_killed, words};

use super::said::Said;
use super::{Renderer, fill, from_environment};

/// A scene to render, with its sample count, seed and threads.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    pub scene: &'a Path,
    /// Samples per pixel.
    pub samples: u32,
    pub seed: u32,
    /// Number of threads; 0 means all.
    pub threads: usize,
    /// How long the program may run.
    pub limit: Option<Duration>,
}

impl<'a> Job<'a> {
    /// On all threads, for as long as it takes.
    pub fn new(scene: &'a Path, samples: u32, seed: u32) -> Self {
        Self { scene, samples, seed, threads: 0, limit: None }
    }
}

/// Times of a render in seconds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Took {
    /// Wall-clock time of rendering, without start-up and planning.
    pub seconds: f64,
    /// Wall-clock time of planning how to render the scene, which does not depend on the number of samples.
    pub planning: f64,
    /// Processor time of planning and rendering on all threads; of the whole process where the renderer does
    /// not report it.
    pub cpu_seconds: f64,
    /// Wall-clock time before and after planning and rendering.
    pub startup: f64,
}

impl Took {
    /// Seconds of planning and of samples that are compared. On a machine with other load they are processor
    /// time, of which the part of planning is unknown and therefore 0.
    pub fn parts(&self, processor_time: bool) -> (f64, f64) {
        if processor_time { (0.0, self.cpu_seconds) } else { (self.planning, self.seconds) }
    }

    /// The sum of both parts.
    pub fn counted(&self, processor_time: bool) -> f64 {
        let (planning, samples) = self.parts(processor_time);
        planning + samples
    }
}

/// A rendered picture.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Red, green and blue one after the other, each in row-major order.
    pub picture: Picture,
    pub width: usize,
    pub height: usize,
    pub took: Took,
}

impl Renderer {
    /// Renders to the file `out` and reads its colours. Errors: those of [`Self::run`], or a file without
    /// finite R, G, B.
    pub fn render(&self, job: &Job, out: &Path) -> Result<Rendered, String> {
        let took = self.run(job, out)?;
        let (picture, width, height) = read(out)?;
        Ok(Rendered { picture, width, height, took })
    }

    /// Renders to the file `out`. Errors: the program does not start, takes too long or fails; the message
    /// has its last words.
    pub fn run(&self, job: &Job, out: &Path) -> Result<Took, String> {
        let command = from_environment(&self.command)?;
        let words = words(&command).ok_or("a quote of the command is not closed")?;
        let words: Vec<String> = words.iter().map(|word| fill(word, job, out)).collect();
        let (program, arguments) = words.split_first().ok_or("the command is empty")?;
        // A file of an earlier render must not pass for the result.
        if out.exists() {
            std::fs::remove_file(out).map_err(|e| format!("{}: {e}", out.display()))?;
        }
        let (start, busy) = (Instant::now(), children_seconds());
        let output = output(Command::new(sibling(program)).args(arguments), job.limit)
            .map_err(|why| format!("{program:?} {why}"))?;
        let (wall, cpu) = (start.elapsed().as_secs_f64(), children_seconds() - busy);
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
            let said = match (lines.next(), lines.next_back()) {
                (None, _) => "it said nothing".to_owned(),
                (Some(line), None) => line.to_owned(),
                (Some(first), Some(last)) => format!("{first} … {last}"),
            };
            return Err(format!("{program:?} failed ({}): {said}", output.status));
        }
        if !out.exists() {
            return Err(format!("{program:?} ended well, but wrote no {}", out.display()));
        }
        let said = Said::of(&String::from_utf8_lossy(&output.stdout))?;
        let seconds = said.seconds.unwrap_or(wall);
        let planning = said.planning.unwrap_or(0.0);
        if seconds + planning > LOOSE * wall {
            let said = seconds + planning;
            return Err(format!("{program:?} says that it rendered for {said} s, but ran for {wall:.3} s"));
        }
        let all = wall * std::thread::available_parallelism().map_or(1.0, |cores| usize::from(cores) as f64);
        if let Some(said) = said.cpu_seconds.filter(|said| *said > LOOSE * all + TICK) {
            return Err(format!(
                "{program:?} says that it took {said} s of processors, which had {all:.3} s"
            ));
        }
        let cpu_seconds = said.cpu_seconds.unwrap_or(cpu.max(1e-3));
        Ok(Took { seconds, planning, cpu_seconds, startup: (wall - planning - seconds).max(0.0) })
    }
}

/// How much longer than it ran a program may say that it rendered: clocks differ.
const LOOSE: f64 = 1.01;

/// What clocks of processors are off by, in seconds: they count in hundredths.
const TICK: f64 = 0.05;

/// How long a pipe is read after the program has ended: what that has left running may hold it open.
const GRACE: Duration = Duration::from_secs(1);

/// What a command prints until it ends; it is killed, with all that it has started, if that is not within the
/// limit.
fn output(command: &mut Command, limit: Option<Duration>) -> Result<Output, String> {
    /// Reads beside the wait, so that no full pipe stops the program.
    fn all_of(mut pipe: impl Read + Send + 'static) -> impl FnOnce() -> Vec<u8> {
        let (pieces, said) = channel();
        spawn(move || {
            let mut piece = [0; 1 << 16];
            // What cannot be read was not said.
            while let Ok(length) = pipe.read(&mut piece) {
                if length == 0 || pieces.send(piece[..length].to_vec()).is_err() {
                    break;
                }
            }
        });
        move || {
            let end = Instant::now() + GRACE;
            let next = || said.recv_timeout(end.saturating_duration_since(Instant::now())).ok();
            std::iter::from_fn(next).flatten().collect()
        }
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| format!("does not start: {e}"))?;
    let (stdout, stderr) = (child.stdout.take().map(all_of), child.stderr.take().map(all_of));
    let status = match limit {
        None => child.wait().map_err(|e| e.to_string())?,
        Some(limit) => ends_or_is_killed(&mut child, limit)
            .map_err(|e| e.to_string())?
            .ok_or_else(|| format!("took longer than the limit of {} s", limit.as_secs_f64()))?,
    };
    let [stdout, stderr] = [stdout.map_or(vec![], |read| read()), stderr.map_or(vec![], |read| read())];
    Ok(Output { status, stdout, stderr })
}

/// Channels R, G and B of an OpenEXR file, and its width and height.
pub fn read(file: &Path) -> Result<(Picture, usize, usize), String> {
    let found = image::load(file).map_err(|e| e.to_string())?;
    let named = |name: &str| found.channels.iter().find(|c| c.name == name);
    let channels: Option<Vec<_>> = ["R", "G", "B"].into_iter().map(named).collect();
    let channels = channels.ok_or_else(|| format!("{}: there are no channels R, G, B", file.display()))?;
    for channel in &channels {
        if let Some((index, value)) = channel.mean.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            let (x, y) = (index % found.width, index / found.width);
            return Err(format!("channel {} of the picture is {value} at pixel ({x}, {y})", channel.name));
        }
    }
    let picture: Picture = channels.iter().flat_map(|c| c.mean.iter().copied()).collect();
    Ok((picture, found.width, found.height))
}

/// Processor time of the children that have ended, in seconds; 0 where the system does not report it. Linux
/// counts it in hundredths (`proc(5)`, fields 16 and 17 of `stat`); the name of the program, in parentheses,
/// may contain spaces.
fn children_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let fields = after.split_whitespace().skip(13).take(2);
    fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// The program of this name in the folder of this one, if it exists there; otherwise it is searched on the
/// path.
fn sibling(program: &str) -> PathBuf {
    let beside = std::env::current_exe().ok().map(|exe| exe.with_file_name(program));
    beside.filter(|path| path.is_file()).unwrap_or_else(|| program.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_program_and_a_failing_one_are_errors() {
        let job = Job::new(Path::new("a b.xml"), 1, 7);
        let out = std::env::temp_dir().join("etalon-no-such-picture.exr");
        let error = |command: &str| {
            Renderer { command: command.into(), mean_of: None, color: None }.render(&job, &out).unwrap_err()
        };
        assert!(error("no-such-renderer {out}").contains("does not start"));
        assert!(error("").contains("empty"));
        assert_eq!(fill("x{scene}:{seed}", &job, &out), "xa b.xml:7");
        let odd = Job { scene: Path::new("a{seed}.xml"), ..job };
        assert_eq!(fill("{scene} {{seed} {x {spp}", &odd, &out), "a{seed}.xml {7 {x 1");
    }

    #[test]
    fn a_childs_work_is_counted() {
        let before = children_seconds();
        let work = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        assert!(Command::new("sh").args(["-c", work]).status().unwrap().success());
        assert!(children_seconds() > before);
    }

    #[test]
    fn a_program_that_never_ends_is_stopped() {
        let out = std::env::temp_dir().join("etalon-no-such-picture.exr");
        let job = Job { limit: Some(Duration::from_millis(200)), ..Job::new(Path::new("any.xml"), 1, 0) };
        let renderer = |command: &str| Renderer { command: command.into(), mean_of: None, color: None };
        let error = renderer("sleep 1000").run(&job, &out).unwrap_err();
        assert_eq!(error, "\"sleep\" took longer than the limit of 0.2 s");
        // More than a pipe holds, within a limit that does not matter.
        let many = "sh -c 'head -c 1000000 /dev/zero; echo last words >&2; exit 3'";
        let job = Job { limit: Some(Duration::from_secs(1000)), ..job };
        let error = renderer(many).run(&job, &out).unwrap_err();
        assert!(error.ends_with("last words"), "{error}");
    }

    #[test]
    fn what_a_program_has_started_neither_outlives_it_nor_is_waited_for() {
        let folder = std::env::temp_dir().join(format!("etalon-descendants-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (out, alive) = (folder.join("out.exr"), folder.join("alive"));
        let renderer = |command: String| Renderer { command, mean_of: None, color: None };
        let run = |command: String, limit: u64| {
            let job =
                Job { limit: Some(Duration::from_millis(limit)), ..Job::new(Path::new("any.xml"), 1, 0) };
            renderer(command).run(&job, &out)
        };
        // A script that waits for a program of its own.
        let script = format!("sh -c 'sh -c \"sleep 3; touch {}\"; true'", alive.display());
        assert!(run(script, 500).unwrap_err().contains("took longer"));
        // One that leaves a program running, which holds its output open.
        let start = Instant::now();
        let took =
            run("sh -c 'echo picture > {out}; sleep 20 & echo {\\\"seconds\\\": 0.001}'".into(), 600_000);
        assert!(start.elapsed() < Duration::from_secs(10), "it was waited for");
        assert_eq!(took.unwrap().seconds, 0.001);
        std::thread::sleep(Duration::from_secs(4).saturating_sub(start.elapsed()));
        assert!(!alive.exists(), "a program outlived the one that had started it");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn nobody_renders_for_longer_than_it_runs() {
        let out = std::env::temp_dir().join(format!("etalon-never-{}.exr", std::process::id()));
        let says = |what: &str| {
            let command = format!("sh -c 'echo picture > {{out}}; echo {{\\\"seconds\\\": {what}}}'");
            Renderer { command, mean_of: None, color: None }.run(&Job::new(Path::new("any.xml"), 1, 0), &out)
        };
        assert!(says("0.0001").is_ok());
        let error = says("5000").unwrap_err();
        assert!(error.contains("says that it rendered for 5000 s, but ran for"), "{error}");
        let error = says("0.0001, \\\"cpu_seconds\\\": 5000").unwrap_err();
        assert!(error.contains("says that it took 5000 s of processors, which had"), "{error}");
        assert!(says("1e-300").unwrap_err().contains("which is no time"));
        std::fs::remove_file(&out).unwrap();
    }
}
