//! `--help`, `--version`, completions: every example in them works.

use std::path::Path;
use std::process::Command;

use crate::also::heaved;
use crate::harness::{SMALL, folder, pair, rodsight, rodsight_in, true_pick};

const COMMANDS: [&str; 6] = [
    "demo",
    "render",
    "solve",
    "inspect",
    "schema",
    "completions",
];

/// The command lines after "Example:", continuation lines joined.
fn examples(help: &str) -> Vec<String> {
    let (_, after) = help.split_once("Example").expect("an example");
    let joined = after.replace("\\\n", " ");
    joined
        .lines()
        .filter_map(|line| line.strip_prefix("  rodsight "))
        .map(|line| format!("rodsight {line}"))
        .collect()
}

/// A folder with what the examples name, in the small scene's size.
fn stage(folder: &Path) {
    std::fs::create_dir_all(folder.join("scenes")).unwrap();
    std::fs::create_dir_all(folder.join("pair")).unwrap();
    std::fs::write(folder.join("scenes/paper.toml"), SMALL).unwrap();
    for file in ["left.png", "right.png", "rig.toml"] {
        std::fs::copy(pair().join(file), folder.join("pair").join(file)).unwrap();
    }
    std::fs::create_dir_all(folder.join("heaved")).unwrap();
    for file in ["left.png", "right.png"] {
        std::fs::copy(heaved().join(file), folder.join("heaved").join(file)).unwrap();
    }
    // As the help has it.
    let help = rodsight(&["solve", "--help"]);
    let lines = help
        .done()
        .lines()
        .skip_while(|line| *line != "  schema = 1");
    let lines: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
    assert!(lines.len() > 3, "{lines:?}");
    std::fs::write(folder.join("heaved.toml"), lines.join("\n")).unwrap();
    std::fs::copy(pair().join("left.png"), folder.join("l.png")).unwrap();
    std::fs::copy(pair().join("right.png"), folder.join("r.png")).unwrap();
    let camera = "  camera_model: pinhole\n  distortion_model: none\n  intrinsics: [391.644404911, 391.644404911, 239.5, 134.5]\n  \
                  resolution: [480, 270]\n";
    let transform = "  T_cn_cnm1: [[1, 0, 0, -1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
    std::fs::write(
        folder.join("camchain.yaml"),
        format!("cam0:\n{camera}cam1:\n{camera}{transform}"),
    )
    .unwrap();
}

#[test]
fn help_of_every_command_has_examples_that_work() {
    let folder = folder();
    stage(folder.path());
    let program = Path::new(env!("CARGO_BIN_EXE_rodsight"))
        .parent()
        .unwrap()
        .to_owned();
    let path = std::env::join_paths(
        std::iter::once(program).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let path = path.unwrap();
    let pick = true_pick();
    let pick = pick.trim_end_matches(",left");
    let mut ran = 0;
    for command in COMMANDS {
        let run = rodsight(&[command, "--help"]);
        for example in examples(run.done()) {
            // The demo is at full size and has a test of its own; the rest is told the small scene's pixels.
            if command == "demo" {
                assert!(example.starts_with("rodsight demo"), "{example}");
                continue;
            }
            let small = example
                .replace("1029.3,637.0", pick)
                .replace("1029,637", pick)
                .replace("700,0,640,1080", "170,0,180,270")
                .replace("80,0,640,1080", "20,0,180,270")
                .replace("~/.local/share/bash-completion/completions/", "./");
            let output = Command::new("sh")
                .args(["-c", &small])
                .current_dir(folder.path())
                .env("PATH", &path)
                .output()
                .unwrap();
            assert!(
                output.status.success() && output.stderr.is_empty(),
                "{small}: {output:?}"
            );
            ran += 1;
        }
    }
    assert!(ran >= 7, "{ran} examples");
}

#[test]
fn help_names_scenes_that_exist_and_the_exit_codes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let help = rodsight(&["render", "--help"]);
    let scene = help
        .done()
        .split_whitespace()
        .find(|word| word.starts_with("scenes/"))
        .unwrap();
    assert!(root.join(scene).is_file(), "{scene}");
    let help = rodsight(&["--help"]);
    let flat = help.done().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        flat.contains(
            "0 done, 1 failed, 2 bad usage or input, 3 refused or gate not met, 4 no adapter"
        ),
        "{flat}"
    );
    for command in COMMANDS {
        assert!(help.out.contains(command), "{command}");
    }
}

#[test]
fn version_is_that_of_the_package() {
    let expected = concat!("rodsight ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(rodsight(&["--version"]).done(), expected);
    assert_eq!(rodsight(&["-V"]).done(), expected);
}

#[test]
fn completions_know_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = rodsight(&["completions", shell]);
        for command in COMMANDS {
            assert!(run.done().contains(command), "{shell}: {command}");
        }
    }
}

#[test]
fn output_away_from_a_terminal_has_no_colours_and_no_progress() {
    let folder = folder();
    std::fs::write(folder.path().join("s.toml"), SMALL).unwrap();
    for no_color in [false, true] {
        for args in [
            &["render", "s.toml", "-o", "out"][..],
            &["render", "no.toml", "-o", "out"],
            &["slove"],
            &["--help"],
        ] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_rodsight"));
            command.args(args).current_dir(folder.path());
            if no_color {
                command.env("NO_COLOR", "1");
            }
            let output = command.output().unwrap();
            for bytes in [&output.stdout, &output.stderr] {
                assert!(
                    !bytes.iter().any(|byte| matches!(byte, 0x1b | b'\r')),
                    "{args:?}: {output:?}"
                );
            }
        }
    }
    rodsight_in(folder.path(), &["render", "s.toml", "-o", "out", "--json"]).json();
}
