//! What is said of files that are no scenes: the file, the key, what was expected and what was found.

use std::path::{Path, PathBuf};

use rodsight_scene::{EdgeSampling, Exposure, Scene, SceneFile, Sensor};

/// A small valid scene that the tests break one line at a time.
const GOOD: &str = r#"
schema = 1
id = "small"
mode = "single"
rig_file = "rigs/paper.toml"

[water]
name = "IB"

[[lamp]]
position_m = [0.1, -0.9, -1.35]
direction = [1, 0.2, 0.3]
radiant_intensity_w_per_sr = [1, 1, 1]
inner_half_angle_deg = 30
outer_half_angle_deg = 60

[[rod]]
id = "cable"
centre_m = [2.3, 0, -0.9]
direction = [0, 0, 2]
length_m = 2
radius_m = 0.05
albedo = [0.8, 0.4, 0.1]

[seabed]
z_m = 0.5
albedo = [0.4, 0.4, 0.3]

[target]
rod = "cable"
"#;

fn scenes_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn load(text: &str) -> Result<Scene, String> {
    let path = scenes_dir().join("x.toml");
    Scene::from_toml(text, &path).map_err(|error| {
        let directory = format!("{}", scenes_dir().display());
        error.to_string().replace(&directory, "scenes")
    })
}

/// The message for the good scene with one piece of text replaced.
fn complaint(old: &str, new: &str) -> String {
    assert!(GOOD.contains(old), "{old}");
    match load(&GOOD.replacen(old, new, 1)) {
        Ok(_) => panic!("accepted: {new}"),
        Err(message) => message,
    }
}

#[test]
fn good_scene_loads_with_defaults() {
    let scene = load(GOOD).unwrap();
    assert_eq!(scene.bits, 8);
    assert_eq!(scene.seed, 0);
    assert_eq!(
        scene.sensor,
        Sensor::Plain {
            noise_sigma_dn: 0.0
        }
    );
    assert!(matches!(scene.exposure, Exposure::Auto { .. }));
    assert_eq!(scene.sampling.edge, EdgeSampling::Fibonacci { points: 233 });
    assert_eq!(scene.rods[0].direction.z, 1.0);
}

#[test]
fn messages_are_exactly_these() {
    for (old, new, message) in [
        (
            "radius_m = 0.05",
            "radius_m = -0.05",
            "scenes/x.toml: rod[0].radius_m: expected > 0 and finite, found -0.05",
        ),
        (
            "length_m = 2",
            "length_m = nan",
            "scenes/x.toml: rod[0].length_m: expected > 0 and finite, found NaN",
        ),
        (
            "name = \"IB\"",
            "name = \"IX\"",
            "scenes/x.toml: water.name: expected one of pure_sea, IB, II, III, 1C, 3C, 5C, I, IA, 7C, 9C, found \"IX\"",
        ),
        (
            "radius_m = 0.05",
            "radius = 0.05",
            "scenes/x.toml:22: rod[0].radius: unknown field `radius`, expected one of `id`, `from_m`, `to_m`, `centre_m`, \
             `direction`, `length_m`, `radius_m`, `bend`, `albedo`, `flat_radiance_w_per_m2_sr`, `surface`; did you mean `radius_m`?",
        ),
        (
            "outer_half_angle_deg = 60",
            "outer_half_angle_deg = 20",
            "scenes/x.toml: lamp[0].outer_half_angle_deg: expected at least inner_half_angle_deg (30) and < 180, found 20",
        ),
        (
            "centre_m = [2.3, 0, -0.9]",
            "centre_m = [-2.3, 0, -0.9]",
            "scenes/x.toml: rod[0]: expected a rod in front of at least one camera, found \"cable\" wholly behind both: \
             its foremost point at z = -2.250 m of the left camera, -2.250 m of the right",
        ),
        (
            "[target]",
            "[sampling]\nedge = { fibonacci = 100 }\n[target]",
            "scenes/x.toml: sampling.edge.fibonacci: expected a Fibonacci number up to 10946 (the nearest is 89), found 100",
        ),
        (
            "rod = \"cable\"",
            "rod = \"pipe\"",
            "scenes/x.toml: target.rod: expected the id of a rod: \"cable\", found \"pipe\"",
        ),
        (
            "rod = \"cable\"",
            "rod = \"cable\"\nalong_m = 1.5",
            "scenes/x.toml: target.along_m: expected within the rod's length, -1 to 1, found 1.5",
        ),
        (
            "centre_m = [2.3, 0, -0.9]",
            "centre_m = [2.3, 0, -3.9]",
            "scenes/x.toml: target: expected a grasp that the left image shows, found it at (1300.6, -1435.3) px",
        ),
    ] {
        assert_eq!(complaint(old, new), message);
    }
}

/// One broken line each: what is replaced ~ by what (`\n` begins a new line) ~ the key ~ expected ~ found.
const BROKEN: &str = r#"
schema = 1 ~ schema = 2 ~ schema ~ 1 ~ 2
id = "small" ~ id = "a b/c" ~ id ~ letters ~ a b/c
schema = 1 ~ schema = 1\nbits = 12 ~ bits ~ 8 or 16 ~ 12
schema = 1 ~ schema = 1\nseed = -1 ~ seed ~ u64 ~ -1
schema = 1 ~ schema = 1\nambient_radiance_w_per_m2_sr = [0, -1, 0] ~ ambient_radiance_w_per_m2_sr[1] ~ >= 0 ~ -1
schema = 1 ~ schema = 1\nbackground_radiance_w_per_m2_sr = [0, 0, inf] ~ background_radiance_w_per_m2_sr[2] ~ finite ~ inf
"single" ~ "koschmieder" ~ ambient_radiance_w_per_m2_sr ~ > 0 in at least one band ~ [0, 0, 0]
"single" ~ "singel" ~ mode ~ did you mean `single` ~ singel
name = "IB" ~ absorption_per_m = [-0.1, 0, 0]\nscattering_per_m = [0, 0, 0] ~ water.absorption_per_m[0] ~ >= 0 ~ -0.1
name = "IB" ~ absorption_per_m = [0, 0, 0]\nscattering_per_m = [0, nan, 0] ~ water.scattering_per_m[1] ~ >= 0 ~ NaN
name = "IB" ~ name = "IB"\nscattering_per_m = [0, 0, 0] ~ water ~ either name ~ a name and coefficients
name = "IB" ~  ~ water ~ either name ~ none of them
name = "IB" ~ scattering_per_m = [0, 0, 0] ~ water ~ either name ~ scattering_per_m only
name = "IB" ~ name = "IB"\nphase = "petzold" ~ water.phase ~ did you mean `petzold3` ~ petzold
name = "IB" ~ name = "IB"\nphase = { henyey_greenstein = { g = 1.0 } } ~ water.phase.henyey_greenstein.g ~ > -1 and < 1 ~ 1
name = "IB" ~ name = "IB"\nphase = { lobes = [{ weight = 0.5, g = 0.9 }] } ~ water.phase.lobes ~ sum to 1 ~ 0.5
name = "IB" ~ name = "IB"\nphase = { lobes = [{ wieght = 1, g = 0.9 }] } ~ water.phase ~ did you mean `weight` ~ wieght
name = "IB" ~ name = "IB"\nphase = { fournier_forand = { refractive_index = 0.9, junge_slope = 3.5 } } ~ water.phase.fournier_forand.refractive_index ~ > 1 ~ 0.9
direction = [1, 0.2, 0.3] ~ direction = [0, 0, 0] ~ lamp[0].direction ~ zero length ~ [0, 0, 0]
direction = [1, 0.2, 0.3] ~ aim_at_m = [0.1, -0.9, -1.35] ~ lamp[0].aim_at_m ~ other than position_m ~ 0.1
direction = [1, 0.2, 0.3] ~  ~ lamp[0] ~ either direction or aim_at_m ~ neither
radiant_intensity_w_per_sr = [1, 1, 1] ~ radiant_intensity_w_per_sr = [1, 1] ~ lamp[0].radiant_intensity_w_per_sr ~ 3 ~ invalid length 2
inner_half_angle_deg = 30 ~ inner_half_angle_deg = 0 ~ lamp[0].inner_half_angle_deg ~ at least 0.001 and < 180 ~ 0
outer_half_angle_deg = 60 ~ outer_half_angle_deg = 180 ~ lamp[0].outer_half_angle_deg ~ < 180 ~ 180
direction = [0, 0, 2] ~ direction = [0, 0, 0] ~ rod[0].direction ~ zero length ~ [0, 0, 0]
radius_m = 0.05 ~ radius_m = 1e-9 ~ rod[0].radius_m ~ between 1e-6 and 1e6 ~ 0.000000001
centre_m = [2.3, 0, -0.9] ~ centre_m = [2.3, 1e9, -0.9] ~ rod[0].centre_m[1] ~ within -1e6 to 1e6 ~ 1000000000
direction = [0, 0, 2] ~ direction = "down" ~ rod[0].direction ~ array ~ down
length_m = 2 ~ length_m = 0 ~ rod[0].length_m ~ > 0 ~ 0
length_m = 2 ~ from_m = [0, 0, 0] ~ rod[0] ~ from_m and to_m, or centre_m ~ some of both
length_m = 2 ~  ~ rod[0].length_m ~ from_m and to_m, or centre_m ~ nothing
albedo = [0.8, 0.4, 0.1] ~ albedo = [0.8, 1.4, 0.1] ~ rod[0].albedo[1] ~ between 0 and 1 ~ 1.4
albedo = [0.8, 0.4, 0.1] ~  ~ rod[0] ~ either albedo or ~ neither
albedo = [0.8, 0.4, 0.1] ~ flat_radiance_w_per_m2_sr = [1, 1, -1] ~ rod[0].flat_radiance_w_per_m2_sr[2] ~ >= 0 ~ -1
radius_m = 0.05 ~ radius_m = 0.05\nbend = { sagitta_m = 0.7, towards = [0, 1, 0] } ~ rod[0].bend.sagitta_m ~ at most 0.3 of the length ~ 0.7
radius_m = 0.05 ~ radius_m = 0.05\nbend = { sagitta_m = 0.1, towards = [0, 0, 1] } ~ rod[0].bend.towards ~ across the rod ~ along
radius_m = 0.05 ~ radius_m = 1.2\nbend = { sagitta_m = 0.5, towards = [0, 1, 0] } ~ rod[0].radius_m ~ less than the radius of the bend ~ 1.2
radius_m = 0.05 ~ radius_m = 0.05\nbend = { sagita_m = 0.1, towards = [0, 1, 0] } ~ rod[0] ~ did you mean `sagitta_m` ~ sagita_m
z_m = 0.5 ~ z_m = -1.0 ~ seabed.z_m ~ below the left camera ~ -1
z_m = 0.5 ~ z_m = -0.95 ~ target ~ above the seabed ~ -0.9
z_m = 0.5 ~ z_m = 0.5\ntexture_contrast = 1.5 ~ seabed.texture_contrast ~ between 0 and 1 ~ 1.5
z_m = 0.5 ~ z_m = 0.5\ntexture_scale_m = 0 ~ seabed.texture_scale_m ~ > 0 ~ 0
[target] ~ [exposure]\ngain_m2_sr_per_w = 0\n[target] ~ exposure.gain_m2_sr_per_w ~ > 0 ~ 0
[target] ~ [exposure]\nauto = { quantile = 1.5 }\n[target] ~ exposure.auto.quantile ~ > 0 and at most 1 ~ 1.5
[target] ~ [exposure]\nauto = { level = 0 }\n[target] ~ exposure.auto.level ~ > 0 and at most 1 ~ 0
[target] ~ [sensor.plain]\nnoise_sigma_dn = -1\n[target] ~ sensor.plain.noise_sigma_dn ~ 0 ~ -1
[target] ~ [sensor.emva]\nfull_well_e = 0\n[target] ~ sensor.emva.full_well_e ~ > 0 ~ 0
[target] ~ [sensor.emva]\nadc_bits = 24\n[target] ~ sensor.emva.adc_bits ~ 8 to 16 ~ 24
[target] ~ [sensor.emva]\nread_nose_e = 1\n[target] ~ sensor.emva ~ did you mean `read_noise_e` ~ read_nose_e
[target] ~ [sensor.ccd]\n[target] ~ sensor ~ `plain` ~ ccd
[target] ~ [sampling]\nairlight_points = 0\n[target] ~ sampling.airlight_points ~ 1 to 4096 ~ 0
[target] ~ [sampling]\nedge = { grid = 100 }\n[target] ~ sampling.edge.grid ~ 1 to 64 ~ 100
rod = "cable" ~ rod = "cable"\nnear_m = [2.3, 0, 3] ~ target.near_m ~ within the rod's length ~ 3.9
rod = "cable" ~ rod = "cable"\nnear_m = [2.3, 0, 0]\nalong_m = 0 ~ target ~ at most one of ~ both
rod = "cable" ~ rod = "cable"\npick_eye = "lefft" ~ target.pick_eye ~ did you mean `left` ~ lefft
[target] ~ [sensor.emva]\nfull_well_e = 1e4\nread_noise_e = 2\ndark_e = 1e4\nprnu = 0\ndsnu_e = 0\nadc_bits = 12\n[target] ~ sensor.emva.dark_e ~ less than the full well (10000) ~ 10000
position_m = [0.1, -0.9, -1.35] ~ position_m = [0.1, -0.9, 0.5] ~ lamp[0].position_m ~ z above the seabed, less than 0.5 ~ 0.5
rig_file = "rigs/paper.toml" ~ rig_file = "rigs/flat_port.toml"\nlens = { aperture = { f_number = 4, focal_length_m = 0.008, focus_m = 0.02 } } ~ lens.aperture ~ a lens that sees ahead, and only water ~ the left camera: focus_m: expected a depth in the water
[seabed] ~ [sea_bed] ~ sea_bed ~ did you mean `seabed` ~ sea_bed
"#;

#[test]
fn every_number_is_checked_and_named() {
    for case in BROKEN.trim().lines() {
        let columns: Vec<String> = case.split(" ~ ").map(|c| c.replace("\\n", "\n")).collect();
        let [old, new, said @ ..] = columns.as_slice() else {
            panic!("{case}");
        };
        assert_eq!(said.len(), 3, "{case}");
        let message = complaint(old, new);
        for part in said.iter().map(String::as_str).chain(["scenes/x.toml"]) {
            assert!(
                message.contains(part),
                "{new}\n  said: {message}\n  without: {part}"
            );
        }
    }
}

#[test]
fn duplicate_ids_and_second_tables_are_counted() {
    let rod = "[[rod]]\nid = \"ID\"\nfrom_m = [3, 0, 0]\nto_m = [3, 0, -2]\nradius_m = 0.1\nalbedo = [1, 1, 1]\n";
    let with = |piece: &str| load(&GOOD.replace("[seabed]", &format!("{piece}\n[seabed]")));
    with(&rod.replace("ID", "other")).unwrap();
    let message = with(&rod.replace("ID", "cable")).unwrap_err();
    assert_eq!(
        message,
        "scenes/x.toml: rod[1].id: expected a name that rod[0] does not have, found \"cable\" again"
    );
    let message = with(
        &rod.replace("ID", "o")
            .replace("radius_m = 0.1", "radius_m = \"thick\""),
    )
    .unwrap_err();
    assert!(
        message.contains("rod[1].radius_m: invalid type: string \"thick\", expected f64"),
        "{message}"
    );
    let message = with(
        &rod.replace("ID", "o")
            .replace("to_m = [3, 0, -2]", "to_m = [3, 0, 0]"),
    )
    .unwrap_err();
    assert!(
        message.contains("rod[1].to_m: expected a point other than from_m, found [3, 0, 0]"),
        "{message}"
    );
    let message = with(&rod.replace("ID", "o").replace("radius_m = 0.1\n", "")).unwrap_err();
    assert!(
        message.contains("rod[1]: missing field `radius_m`"),
        "{message}"
    );
}

#[test]
fn cameras_and_lamps_inside_rods_are_refused() {
    let message = complaint("centre_m = [2.3, 0, -0.9]", "centre_m = [0.02, 0.5, -0.9]");
    assert_eq!(
        message,
        "scenes/x.toml: rod[0]: expected no camera inside a rod, found the right camera inside \"cable\""
    );
    let message = complaint(
        "position_m = [0.1, -0.9, -1.35]",
        "position_m = [2.31, 0.01, -1.35]",
    );
    assert!(
        message.contains("lamp[0].position_m: expected no lamp inside a rod"),
        "{message}"
    );
}

#[test]
fn rigs_are_checked_inline_and_in_their_own_file() {
    let paper = std::fs::read_to_string(scenes_dir().join("paper.toml")).unwrap();
    let broken = |old: &str, new: &str| load(&paper.replacen(old, new, 1)).unwrap_err();
    assert_eq!(
        broken("fx_px = 1566.577619644", "fx_px = -1.0"),
        "scenes/x.toml: rig.left.fx_px: expected a positive number, found -1"
    );
    let message = broken(
        "translation_m = [0.0, -0.5, -1.0]",
        "translation_m = [0.0, 1.5, -1.0]",
    );
    assert!(
        message.starts_with("scenes/x.toml: rig.right.rig_from_camera"),
        "{message}"
    );
    assert!(message.contains("exchanged"), "{message}");
    let message = broken("cx_px = 960.0", "cx_pix = 960.0");
    assert!(
        message.contains("rig.left") && message.contains("did you mean `cx_px`"),
        "{message}"
    );

    let message = complaint("rig_file = \"rigs/paper.toml\"", "");
    assert_eq!(
        message,
        "scenes/x.toml: rig: expected either [rig] or rig_file, found neither"
    );
    let message = complaint("rigs/paper.toml", "rigs/none.toml");
    assert!(message.starts_with("scenes/rigs/none.toml: "), "{message}");
}

#[test]
fn files_that_are_missing_or_no_toml_say_so() {
    let message = Scene::load(Path::new("none/at/all.toml"))
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("none/at/all.toml: "), "{message}");
    let message = load("schema = 1\nid = \n").unwrap_err();
    assert!(message.starts_with("scenes/x.toml:2: "), "{message}");
    let message = load("schema = 1\n").unwrap_err();
    assert!(message.contains("missing field `id`"), "{message}");
}

#[test]
fn air_needs_no_water_and_full_is_left_to_the_renderer() {
    let air = GOOD
        .replace("\"single\"", "\"air\"")
        .replace("[water]\nname = \"IB\"\n", "");
    let scene = load(&air).unwrap();
    assert!(scene.medium.is_vacuum());
    assert_eq!(scene.water_label, "none");
    let message = complaint("[water]\nname = \"IB\"\n", "");
    assert!(
        message.contains("water: expected a table [water] in every mode but \"air\""),
        "{message}"
    );
    load(&GOOD.replace("\"single\"", "\"full\"")).unwrap();
    load(&GOOD.replace(
        "\"single\"",
        "\"koschmieder\"\nambient_radiance_w_per_m2_sr = [0, 1, 1]",
    ))
    .unwrap();
}

#[test]
fn bend_between_ends_keeps_the_ends() {
    let text = GOOD.replace(
        "centre_m = [2.3, 0, -0.9]\ndirection = [0, 0, 2]\nlength_m = 2",
        "from_m = [2.3, 0, -1.9]\nto_m = [2.3, 0, 0.1]\nbend = { sagitta_m = 0.1, towards = [0, 1, 0.5] }",
    );
    let rod = load(&text).unwrap().rods.remove(0);
    let half_m = 0.5 * rod.length_m;
    for (along_m, z_m) in [(-half_m, -1.9), (half_m, 0.1)] {
        let tip = rod.axis_at(along_m).0;
        assert!(
            (tip - rodsight_geometry::Vec3::new(2.3, 0.0, z_m)).norm() < 1e-12,
            "{tip}"
        );
    }
    assert!((rod.centre_m.y + 0.1).abs() < 1e-15);
}

#[test]
fn seeds_use_all_64_bits() {
    let mut scene = load(GOOD).unwrap();
    scene.seed = u64::MAX;
    let again = load(
        &SceneFile::from_scene(&scene)
            .to_toml()
            .replace("x.toml", ""),
    )
    .unwrap();
    assert_eq!(again.seed, u64::MAX);
}

#[test]
fn schemas_know_the_keys() {
    for (schema, keys) in [
        (
            rodsight_scene::scene_json_schema(),
            ["radius_m", "scattering_per_m", "fibonacci"],
        ),
        (
            rodsight_scene::rig_json_schema(),
            ["fx_px", "rig_from_camera", "quaternion_wxyz"],
        ),
    ] {
        let text = serde_json::to_string(&schema).unwrap();
        for key in keys {
            assert!(text.contains(key), "{key}");
        }
    }
}
