//! The command as users run it: what it says, with which exit code it ends, and which files it leaves. Failures show the
//! command, its folder and both of its outputs.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test fails by panicking, and says what it skips")]

#[cfg(target_os = "linux")]
mod budget;
mod changes;
mod files;
mod floods;
mod images;
mod init;
mod kills;
#[cfg(target_os = "linux")]
mod limits;
mod lit;
#[cfg(target_os = "linux")]
mod names;
mod outs;
mod poses;
mod ran;
mod reduce;
mod runs;
mod spheres;
#[cfg(unix)]
mod stops;
#[cfg(target_os = "linux")]
mod streams;
#[cfg(target_os = "linux")]
mod threads;
mod typed;
mod verify;
