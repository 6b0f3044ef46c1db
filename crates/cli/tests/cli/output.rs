//! Output that cannot be written, runs that are interrupted: nothing half-written stays.
#![cfg(unix)]

use std::io::Read;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::harness::{Run, SMALL, folder, names, pair, rodsight, solve, text};

fn render_to(output: &Path) -> Run {
    let scene = pair().join("scene.toml");
    rodsight(&["render", text(&scene), "-o", text(output)])
}

#[test]
fn output_that_is_no_folder_is_told_before_any_work() {
    let folder = folder();
    let file = folder.path().join("file");
    std::fs::write(&file, "mine").unwrap();
    for output in [&file, &file.join("below"), Path::new("/proc/rodsight")] {
        let says = [text(output), "cannot write to this output folder"];
        render_to(output).failed(2, &says);
        rodsight(&["demo", "-o", text(output)]).failed(2, &says);
        solve(&["--method", "paper", "--trace", text(output)]).failed(2, &says);
    }
    assert_eq!(std::fs::read(&file).unwrap(), b"mine");
}

#[test]
fn full_disk_leaves_no_half_file() {
    for (file, kept) in [
        ("left.png", &[][..]),
        ("left.exr", &["left.png", "right.png"]),
        (
            "truth.json",
            &[
                "left.exr",
                "left.png",
                "rig.toml",
                "right.exr",
                "right.png",
                "scene.toml",
            ],
        ),
    ] {
        let folder = folder();
        std::fs::write(folder.path().join("truth.json"), "of an older pair").unwrap();
        // Its temporary file is on a device that is full.
        symlink("/dev/full", folder.path().join(format!("{file}.part"))).unwrap();
        render_to(folder.path()).failed(2, &[file, "No space left on device"]);
        assert_eq!(names(folder.path()), kept, "{file}");
    }
    let folder = folder();
    for name in ["left.png", "right.png", "truth.json"] {
        std::fs::copy(pair().join(name), folder.path().join(name)).unwrap();
    }
    symlink("/dev/full", folder.path().join("inspect.html.part")).unwrap();
    rodsight(&["inspect", text(folder.path())])
        .failed(2, &["inspect.html", "No space left on device"]);
    assert_eq!(
        names(folder.path()),
        ["inspect.png", "left.png", "right.png", "truth.json"]
    );
}

#[test]
fn full_standard_output_is_a_failure() {
    for args in [&["schema", "truth"][..], &["completions", "zsh"]] {
        let full = std::fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let output = program().args(args).stdout(full).output().unwrap();
        Run::of(&output).failed(1, &["standard output", "No space left on device"]);
    }
}

#[test]
fn file_size_limit_is_an_error_of_the_file() {
    let folder = folder();
    let output = folder.path().join("out");
    // 2 to 4 MB, whatever the shell counts in: room for the images, not for the channels.
    let script = "ulimit -f 4000; exec \"$0\" render \"$1\" -o \"$2\"";
    let run = Command::new("sh")
        .args([
            "-c",
            script,
            env!("CARGO_BIN_EXE_rodsight"),
            text(&pair().join("scene.toml")),
            text(&output),
        ])
        .output()
        .unwrap();
    Run::of(&run).failed(2, &["left.exr", "File too large"]);
    assert_eq!(names(&output), ["left.png", "right.png"]);
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_rodsight"))
}

fn start_render(scene: &Path, output: &Path) -> Child {
    let mut command = program();
    command.arg("render").arg(scene).arg("-o").arg(output);
    command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn wait_for(what: &str, child: &mut Child, done: impl Fn() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(child.try_wait().unwrap().is_none(), "ended before {what}");
        assert!(start.elapsed() < Duration::from_secs(120), "no {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn interrupt(child: Child, signal: &str) -> Run {
    let told = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(told.success());
    Run::of(&child.wait_with_output().unwrap())
}

#[test]
fn interrupt_while_rendering_leaves_nothing() {
    let folder = folder();
    let scene = folder.path().join("slow.toml");
    // Seconds, of which the interrupt comes after a third of one.
    let slow = SMALL.replace("fibonacci = 55", "fibonacci = 10946");
    assert_ne!(slow, SMALL);
    std::fs::write(&scene, slow).unwrap();
    for signal in ["-INT", "-TERM"] {
        let output = folder.path().join("deep/out");
        let mut child = start_render(&scene, &output);
        wait_for("the output folder", &mut child, || output.exists());
        std::thread::sleep(Duration::from_millis(300));
        interrupt(child, signal).failed(130, &[]);
        assert_eq!(names(folder.path()), ["slow.toml"], "{signal}");
    }
}

#[test]
fn interrupt_while_writing_leaves_whole_files_only() {
    let folder = folder();
    let output = folder.path();
    std::fs::write(output.join("truth.json"), "of an older pair").unwrap();
    std::fs::write(output.join("mine.part"), "not ours to delete").unwrap();
    // The writer gets stuck in a pipe that nobody empties.
    let pipe = output.join("left.exr.part");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let mut reader = std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .open(&pipe)
        .unwrap();
    let mut child = start_render(&pair().join("scene.toml"), output);
    // It is in the middle of the file once the first byte has come.
    let first = std::thread::spawn(move || reader.read_exact(&mut [0]).map(|()| reader));
    wait_for("left.exr", &mut child, || first.is_finished());
    let reader = first.join().unwrap().unwrap();
    interrupt(child, "-INT").failed(130, &[]);
    drop(reader);
    assert_eq!(names(output), ["left.png", "mine.part", "right.png"]);
    assert!(rodsight_render::read_image(&output.join("right.png")).is_ok());
}

#[test]
fn broken_pipe_is_a_quiet_end() {
    for args in [
        &["schema", "scene"][..],
        &["completions", "bash"],
        &["--help"],
        &["render", "--help"],
    ] {
        let mut child = program()
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut err = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut err)
            .unwrap();
        assert_eq!(
            (child.wait().unwrap().code(), err.as_str()),
            (Some(0), ""),
            "{args:?}"
        );
    }
}
