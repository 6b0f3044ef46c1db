//! No arguments and no file make the program panic: [`Run::of`](crate::harness::Run::of) looks for that in every run.

use rodsight_testkit::{SplitMix64, seed};

use crate::harness::{SMALL, folder, pair, rodsight, rodsight_in, solve_args, text};

fn pick<'a>(random: &mut SplitMix64, from: &[&'a str]) -> &'a str {
    from[random.next_u64() as usize % from.len()]
}

const WORDS: [&str; 40] = [
    "solve",
    "inspect",
    "schema",
    "completions",
    "help",
    "--left",
    "--right",
    "--rig",
    "--roi-left",
    "--roi-right",
    "--pick",
    "--radius-m",
    "--method",
    "--params",
    "--trace",
    "--json",
    "--help",
    "-h",
    "-V",
    "-o",
    "--",
    "-",
    "",
    "0",
    "-1",
    "NaN",
    "inf",
    "1e999",
    "1,2,3,4",
    "0,0,4294967295,4294967295",
    "5,5,right",
    "0.05,0.001",
    "paper",
    "bash",
    "scene",
    "truth",
    ".",
    "/dev/null",
    "\u{2028}é\t\n",
    "--backend=gpu",
];

#[test]
fn any_arguments_end_with_a_code() {
    let folder = folder();
    let mut random = SplitMix64::new(seed(1, "arguments", 0));
    for _ in 0..150 {
        let count = random.next_u64() % 7;
        let args: Vec<&str> = (0..count).map(|_| pick(&mut random, &WORDS)).collect();
        let run = rodsight_in(folder.path(), &args);
        assert!(run.code <= 2, "{args:?}: {run:?}");
    }
}

#[test]
fn any_request_ends_with_a_code() {
    let values: [(&str, &[&str]); 4] = [
        (
            "--roi-left",
            &[
                "0,0,1,1",
                "0,0,480,1",
                "0,0,1,270",
                "479,269,1,1",
                "100,100,2,2",
                "170,0,180,270",
                "0,0,3,3",
            ],
        ),
        (
            "--roi-right",
            &[
                "0,0,1,1",
                "0,0,480,2",
                "0,0,2,270",
                "479,269,1,1",
                "20,0,180,270",
                "60,60,9,9",
            ],
        ),
        (
            "--pick",
            &[
                "0,0",
                "480,270",
                "-0.0,0",
                "257.3,159.3",
                "479.999,0.001",
                "1e-300,1e-300",
                "150,150,right",
            ],
        ),
        (
            "--radius-m",
            &[
                "1e-300",
                "1e300",
                "0.05",
                "0.05,1e-300",
                "0.05,1e300",
                "1e9,1",
            ],
        ),
    ];
    let mut random = SplitMix64::new(seed(1, "requests", 0));
    for _ in 0..60 {
        let mut more = vec![
            "--json",
            "--method",
            pick(&mut random, &["paper", "paper-bisector"]),
        ];
        for (option, choices) in values {
            if random.unit() < 0.6 {
                more.extend([option, pick(&mut random, choices)]);
            }
        }
        let run = rodsight(&solve_args(&more));
        assert!(matches!(run.code, 0 | 2 | 3), "{more:?}: {run:?}");
        assert!(
            run.code == 2 || serde_json::from_str::<serde_json::Value>(&run.out).is_ok(),
            "{more:?}: {run:?}"
        );
    }
}

/// The text with a few of its characters, numbers or lines replaced.
fn spoilt(random: &mut SplitMix64, content: &str) -> String {
    let mut lines: Vec<String> = content.lines().map(str::to_owned).collect();
    for _ in 0..=random.next_u64() % 2 {
        let at = random.next_u64() as usize % lines.len();
        let new = pick(
            random,
            &[
                "nan",
                "-1",
                "0",
                "1e308",
                "1e-308",
                "-inf",
                "[]",
                "{}",
                "\"\"",
                "4294967296",
                "true",
            ],
        );
        match random.next_u64() % 4 {
            0 => drop(lines.remove(at)),
            1 => lines.insert(
                at,
                pick(random, &["x = 1", "[[rod]]", "[left]", "}", "\"", "- a: b"]).to_owned(),
            ),
            _ => {
                let line = &lines[at];
                let Some(from) = line.find(|c: char| c.is_ascii_digit()) else {
                    continue;
                };
                let length = line[from..]
                    .find(|c: char| !(c.is_ascii_digit() || c == '.'))
                    .unwrap_or(line.len() - from);
                lines[at] = format!("{}{new}{}", &line[..from], &line[from + length..]);
            }
        }
    }
    lines.join("\n")
}

#[test]
fn any_scene_rig_or_truth_ends_with_a_code() {
    let folder = folder();
    let mut random = SplitMix64::new(seed(1, "files", 0));
    // A scene that is valid all the same is refused before the long work, by the last thing that is checked: its grasp lies in the sand.
    let scene = SMALL.replace("along_m = 0.0", "along_m = 1.2");
    for _ in 0..80 {
        std::fs::write(folder.path().join("s.toml"), spoilt(&mut random, &scene)).unwrap();
        let run = rodsight_in(folder.path(), &["render", "s.toml", "-o", "out"]);
        assert!(run.code == 2 && run.err.contains("s.toml"), "{run:?}");
        assert!(!folder.path().join("out").exists());
    }
    let rig = std::fs::read_to_string(pair().join("rig.toml")).unwrap();
    let path = folder.path().join("rig.toml");
    for _ in 0..60 {
        std::fs::write(&path, spoilt(&mut random, &rig)).unwrap();
        let run = rodsight(&solve_args(&["--rig", text(&path), "--json"]));
        assert!(
            matches!(run.code, 0 | 3) || run.err.contains("rig.toml") || run.err.contains("pick"),
            "{run:?}"
        );
    }
    for name in ["left.png", "right.png"] {
        std::fs::copy(pair().join(name), folder.path().join(name)).unwrap();
    }
    let truth = std::fs::read_to_string(pair().join("truth.json")).unwrap();
    for _ in 0..15 {
        std::fs::write(
            folder.path().join("truth.json"),
            spoilt(&mut random, &truth),
        )
        .unwrap();
        let run = rodsight(&["inspect", text(folder.path())]);
        assert!(matches!(run.code, 0 | 2), "{run:?}");
    }
}
