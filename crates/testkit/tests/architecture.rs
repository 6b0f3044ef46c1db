//! The one direction in which crates may depend on each other, read from `cargo metadata`.

use std::process::Command;

use serde_json::Value;

/// Which of our crates each of our crates may use, in its code (normal dependencies) and in its build script.
/// The solver stands on geometry alone: it cannot name the truth it is measured against.
const ALLOWED: &[(&str, &[&str])] = &[
    ("rodsight-geometry", &[]),
    ("rodsight-optics", &["rodsight-geometry"]),
    ("rodsight-scene", &["rodsight-geometry", "rodsight-optics"]),
    (
        "rodsight-render",
        &[
            "rodsight-geometry",
            "rodsight-optics",
            "rodsight-scene",
            "rodsight-shaders",
        ],
    ),
    ("rodsight-shaders", &[]),
    ("rodsight-solver", &["rodsight-geometry"]),
    (
        "rodsight-bench",
        &["rodsight-geometry", "rodsight-render", "rodsight-solver"],
    ),
    ("rodsight-testkit", &[]),
];

/// May use every crate of ours but the test kit.
const FREE: &[&str] = &["rodsight", "rodsight-benches"];

/// Used by one crate alone: what is behind it may change without anybody else's knowing.
const PRIVATE: &[(&str, &str)] = &[("rodsight-shaders", "rodsight-render")];

/// What is wrong with the graph, one line each.
fn faults(metadata: &Value) -> Vec<String> {
    let packages = metadata["packages"].as_array().expect("a list of packages");
    let name = |package: &Value| package["name"].as_str().expect("a name").to_owned();
    let ours: Vec<String> = packages.iter().map(name).collect();
    let mut faults = Vec::new();
    for (known, _) in ALLOWED {
        if !ours.iter().any(|o| o == known) {
            faults.push(format!("{known} is not in the workspace"));
        }
    }
    for package in packages {
        let from = name(package);
        let allowed = ALLOWED.iter().find(|(crate_name, _)| *crate_name == from);
        if allowed.is_none() && !FREE.contains(&from.as_str()) {
            faults.push(format!("{from} has no row in the table of allowed arrows"));
        }
        for dependency in package["dependencies"].as_array().expect("a list") {
            let to = name(dependency);
            // Development dependencies may point anywhere.
            if !ours.contains(&to) || dependency["kind"].as_str() == Some("dev") {
                continue;
            }
            let fine = to != "rodsight-testkit"
                && PRIVATE.iter().all(|(used, by)| *used != to || *by == from)
                && allowed.is_none_or(|(_, targets)| targets.contains(&to.as_str()));
            if !fine {
                faults.push(format!("{from} must not depend on {to}"));
            }
        }
    }
    faults
}

fn metadata() -> Value {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "cargo metadata: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("cargo writes JSON")
}

#[test]
fn crates_depend_on_each_other_in_one_direction_only() {
    let faults = faults(&metadata());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The metadata with one more dependency.
fn with_arrow(from: &str, to: &str, kind: Option<&str>) -> Value {
    let mut metadata = metadata();
    let packages = metadata["packages"].as_array_mut().expect("a list");
    let package = packages
        .iter_mut()
        .find(|p| p["name"] == from)
        .expect("the crate");
    package["dependencies"]
        .as_array_mut()
        .expect("a list")
        .push(serde_json::json!({ "name": to, "kind": kind }));
    metadata
}

#[test]
fn wrong_arrows_are_found() {
    for (from, to, kind) in [
        ("rodsight-solver", "rodsight-render", None),
        ("rodsight-solver", "rodsight-scene", None),
        ("rodsight-solver", "rodsight-optics", None),
        ("rodsight-solver", "rodsight-bench", Some("build")),
        ("rodsight-geometry", "rodsight-optics", None),
        ("rodsight-scene", "rodsight-render", None),
        ("rodsight-bench", "rodsight-scene", None),
        ("rodsight", "rodsight-testkit", None),
        ("rodsight-render", "rodsight-testkit", None),
        ("rodsight-testkit", "rodsight-geometry", None),
        ("rodsight-solver", "rodsight-shaders", None),
        ("rodsight", "rodsight-shaders", None),
    ] {
        let found = faults(&with_arrow(from, to, kind));
        assert!(
            found.contains(&format!("{from} must not depend on {to}")),
            "{from} → {to} was not found: {found:?}"
        );
    }
    let fine = faults(&with_arrow(
        "rodsight-solver",
        "rodsight-render",
        Some("dev"),
    ));
    assert!(fine.is_empty(), "{fine:?}");
}

#[test]
fn crates_that_are_unknown_or_missing_are_found() {
    let mut graph = metadata();
    for package in graph["packages"].as_array_mut().expect("a list") {
        if package["name"] == "rodsight-optics" {
            package["name"] = "rodsight-newcomer".into();
        }
    }
    let found = faults(&graph);
    assert!(
        found.contains(&"rodsight-newcomer has no row in the table of allowed arrows".to_owned()),
        "{found:?}"
    );
    assert!(
        found.contains(&"rodsight-optics is not in the workspace".to_owned()),
        "{found:?}"
    );
}
