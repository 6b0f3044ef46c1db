//! TOML files read strictly: an unknown key is an error that names the nearest known one.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

/// A configuration file that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// It cannot be read.
    #[error("{}: {message}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        message: String,
    },
    /// It is not what was expected.
    #[error("{}{}: {message}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    Parse {
        /// The file.
        path: PathBuf,
        /// The line, from 1, where it is known.
        line: Option<usize>,
        /// What was expected and what was found.
        message: String,
    },
}

/// Reads a whole text file.
///
/// # Errors
/// What the system said, with the path.
pub fn read_text(path: &Path) -> Result<String, ConfigError> {
    std::fs::read_to_string(path).map_err(|error| ConfigError::Io {
        path: path.to_owned(),
        message: error.to_string(),
    })
}

/// Parses TOML text; `path` is only named in messages.
///
/// # Errors
/// Broken TOML, a missing key, a wrong type, or an unknown key (with the nearest known one).
pub fn parse_toml<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, ConfigError> {
    toml::from_str(text).map_err(|error| {
        let at = error.span().map(|span| span.start.min(text.len()));
        let line = at.map(|at| text[..at].matches('\n').count());
        let mut message = with_nearest_key(error.message());
        // A wrong type is told without its key: quote the line that has it.
        if let Some(source) = line.and_then(|n| text.lines().nth(n))
            && message.starts_with("invalid")
        {
            message = format!("{message}, in `{}`", source.trim());
        }
        ConfigError::Parse {
            path: path.to_owned(),
            line: line.map(|n| n + 1),
            message,
        }
    })
}

/// Adds "did you mean" to serde's "unknown field `x`, expected one of `a`, `b`".
pub fn with_nearest_key(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    if !(message.starts_with("unknown field") || message.starts_with("unknown variant")) {
        return message.to_owned();
    }
    let Some(found) = quoted.next() else {
        return message.to_owned();
    };
    let nearest = quoted
        .map(|known| (strsim::osa_distance(found, known), known))
        .min();
    match nearest {
        Some((distance, known)) if distance <= 2.max(known.len() / 2) => {
            format!("{message}; did you mean `{known}`?")
        }
        _ => message.to_owned(),
    }
}
