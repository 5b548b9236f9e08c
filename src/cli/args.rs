//! What was typed.

use clap::{CommandFactory, Parser, Subcommand};

use super::ending::Answer;
use super::{check, eval, explain, export, init, inspect, light, plan, poses, render, run, shell, synth, verify};

/// Recovers how every surface of a scene reflects light, from ordinary aerial photographs.
///
/// Exit codes: 0 all done; 1 broken; 2 the command line or the pipeline file is wrong; 3 done, but items were skipped;
/// 130 interrupted, and the same command goes on from there.
#[derive(Debug, Parser)]
#[command(name = "gonio", version)]
pub(super) struct Args {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// A command. Each has its options and its work in a file of its own.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Look at a project's folder and write its pipeline file, gonio.toml, in which every key is explained
    Init(init::Args),
    /// Run a pipeline, or go on where it was stopped
    Run(run::Args),
    /// Find every problem of a pipeline file
    Check(check::Args),
    /// Say what a run will take: stages, workers, memory, disk and time
    Plan(plan::Args),
    /// Say what the next run would do over, and which input or setting is the cause
    Explain(explain::Args),
    /// Find how the photographs are exposed and the light that they were taken in, and nothing else
    Light(light::Args),
    /// Hold every file of a run against its checksum and, with --inputs, every input against what was made of it
    Verify(verify::Args),
    /// Say what posed photographs of any format hold and, with --colmap, write them as a COLMAP model
    Poses(poses::Args),
    /// Write what every pixel of a frame sees: triangle, position, normal, depth, uv, as one EXR
    Buffers(inspect::BuffersArgs),
    /// Write the reflectance maps of triangles of a finished run
    Maps(inspect::MapsArgs),
    /// Make data with a known truth
    #[command(subcommand)]
    Synth(synth::Synth),
    /// Show a frame relit: the recovered materials under a sun of your choice, from where the photograph was taken
    Render(render::Args),
    /// Measure how far an estimate is from the truth
    #[command(subcommand)]
    Eval(eval::Eval),
    /// Write the exports of a finished run again
    Export(export::Args),
    /// Print the completions of a shell, as for ~/.bashrc: source <(gonio completions bash)
    Completions(shell::CompletionsArgs),
    /// Print gonio's manual page, as for a pipe: gonio man | man -l -
    Man(shell::ManArgs),
}

impl Command {
    /// Does what was asked.
    pub(super) fn run(self) -> Answer {
        match self {
            Command::Init(args) => init::init(&args),
            Command::Run(args) => run::run(&args),
            Command::Check(args) => check::check(&args),
            Command::Plan(args) => plan::plan(&args),
            Command::Explain(args) => explain::explain(&args),
            Command::Light(args) => light::light(&args),
            Command::Verify(args) => verify::verify(&args),
            Command::Poses(args) => poses::poses(&args),
            Command::Buffers(args) => inspect::buffers(&args),
            Command::Maps(args) => inspect::maps(&args),
            Command::Synth(what) => synth::synth(what),
            Command::Render(args) => render::render(&args),
            Command::Eval(what) => eval::eval(&what),
            Command::Export(args) => export::export(&args),
            Command::Completions(args) => shell::completions(&args, Args::command()),
            Command::Man(args) => shell::man(&args, Args::command()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_holds_together() {
        Args::command().debug_assert();
    }

    #[test]
    fn overlays_follow_the_file() {
        let typed = "gonio maps p.toml --set a.b=1 --set c.d=x=y --triangles 1,22,333 --out m.npz";
        let Command::Maps(maps) = Args::try_parse_from(typed.split(' ')).unwrap().command else {
            panic!("another command")
        };
        assert_eq!((maps.pipeline.set.len(), maps.triangles, maps.out), (2, vec![1, 22, 333], "m.npz".into()));
    }
}
