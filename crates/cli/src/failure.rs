//! Errors as people and scripts see them: one message, one exit code.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
#[cfg(unix)]
use std::sync::Arc;
use std::sync::{Mutex, PoisonError};

use anyhow::Context as _;

/// What went wrong, by exit code.
#[derive(Debug)]
pub(crate) enum Failure {
    /// 1: it should have worked.
    Failed(anyhow::Error),
    /// 2: what was given cannot be used.
    Input(anyhow::Error),
    /// 4: no machine part that could do it.
    NoAdapter(anyhow::Error),
    /// 3: the answer is no; it has been printed already.
    Refused,
}

impl Failure {
    pub(crate) fn input(error: impl Into<anyhow::Error>) -> Self {
        Self::Input(error.into())
    }

    pub(crate) fn failed(error: impl Into<anyhow::Error>) -> Self {
        Self::Failed(error.into())
    }

    /// The same, of a file.
    pub(crate) fn of(self, file: &Path) -> Self {
        match self {
            Self::Input(error) => Self::Input(error.context(file.display().to_string())),
            other => other,
        }
    }

    pub(crate) fn report(self) -> ExitCode {
        let (error, code) = match self {
            Self::Refused => return ExitCode::from(3),
            Self::NoAdapter(error) => (error, 4),
            // Whoever reads our output has heard enough (`rodsight … | head`).
            Self::Failed(error) if is_broken_pipe(&error) => return ExitCode::SUCCESS,
            Self::Failed(error) => (error, 1),
            Self::Input(error) => (error, 2),
        };
        abandon_output();
        // Nothing is left to tell if standard error is gone too.
        drop(writeln!(std::io::stderr(), "rodsight: {error:#}"));
        ExitCode::from(code)
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

/// A scene this backend cannot do, a file that is no image, a disk that is full: all of it is for the user to mend. No adapter,
/// or one too small, has its own code; one that fails in the middle is nobody's input.
impl From<rodsight_render::RenderError> for Failure {
    fn from(error: rodsight_render::RenderError) -> Self {
        use rodsight_render::RenderError as E;
        match error {
            E::NoAdapter { .. } | E::AdapterLimit { .. } | E::LoopsCut { .. } => {
                Self::NoAdapter(anyhow::Error::new(error).context("--backend gpu"))
            }
            E::Device { .. } => Self::failed(error),
            error => Self::input(error),
        }
    }
}

/// Folders that were made for the output, innermost first: an answer of no leaves none of them behind.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Makes an output folder, or says why not, before any long work starts.
pub(crate) fn claim_output(folder: &Path) -> Result<(), Failure> {
    let missing = folder
        .ancestors()
        .take_while(|path| !path.as_os_str().is_empty() && !path.exists());
    MADE.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .extend(missing.map(Path::to_owned));
    let probe = folder.join(".rodsight.part");
    std::fs::create_dir_all(folder)
        .and_then(|()| {
            rodsight_render::write_whole(&probe, |_| Ok(())).map_err(std::io::Error::other)
        })
        .and_then(|()| std::fs::remove_file(&probe))
        .with_context(|| format!("{}: cannot write to this output folder", folder.display()))
        .map_err(Failure::Input)
}

/// Takes the folders back that were made and got no files.
fn abandon_output() {
    for folder in MADE
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .drain(..)
    {
        // What is not empty stays: that is what this call does with it.
        drop(std::fs::remove_dir(folder));
    }
}

/// On Ctrl-C, and when told to terminate: no unfinished file stays, exit code 130.
pub(crate) fn on_interrupt() {
    let handler = || {
        rodsight_render::discard_unfinished();
        abandon_output();
        std::process::exit(130);
    };
    // Without a handler an interrupt still ends the run; only the tidying is lost.
    drop(ctrlc::set_handler(handler));
    // A file larger than the limit (`ulimit -f`) is then an error of that file, and not the end of the program.
    #[cfg(unix)]
    drop(signal_hook::flag::register(
        signal_hook::consts::SIGXFSZ,
        Arc::default(),
    ));
}
