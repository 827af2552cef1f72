//! The commands that test sampled distributions: `validate bsdf`, `sampling` and `furnace`.

use crate::console::{self, print};
use crate::crew::ask_and_print;
use crate::documents::Documents;
use crate::trial::{Trial, effort, effort_of_sampling};
use crate::{furnace, ledger, limits, materials, peers, sampling};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;
use validation::checks::Effort;
use validation::{Report, Verdict};

/// The effort of the checks, and the documents to write.
#[derive(clap::Args)]
struct Settings {
    /// Samples a check
    #[arg(long, default_value_t = 1 << 18, value_parser = console::samples)]
    samples: usize,
    /// Ask what is inconclusive again, of 4, 16 and 64 times the samples; 10 000 states for `jacobian`,
    /// harmonics to degree 8 for `moments`
    #[arg(long)]
    thorough: bool,
    /// Another number, other seeds
    #[arg(long, alias = "seed", default_value_t = 0, value_parser = crate::console::number)]
    number: u64,
    #[command(flatten)]
    documents: Documents,
    /// Append every p-value to a file of JSON lines
    #[arg(long, value_name = "FILE")]
    ledger: Option<PathBuf>,
}

#[derive(clap::Args)]
pub struct BsdfArguments {
    /// Only this material; of a peer, configurations whose name contains this
    name: Option<String>,
    /// Judge another program's BSDFs, over the protocol of docs/peer-protocol.md
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["thorough", "ledger"])]
    peer: Option<String>,
    /// Of a peer, only this check
    #[arg(long, requires = "peer")]
    check: Option<String>,
    /// Seconds a peer may take for one answer
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = console::positive_seconds, requires = "peer")]
    timeout: Duration,
    #[command(flatten)]
    settings: Settings,
}

#[derive(clap::Args)]
pub struct SamplingArguments {
    /// Only subjects whose name contains this
    name: Option<String>,
    #[command(flatten)]
    settings: Settings,
}

#[derive(clap::Args)]
pub struct FurnaceArguments {
    /// Only cells of the furnace whose name contains this
    name: Option<String>,
    /// Samples an albedo
    #[arg(long, default_value_t = 1 << 18, value_parser = console::samples)]
    samples: usize,
    /// Ask what is inconclusive again, of 4, 16 and 64 times the samples
    #[arg(long, conflicts_with = "losses")]
    thorough: bool,
    /// Another number, other seeds
    #[arg(long, alias = "seed", default_value_t = 0, value_parser = crate::console::number)]
    number: u64,
    #[command(flatten)]
    documents: Documents,
    /// Write what single scattering loses, and check nothing
    #[arg(long, value_name = "CSV", conflicts_with_all = ["json", "digest"])]
    losses: Option<PathBuf>,
}

/// Runs all checks on materials, or on those of another program.
pub fn bsdf(arguments: BsdfArguments) -> Result<Verdict, Box<dyn Error>> {
    let BsdfArguments { name, peer, check, timeout, settings } = arguments;
    let name = name.as_deref();
    if let Some(command) = peer {
        let Settings { samples, number, documents, .. } = settings;
        documents.check_writable(&[], &[])?;
        return documents.finish(peers::run(
            &command,
            &peers::Settings { name, check: check.as_deref(), samples, number, limit: timeout },
            print,
        )?);
    }
    let trials = [materials::trials(name), limits::trials(name)].concat();
    // A name of nothing would be that of all limits.
    if trials.is_empty() || name == Some("") {
        return Err("there is no such material; see `etalon plugins`".into());
    }
    let effort = effort(settings.samples, trials.len(), settings.thorough);
    judge("materials", trials, &effort, settings)
}

/// Runs all checks on all other sampled distributions.
pub fn sampling(arguments: SamplingArguments) -> Result<Verdict, Box<dyn Error>> {
    let SamplingArguments { name, settings } = arguments;
    let trials = sampling::trials(name.as_deref());
    if trials.is_empty() {
        return Err("there is nothing of this name".into());
    }
    let effort = effort_of_sampling(settings.samples, trials.len(), settings.thorough);
    judge("sampling", trials, &effort, settings)
}

/// Measures energy over roughness, index and angle.
pub fn furnace(arguments: FurnaceArguments) -> Result<Verdict, Box<dyn Error>> {
    let FurnaceArguments { name, samples, thorough, number, documents, losses } = arguments;
    if losses.is_some() {
        console::check_writable(&[], &[&losses])?;
        console::write(losses.as_deref(), || Ok(furnace::losses()))?;
        return Ok(Verdict::Equivalent);
    }
    let cells = furnace::cells(name.as_deref());
    if cells.is_empty() {
        return Err("there is nothing of this name".into());
    }
    documents.check_writable(&[], &[])?;
    let effort = Effort { albedo: 1e-3, ..effort(samples, cells.len(), thorough) };
    let outcomes = ask_and_print(&cells, |cell| &cell.name, |cell| cell.run(&effort, number).map(Some))?;
    documents.finish(Report::new("furnace", outcomes))
}

fn judge(
    title: &str,
    trials: Vec<Trial>,
    effort: &Effort,
    Settings { number, documents, ledger, .. }: Settings,
) -> Result<Verdict, Box<dyn Error>> {
    // What is appended to must be none of the documents either.
    let appended: Vec<&Path> = ledger.iter().map(PathBuf::as_path).collect();
    documents.check_writable(&appended, &[])?;
    let outcomes = ask_and_print(&trials, |trial| &trial.name, |trial| trial.run(effort, number))?;
    if let Some(path) = ledger {
        ledger::append(&path, &outcomes, number)?;
    }
    documents.finish(Report::new(title, outcomes))
}
