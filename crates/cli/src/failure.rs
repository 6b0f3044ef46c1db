//! Errors as people and scripts see them: one message, one exit code.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;

/// What went wrong, by exit code.
#[derive(Debug)]
pub(crate) enum Failure {
    /// 1: it should have worked.
    Failed(anyhow::Error),
    /// 2: what was given cannot be used.
    Input(anyhow::Error),
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

    pub(crate) fn report(self) -> ExitCode {
        let (error, code) = match self {
            Self::Refused => return ExitCode::from(3),
            // Whoever reads our output has heard enough (`rodsight … | head`).
            Self::Failed(error) if is_broken_pipe(&error) => return ExitCode::SUCCESS,
            Self::Failed(error) => (error, 1),
            Self::Input(error) => (error, 2),
        };
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

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::failed(error)
    }
}

/// A scene this backend cannot do, a file that is no image, a disk that is full: all of it is for the user to mend.
impl From<rodsight_render::RenderError> for Failure {
    fn from(error: rodsight_render::RenderError) -> Self {
        Self::input(error)
    }
}

/// The folder being written to, so that an interrupt can take away unfinished files.
static OUTPUT: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Makes an output folder, or says why not, before any long work starts.
pub(crate) fn claim_output(folder: &std::path::Path) -> Result<(), Failure> {
    use anyhow::Context as _;
    let probe = folder.join(".rodsight.part");
    std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::File::create(&probe))
        .and_then(|_| std::fs::remove_file(&probe))
        .with_context(|| format!("{}: cannot write to this output folder", folder.display()))
        .map_err(Failure::Input)?;
    if let Ok(mut output) = OUTPUT.lock() {
        *output = Some(folder.to_owned());
    }
    Ok(())
}

/// On Ctrl-C: no unfinished file stays, exit code 130.
pub(crate) fn on_interrupt() {
    let handler = || {
        let folder = OUTPUT.lock().ok().and_then(|output| output.clone());
        for entry in folder.and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten().flatten() {
            if entry.path().extension().is_some_and(|extension| extension == "part") {
                drop(std::fs::remove_file(entry.path()));
            }
        }
        std::process::exit(130);
    };
    // Without a handler an interrupt still ends the run; only the tidying is lost.
    drop(ctrlc::set_handler(handler));
}
