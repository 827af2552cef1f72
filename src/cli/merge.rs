//! `etalon merge`

use super::{NOT_FINITE, Outcome};
use etalon::{files, image};
use std::path::PathBuf;
use std::process::ExitCode;

/// Joins parts of a render, by samples or by crop, into the file that one run would have written
#[derive(clap::Args)]
pub struct Arguments {
    /// Files that `etalon render --samples` or `--crop` wrote
    #[arg(required = true)]
    parts: Vec<PathBuf>,
    /// OpenEXR file to write
    #[arg(short, long, value_name = "OUT.exr", value_parser = super::exr_file())]
    output: PathBuf,
    /// Also write an 8-bit picture
    #[arg(long, value_name = "OUT.png", value_parser = super::png_file())]
    png: Option<PathBuf>,
}

impl Arguments {
    pub fn run(self) -> Outcome {
        files::check_outputs(&[], &[Some(&self.output), self.png.as_ref()])?;
        // A merged file may take the place of a part, a picture may not.
        files::check_replacing(&self.parts, &self.output)?;
        files::check_outputs(&self.parts, &[self.png.as_ref()])?;
        let merged = image::merge_files(self.parts)?;
        // Both can be made before one is written.
        let picture = self.png.as_ref().map(|_| image::develop(&merged)).transpose()?;
        image::write_exr(&self.output, &merged)?;
        if let (Some(path), Some(picture)) = (&self.png, &picture) {
            image::write_png(path, picture)?;
        }
        if merged.crop.pixels() < merged.full.0 as usize * merged.full.1 as usize {
            let (crop, (width, height)) = (&merged.crop, merged.full);
            eprintln!(
                "note: {} has {}x{} pixels at {},{} of a film of {width}x{height}",
                self.output.display(),
                crop.width,
                crop.height,
                crop.x,
                crop.y
            );
        }
        let not_finite = merged.not_finite();
        if not_finite > 0 {
            eprintln!("warning: {not_finite} pixels are not finite, as the renders of the parts said");
            return Ok(ExitCode::from(NOT_FINITE));
        }
        Ok(ExitCode::SUCCESS)
    }
}
