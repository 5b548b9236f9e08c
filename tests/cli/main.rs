//! The command as users run it: what it says, with which exit code it ends, and which files it leaves. Failures show the
//! command, its folder and both of its outputs.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test fails by panicking, and says what it skips")]

#[cfg(target_os = "linux")]
mod budget;
mod changes;
mod files;
mod floods;
mod images;
mod kills;
mod lit;
mod ran;
mod reduce;
mod runs;
mod spheres;
mod typed;
