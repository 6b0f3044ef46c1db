//! Why a scene file is no scene.

use std::fmt::Display;
use std::path::Path;

use rodsight_geometry::RigError;
use rodsight_geometry::config::ConfigError;

/// Why a scene file is no scene. The message names the file, the key, what was expected and what was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum SceneError {
    /// Unreadable, no TOML, an unknown key, a wrong type.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The file named by `rig_file`.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The rig written in the scene itself.
    #[error("{path}: rig.{message}")]
    InlineRig { path: String, message: String },
    #[error("{path}: {key}: expected {expected}, found {found}")]
    Value {
        path: String,
        key: String,
        expected: String,
        found: String,
    },
}

/// Names the key of a TOML error: the parser gives the line only.
pub(crate) fn with_key(text: &str, error: ConfigError) -> ConfigError {
    match error {
        ConfigError::Parse {
            path,
            line: Some(line),
            message,
        } => {
            let message = match key_at(text, line) {
                Some(key) => format!("{key}: {message}"),
                None => message,
            };
            ConfigError::Parse {
                path,
                line: Some(line),
                message,
            }
        }
        other => other,
    }
}

/// The key path of a line, as `rod[1].radius_m`; `None` where the line is not of the plain form a scene file has.
fn key_at(text: &str, line: usize) -> Option<String> {
    let mut table = String::new();
    let mut arrays: Vec<(&str, usize)> = Vec::new();
    let mut key = None;
    for row in text.lines().take(line).map(str::trim) {
        key = None;
        if let Some(name) = row
            .strip_prefix("[[")
            .and_then(|rest| rest.split_once("]]"))
        {
            let name = name.0.trim();
            match arrays.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => arrays.push((name, 1)),
            }
            name.clone_into(&mut table);
        } else if let Some(name) = row.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            // Inside an array of arrays this is a row of numbers, not a table.
            if name.0.starts_with(|c: char| c.is_ascii_alphabetic()) {
                name.0.trim().clone_into(&mut table);
            }
        } else if let Some((left, _)) = row.split_once('=') {
            key = Some(left.trim());
        }
    }
    for (name, count) in arrays {
        if table == name || table.strip_prefix(name).is_some_and(|r| r.starts_with('.')) {
            table.insert_str(name.len(), &format!("[{}]", count - 1));
        }
    }
    match (table.is_empty(), key) {
        (true, None) => None,
        (true, Some(key)) => Some(key.to_owned()),
        (false, None) => Some(table),
        (false, Some(key)) => Some(format!("{table}.{key}")),
    }
}

/// Complaints about one file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Complaints<'a> {
    pub(crate) path: &'a Path,
}

impl Complaints<'_> {
    /// The file cannot be read.
    pub(crate) fn unreadable(&self, error: &std::io::Error) -> SceneError {
        let (path, message) = (self.path.to_owned(), error.to_string());
        ConfigError::Io { path, message }.into()
    }

    pub(crate) fn value(
        &self,
        key: impl Into<String>,
        expected: impl Into<String>,
        found: impl Display,
    ) -> SceneError {
        SceneError::Value {
            path: self.path.display().to_string(),
            key: key.into(),
            expected: expected.into(),
            found: found.to_string(),
        }
    }
}
