//! Arguments that make no sense: code 2, and what was expected.

use crate::harness::{pair, rodsight, solve, text};

#[test]
fn region_outside_the_image_says_which_image_and_how_large_it_is() {
    for (eye, option) in [("left", "--roi-left"), ("right", "--roi-right")] {
        for region in [
            "400,0,81,10",
            "0,200,10,71",
            "480,0,1,1",
            "0,0,0,10",
            "0,0,10,0",
            "4294967295,0,4294967295,1",
        ] {
            solve(&[option, region, "--json"]).failed(
                2,
                &[
                    &format!("{eye} region"),
                    "inside the image of 480×270 px",
                    region,
                ],
            );
        }
        for region in [
            "1,2,3",
            "1,2,3,4,5",
            "-1,2,3,4",
            "1.5,2,3,4",
            "99999999999,0,1,1",
            "a,b,c,d",
            "",
            "NaN,0,1,1",
        ] {
            solve(&[option, region]).failed(
                2,
                &[option, "expected four whole numbers", "700,0,640,1080"],
            );
        }
    }
}

#[test]
fn pick_outside_the_image_says_how_large_it_is() {
    for (pick, eye) in [
        ("-1,5", "left"),
        ("481,5", "left"),
        ("5,270.5,right", "right"),
        ("1e300,-1e300", "left"),
    ] {
        solve(&["--pick", pick]).failed(
            2,
            &[
                "pick: expected a pixel",
                &format!("{eye} image, 0,0 to 480,270"),
            ],
        );
    }
    for pick in ["5", "5,6,7", "NaN,5", "inf,5", "5,6,up", "", "left", "5;6"] {
        solve(&["--pick", pick]).failed(2, &["--pick", "expected two numbers and perhaps an eye"]);
    }
}

#[test]
fn radius_that_is_no_length_is_named() {
    for (radius, says) in [
        ("-0.05", "radius_m"),
        ("0", "radius_m"),
        ("NaN", "radius_m"),
        ("inf", "radius_m"),
        ("0.05,-1", "sigma_m"),
    ] {
        solve(&["--radius-m", radius]).failed(2, &[says, "expected a positive number of metres"]);
    }
    for radius in ["5cm", "0.05,0.01,0.1", "", "0,05,"] {
        solve(&["--radius-m", radius])
            .failed(2, &["--radius-m", "expected metres, as 0.05 or 0.05,0.001"]);
    }
}

#[test]
fn usage_says_what_is_missing_or_unknown() {
    let run = rodsight(&["solve", "--left", "l.png"]);
    run.failed(2, &["--right <RIGHT>", "--rig <RIG>", "not provided"]);
    solve(&["--roi", "1,2,3,4"]).failed(2, &["--roi", "similar"]);
    rodsight(&["sovle"]).failed(2, &["sovle", "solve"]);
    rodsight(&["render"]).failed(2, &["<SCENE>", "--output"]);
    rodsight(&["render", "s.toml", "-o", "x", "--seed", "-1"]).failed(2, &["--seed", "-1"]);
    rodsight(&["render", "s.toml", "-o", "x", "--backend", "metal"])
        .failed(2, &["metal", "auto, cpu, gpu"]);
    rodsight(&["inspect"]).failed(2, &["<FOLDER>"]);
    rodsight(&["completions", "cmd"]).failed(2, &["cmd", "bash"]);
    rodsight::<&str>(&[]).failed(2, &["Usage: rodsight <COMMAND>", "demo"]);
    let left = pair().join("left.png");
    rodsight(&["solve", text(&left)]).failed(2, &["unexpected argument", "left.png"]);
}
