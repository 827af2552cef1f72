//! The process that reads inputs. It prints a line before each input and a line about each; its parent
//! notices if it dies.

use super::Format;
use super::seeds::Seeds;
use super::watch::Effort;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Bytes in use now, and the largest number since `reset`, as the counting allocator of the binary reports
/// them.
pub struct Meter {
    pub reset: fn(),
    pub current: fn() -> usize,
    pub peak: fn() -> usize,
}

/// Reads inputs from number `first` on until the time is over or `count` inputs are read.
///
/// Output lines: `N` before input N; `panic MESSAGE` and `memory BYTES` about it; `done` at the end, or
/// `broken MESSAGE` if the worker cannot go on.
pub fn work(
    format: &Format,
    seeds: &Seeds,
    Effort { first, count, time }: Effort,
    folder: &Path,
    meter: &Meter,
) {
    let words = Arc::new(Mutex::new(String::new()));
    let heard = words.clone();
    std::panic::set_hook(Box::new(move |panic| {
        if let Ok(mut words) = heard.lock() {
            *words = panic.to_string().replace('\n', " ");
        }
    }));
    let file = folder.join(format!("input.{}", format.extensions[0]));
    let start = Instant::now();
    for number in (first..first.saturating_add(count)).take_while(|_| start.elapsed() < time) {
        say(&number.to_string());
        let input = seeds.input(format, number);
        if std::fs::write(&file, &input).is_err() {
            say(&format!("broken {}: the input cannot be written", file.display()));
            return;
        }
        (meter.reset)();
        let before = (meter.current)();
        if catch_unwind(AssertUnwindSafe(|| (format.read)(&input, &file))).is_err() {
            say(&format!("panic {}", words.lock().map(|w| w.clone()).unwrap_or_default()));
        }
        let used = (meter.peak)().saturating_sub(before);
        say(&format!("memory {used}"));
    }
    say("done");
}

fn say(line: &str) {
    // If the parent no longer reads, it is about to end this process.
    let _ = writeln!(std::io::stdout(), "{line}");
}
