//! All that is neither rod nor seabed: growth, stones, occluders, props.

use rodsight_geometry::{Mat3, Vec3};
use rodsight_optics::Bands;
use rodsight_scene::{Scene, Shape};

use super::lump::Lump;
use super::solid::{Capped, Ray, SolidHit};
use super::triangles::{Triangles, scaled};
use super::world::Thing;
use crate::bvh::{Bounds, Bvh};
use crate::strew;

/// A convex solid that belongs to something.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) solid: Solid,
    pub(crate) thing: Thing,
    /// Solids that pass smoothly into each other have the same.
    pub(crate) part: u32,
    pub(crate) albedo: Bands,
}

/// A convex solid.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    Lump(Lump),
    Capped(Capped),
}

impl Solid {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Lump(lump) => lump.bounds(),
            Self::Capped(capped) => capped.bounds(),
        }
    }

    #[inline]
    fn hit(&self, ray: &Ray) -> Option<SolidHit> {
        match self {
            Self::Lump(lump) => lump.hit(ray),
            Self::Capped(capped) => capped.hit(ray),
        }
    }
}

/// Everything but rods and seabed, ready to be hit.
#[derive(Clone, Debug)]
pub(crate) struct Bodies {
    pub(crate) solids: Vec<Body>,
    pub(crate) tree: Bvh,
    pub(crate) triangles: Triangles,
}

impl Bodies {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut solids = Vec::new();
        let mut add = |solid: Solid, thing: Thing, part: u32, albedo: Bands| {
            solids.push(Body {
                solid,
                thing,
                part,
                albedo,
            });
        };
        for (index, occluder) in scene.occluders.iter().enumerate() {
            for solid in pieces(&occluder.shape) {
                add(solid, Thing::Occluder(index), 0, occluder.albedo);
            }
        }
        let growth = (0..scene.rods.len()).flat_map(|rod| {
            strew::growth(scene, rod)
                .into_iter()
                .map(move |lump| (Thing::Growth(rod), lump))
        });
        let stones = strew::stones(scene)
            .into_iter()
            .map(|lump| (Thing::Stones, lump));
        for (part, (thing, lump)) in growth.chain(stones).enumerate() {
            let ball = Lump::new(lump.centre_m, &lump.axes_m, false);
            add(Solid::Lump(ball), thing, part as u32, lump.albedo);
        }
        let boxes: Vec<Bounds> = solids.iter().map(|body| body.solid.bounds()).collect();
        Self {
            tree: Bvh::new(&boxes),
            solids,
            triangles: Triangles::new(&scene.props),
        }
    }

    /// The first solid on the ray and where; of two at the very same distance the one that comes first, whatever the tree.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<(usize, SolidHit)> {
        let mut first: Option<(usize, SolidHit)> = None;
        self.tree.visit(ray, 0.0, f64::INFINITY, |index| {
            if let Some(hit) = self.solids[index].solid.hit(ray)
                && first
                    .is_none_or(|(there, f)| hit.t_m < f.t_m || (hit.t_m == f.t_m && index < there))
            {
                first = Some((index, hit));
            }
            first.map_or(f64::INFINITY, |(_, f)| f.t_m)
        });
        first
    }

    /// Where a ray first meets what grows on a rod, whatever else there is.
    pub(crate) fn growth(&self, ray: &Ray, rod: usize) -> Option<f64> {
        let mut first_m = f64::INFINITY;
        self.tree.visit(ray, 0.0, f64::INFINITY, |index| {
            let body = &self.solids[index];
            if body.thing == Thing::Growth(rod)
                && let Some(hit) = body.solid.hit(ray)
            {
                first_m = first_m.min(hit.t_m);
            }
            first_m
        });
        first_m.is_finite().then_some(first_m)
    }

    /// Height of the highest lump on a rod over its surface, m.
    pub(crate) fn tallest_m(&self, rod: usize) -> f64 {
        let lumps = self
            .solids
            .iter()
            .filter(|body| body.thing == Thing::Growth(rod));
        lumps.fold(0.0, |most: f64, body| match &body.solid {
            // Lumps are centred on the surface, and lower than wide.
            Solid::Lump(lump) => most.max(lump.shortest_m),
            Solid::Capped(_) => most,
        })
    }

    /// Whether the first `length_m` of the ray meet any of it.
    pub(crate) fn block(&self, ray: &Ray, length_m: f64) -> bool {
        let mut blocked = false;
        self.tree.visit(ray, 0.0, length_m, |index| {
            let hit = self.solids[index].solid.hit(ray);
            blocked = blocked || hit.is_some_and(|hit| hit.t_m < length_m);
            if blocked { f64::NEG_INFINITY } else { length_m }
        });
        blocked || self.triangles.block(ray, length_m)
    }
}

/// The convex solids of an occluder.
fn pieces(shape: &Shape) -> Vec<Solid> {
    let ball = |centre_m: Vec3, radius_m: f64| {
        Solid::Lump(Lump::new(centre_m, &(Mat3::identity() * radius_m), false))
    };
    match *shape {
        Shape::Sphere { centre_m, radius_m } => vec![ball(centre_m, radius_m)],
        Shape::Capsule {
            from_m,
            to_m,
            radius_m,
        } => {
            let axis = to_m - from_m;
            let (middle_m, half_m) = ((from_m + to_m) * 0.5, 0.5 * axis.norm());
            let side = Capped::new(middle_m, axis.normalize(), half_m, radius_m);
            vec![
                Solid::Capped(side),
                ball(from_m, radius_m),
                ball(to_m, radius_m),
            ]
        }
        Shape::Block {
            centre_m,
            half_m,
            rotation,
        } => vec![Solid::Lump(Lump::new(
            centre_m,
            &scaled(&rotation, &half_m),
            true,
        ))],
    }
}
