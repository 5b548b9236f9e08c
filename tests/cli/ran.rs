//! A run of the command.

use std::path::Path;
use std::process::{Command, Output};

/// What a command did.
pub struct Ran {
    command: String,
    output: Output,
}

impl Ran {
    /// Runs `gonio` with these arguments, separated by blanks, in a folder.
    pub fn gonio(folder: &Path, args: &str) -> Ran {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gonio"));
        command.current_dir(folder).args(args.split_whitespace());
        let output = command.output().unwrap();
        Ran { command: format!("{command:?} in {}", folder.display()), output }
    }

    /// Runs a script of the shell in a folder. `$GONIO` is the command.
    #[cfg(unix)]
    pub fn script(folder: &Path, script: &str) -> Ran {
        let mut command = Command::new("sh");
        command.current_dir(folder).args(["-c", script]).env("GONIO", env!("CARGO_BIN_EXE_gonio"));
        let output = command.output().unwrap();
        Ran { command: format!("{script}\nin {}", folder.display()), output }
    }

    /// The exit code; `None` where a signal ended the command.
    #[cfg(unix)]
    pub fn code(&self) -> Option<i32> {
        self.output.status.code()
    }

    pub fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).into_owned()
    }

    pub fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    /// The exit code is this one.
    #[track_caller]
    pub fn ends(&self, code: i32) -> &Ran {
        assert_eq!(self.output.status.code(), Some(code), "{self}");
        self
    }

    /// Either output holds these words.
    #[track_caller]
    pub fn says(&self, words: &str) -> &Ran {
        assert!(self.stdout().contains(words) || self.stderr().contains(words), "no {words:?}: {self}");
        self
    }
}

impl std::fmt::Display for Ran {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (status, stdout, stderr) = (self.output.status, self.stdout(), self.stderr());
        write!(f, "{}\n{status}\n--- stdout\n{stdout}--- stderr\n{stderr}", self.command)
    }
}
