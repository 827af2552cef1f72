//! Another program that answers each line with a line.
//!
//! Reading and writing have a thread each, so that a program that does not read, does not answer, or answers
//! without end costs no more than the time limit.

use std::{
    io::{BufRead, BufReader, Read, Write},
    process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio},
    sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel},
    thread::{sleep, spawn},
    time::{Duration, Instant},
};

use super::{Lines, PeerError};

/// Largest length of a line in bytes; a longer one is an error.
const LONGEST_LINE: u64 = 1 << 26;

/// A running program. When this is dropped its input ends, and it is killed if it does not end by itself.
pub struct Process {
    child: Child,
    /// What it is asked; `None` once there is nothing more.
    requests: Option<Sender<String>>,
    replies: Receiver<Result<String, String>>,
    limit: Duration,
}

impl Process {
    /// Starts `command`: a program and its arguments, separated by spaces; quotes (' or ") hold spaces
    /// together. Its standard error is that of this process. `limit` is the time limit of each answer.
    /// Errors: an open quote, an empty command, a program that does not start.
    pub fn start(command: &str, limit: Duration) -> Result<Self, PeerError> {
        let words =
            words(command).ok_or_else(|| PeerError(format!("a quote is not closed in: {command}")))?;
        let (program, arguments) =
            words.split_first().ok_or_else(|| PeerError("the peer's command is empty".into()))?;
        let mut child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| PeerError(format!("the peer's command {program:?} does not start: {e}")))?;
        let (Some(stdin), Some(stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(PeerError("the peer has no standard input or output".into()));
        };
        let (requests, pending) = channel();
        // At most one line is read ahead, so that endless output does not fill the memory.
        let (answers, replies) = sync_channel(1);
        spawn(move || write_lines(stdin, &pending));
        spawn(move || read_lines(stdout, &answers));
        Ok(Self { child, requests: Some(requests), replies, limit })
    }

    /// How the program ended, if it has.
    fn ending(&mut self) -> String {
        match ends_within(&mut self.child, Duration::from_millis(500)) {
            Ok(Some(status)) => format!("ended ({status})"),
            _ => "closed its output".into(),
        }
    }
}

/// How a program ended, if it does within this time; if it does not, it is killed, with all that it has
/// started, as far as the system tells what that is (`/proc`).
pub fn ends_or_is_killed(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let ended = ends_within(child, limit);
    if !matches!(ended, Ok(Some(_))) {
        // Known before it ends: afterwards they are nobody's. All fail only if what they kill has ended.
        let started = descendants(child.id());
        let _ended = child.kill();
        let kill =
            |id: &u32| Command::new("kill").args(["-KILL", &id.to_string()]).stderr(Stdio::null()).status();
        started.iter().for_each(|id| drop(kill(id)));
        let _ended = child.wait();
    }
    ended
}

/// The programs that one has started, and that these have started, by the parents that Linux tells
/// (`proc(5)`, field 4 of `stat`; the name of the program, in parentheses, may contain spaces).
fn descendants(of: u32) -> Vec<u32> {
    let parent = |id: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
        stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
    };
    let names = std::fs::read_dir("/proc").into_iter().flatten().flatten().map(|entry| entry.file_name());
    let all: Vec<(u32, u32)> = names
        .filter_map(|name| name.to_str()?.parse().ok())
        .filter_map(|id| Some((id, parent(id)?)))
        .collect();
    let mut found = vec![of];
    let mut next = 0;
    while next < found.len() {
        let children = all.iter().filter(|(_, parent)| *parent == found[next]).map(|(id, _)| *id);
        let children: Vec<u32> = children.filter(|id| !found.contains(id)).collect();
        found.extend(children);
        next += 1;
    }
    found.split_off(1)
}

/// How a program ended, if it does within this time.
fn ends_within(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(None) if start.elapsed() < limit => sleep(Duration::from_millis(5)),
            ended => return ended,
        }
    }
}

impl Lines for Process {
    fn exchange(&mut self, request: String) -> Result<String, PeerError> {
        if let Ok(line) = self.replies.try_recv() {
            let line = line.map_or_else(|message| message, |line| beginning(&line));
            return Err(PeerError(format!("the peer wrote a line that nobody asked for: {line}")));
        }
        // Sending fails only if the program has ended, which the reader then reports.
        let _gone = self.requests.as_ref().map(|requests| requests.send(request));
        match self.replies.recv_timeout(self.limit) {
            Ok(Ok(line)) => Ok(line),
            Ok(Err(message)) => Err(PeerError(format!("the peer's answer cannot be read: {message}"))),
            Err(RecvTimeoutError::Timeout) => {
                let seconds = self.limit.as_secs_f64();
                Err(PeerError(format!("the peer did not answer within {seconds} s; --timeout allows more")))
            }
            Err(RecvTimeoutError::Disconnected) => {
                Err(PeerError(format!("the peer {} before it answered", self.ending())))
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Its input ends, at which it has a second to end by itself.
        self.requests = None;
        let _ended = ends_or_is_killed(&mut self.child, Duration::from_secs(1));
    }
}

fn write_lines(mut stdin: ChildStdin, pending: &Receiver<String>) {
    for line in pending {
        if stdin.write_all(line.as_bytes()).and_then(|()| stdin.write_all(b"\n")).is_err() {
            return;
        }
        if stdin.flush().is_err() {
            return;
        }
    }
}

fn read_lines(stdout: ChildStdout, answers: &SyncSender<Result<String, String>>) {
    let mut reader = BufReader::new(stdout);
    loop {
        let mut line = vec![];
        let answer = match reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line) {
            Ok(0) => return,
            Ok(_) if line.len() as u64 == LONGEST_LINE => {
                Err(format!("a line is longer than {LONGEST_LINE} bytes"))
            }
            // What ended in the midst of a line has not answered.
            Ok(_) if line.pop() != Some(b'\n') => return,
            Ok(_) => String::from_utf8(line).map_err(|_| "it is not UTF-8".to_string()),
            Err(error) => Err(error.to_string()),
        };
        let last = answer.is_err();
        if answers.send(answer).is_err() || last {
            return;
        }
    }
}

/// The first characters of a line, for messages.
pub(super) fn beginning(line: &str) -> String {
    let line = line.trim_end();
    let short: String = line.chars().take(60).collect();
    if short.len() < line.len() { format!("{short:?}…") } else { format!("{short:?}") }
}

/// Splits a command at spaces outside quotes; `None` if a quote is left open.
pub fn words(command: &str) -> Option<Vec<String>> {
    let (mut words, mut word, mut quote) = (vec![], None::<String>, None);
    for c in command.chars() {
        match quote {
            Some(q) if c == q => quote = None,
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    quote.is_none().then_some(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_words_together() {
        let expected = ["sh", "-c", "echo \"a b\"", "", "x"];
        assert_eq!(words("sh  -c 'echo \"a b\"' \"\" x ").unwrap(), expected);
        assert_eq!(words("sh -c 'echo"), None);
    }
}
