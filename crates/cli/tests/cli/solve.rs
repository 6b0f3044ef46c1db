//! `rodsight solve` on a pair of our own.

use serde_json::Value;

use crate::harness::{Run, folder, names, pair, read_json, rodsight, solve, text, vector};

/// Every key of the contract, as a path; what is unknown is null, not absent.
const CONTRACT: &[&str] = &[
    "/schema",
    "/method",
    "/status",
    "/reason",
    "/axis/point_m",
    "/axis/direction",
    "/axis/covariance",
    "/radius_m",
    "/radius_sigma_m",
    "/grasp/point_m",
    "/grasp/covariance_m2",
    "/grasp/paper_point_m",
    "/centerlines/left/rho_px",
    "/centerlines/left/theta_rad",
    "/centerlines/right/rho_px",
    "/centerlines/right/theta_rad",
    "/observability",
    "/timing_ms/total",
];

fn millimetres(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
    squares.sqrt() * 1e3
}

/// How far the answer passes the true grasp point, mm.
fn axis_offset_mm(answer: &Value) -> f64 {
    let truth = read_json(&pair().join("truth.json"));
    let (grasp, point) = (
        vector(&truth["grasp"]["point_m"]),
        vector(&answer["axis"]["point_m"]),
    );
    let direction = vector(&answer["axis"]["direction"]);
    let along: f64 = (0..3).map(|k| (grasp[k] - point[k]) * direction[k]).sum();
    millimetres(grasp, [0, 1, 2].map(|k| point[k] + along * direction[k]))
}

#[test]
fn solve_keeps_the_contract() {
    let answer = solve(&["--json"]).json();
    for key in CONTRACT {
        assert!(answer.pointer(key).is_some(), "{key} in {answer}");
    }
    let keys: Vec<&str> = answer
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let mut top: Vec<&str> = CONTRACT
        .iter()
        .map(|key| key.split('/').nth(1).unwrap())
        .collect();
    top.dedup();
    top.sort_unstable();
    assert_eq!(keys, top);
    assert_eq!(
        (&answer["schema"], &answer["status"], &answer["reason"]),
        (&1.into(), &"ok".into(), &Value::Null)
    );
    assert!(axis_offset_mm(&answer) < 8.0, "{}", axis_offset_mm(&answer));
    let truth = read_json(&pair().join("truth.json"));
    let grasp = |value: &Value| vector(&value["grasp"]["point_m"]);
    assert!(millimetres(grasp(&answer), grasp(&truth)) < 8.0, "{answer}");
    assert_eq!(answer["axis"]["covariance"].as_array().unwrap().len(), 6);
    assert!((answer["radius_m"].as_f64().unwrap() - 0.05).abs() < 0.005);
}

#[test]
fn solve_by_every_method_says_which() {
    for method in ["paper", "paper-bisector"] {
        let answer = solve(&["--json", "--method", method]).json();
        assert_eq!(
            (&answer["method"], &answer["status"]),
            (&method.into(), &"ok".into())
        );
        assert!(
            axis_offset_mm(&answer) < 20.0,
            "{method}: {}",
            axis_offset_mm(&answer)
        );
    }
    let run = solve(&["--method", "joined"]);
    run.failed(2, &["paper, paper-bisector", "joined"]);
}

#[test]
fn solve_in_words_is_for_people() {
    let run = solve(&[]);
    for text in [
        "joint: ok",
        "axis point, m",
        "axis direction",
        "grasp, m",
        "radius 50.",
        "x forward",
    ] {
        assert!(run.done().contains(text), "{text} in {run:?}");
    }
}

#[test]
fn solve_without_a_pick_knows_no_grasp() {
    let truth = pair();
    let file = |name: &str| text(&truth.join(name)).to_owned();
    let run = rodsight(&[
        "solve",
        "--left",
        &file("left.png"),
        "--right",
        &file("right.png"),
        "--rig",
        &file("rig.toml"),
        "--json",
    ]);
    let answer = run.json();
    assert_eq!(answer["grasp"], Value::Null);
    assert!(axis_offset_mm(&answer) < 8.0);
}

#[test]
fn solve_takes_a_pick_of_the_right_eye() {
    let truth = read_json(&pair().join("truth.json"));
    // Where the right eye sees the grasp (or the surface before it, a centimetre off along the rod): parallel cameras of the small scene, a metre apart.
    let [x, y, z] = vector(&truth["grasp"]["point_m"]);
    let pick = format!(
        "{},{},right",
        391.644404911 * (y - 0.5) / x + 240.0,
        391.644404911 * (z + 1.0) / x + 135.0
    );
    let answer = solve(&["--json", "--pick", &pick]).json();
    assert_eq!(answer["status"], "ok");
    assert!(
        millimetres(vector(&answer["grasp"]["point_m"]), [x, y, z]) < 15.0,
        "{answer}"
    );
}

#[test]
fn solve_takes_regions_and_a_radius() {
    let answer = solve(&[
        "--json",
        "--roi-left",
        "170,0,180,270",
        "--roi-right",
        "20,0,180,270",
    ])
    .json();
    assert!(axis_offset_mm(&answer) < 8.0);
    let answer = solve(&["--json", "--radius-m", "0.05"]).json();
    assert_eq!(
        (&answer["radius_m"], &answer["radius_sigma_m"]),
        (&0.05.into(), &0.0.into())
    );
    let answer = solve(&["--json", "--radius-m", "0.05,0.001"]).json();
    assert!((answer["radius_m"].as_f64().unwrap() - 0.05).abs() < 0.003);
}

#[test]
fn solve_takes_parameters_from_a_file() {
    let folder = folder();
    let params = folder.path().join("params.toml");
    std::fs::write(
        &params,
        "hough_rho_step_px = 1.0\nhough_theta_step_deg = 1.0\nsegmentation = \"hue\"\n",
    )
    .unwrap();
    let fine = solve(&[
        "--json",
        "--method",
        "paper-bisector",
        "--params",
        text(&params),
    ])
    .json();
    assert_eq!(fine["status"], "ok");
    std::fs::write(&params, "hough_threshold = { votes = 100000 }\n").unwrap();
    assert_eq!(
        solve(&["--method", "paper-bisector", "--params", text(&params)]).code,
        3
    );
}

fn refused(run: &Run, code: &str, says: &str) {
    assert_eq!((run.code, run.err.as_str()), (3, ""), "{run:?}");
    let answer: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(
        (&answer["status"], &answer["observability"]["refusal"]),
        (&"refused".into(), &code.into()),
        "{run:?}"
    );
    assert!(answer["reason"].as_str().unwrap().contains(says), "{run:?}");
    for key in ["axis", "grasp", "radius_m", "radius_sigma_m", "centerlines"] {
        assert!(answer.get(key).is_some(), "{key} in {run:?}");
    }
}

#[test]
fn solve_refuses_with_a_reason_and_code_3() {
    // Off the rod, on the sand: whose hue is then taken for the rod's.
    refused(
        &solve(&["--json", "--method", "paper-bisector", "--pick", "20,250"]),
        "no_pair",
        "left image: none of",
    );
    refused(
        &solve(&["--json", "--pick", "20,250"]),
        "pick_off_rod",
        "pick is off the rod",
    );
    for option in ["--params", "--trace"] {
        let told = "joint has no stages to draw and no parameters";
        solve(&[option, "somewhere"]).failed(2, &[told]);
    }
    // The same when the rod's hue is known.
    let folder = folder();
    let params = folder.path().join("params.toml");
    std::fs::write(
        &params,
        "hue_window = { from_deg = 350, to_deg = 60, min_saturation = 0.3 }\n",
    )
    .unwrap();
    let off = [
        "--method",
        "paper-bisector",
        "--params",
        text(&params),
        "--pick",
        "20,250",
    ];
    refused(
        &solve(&[&off[..], &["--json"]].concat()),
        "pick_off_rod",
        "pick is off the rod",
    );
    // A region without the rod.
    let run = solve(&[
        "--json",
        "--roi-left",
        "400,0,80,100",
        "--roi-right",
        "400,0,80,100",
        "--pick",
        "440,50",
    ]);
    assert_eq!(run.code, 3, "{run:?}");
    assert!(run.out.contains("\"status\": \"refused\""));
    let run = solve(&off);
    assert_eq!((run.code, run.err.as_str()), (3, ""));
    assert!(
        run.out
            .starts_with("paper-bisector: refused\n  pick is off the rod"),
        "{run:?}"
    );
}

#[test]
fn solve_traces_the_figure_of_the_paper() {
    let folder = folder();
    let trace = folder.path().join("trace");
    solve(&["--json", "--method", "paper", "--trace", text(&trace)]).json();
    let panels = ["a-edges", "b-hough", "c-refined-once", "d-refined"];
    let expected: Vec<String> = ["left", "right"]
        .iter()
        .flat_map(|eye| panels.map(|panel| format!("{eye}-{panel}.png")))
        .collect();
    assert_eq!(names(&trace), expected);
    for name in &expected {
        let image = rodsight_render::read_image(&trace.join(name)).unwrap();
        assert_eq!((image.width_px(), image.height_px()), (480, 270));
    }
}
