//! The command line: `etalon render`, `merge`, `explain`, `replay`, `plugins`.

mod cli;
mod out_of_memory;

use clap::Parser;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: out_of_memory::Telling = out_of_memory::Telling;

fn main() -> ExitCode {
    // Who reads the output may have read enough: that is the end, and no error.
    sigpipe::reset();
    let command = cli::Command::parse();
    match command.run() {
        Ok(code) => code,
        Err(error) => {
            let error = error.to_string();
            // Errors about a scene draw the place themselves and begin with the word.
            eprintln!("{}{error}", if error.starts_with("error") { "" } else { "error: " });
            ExitCode::from(cli::BAD_INPUT)
        }
    }
}
