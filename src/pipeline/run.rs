//! Section `[run]`: where a run writes, and with how much it runs.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use crate::base::units::Bytes;
use crate::config::{Effect, Key, Keys, Leads, Problem, Section, Settings, Value};
use crate::disk::mark;
use crate::flow::pool;

/// Section `[run]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The folder that belongs to this run.
    pub work: PathBuf,
    /// The memory that a run may hold.
    pub memory: Bytes,
    /// Threads of each stage's workers, and of work outside of stages; 0 for as many as the machine has.
    pub threads: usize,
    /// Seconds that a drain may take before it becomes a halt.
    pub grace: u64,
    /// Whether all files from before are held against their records.
    pub verify: bool,
    /// The photographs that are left out, to judge the materials by; `None` if all are used.
    pub holdout: Option<Every>,
}

/// Every so many-th of a list, 2 to 1000.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Every(usize);

impl Every {
    /// Whether the list has the item at this place, counted from 0.
    pub fn has(self, at: usize) -> bool {
        at % self.0 == self.0 - 1
    }
}

impl fmt::Display for Every {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ending = match (self.0 % 10, self.0 % 100) {
            (_, 11..=13) => "th",
            (1, _) => "st",
            (2, _) => "nd",
            (3, _) => "rd",
            _ => "th",
        };
        write!(f, "every {}{ending}", self.0)
    }
}

impl FromStr for Every {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = text.strip_prefix("every ").map(|rest| rest.trim_end_matches(char::is_alphabetic).parse());
        let every = count.and_then(Result::ok).filter(|n| (2..=1000).contains(n)).map(Every);
        let good = every.filter(|every| every.to_string() == text);
        good.ok_or_else(|| "must be as \"every 4th\", from \"every 2nd\" to \"every 1000th\"".to_owned())
    }
}

/// The most threads that can be asked for.
const THREADS: usize = 1024;

/// The most seconds of grace that can be asked for: a day.
const GRACE: u64 = 86_400;

impl Run {
    /// The threads that work is shared out among.
    pub fn threads(&self) -> usize {
        pool::threads(self.threads, pool::available())
    }

    /// The time that a drain may take before it becomes a halt.
    pub fn grace(&self) -> Duration {
        Duration::from_secs(self.grace)
    }
}

impl Section for Run {
    const NAME: &'static str = "run";
    const ABOUT: &'static str = "Where a run writes, and with how much memory and how many threads it runs.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "work",
            doc: "The folder of this run: segments, materials.npy, evidence.npy, report.json, export/. One run at a time uses it. \
                  Without it, work/NAME beside this file, which is named NAME.toml.",
            value: Value::Optional("\"work/scene\""),
        },
        Key {
            name: "memory",
            doc: "The memory that a run may hold, with B, KiB, MiB, GiB or TiB. `gonio plan` says whether it is enough. With \
                  little memory a run is slower; frames that do not fit at all are skipped until there is more.",
            value: Value::Default("\"4GiB\""),
        },
        Key {
            name: "threads",
            doc: "Threads that each stage may have, and work outside of stages; 0 for as many as the machine has. Where the \
                  system grants fewer, a run goes on with those. The result is the same for any number.",
            value: Value::Default("0"),
        },
        Key {
            name: "grace",
            doc: "Seconds that a run may take to finish what is in flight when it is told to stop, as by Ctrl-C, 0 to 86400. \
                  Then it stops at once; what was committed stays.",
            value: Value::Default("30"),
        },
        Key {
            name: "verify",
            doc: "Whether a run first holds all that it has from before against checksums, as `gonio verify` does, and does over \
                  what is rotten. Tables and exports are held against theirs by every run, the rest when it is read.",
            value: Value::Default("false"),
        },
        Key {
            name: "holdout",
            doc: "Photographs that are left out, so that `gonio eval scene` can judge the materials by them: every so many-th, \
                  sorted by name.",
            value: Value::Optional("\"every 4th\""),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let size = "must be a number and one of B, KiB, MiB, GiB, TiB, as in \"3GiB\"";
        let leads = Leads::to_folder_or_nothing("name a folder for this run");
        let work = keys.optional_path("work", leads).unwrap_or_else(|| {
            // What is given and wrong is told, and nothing is said of another folder.
            if keys.is_good("work") { keys.beside("work").join(keys.stem()) } else { PathBuf::new() }
        });
        // A folder that cannot be read is told by the run itself.
        if let Ok(Some(why)) = mark::foreign(&work) {
            let hint = "nothing is changed there; name a new or empty folder, as work = \"work/NAME\"";
            keys.check("work", false, Problem::new(why).got(work.display().to_string()).hint(hint));
        }
        Run {
            work,
            memory: keys.parsed("memory", |text| text.parse().map_err(|_: String| size.to_owned())),
            threads: keys.within("threads", 0..=THREADS),
            grace: keys.within("grace", 0..=GRACE),
            verify: keys.value("verify"),
            holdout: keys.optional_parsed("holdout", str::parse),
        }
    }

    fn settings(&self) -> Settings {
        let Run { work, memory, threads, grace, verify, holdout } = self;
        Settings::of(Self::NAME)
            .with("work", work, Effect::Nothing)
            .with("memory", memory.to_string(), Effect::Nothing)
            .with("threads", threads, Effect::Nothing)
            .with("grace", grace, Effect::Nothing)
            .with("verify", verify, Effect::Nothing)
            .optional("holdout", holdout.map(|every| every.to_string()), Effect::Input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_so_many_th_is_read_as_it_is_written() {
        for text in ["every 2nd", "every 3rd", "every 4th", "every 11th", "every 21st", "every 112th", "every 1000th"] {
            assert_eq!(text.parse::<Every>().map(|every| every.to_string()), Ok(text.to_owned()));
        }
        for text in ["", "every", "every 4", "4th", "every 1st", "every 0th", "every 2th", "every 1001st", "every -2nd"]
        {
            assert!(text.parse::<Every>().is_err_and(|why| why.contains("every 4th")), "{text}");
        }
        let held: Vec<usize> = (0..9).filter(|at| Every(4).has(*at)).collect();
        assert_eq!(held, [3, 7]);
    }
}
