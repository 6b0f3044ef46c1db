//! `rodsight render`.

use std::path::Path;

use rodsight_render::{read_exr, read_image};

use crate::harness::{
    SMALL, folder, names, pair, read_json, rodsight, rodsight_in, rodsight_without_driver, text,
};

const FILES: [&str; 7] = [
    "left.exr",
    "left.png",
    "rig.toml",
    "right.exr",
    "right.png",
    "scene.toml",
    "truth.json",
];

#[test]
fn render_writes_every_file_and_every_channel() {
    let pair = pair();
    assert_eq!(names(pair), FILES);
    for eye in ["left", "right"] {
        let image = read_image(&pair.join(format!("{eye}.png"))).unwrap();
        assert_eq!(
            (image.width_px(), image.height_px(), image.channels()),
            (480, 270, 3)
        );
        let frame = read_exr(&pair.join(format!("{eye}.exr"))).unwrap();
        assert_eq!((frame.width_px, frame.height_px), (480, 270));
        assert!(
            frame
                .pixels
                .iter()
                .any(|pixel| pixel.instance == 2 && pixel.depth_m > 1.0)
        );
    }
}

#[test]
fn render_names_the_exr_channels_as_the_documentation_does() {
    let channels = |name: &str| {
        let meta = std::fs::read(pair().join(name)).unwrap();
        let header = String::from_utf8_lossy(&meta[..4096]).into_owned();
        header.split('\0').map(str::to_owned).collect::<Vec<_>>()
    };
    let found = channels("left.exr");
    for name in [
        "R",
        "G",
        "B",
        "direct.R",
        "backscatter.G",
        "clean.B",
        "transmission.R",
        "normal.X",
        "depth_m",
        "range_m",
        "disparity_px",
        "instance",
        "material",
        "occluded",
    ] {
        // A channel's name comes after the end of the entry before it.
        assert!(
            found.iter().any(|text| text.ends_with(name)),
            "{name} in {found:?}"
        );
    }
}

fn render_bytes(folder: &Path, name: &str, threads: &str, more: &[&str]) -> Vec<Vec<u8>> {
    let scene = folder.join("small.toml");
    std::fs::write(&scene, SMALL).unwrap();
    let output = folder.join(name);
    let run = assert_cmd::Command::new(env!("CARGO_BIN_EXE_rodsight"))
        .env("RAYON_NUM_THREADS", threads)
        .args(["render", text(&scene), "-o", text(&output)])
        .args(more)
        .output()
        .unwrap();
    assert!(run.status.success(), "{run:?}");
    FILES
        .iter()
        .map(|file| std::fs::read(output.join(file)).unwrap())
        .collect()
}

#[test]
fn render_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = folder();
    let one = render_bytes(folder.path(), "a", "1", &[]);
    let two = render_bytes(folder.path(), "b", "2", &[]);
    let again: Vec<_> = FILES
        .iter()
        .map(|file| std::fs::read(pair().join(file)).unwrap())
        .collect();
    for (index, file) in FILES.iter().enumerate() {
        assert!(
            one[index] == two[index],
            "{file} differs between one thread and two"
        );
        assert!(
            one[index] == again[index],
            "{file} differs between two runs"
        );
    }
    let other = render_bytes(folder.path(), "c", "2", &["--seed", "2"]);
    let differs = |file: &str| {
        let index = FILES.iter().position(|f| *f == file).unwrap();
        one[index] != other[index]
    };
    assert!(differs("left.png") && differs("right.png") && differs("truth.json"));
    assert!(!differs("rig.toml"));
    assert_eq!(read_json(&folder.path().join("c/truth.json"))["seed"], 2);
}

#[test]
fn render_reads_back_the_scene_it_wrote() {
    let folder = folder();
    let scene = pair().join("scene.toml");
    let run = rodsight(&[
        "render",
        text(&scene),
        "-o",
        text(&folder.path().join("again")),
    ]);
    run.done();
    for file in FILES {
        let bytes = |base: &Path| std::fs::read(base.join(file)).unwrap();
        assert!(
            bytes(pair()) == bytes(&folder.path().join("again")),
            "{file}"
        );
    }
}

#[test]
fn render_summary_lists_files_that_are_there() {
    let folder = folder();
    std::fs::write(folder.path().join("s.toml"), SMALL).unwrap();
    let summary = rodsight_in(
        folder.path(),
        &[
            "render",
            "s.toml",
            "-o",
            "deep/er",
            "--json",
            "--backend",
            "cpu",
        ],
    )
    .json();
    let files = summary["files"].as_array().unwrap();
    assert_eq!(files.len(), FILES.len());
    for file in files {
        assert!(
            folder.path().join(file.as_str().unwrap()).is_file(),
            "{file}"
        );
    }
    assert_eq!(summary["backend"], "cpu");
    assert!(summary["timing_ms"]["render"].as_f64().unwrap() > 0.0);
}

#[test]
fn render_summary_lists_raw_images_jpegs_and_props() {
    let folder = folder();
    let props = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/props");
    let mesh = props.join("boulder.glb");
    std::fs::copy(mesh, folder.path().join("boulder.glb")).unwrap();
    let more = concat!(
        "\n[output]\nformat = \"jpeg\"\nraw = true\n",
        "[[prop]]\nid = \"stone\"\nfile = \"boulder.glb\"\nposition_m = [3.0, 0.5, 0.0]\n",
    );
    let scene = SMALL.to_owned() + more;
    std::fs::write(folder.path().join("s.toml"), scene).unwrap();
    let expected = [
        "left.jpg",
        "right.jpg",
        "left_raw.png",
        "right_raw.png",
        "left.exr",
        "right.exr",
        "props/stone.glb",
        "rig.toml",
        "scene.toml",
        "truth.json",
    ];
    let args = ["render", "s.toml", "-o", "pair", "--backend", "cpu"];
    let run = rodsight_in(folder.path(), &args);
    let line = format!("pair: {}\n", expected.join(" "));
    assert!(run.done().contains(&line), "{run:?}");
    let summary = rodsight_in(folder.path(), &[&args[..], &["--json"]].concat()).json();
    let files = summary["files"].as_array().unwrap();
    for (file, name) in files.iter().zip(expected) {
        let path = Path::new("pair").join(name);
        assert_eq!(file.as_str(), path.to_str());
        assert!(folder.path().join(path).is_file(), "{file}");
    }
    assert_eq!(files.len(), expected.len());
}

#[test]
fn render_says_what_to_do_next_and_that_works() {
    let folder = folder();
    std::fs::write(folder.path().join("s.toml"), SMALL).unwrap();
    let run = rodsight_in(folder.path(), &["render", "s.toml", "-o", "pair"]);
    let next = run
        .done()
        .lines()
        .find_map(|line| line.strip_prefix("next: rodsight "))
        .expect("what is next");
    let args: Vec<&str> = next.split_whitespace().collect();
    assert!(
        rodsight_in(folder.path(), &args)
            .done()
            .starts_with("joint: ok\n")
    );
}

#[test]
fn render_over_an_older_pair_leaves_nothing_of_it() {
    let folder = folder();
    for file in FILES {
        std::fs::write(folder.path().join(file), "old").unwrap();
    }
    std::fs::write(folder.path().join("notes.part"), "mine").unwrap();
    let scene = pair().join("scene.toml");
    rodsight(&["render", text(&scene), "-o", text(folder.path())]).done();
    for file in FILES {
        assert!(
            std::fs::read(folder.path().join(file)).unwrap()
                == std::fs::read(pair().join(file)).unwrap(),
            "{file}"
        );
    }
    assert_eq!(
        std::fs::read(folder.path().join("notes.part")).unwrap(),
        b"mine"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn render_without_an_adapter_is_code_4_and_auto_takes_the_cpu() {
    let folder = folder();
    let scene = pair().join("scene.toml");
    let output = folder.path().join("out");
    let args = |backend| {
        let file = text(&scene);
        [
            "render",
            file,
            "-o",
            text(&output),
            "--json",
            "--backend",
            backend,
        ]
    };
    rodsight_without_driver(&args("gpu")).failed(
        4,
        &[
            "--backend gpu",
            "no adapter",
            "apt install mesa-vulkan-drivers",
            "cpu backend",
        ],
    );
    assert!(!output.exists());
    let summary = rodsight_without_driver(&args("auto")).json();
    assert_eq!(summary["backend"], "cpu");
    assert_eq!(summary["backend_reason"], "no graphics card found");
}

#[test]
fn render_says_how_much_is_beyond_the_model() {
    let folder = folder();
    for (mode, says) in [("full", true), ("single", false)] {
        let harbour = SMALL
            .replace("mode = \"single\"", &format!("mode = \"{mode}\""))
            .replace("name = \"IB\"", "name = \"5C\"");
        let scene = folder.path().join("harbour.toml");
        std::fs::write(&scene, harbour).unwrap();
        let output = folder.path().join(mode);
        let run = rodsight(&["render", text(&scene), "-o", text(&output)]);
        assert_eq!(run.done().contains("beyond the model: "), says, "{run:?}");
    }
}
