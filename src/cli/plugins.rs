//! `etalon plugins`

use super::{Outcome, say};
use etalon::scene::catalogue::{Model, catalogue};
use std::io;
use std::process::ExitCode;

/// Lists every model with its parameters
#[derive(clap::Args)]
pub struct Arguments {
    /// Print a JSON document
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Outcome {
        let models = catalogue();
        if self.json {
            say!("{}", serde_json::to_string_pretty(&models)?);
            return Ok(ExitCode::SUCCESS);
        }
        let mut kind = "";
        for model in &models {
            if model.kind != kind {
                kind = model.kind;
                say!("\n{kind}s");
            }
            print(model)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn print(model: &Model) -> io::Result<()> {
    say!("  {:<18} {}", model.name, model.about);
    for p in &model.parameters {
        say!("    {:<22} {:<9} {} [{}]", p.name, p.kind, p.about, p.default);
    }
    Ok(())
}
