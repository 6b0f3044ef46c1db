//! Golden numbers in TOML files, fetched by dotted path. A path that is not there panics with its name: a golden test that
//! silently compares nothing is worse than none.

use std::path::{Path, PathBuf};

use toml::Value;

/// A golden file.
#[derive(Clone, Debug)]
pub struct Golden {
    path: PathBuf,
    root: Value,
}

impl Golden {
    /// Loads a file; panics if it cannot be read or is no TOML.
    #[track_caller]
    pub fn load(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref().to_owned();
        let text = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("golden file {}: {error}", path.display()));
        let table: toml::Table = text
            .parse()
            .unwrap_or_else(|error| panic!("golden file {}: {error}", path.display()));
        Self {
            path,
            root: Value::Table(table),
        }
    }

    /// The value at a dotted path, in which numbers count the items of arrays: `table2.0.hough.1`.
    #[track_caller]
    pub fn value(&self, dotted: &str) -> &Value {
        let mut value = &self.root;
        for key in dotted.split('.') {
            let next = match (value, key.parse::<usize>()) {
                (Value::Array(items), Ok(index)) => items.get(index),
                (Value::Table(table), _) => table.get(key),
                _ => None,
            };
            value =
                next.unwrap_or_else(|| panic!("{}: no `{key}` in `{dotted}`", self.path.display()));
        }
        value
    }

    /// A number.
    #[track_caller]
    pub fn f64(&self, dotted: &str) -> f64 {
        self.number(self.value(dotted), dotted)
    }

    /// An array of just `N` numbers.
    #[track_caller]
    pub fn array<const N: usize>(&self, dotted: &str) -> [f64; N] {
        let numbers = self.numbers(dotted);
        numbers.as_slice().try_into().unwrap_or_else(|_| {
            panic!(
                "{}: `{dotted}`: expected {N} numbers, found {}",
                self.path.display(),
                numbers.len()
            )
        })
    }

    /// An array of any number of numbers, one at least.
    #[track_caller]
    pub fn numbers(&self, dotted: &str) -> Vec<f64> {
        let mut numbers = Vec::new();
        for item in self.items(dotted) {
            numbers.push(self.number(item, dotted));
        }
        numbers
    }

    /// How many items an array has; one at least.
    #[track_caller]
    pub fn len(&self, dotted: &str) -> usize {
        self.items(dotted).len()
    }

    #[track_caller]
    fn items(&self, dotted: &str) -> &[Value] {
        match self.value(dotted) {
            Value::Array(items) if !items.is_empty() => items,
            other => panic!(
                "{}: `{dotted}`: expected an array that is not empty, found {other}",
                self.path.display()
            ),
        }
    }

    #[track_caller]
    fn number(&self, value: &Value, dotted: &str) -> f64 {
        match value {
            Value::Float(number) => *number,
            Value::Integer(number) => *number as f64,
            other => panic!(
                "{}: `{dotted}`: expected a number, found {other}",
                self.path.display()
            ),
        }
    }
}
