//! Scenes that `--example rendered` draws: by seed alone, and true where they are looked at without a solver.

#[path = "../examples/asked/mod.rs"]
mod asked;
#[path = "../examples/rendered/scenes/mod.rs"]
mod scenes;

use asked::answer::Answer;
use rodsight_geometry::{Cylinder, Eye, Image, Pixel, Rig, Samples, StereoPair};
use rodsight_render::{CpuRenderer, Renderer, srgb_decode};
use rodsight_scene::{Exposure, Lens, Material, Mode, SensorEntry};
use rodsight_solver::{Method, Status};
use scenes::draft::{Draft, Trial};
use scenes::{looks, ports};

fn trial(seed: u64, change: impl FnOnce(&mut Draft)) -> Trial {
    let mut draft = Draft::new(seed);
    change(&mut draft);
    draft.finish().expect("a scene whose rod is in both images")
}

fn shot(trial: &Trial) -> scenes::shot::Shot {
    trial.shoot().expect("a scene that can be rendered")
}

#[test]
fn seed_alone_makes_the_pair() {
    let images = |seed| {
        let pair = shot(&trial(seed, |_| ())).pair;
        [pair.left, pair.right]
    };
    let [left, right] = images(3);
    assert_eq!([&left, &right], images(3).each_ref());
    let [other_left, other_right] = images(4);
    assert!(left != other_left && right != other_right);
}

/// Drawn for one aspect, a scene stays what it was in all others.
#[test]
fn one_aspect_changes_alone() {
    let plain = Draft::new(5).file;
    let mut draft = Draft::new(5);
    looks::surface(&mut draft, "striped");
    assert!(
        draft.file.rod[0]
            .surface
            .is_some_and(|surface| surface.stripes.is_some())
    );
    draft.file.rod[0].surface = plain.rod[0].surface;
    assert_eq!(draft.file, plain);
}

#[test]
fn rods_are_in_both_images() {
    for seed in [0, 1, 2] {
        // Of the four limbs: none is known where one is not seen.
        let contrast = shot(&trial(seed, |_| ())).contrast_to_noise;
        assert!(
            contrast.is_some_and(|contrast| contrast > 1.0),
            "{contrast:?}"
        );
    }
    // A rod that only one eye sees is none of these scenes.
    let mut draft = Draft::new(0);
    draft.file.rod[0].centre_m = Some([2.0, -1.4, -1.0]);
    assert!(draft.finish().is_none());
}

/// What is rendered through a window is what the whole image has there: the samples of a pixel at an edge lie elsewhere, and the
/// water's light is interpolated between other places, but no more; at the border the lens blurs what is inside alone. A window that is a pixel aside is found out.
#[test]
fn windows_show_what_the_whole_image_shows() {
    const MARGIN_PX: u32 = 5;
    let mut trial = trial(1, |draft| draft.file.sensor = SensorEntry::default());
    trial.scene.exposure = Exposure::Fixed(20.0);
    let whole = CpuRenderer
        .shoot(&trial.scene, &|_| ())
        .expect("a scene that can be rendered");
    let pair = shot(&trial).pair;
    for (eye, part) in [(Eye::Left, &pair.left), (Eye::Right, &pair.right)] {
        let (Samples::U8(part), Samples::U8(whole)) = (part.samples(), whole.eye(eye).samples())
        else {
            panic!("8 bits");
        };
        let region = trial.regions[eye as usize];
        let width = 1920;
        let differ = |aside: usize| {
            let rows = region.y_px + MARGIN_PX..region.y_px + region.height_px - MARGIN_PX;
            let differ = rows.flat_map(|y| {
                let from = 3 * (y as usize * width + (region.x_px + MARGIN_PX) as usize);
                let to = from + 3 * (region.width_px - 2 * MARGIN_PX) as usize;
                part[from..to]
                    .iter()
                    .zip(&whole[from - 3 * aside..])
                    .map(|(a, b)| a.abs_diff(*b))
            });
            let by_more = differ.filter(|codes| *codes > 2).count();
            by_more as f64 / f64::from(3 * region.width_px * region.height_px)
        };
        let (here, aside) = (differ(0), differ(1));
        assert!(here < 1e-3, "{eye:?}: {here}");
        assert!(aside > 2e-2, "{eye:?}: {aside}");
    }
}

/// Linear brightness of the pixel that a place is in.
fn green(image: &Image, at: &Pixel) -> f64 {
    let Samples::U8(samples) = image.samples() else {
        panic!("8 bits");
    };
    let pixel = at.y as usize * image.width_px() as usize + at.x as usize;
    srgb_decode(f64::from(samples[3 * pixel + 1]) / 255.0)
}

/// How far outside of the two limbs of a cylinder the image has its edges, px: how much of a stretch across the limb the rod covers by
/// its brightness, more than half of it; mean over many places. `shift_px` takes other limbs, so much farther out.
fn wider_px(pair: &StereoPair, rig: &Rig, eye: Eye, rod: &Cylinder, shift_px: f64) -> [f64; 2] {
    const REACH_PX: f64 = 8.0;
    const STEP_PX: f64 = 0.05;
    let mounted = rig.eye(eye);
    let image = match eye {
        Eye::Left => &pair.left,
        Eye::Right => &pair.right,
    };
    let lines = rod
        .image_lines(&mounted.camera, &mounted.rig_from_camera)
        .expect("limbs");
    let mut off_px = [0.0; 2];
    let places = 200;
    for k in 0..places {
        let along_m = (f64::from(k) / f64::from(places) - 0.5) * 0.5;
        let axis = mounted
            .project(&(rod.axis.point_m + rod.axis.direction * along_m))
            .expect("ahead");
        for (off_px, line) in off_px.iter_mut().zip(&lines[..2]) {
            let away = line.distance_px(&axis);
            let outwards = line.normal() * -away.signum();
            let limb = axis + outwards * away.abs() + outwards * shift_px;
            let at = |x_px: f64| green(image, &(limb + outwards * x_px));
            let (inside, outside) = (at(-REACH_PX), at(REACH_PX));
            let steps = (2.0 * REACH_PX / STEP_PX) as i32;
            let covered: f64 = (0..steps)
                .map(|k| at((f64::from(k) + 0.5) * STEP_PX - REACH_PX))
                .map(|value| (value - outside) / (inside - outside) * STEP_PX)
                .sum();
            *off_px += (covered - REACH_PX) / f64::from(places);
        }
    }
    off_px
}

/// The limbs by formula are where the picture has them: of rods of one brightness, without noise. Rounding to 8 bits and the steps of
/// the stretch leave less than 0.02 px; limbs that are 0.05 px aside are found out.
#[test]
fn limbs_by_formula_are_where_the_picture_shows_them() {
    for seed in [0, 1, 2] {
        let mut trial = trial(seed, |draft| {
            draft.file.mode = Mode::Air;
            draft.file.seabed = None;
            draft.file.lens = Lens::default();
            draft.file.sensor = SensorEntry::default();
        });
        trial.scene.rods[0].material = Material::Flat([1.0; 3]);
        trial.scene.background_radiance = [0.5; 3];
        let shot = shot(&trial);
        for eye in Eye::BOTH {
            let wider = |shift| wider_px(&shot.pair, &trial.scene.rig, eye, &shot.target, shift);
            let (right, wrong) = (wider(0.0), wider(0.05));
            for off_px in right {
                assert!(off_px.abs() < 0.02, "seed {seed}, {eye:?}: {right:?}");
            }
            for off_px in wrong {
                assert!(off_px < -0.03, "seed {seed}, {eye:?}: {wrong:?}");
            }
        }
    }
}

/// The same pictures, and two beliefs about the cameras: with the ports the rod is where it is, without it is somewhere else.
#[test]
fn ports_matter_to_who_ignores_them() {
    let seen = |name| trial(3, |draft| ports::port(draft, name));
    let (known, ignored) = (seen("ports"), seen("focal length"));
    let (known_shot, ignored_shot) = (shot(&known), shot(&ignored));
    assert_eq!(known_shot.pair.left, ignored_shot.pair.left);
    assert_ne!(known_shot.pair.rig, ignored_shot.pair.rig);
    let off_mm = |trial: &Trial, shot: &scenes::shot::Shot| {
        let answer = Answer::of(
            3,
            &trial.asked,
            Some(&shot.target),
            &shot.pair,
            Method::Joint,
        )
        .expect("a request that makes sense");
        assert_ne!(answer.status(), Status::Refused);
        answer.offset_mm().expect("an axis")
    };
    let (known_mm, ignored_mm) = (off_mm(&known, &known_shot), off_mm(&ignored, &ignored_shot));
    assert!(
        known_mm < 1.0 && ignored_mm > 10.0,
        "{known_mm} mm, {ignored_mm} mm"
    );
}
