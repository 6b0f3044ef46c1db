//! Runs the program and looks at what it did.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

/// The founding scene at a quarter of its resolution.
pub(crate) const SMALL: &str = include_str!("small.toml");

/// What a run left behind.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Run {
    /// Of any finished process; none may panic, and none may end by a code that is not in `--help`.
    pub(crate) fn of(output: &std::process::Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("text is UTF-8");
        let run = Self {
            code: output.status.code().unwrap_or(-1),
            out: text(&output.stdout),
            err: text(&output.stderr),
        };
        assert!(!run.err.contains("panicked"), "{run:?}");
        assert!([0, 1, 2, 3, 4, 130].contains(&run.code), "{run:?}");
        run
    }

    /// The standard output of a run that went well, with nothing on standard error: there is no terminal.
    pub(crate) fn done(&self) -> &str {
        assert_eq!((self.code, self.err.as_str()), (0, ""), "{self:?}");
        &self.out
    }

    /// The JSON of a run that went well.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(self.done()).expect("JSON on standard output")
    }

    /// A run that ended with this code and a message that says all of this, and nothing on standard output.
    pub(crate) fn failed(&self, code: i32, says: &[&str]) {
        assert_eq!(self.code, code, "{self:?}");
        assert_eq!(self.out, "", "{self:?}");
        for text in says {
            assert!(self.err.contains(text), "expected {text:?} in {self:?}");
        }
    }
}

/// A run of the program in a folder.
pub(crate) fn rodsight_in<S: AsRef<std::ffi::OsStr>>(folder: &Path, args: &[S]) -> Run {
    let output = assert_cmd::Command::new(env!("CARGO_BIN_EXE_rodsight"))
        .current_dir(folder)
        .args(args)
        .timeout(Duration::from_secs(300))
        .output()
        .expect("the program starts");
    Run::of(&output)
}

/// A run of the program where no Vulkan driver is found, all paths absolute. Other systems have other interfaces.
#[cfg(target_os = "linux")]
pub(crate) fn rodsight_without_driver(args: &[&str]) -> Run {
    let output = assert_cmd::Command::new(env!("CARGO_BIN_EXE_rodsight"))
        .current_dir(env!("CARGO_TARGET_TMPDIR"))
        .envs(["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|name| (name, "/no/driver.json")))
        .args(args)
        .timeout(Duration::from_secs(300))
        .output()
        .expect("the program starts");
    Run::of(&output)
}

/// A run of the program, all paths absolute.
pub(crate) fn rodsight<S: AsRef<std::ffi::OsStr>>(args: &[S]) -> Run {
    rodsight_in(Path::new(env!("CARGO_TARGET_TMPDIR")), args)
}

/// A folder that goes away.
pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// The small scene, rendered once for all tests that only read it.
pub(crate) fn pair() -> &'static Path {
    static PAIR: OnceLock<PathBuf> = OnceLock::new();
    PAIR.get_or_init(|| {
        let base = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli-pair");
        std::fs::create_dir_all(&base).expect("a folder");
        let scene = base.join("small.toml");
        std::fs::write(&scene, SMALL).expect("a file");
        let pair = base.join("pair");
        rodsight(&["render", text(&scene), "-o", text(&pair)]).done();
        pair
    })
}

/// A path as an argument.
pub(crate) fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// The JSON in a file.
pub(crate) fn read_json(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_slice(&bytes).expect("JSON")
}

/// The names in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8")
        })
        .collect();
    names.sort();
    names
}

/// Three numbers.
pub(crate) fn vector(value: &Value) -> [f64; 3] {
    let numbers = value
        .as_array()
        .unwrap_or_else(|| panic!("a vector, found {value}"));
    let numbers: Vec<f64> = numbers
        .iter()
        .map(|v| v.as_f64().expect("a number"))
        .collect();
    numbers.try_into().expect("three numbers")
}

/// Arguments of `solve` on the small pair, with its true pick.
pub(crate) fn solve_args(more: &[&str]) -> Vec<String> {
    let pair = pair();
    let file = |name: &str| text(&pair.join(name)).to_owned();
    let mut args = vec!["solve".to_owned()];
    for (option, name) in [
        ("--left", "left.png"),
        ("--right", "right.png"),
        ("--rig", "rig.toml"),
    ] {
        // What a test gives itself is not given twice.
        if !more.contains(&option) {
            args.extend([option.to_owned(), file(name)]);
        }
    }
    if !more.contains(&"--pick") {
        args.extend(["--pick".to_owned(), true_pick()]);
    }
    args.extend(more.iter().map(|&arg| arg.to_owned()));
    args
}

/// Where the operator would point in the small pair.
pub(crate) fn true_pick() -> String {
    let truth = read_json(&pair().join("truth.json"));
    let pick = &truth["grasp"]["pick_px"];
    format!("{},{},left", pick[0], pick[1])
}

/// A run of `solve` on the small pair.
pub(crate) fn solve(more: &[&str]) -> Run {
    rodsight(&solve_args(more))
}
