//! Every scene in `scenes/` loads and is what its comments say.

use std::path::PathBuf;

use rodsight_geometry::{Eye, Rig, Vec3, angle_between};
use rodsight_scene::{Scene, SceneFile};

fn scenes_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn shipped() -> Vec<(PathBuf, Scene)> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(scenes_dir())
        .expect("scenes/ is part of the repository")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    paths.sort();
    paths
        .into_iter()
        .map(|path| {
            let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
            (path, scene)
        })
        .collect()
}

fn scene(id: &str) -> Scene {
    Scene::load(&scenes_dir().join(format!("{id}.toml"))).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn shipped_scenes_load_under_their_own_name_with_the_grasp_in_both_images() {
    let scenes = shipped();
    assert!(scenes.len() >= 7, "found {}", scenes.len());
    for (path, scene) in scenes {
        assert_eq!(path.file_stem().unwrap(), scene.id.as_str());
        let (grasp_m, _) = scene.rods[scene.target.rod].axis_at(scene.target.along_m);
        for eye in Eye::BOTH {
            let mounted = scene.rig.eye(eye);
            let pixel = mounted.project(&grasp_m).unwrap();
            let (u, v) = (pixel.x, pixel.y);
            assert!(
                (50.0..1870.0).contains(&u) && (50.0..1030.0).contains(&v),
                "{} {}: ({u:.1}, {v:.1})",
                scene.id,
                eye.name()
            );
        }
    }
}

#[test]
fn shipped_scenes_come_back_from_their_resolved_file_to_the_last_bit() {
    for (_, scene) in shipped() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("props")).unwrap();
        for prop in &scene.props {
            let file = folder.path().join(format!("props/{}.glb", prop.id));
            std::fs::write(file, prop.mesh.to_glb()).unwrap();
        }
        let (text, path) = (
            SceneFile::from_scene(&scene).to_toml(),
            folder.path().join("scene.toml"),
        );
        let again =
            Scene::from_toml(&text, &path).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(format!("{scene:?}"), format!("{again:?}"));
    }
}

#[test]
fn paper_scene_shows_the_golden_grasp_pixels() {
    let scene = scene("paper");
    assert_eq!(
        scene.rig,
        Rig::load(&scenes_dir().join("rigs/paper.toml")).unwrap()
    );
    let (grasp_m, direction) = scene.rods[0].axis_at(scene.target.along_m);
    assert!((grasp_m - Vec3::new(2.26, -0.4, -0.86)).norm() < 1e-15);
    assert!(angle_between(&direction, &Vec3::new(-0.023, 0.029, 0.111)) < 1e-15);
    for (eye, u_px) in [(Eye::Left, 1029.317594), (Eye::Right, 336.141656)] {
        let pixel = scene.rig.eye(eye).project(&grasp_m).unwrap();
        assert!(
            (pixel.x - u_px).abs() < 1e-5 && (pixel.y - 637.044631).abs() < 1e-5,
            "{pixel}"
        );
    }
    let rod = &scene.rods[0];
    let seabed_m = scene.seabed.unwrap().z_m;
    assert!(
        rod.axis_at(0.5 * rod.length_m).0.z > seabed_m,
        "the cable reaches the sand"
    );
    assert_eq!(scene.water_label, "IB");
}

#[test]
fn special_scenes_are_what_they_are_called() {
    let parallel = scene("parallel_to_baseline");
    assert!(angle_between(&parallel.rods[0].direction, &parallel.rig.baseline()) < 1e-12);
    for eye in Eye::BOTH {
        for end in [-0.5, 0.5] {
            let tip = parallel.rods[0].axis_at(end * parallel.rods[0].length_m).0;
            let mounted = parallel.rig.eye(eye);
            assert!(!mounted.camera.contains(&mounted.project(&tip).unwrap()));
        }
    }
    let bent = scene("bent_cable");
    let sagitta_m = bent.rods[0].bend.unwrap().sagitta_m;
    assert!((sagitta_m / bent.rods[0].length_m - 0.03).abs() < 1e-12);
    assert_eq!(scene("thick_pipe").rods[0].radius_m, 0.25);

    let crossing = scene("crossing_rods");
    let [near, far] = [&crossing.rods[0], &crossing.rods[1]];
    assert_eq!(crossing.target.rod, 0);
    for eye in Eye::BOTH {
        let mounted = crossing.rig.eye(eye);
        let ends = [near, far].map(|rod| {
            [-0.5, 0.5].map(|s| mounted.project(&rod.axis_at(s * rod.length_m).0).unwrap())
        });
        // The images of two segments cross where the ends of each lie on both sides of the other.
        let side = |line: [_; 2], p| {
            let [a, b]: [rodsight_geometry::Pixel; 2] = line;
            let p: rodsight_geometry::Pixel = p;
            (b - a).perp(&(p - a)).signum()
        };
        assert!(side(ends[0], ends[1][0]) != side(ends[0], ends[1][1]));
        assert!(side(ends[1], ends[0][0]) != side(ends[1], ends[0][1]));
    }
    assert!(near.centre_m.x < far.centre_m.x);

    let pipe = scene("pipe_over_sand");
    let clearance_m = pipe.seabed.unwrap().z_m - pipe.rods[0].centre_m.z - pipe.rods[0].radius_m;
    assert!((clearance_m - 0.02).abs() < 1e-12);
}
