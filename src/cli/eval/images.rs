//! `gonio eval images`: how far pictures are from those that they should be.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::{Value, json};

use crate::after::{self, Compared, Pair, Unpaired, compare};
use crate::cli::ending::{Answer, Ending};
use crate::cli::print::{Lines, out};
use crate::render::pictures::PictureErrors;

/// Options of `eval images`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The truth: a picture, or a folder of them. Where alpha is 0 or a value is not finite, nothing is compared
    #[arg(value_name = "A")]
    truth: PathBuf,
    /// What was found: a picture, or a folder with pictures of the same names. Where alpha is 0 or a value is not finite,
    /// it is all wrong
    #[arg(value_name = "B")]
    found: PathBuf,
    /// What is compared
    #[arg(long, value_enum, default_value_t = Space::Linear)]
    space: Space,
    /// Write one JSON object; a figure that is infinite or not a number is null there
    #[arg(long)]
    json: bool,
}

/// What is compared.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Space {
    /// Linear radiance
    Linear,
    /// Values as a screen is sent them
    Srgb,
}

impl From<Space> for after::ColorSpace {
    fn from(space: Space) -> Self {
        match space {
            Space::Linear => after::ColorSpace::Linear,
            Space::Srgb => after::ColorSpace::Srgb,
        }
    }
}

/// Compares pictures and shows the table.
pub(super) fn images(options: &Args) -> Answer {
    let compared = compare(&options.truth, &options.found, options.space.into())?;
    let text = if options.json { as_json(&compared, options.space) } else { as_table(&compared, options.space) };
    out(&text)?;
    Ok(if compared.skipped.is_empty() { Ending::Done } else { Ending::Skipped })
}

fn as_table(compared: &Compared, space: Space) -> String {
    let mut lines = Lines::default();
    for Unpaired { name, why } in &compared.skipped {
        lines.add(format!("skipped {}: {why}", name.display()));
    }
    let values = match space {
        Space::Linear => "linear radiance",
        Space::Srgb => "sRGB values",
    };
    lines.add(format!("errors of {values}, clipped to [0, 1]; PSNR in dB"));
    lines.add(format!("{:34}{:>8}{:>9}{:>9}{:>9}{:>12}", "", "PSNR", "NRMSE", "DSSIM", "MAE", "pixels"));
    for Pair { name, errors } in &compared.pairs {
        lines.add(line(&name.display().to_string(), errors));
    }
    if compared.pairs.len() > 1 {
        lines.add(line(&format!("all {} together", compared.pairs.len()), &compared.all));
    }
    let missing = compared.all.pixels.missing;
    if missing > 0 {
        lines.add(format!("{missing} pixels are nothing in what was found, and count as all wrong"));
    }
    lines.finish()
}

fn line(name: &str, errors: &PictureErrors) -> String {
    let PictureErrors { pixels, similarity } = errors;
    let (psnr, nrmse, dssim, mae) = (pixels.psnr(), pixels.nrmse(), similarity.dssim(), pixels.mae());
    format!("{name:34}{psnr:>8.2}{nrmse:>9.5}{dssim:>9.5}{mae:>9.5}{:>12}", pixels.count)
}

fn as_json(compared: &Compared, space: Space) -> String {
    let named = |Pair { name, errors }: &Pair| {
        let mut row = figures(errors);
        row["name"] = json!(shown(name));
        row
    };
    let skipped = |Unpaired { name, why }: &Unpaired| json!({ "name": shown(name), "why": why });
    json!({
        "space": match space { Space::Linear => "linear", Space::Srgb => "srgb" },
        "pictures": compared.pairs.iter().map(named).collect::<Vec<_>>(),
        "all": figures(&compared.all),
        "skipped": compared.skipped.iter().map(skipped).collect::<Vec<_>>(),
    })
    .to_string()
}

/// The figures as JSON.
fn figures(PictureErrors { pixels, similarity }: &PictureErrors) -> Value {
    json!({
        "psnr": pixels.psnr(), "nrmse": pixels.nrmse(), "dssim": similarity.dssim(), "mae": pixels.mae(),
        "pixels": pixels.count, "missing": pixels.missing,
    })
}

fn shown(name: &Path) -> String {
    name.display().to_string()
}
