//! YAML as calibration tools write it, with look-ups that say what is missing.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

use super::{RigError, checked_rotation};
use crate::Mat3;
use crate::config::ConfigError;

/// Any YAML node. `OpenCV`'s tags (`!!opencv-matrix`) are ignored by the parser: the keys `rows`, `cols`, `data` say the same.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    Nothing,
    Flag(bool),
    Number(f64),
    Text(String),
    List(Vec<Self>),
    Map(BTreeMap<String, Self>),
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a YAML node")
    }
    fn visit_bool<E>(self, v: bool) -> Result<Node, E> {
        Ok(Node::Flag(v))
    }
    fn visit_i64<E>(self, v: i64) -> Result<Node, E> {
        Ok(Node::Number(v as f64))
    }
    fn visit_u64<E>(self, v: u64) -> Result<Node, E> {
        Ok(Node::Number(v as f64))
    }
    fn visit_f64<E>(self, v: f64) -> Result<Node, E> {
        Ok(Node::Number(v))
    }
    fn visit_str<E>(self, v: &str) -> Result<Node, E> {
        Ok(match v {
            // How OpenCV spells them; the YAML standard knows .nan, .NaN and .NAN only.
            ".Nan" => Node::Number(f64::NAN),
            _ => Node::Text(v.to_owned()),
        })
    }
    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Nothing)
    }
    fn visit_none<E>(self) -> Result<Node, E> {
        Ok(Node::Nothing)
    }
    fn visit_some<D: Deserializer<'de>>(self, inner: D) -> Result<Node, D::Error> {
        Node::deserialize(inner)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Node, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Node::List(list))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Node, A::Error> {
        let mut map = BTreeMap::new();
        while let Some((key, value)) = entries.next_entry()? {
            map.insert(key, value);
        }
        Ok(Node::Map(map))
    }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

impl Node {
    /// What this is, for messages.
    fn kind(&self) -> String {
        match self {
            Self::Nothing => "nothing".to_owned(),
            Self::Flag(flag) => flag.to_string(),
            Self::Number(number) => number.to_string(),
            Self::Text(text) => format!("\"{text}\""),
            Self::List(list) => format!("a sequence of {}", list.len()),
            Self::Map(map) => format!("a mapping of {}", map.len()),
        }
    }
}

/// A mapping of a YAML file, and where it stands in it.
#[derive(Clone, Debug)]
pub(super) struct File {
    path: PathBuf,
    /// "" at the top level, else "cam0." and the like.
    prefix: String,
    map: BTreeMap<String, Node>,
}

impl File {
    /// Parses a file. Directives and document marks are dropped: `OpenCV` 2–4 writes `%YAML:1.0`, which is no YAML, and
    /// intrinsics and extrinsics that two files held are often put one after the other into one.
    pub(super) fn parse(text: &str, path: &Path) -> Result<Self, ConfigError> {
        let body: String = text
            .trim_start_matches('\u{feff}')
            .lines()
            .map(|line| {
                let mark = line.starts_with("%YAML") || matches!(line.trim_end(), "---" | "...");
                // Kept as empty lines, for the line numbers of messages.
                if mark {
                    "\n".to_owned()
                } else {
                    format!("{line}\n")
                }
            })
            .collect();
        let options = serde_saphyr::options! {
            non_finite_float_policy: serde_saphyr::NonFiniteFloatPolicy::PassThrough,
            with_snippet: false,
        };
        let map = serde_saphyr::from_str_with_options(&body, options).map_err(
            |error: serde_saphyr::Error| ConfigError::Parse {
                path: path.to_owned(),
                line: error.location().map(|at| at.line() as usize),
                message: error.to_string(),
            },
        )?;
        Ok(Self {
            path: path.to_owned(),
            prefix: String::new(),
            map,
        })
    }

    /// The file's path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The keys, for messages.
    pub(super) fn keys(&self) -> String {
        if self.map.is_empty() {
            return "no keys".to_owned();
        }
        let keys: Vec<_> = self.map.keys().map(String::as_str).collect();
        format!("the keys {}", keys.join(", "))
    }

    /// Whether one of these keys is there.
    pub(super) fn has(&self, keys: &[&str]) -> bool {
        keys.iter().any(|key| self.map.contains_key(*key))
    }

    /// What is wrong with a key.
    pub(super) fn complaint(
        &self,
        key: &str,
        expected: &str,
        found: impl Into<String>,
    ) -> RigError {
        RigError::value(&self.path, &self.key(key), expected, found)
    }

    /// A key with the place it stands in.
    pub(super) fn key(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    /// The first of several spellings of a key that is there, with its spelling.
    pub(super) fn find<'a>(&'a self, spellings: &[&'a str]) -> Option<(&'a str, &'a Node)> {
        spellings
            .iter()
            .find_map(|key| self.map.get(*key).map(|node| (*key, node)))
    }

    fn need<'a>(
        &'a self,
        spellings: &[&'a str],
        expected: &str,
    ) -> Result<(&'a str, &'a Node), RigError> {
        self.find(spellings)
            .ok_or_else(|| self.complaint(spellings[0], expected, "no such key"))
    }

    /// A mapping inside this one.
    pub(super) fn section(&self, key: &str) -> Result<Self, RigError> {
        match self.need(&[key], "a mapping")?.1 {
            Node::Map(map) => Ok(Self {
                path: self.path.clone(),
                prefix: format!("{}{key}.", self.prefix),
                map: map.clone(),
            }),
            other => Err(self.complaint(key, "a mapping", other.kind())),
        }
    }

    /// A word, in lower case; `None` if the key is not there.
    pub(super) fn word(&self, spellings: &[&str]) -> Result<Option<(String, String)>, RigError> {
        match self.find(spellings) {
            None => Ok(None),
            Some((key, Node::Text(text))) => Ok(Some((key.to_owned(), text.to_lowercase()))),
            Some((key, other)) => Err(self.complaint(key, "a word", other.kind())),
        }
    }

    /// Whether a switch (true, 1) is on; off if the key is not there.
    pub(super) fn switch(&self, spellings: &[&str]) -> Result<bool, RigError> {
        match self.find(spellings) {
            None => Ok(false),
            Some((_, Node::Flag(flag))) => Ok(*flag),
            Some((_, Node::Number(number))) if *number == 0.0 || *number == 1.0 => {
                Ok(*number == 1.0)
            }
            Some((key, other)) => Err(self.complaint(key, "true, false, 1 or 0", other.kind())),
        }
    }

    /// Finite numbers in reading order: of a number, of a sequence of numbers or of rows, or of an `OpenCV` matrix.
    pub(super) fn numbers(
        &self,
        spellings: &[&str],
        expected: &str,
    ) -> Result<(String, Vec<f64>), RigError> {
        let (key, node) = self.need(spellings, expected)?;
        let data = match node {
            Node::Map(map) => map.get("data").unwrap_or(node),
            _ => node,
        };
        let mut values = Vec::new();
        collect(data, &mut values).map_err(|found| self.complaint(key, expected, found))?;
        if let Node::Map(map) = node
            && let (Some(Node::Number(rows)), Some(Node::Number(cols))) =
                (map.get("rows"), map.get("cols"))
            && rows * cols != values.len() as f64
        {
            let found = format!("{rows}×{cols} with {} numbers", values.len());
            return Err(self.complaint(key, "rows × cols numbers", found));
        }
        Ok((key.to_owned(), values))
    }

    /// As [`numbers`](Self::numbers), and just so many.
    pub(super) fn array<const N: usize>(
        &self,
        spellings: &[&str],
        expected: &str,
    ) -> Result<[f64; N], RigError> {
        let (key, values) = self.numbers(spellings, expected)?;
        values
            .as_slice()
            .try_into()
            .map_err(|_| self.complaint(&key, expected, format!("{} numbers", values.len())))
    }

    /// A size in pixels.
    pub(super) fn pixels(&self, key: &str, value: f64) -> Result<u32, RigError> {
        if value >= 1.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0 {
            Ok(value as u32)
        } else {
            Err(self.complaint(key, "a whole, positive number of pixels", value.to_string()))
        }
    }

    /// A rotation matrix from its rows.
    pub(super) fn rotation(&self, key: &str, rows: &[f64; 9]) -> Result<Mat3, RigError> {
        checked_rotation(&Mat3::from_row_slice(rows))
            .map_err(|found| self.complaint(key, "an orthonormal right-handed matrix", found))
    }
}

fn collect(node: &Node, values: &mut Vec<f64>) -> Result<(), String> {
    match node {
        Node::Number(number) if number.is_finite() => values.push(*number),
        Node::List(list) => {
            for item in list {
                collect(item, values)?;
            }
        }
        other => return Err(other.kind()),
    }
    Ok(())
}
