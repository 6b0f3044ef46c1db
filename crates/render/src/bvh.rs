//! A tree of boxes over what rays can hit: rods' pieces, triangles.
//!
//! The tree is built by `obvhs`; what is kept is flat and small enough to be sent to a graphics card as it is. Boxes are `f32`,
//! rounded outwards: they only ever say "look closer".

use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use rodsight_geometry::Vec3;

use crate::cpu::solid::Ray;

/// A node: `count` primitives from `first` on in [`Bvh::order`], or, where `count` is 0, the two nodes `first` and `first + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) min_m: [f32; 3],
    pub(crate) first: u32,
    pub(crate) max_m: [f32; 3],
    pub(crate) count: u32,
}

/// An axis-aligned box, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min_m: Vec3,
    pub(crate) max_m: Vec3,
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(
            self.min_m.map(|v| (v as f32).next_down()).data.0[0].into(),
            self.max_m.map(|v| (v as f32).next_up()).data.0[0].into(),
        )
    }
}

/// A tree over primitives that are somebody else's: it knows their boxes and numbers only.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    /// The root first; empty if there is nothing.
    pub(crate) nodes: Vec<Node>,
    /// Numbers of the primitives, as the leaves name them.
    pub(crate) order: Vec<u32>,
    depth: usize,
}

impl Bvh {
    pub(crate) fn new(boxes: &[Bounds]) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let mut time_spent = core::time::Duration::ZERO;
        let tree = build_bvh2(boxes, BvhBuildParams::medium_build(), &mut time_spent);
        let nodes: Vec<Node> = tree
            .nodes
            .iter()
            .map(|node| Node {
                min_m: node.aabb.min.to_array(),
                first: node.first_index,
                max_m: node.aabb.max.to_array(),
                count: node.prim_count,
            })
            .collect();
        Self {
            depth: depth(&nodes),
            nodes,
            order: tree.primitive_indices,
        }
    }

    /// Visits the primitives whose boxes, grown by `margin_rad` times their distance, the ray meets within `limit_m`, roughly near
    /// ones first. `visit` returns the limit from there on.
    pub(crate) fn visit(
        &self,
        ray: &Ray,
        margin_rad: f64,
        limit_m: f64,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        // A stack for the deepest tree would cost most rays more than their walk, and a single box more than what is in it.
        match self.depth {
            0 | 1 => {
                for &primitive in &self.order {
                    visit(primitive as usize);
                }
            }
            2..32 => self.walk(&mut [(0, 0.0); 32], ray, margin_rad, limit_m, visit),
            depth => self.walk(
                &mut vec![(0, 0.0); depth + 1],
                ray,
                margin_rad,
                limit_m,
                visit,
            ),
        }
    }

    fn walk(
        &self,
        stack: &mut [(u32, f64)],
        ray: &Ray,
        margin_rad: f64,
        mut limit_m: f64,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        let Some(root) = self.nodes.first() else {
            return;
        };
        let slabs = Slabs::new(ray, margin_rad);
        stack[0] = (0, slabs.enter_m(root));
        let mut height = usize::from(stack[0].1 < f64::INFINITY);
        while height > 0 {
            height -= 1;
            let (index, enter_m) = stack[height];
            if enter_m > limit_m {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                let leaf = node.first as usize..(node.first + node.count) as usize;
                for &primitive in &self.order[leaf] {
                    limit_m = visit(primitive as usize);
                }
                continue;
            }
            let (one, two) = (node.first, node.first + 1);
            let one_m = slabs.enter_m(&self.nodes[one as usize]);
            let two_m = slabs.enter_m(&self.nodes[two as usize]);
            let (near, far) = if one_m <= two_m {
                ((one, one_m), (two, two_m))
            } else {
                ((two, two_m), (one, one_m))
            };
            for child in [far, near] {
                if child.1 < f64::INFINITY {
                    stack[height] = child;
                    height += 1;
                }
            }
        }
    }
}

/// A ray made ready for slab tests.
pub(crate) struct Slabs {
    origin_m: [f64; 3],
    per_direction: [f64; 3],
    margin_rad: f64,
}

impl Slabs {
    pub(crate) fn new(ray: &Ray, margin_rad: f64) -> Self {
        Self {
            origin_m: ray.origin_m.into(),
            per_direction: ray.direction.map(|v| 1.0 / v).into(),
            margin_rad,
        }
    }

    /// Where the ray enters a node's box, 0 from inside; +∞ if it misses.
    #[expect(clippy::inline_always, reason = "called, it took a third of a render")]
    #[inline(always)]
    pub(crate) fn enter_m(&self, node: &Node) -> f64 {
        let (mut enter, mut leave) = (0.0, f64::INFINITY);
        let margin_m = if self.margin_rad > 0.0 {
            self.margin_rad * self.farthest_m(node)
        } else {
            0.0
        };
        for axis in 0..3 {
            let (origin, per_direction) = (self.origin_m[axis], self.per_direction[axis]);
            let low = (f64::from(node.min_m[axis]) - margin_m - origin) * per_direction;
            let high = (f64::from(node.max_m[axis]) + margin_m - origin) * per_direction;
            // One instruction each, unlike `min` and `max`. 0 · ∞ on a face of the box is NaN, which is passed over.
            let (near, far) = if low < high { (low, high) } else { (high, low) };
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        if enter <= leave { enter } else { f64::INFINITY }
    }

    /// No point of the box is farther from the ray's origin.
    fn farthest_m(&self, node: &Node) -> f64 {
        let reach = |axis: usize| {
            let (low, high) = (f64::from(node.min_m[axis]), f64::from(node.max_m[axis]));
            (low - self.origin_m[axis])
                .abs()
                .max((high - self.origin_m[axis]).abs())
        };
        Vec3::new(reach(0), reach(1), reach(2)).norm()
    }
}

/// Nodes on the longest way from the root to a leaf. Children come after their parents' turn, so the walk needs no recursion.
fn depth(nodes: &[Node]) -> usize {
    let mut stack = vec![(0_u32, 1_usize)];
    let mut deepest = 0;
    while let Some((index, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &nodes[index as usize];
        if node.count == 0 {
            stack.extend([(node.first, level + 1), (node.first + 1, level + 1)]);
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Philox;

    fn numbers(i: u32) -> [f64; 4] {
        Philox::new(5).uniforms([i, 0, 0, 0]).map(|v| 2.0 * v - 1.0)
    }

    /// Every box that a fine march along the ray finds is visited, whatever the order of the tree.
    #[test]
    fn visits_every_box_on_the_ray() {
        let boxes: Vec<Bounds> = (0..300)
            .map(|i| {
                let [x, y, z, size] = numbers(i);
                let centre = Vec3::new(x, y, z) * 3.0;
                let half = Vec3::repeat(0.05 + 0.1 * (size + 1.0));
                Bounds {
                    min_m: centre - half,
                    max_m: centre + half,
                }
            })
            .collect();
        let tree = Bvh::new(&boxes);
        let mut met = 0;
        for i in 0..200 {
            let ([a, b, c, _], [d, e, f, _]) = (numbers(1000 + i), numbers(2000 + i));
            let ray = Ray {
                origin_m: Vec3::new(a, b, c) * 4.0,
                // Along an axis now and then: the slabs then divide by zero.
                direction: if i % 10 == 0 {
                    Vec3::x()
                } else {
                    Vec3::new(d, e, f).normalize()
                },
            };
            let mut visited = vec![false; boxes.len()];
            tree.visit(&ray, 0.0, f64::INFINITY, |index| {
                visited[index] = true;
                f64::INFINITY
            });
            for step in 0..4000 {
                let point = ray.at(f64::from(step) * 2.5e-3);
                for (index, it) in boxes.iter().enumerate() {
                    let inside = (0..3).all(|k| it.min_m[k] <= point[k] && point[k] <= it.max_m[k]);
                    assert!(!inside || visited[index], "ray {i} box {index}");
                    met += u32::from(inside);
                }
            }
        }
        assert!(met > 5_000, "{met}");
    }

    #[test]
    fn margin_grows_with_distance_and_the_limit_ends_the_walk() {
        let at = |x: f64, y: f64| Bounds {
            min_m: Vec3::new(x, y, -0.1),
            max_m: Vec3::new(x + 0.1, y + 0.1, 0.1),
        };
        let tree = Bvh::new(&[at(1.0, 0.0), at(10.0, 0.05), at(10.0, 0.4)]);
        let ray = Ray {
            origin_m: Vec3::zeros(),
            direction: Vec3::x(),
        };
        let seen = |margin_rad: f64, limit_m: f64| {
            let mut seen = Vec::new();
            tree.visit(&ray, margin_rad, limit_m, |index| {
                seen.push(index);
                limit_m
            });
            seen.sort_unstable();
            seen
        };
        assert_eq!(seen(0.0, f64::INFINITY), [0]);
        assert_eq!(seen(0.006, f64::INFINITY), [0, 1]);
        assert_eq!(seen(0.041, f64::INFINITY), [0, 1, 2]);
        assert_eq!(seen(0.041, 5.0), [0]);
        Bvh::new(&[]).visit(&ray, 0.0, 1.0, |_| unreachable!("nothing to visit"));
    }

    /// Boxes that double in size make the most lopsided tree: the walk must not run out of stack.
    #[test]
    fn lopsided_trees_are_walked_whole() {
        let boxes: Vec<Bounds> = (0..120)
            .map(|i| {
                let x = libm::exp2(f64::from(i)) * 1e-18;
                Bounds {
                    min_m: Vec3::new(x, -1.0, -1.0),
                    max_m: Vec3::new(1.1 * x, 1.0, 1.0),
                }
            })
            .collect();
        let mut count = 0;
        let ray = Ray {
            origin_m: Vec3::new(-1.0, 0.0, 0.0),
            direction: Vec3::x(),
        };
        Bvh::new(&boxes).visit(&ray, 0.0, f64::INFINITY, |_| {
            count += 1;
            f64::INFINITY
        });
        assert_eq!(count, boxes.len());
    }
}
