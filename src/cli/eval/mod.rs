//! `gonio eval`: how far an estimate is from the truth.

mod images;
mod lines;
mod materials;
mod scene;

use clap::Subcommand;

use crate::cli::ending::Answer;

/// What is measured.
#[derive(Debug, Subcommand)]
pub(super) enum Eval {
    /// PSNR, NRMSE, DSSIM and MAE of pictures, one by one and all together
    ///
    /// Samples of 8 and 16 bits are taken to be sRGB, floating-point ones to be linear; all are clipped to [0, 1]. PSNR and
    /// SSIM are of a range of 1, NRMSE is over the root mean square of the truth, and DSSIM is (1 - SSIM) / 2 with even
    /// windows of 7 x 7 pixels. Folders are compared by the names of the files in them; a picture that has no partner, or
    /// cannot be compared with it, is listed, and the exit code is then 3.
    Images(images::Args),
    /// Mean absolute errors of kd, ks and roughness over the triangles that were seen, beside two trivial guesses
    Materials(materials::Args),
    /// The same, and how well frames relight, under the sun of the photographs and four others
    Scene(scene::Args),
}

/// Measures and shows what was asked for.
pub(super) fn eval(what: &Eval) -> Answer {
    match what {
        Eval::Images(args) => images::images(args),
        Eval::Materials(args) => materials::materials(args),
        Eval::Scene(args) => scene::scene(args),
    }
}
