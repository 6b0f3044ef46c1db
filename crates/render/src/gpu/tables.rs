//! Tables that hang on the water, the lamps and a camera alone: kept, as the pairs of a set share them.

use std::sync::{Arc, Mutex, PoisonError};

use rodsight_geometry::MountedCamera;
use rodsight_optics::{Halo, Medium};
use rodsight_scene::{Lamp, Mode};

use crate::cpu::airlight_grid::AirlightGrid;
use crate::cpu::overscan::middle_px_per_rad;
use crate::cpu::world::World;

/// As many as two rigs take whose ports part three bands.
const KEPT: usize = 12;

/// The tables of a camera.
#[derive(Debug)]
pub(super) struct Tables {
    pub(super) airlight: AirlightGrid,
    /// In mode `full`.
    pub(super) halo: Option<Halo>,
}

/// All that they hang on.
#[derive(Debug, PartialEq)]
struct Key {
    mode: Mode,
    medium: Medium,
    lamps: Vec<Lamp>,
    mounted: MountedCamera,
}

/// The tables that were asked for last.
#[derive(Debug, Default)]
pub(super) struct TableCache(Mutex<Vec<(Key, Arc<Tables>)>>);

impl TableCache {
    pub(super) fn of(&self, world: &World<'_>, mounted: &MountedCamera) -> Arc<Tables> {
        let scene = world.scene;
        let key = Key {
            mode: scene.mode,
            medium: scene.medium.clone(),
            lamps: scene.lamps.clone(),
            mounted: *mounted,
        };
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, tables)) = known().iter().find(|(other, _)| *other == key) {
            return Arc::clone(tables);
        }
        let tables = Arc::new(Tables {
            airlight: AirlightGrid::new(world, mounted),
            halo: (scene.mode == Mode::Full)
                .then(|| Halo::new(&scene.medium, middle_px_per_rad(mounted))),
        });
        let mut known = known();
        if known.len() == KEPT {
            known.remove(0);
        }
        known.push((key, Arc::clone(&tables)));
        tables
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rodsight_geometry::Eye;
    use rodsight_scene::Scene;

    use super::*;

    #[test]
    fn tables_are_kept_for_what_they_hang_on_and_made_anew_for_anything_else() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let scene = Scene::load(&folder.join("paper.toml")).unwrap();
        let cache = TableCache::default();
        let of = |scene: &Scene, eye| cache.of(&World::new(scene), scene.rig.eye(eye));
        let first = of(&scene, Eye::Left);
        let mut moved = scene.clone();
        moved.rods[0].centre_m.z += 0.1;
        assert!(
            Arc::ptr_eq(&first, &of(&moved, Eye::Left)),
            "rods have no part in it"
        );
        assert!(!Arc::ptr_eq(&first, &of(&scene, Eye::Right)));
        let mut brighter = scene.clone();
        brighter.lamps[0].radiant_intensity_w_per_sr[1] *= 1.5;
        let second = of(&brighter, Eye::Left);
        assert!(first.airlight.knots != second.airlight.knots);
        let mut full = scene.clone();
        full.mode = Mode::Full;
        assert!(first.halo.is_none() && of(&full, Eye::Left).halo.is_some());
        for k in 0..KEPT {
            brighter.lamps[0].radiant_intensity_w_per_sr[1] += k as f64 + 1.0;
            of(&brighter, Eye::Left);
        }
        let again = of(&scene, Eye::Left);
        assert!(!Arc::ptr_eq(&first, &again), "few are kept");
        assert!(first.airlight.knots == again.airlight.knots);
    }
}
