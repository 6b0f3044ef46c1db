//! Surfaces, occluders, props and what lies on the seabed: keys, checks, and the way back to a file.

use std::path::PathBuf;

use rodsight_scene::{Mesh, MeshMaterial, MeshPart, Scene, SceneFile, Shape};

fn paper() -> (PathBuf, String) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes/paper.toml");
    let text = std::fs::read_to_string(&path).expect("it is shipped");
    (path, text)
}

/// The founding scene with more tables before its target (where the rod's own tables end).
fn with(piece: &str) -> Result<Scene, String> {
    let (path, text) = paper();
    // Tables of the rod belong before the seabed's, those of the seabed before the target.
    let before = if piece.contains("[seabed.") {
        "[target]"
    } else {
        "[seabed]"
    };
    let text = text.replacen(before, &format!("{piece}\n{before}"), 1);
    Scene::from_toml(&text, &path).map_err(|error| error.to_string())
}

const SURFACE: &str = r"
[rod.surface]
stripes = { period_m = 0.2, albedo = [0.8, 0.8, 0.8], share = 0.25, starts = 2 }
texture = { contrast = 0.1, scale_m = 0.02 }
gloss = { roughness = 0.3, reflectance = [0.004, 0.004, 0.004] }
fouling = { cover = 0.2, height_m = 0.012, albedo = [0.2, 0.3, 0.1] }
";
const OCCLUDERS: &str = r#"
[[occluder]]
id = "ball"
albedo = [0.5, 0.5, 0.5]
sphere = { centre_m = [1.5, 0.2, -1], radius_m = 0.1 }
[[occluder]]
id = "hose"
albedo = [0.1, 0.1, 0.1]
capsule = { from_m = [1.5, 0.2, -1], to_m = [1.5, 0.6, -1], radius_m = 0.02 }
[[occluder]]
id = "crate"
albedo = [0.4, 0.3, 0.2]
block = { centre_m = [3, 1, -0.3], size_m = [0.4, 0.6, 0.8], rpy_deg = [0, 0, 30] }
"#;
const FLOOR: &str = r"
[seabed.ripples]
wavelength_m = 0.1
height_m = 0.015
heading_deg = 20
[seabed.clutter]
stones_per_m2 = 4
diameter_m = [0.03, 0.2]
albedo = [0.3, 0.3, 0.3]
";

#[test]
fn every_key_arrives_and_comes_back_to_the_last_bit() {
    for piece in [SURFACE, OCCLUDERS, FLOOR] {
        let scene = with(piece).unwrap();
        let text = SceneFile::from_scene(&scene).to_toml();
        let again = Scene::from_toml(&text, &paper().0).unwrap();
        assert_eq!(format!("{scene:?}"), format!("{again:?}"), "{text}");
    }
    let rod = with(SURFACE).unwrap().rods.remove(0);
    assert_eq!(rod.finish.stripes.unwrap().starts, 2);
    assert_eq!(rod.finish.grain.unwrap().scale_m, 0.02);
    assert_eq!(rod.finish.gloss.unwrap().roughness, 0.3);
    assert_eq!(rod.fouling.unwrap().height_m, 0.012);
    let scene = with(OCCLUDERS).unwrap();
    assert!(matches!(scene.occluders[2].shape, Shape::Block { half_m, .. } if half_m.y == 0.3));
    assert_eq!(scene.occluder_instance(2), 5);
    assert_eq!(scene.growth_instance(0), 6);
    assert_eq!(scene.stones_instance(), 7);
    assert_eq!(
        with(FLOOR)
            .unwrap()
            .seabed
            .unwrap()
            .clutter
            .unwrap()
            .reach_m,
        10.0
    );
}

#[test]
fn a_plain_scene_writes_none_of_it() {
    let (path, text) = paper();
    let written = SceneFile::from_scene(&Scene::from_toml(&text, &path).unwrap()).to_toml();
    for key in ["surface", "occluder", "prop", "ripples", "clutter"] {
        assert!(!written.contains(key), "{key}");
    }
}

/// What is replaced ~ by what ~ the key ~ what was expected ~ what was found.
const BROKEN: &str = r#"
period_m = 0.2 ~ period_m = 0 ~ rod[0].surface.stripes.period_m ~ > 0 ~ 0
share = 0.25 ~ share = 1.0 ~ rod[0].surface.stripes.share ~ > 0 and < 1 ~ 1
starts = 2 ~ starts = 5000 ~ rod[0].surface.stripes.starts ~ 0 to 1000 ~ 5000
contrast = 0.1 ~ contrast = 0.3 ~ rod[0].surface.texture.contrast ~ no brighter than albedo 1 ~ 0.3
scale_m = 0.02 ~ scale_m = nan ~ rod[0].surface.texture.scale_m ~ > 0 ~ NaN
roughness = 0.3 ~ roughness = 0.01 ~ rod[0].surface.gloss.roughness ~ between 0.05 and 1 ~ 0.01
reflectance = [0.004 ~ reflectance = [2 ~ rod[0].surface.gloss.reflectance[0] ~ between 0 and 1 ~ 2
cover = 0.2 ~ cover = 1 ~ rod[0].surface.fouling.cover ~ at most 0.95 ~ 1
height_m = 0.012 ~ height_m = -1 ~ rod[0].surface.fouling.height_m ~ > 0 ~ -1
height_m = 0.012 ~ height_m = 1e-4 ~ rod[0].surface.fouling.height_m ~ at most 300000 ~ 0.0001
gloss = ~ glos = ~ rod[0].surface.glos ~ did you mean `gloss` ~ glos
sphere = { centre_m = [1.5, 0.2, -1], radius_m = 0.1 } ~  ~ occluder[0] ~ exactly one of sphere, capsule, block ~ none
radius_m = 0.1 } ~ radius_m = 0 } ~ occluder[0].sphere.radius_m ~ > 0 ~ 0
to_m = [1.5, 0.6, -1] ~ to_m = [1.5, 0.2, -1] ~ occluder[1].capsule.to_m ~ other than from_m ~ [1.5, 0.2, -1]
size_m = [0.4 ~ size_m = [0 ~ occluder[2].block.size_m[0] ~ > 0 ~ 0
rpy_deg = [0, 0, 30] ~ quaternion_wxyz = [2, 0, 0, 0] ~ occluder[2].block.quaternion_wxyz ~ a unit quaternion ~ norm 2
id = "crate" ~ id = "cable" ~ occluder[2].id ~ a name that nothing else has ~ "cable" again
id = "crate" ~ id = "a/b" ~ occluder[2].id ~ letters, digits ~ "a/b"
centre_m = [1.5, 0.2, -1] ~ centre_m = [0.05, 0.5, -1] ~ occluder[0] ~ no camera and no lamp inside it ~ the right camera inside "ball"
centre_m = [3, 1, -0.3] ~ centre_m = [0.1, 0.9, -1.35] ~ occluder[2] ~ no camera and no lamp ~ lamp[1] inside "crate"
wavelength_m = 0.1 ~ wavelength_m = 0.05 ~ seabed.ripples.height_m ~ a quarter of the wavelength ~ 0.015
heading_deg = 20 ~ heading_deg = 400 ~ seabed.ripples.heading_deg ~ within -360 to 360 ~ 400
stones_per_m2 = 4 ~ stones_per_m2 = 1e6 ~ seabed.clutter.stones_per_m2 ~ 300000 stones ~ 1000000
diameter_m = [0.03, 0.2] ~ diameter_m = [0.3, 0.2] ~ seabed.clutter.diameter_m[1] ~ between diameter_m[0] (0.3) ~ 0.2
albedo = [0.3, 0.3, 0.3] ~ albedo = [0.3, 0.9, 0.3] ~ seabed.clutter.albedo ~ at most 2/3 ~ [0.3, 0.9, 0.3]
"#;

#[test]
fn every_number_is_checked_and_named() {
    for case in BROKEN.trim().lines() {
        let columns: Vec<&str> = case.split(" ~ ").collect();
        let [old, new, said @ ..] = columns.as_slice() else {
            panic!("{case}");
        };
        let piece = [SURFACE, OCCLUDERS, FLOOR]
            .into_iter()
            .find(|piece| piece.contains(old));
        let message = with(&piece.expect(old).replacen(old, new, 1)).expect_err(case);
        for part in said {
            assert!(
                message.contains(part),
                "{new}\n  said: {message}\n  without: {part}"
            );
        }
    }
}

#[test]
fn a_surface_that_shines_by_itself_takes_no_colour() {
    let (path, text) = paper();
    let flat = text.replacen(
        "albedo = [0.90, 0.30, 0.04]",
        "flat_radiance_w_per_m2_sr = [1, 1, 1]",
        1,
    );
    let flat = flat.replacen("[seabed]", &format!("{SURFACE}\n[seabed]"), 1);
    let message = Scene::from_toml(&flat, &path).unwrap_err().to_string();
    assert!(
        message.contains("rod[0].surface: expected albedo instead of"),
        "{message}"
    );
}

/// A triangle, as often as asked for.
fn plate(triangles: usize) -> Mesh {
    Mesh {
        parts: vec![MeshPart {
            positions_m: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]; triangles],
            ..MeshPart::default()
        }],
        materials: vec![MeshMaterial {
            name: String::new(),
            base: [0.5; 3],
            metallic: 0.0,
            roughness: 1.0,
            texture: None,
        }],
        ..Mesh::default()
    }
}

/// One file many times over: 500 plates of 20 000 triangles are ten million, and the next is too many.
#[test]
fn triangles_of_all_props_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plate.glb"), plate(20_000).to_glb()).unwrap();
    let prop =
        |k| format!("[[prop]]\nid = \"p{k}\"\nfile = \"plate.glb\"\nposition_m = [3, 0, -1]\n");
    let props: Vec<String> = (0..=500).map(prop).collect();
    let text = paper()
        .1
        .replacen("[seabed]", &(props.concat() + "[seabed]"), 1);
    let error = Scene::from_toml(&text, &folder.path().join("paper.toml")).unwrap_err();
    let expected = "prop[500].file: expected at most 10000000 triangles in all props up to this one, found 10020000";
    assert!(error.to_string().contains(expected), "{error}");
}

#[test]
fn props_are_read_beside_the_scene_and_written_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = plate(1);
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    std::fs::write(folder.path().join("meshes/plate.glb"), mesh.to_glb()).unwrap();
    let prop = |id: &str| {
        format!(
            "[[prop]]\nid = \"{id}\"\nfile = \"meshes/plate.glb\"\nposition_m = [3, 0, -1]\nrpy_deg = [1, 2, 3]\nscale = 0.5\n"
        )
    };
    let text = paper().1.replacen(
        "[seabed]",
        &format!("{}{}[seabed]", prop("a"), prop("b")),
        1,
    );
    let path = folder.path().join("paper.toml");
    let scene = Scene::from_toml(&text, &path).unwrap();
    assert_eq!(*scene.props[1].mesh, mesh);
    assert!(
        std::sync::Arc::ptr_eq(&scene.props[0].mesh, &scene.props[1].mesh),
        "one file is read once"
    );
    assert_eq!(scene.prop_instance(1), 4);

    let written = SceneFile::from_scene(&scene).to_toml();
    std::fs::create_dir(folder.path().join("props")).unwrap();
    for prop in &scene.props {
        std::fs::write(folder.path().join(prop.written_file()), prop.mesh.to_glb()).unwrap();
    }
    let again = Scene::from_toml(&written, &path).unwrap();
    assert_eq!(format!("{scene:?}"), format!("{again:?}"));

    let message = Scene::from_toml(&text.replace("plate.glb", "plat.glb"), &path).unwrap_err();
    assert!(
        message
            .to_string()
            .contains("meshes/plat.glb: No such file"),
        "{message}"
    );
    let message = Scene::from_toml(&text.replace("scale = 0.5", "scale = -1"), &path).unwrap_err();
    assert!(
        message.to_string().contains("prop[0].scale: expected > 0"),
        "{message}"
    );
}
