//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::RenderError;

pub(crate) fn io(path: &Path, error: impl std::fmt::Display) -> RenderError {
    RenderError::Io {
        path: path.to_owned(),
        message: error.to_string(),
    }
}

/// Temporary files that are being written.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Takes away what is half-written, for the end of an interrupted program: no file can be begun or finished any more.
pub fn discard_unfinished() {
    let unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for part in unfinished.iter() {
        // Best effort: there is nobody left to tell.
        drop(std::fs::remove_file(part));
    }
    std::mem::forget(unfinished);
}

/// Writes a file through a temporary neighbour, so that a full disk or a kill leaves no half file under the final name.
///
/// # Errors
/// The file cannot be written.
pub fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), RenderError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    let unfinished = || UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    // Under the lock, both: no file comes up between the last look at the list and the end of the program.
    let begin = || {
        let mut unfinished = unfinished();
        unfinished.push(part.clone());
        File::create(&part)
    };
    let end = |written: std::io::Result<()>| {
        let mut unfinished = unfinished();
        unfinished.retain(|other| *other != part);
        written.and_then(|()| std::fs::rename(&part, path))
    };
    let written = begin().and_then(|file| {
        let mut file = BufWriter::new(file);
        content(&mut file)?;
        file.flush()
    });
    end(written).map_err(|error| {
        // Best effort: the error to report is the first one.
        drop(std::fs::remove_file(&part));
        io(path, error)
    })
}
