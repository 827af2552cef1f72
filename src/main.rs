//! The command line: `etalon render`, `merge`, `explain`, `replay`, `plugins`.

mod cli;
mod out_of_memory;

use etalon::command_line::given;
use etalon::scene::error::SceneError;
use std::error::Error;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: out_of_memory::Telling = out_of_memory::Telling;

fn main() -> ExitCode {
    // If the reader of the output closes it early, the program ends without an error.
    sigpipe::reset();
    match given::<cli::Command>().run() {
        Ok(code) => code,
        Err(error) => {
            print(&*error);
            ExitCode::from(cli::BAD_INPUT)
        }
    }
}

/// Prints an error; those about a scene draw the place themselves, with the word before it.
fn print(error: &(dyn Error + 'static)) {
    match error.downcast_ref::<SceneError>() {
        Some(located) => eprintln!("{located}"),
        None => eprintln!("error: {error}"),
    }
}
