//! Solids as triangles, all wound so that their front is outside.

use core::f64::consts::TAU;

use rodsight_geometry::Vec3;
use rodsight_scene::MeshPart;

/// Triangles of one material as they are gathered.
#[derive(Debug, Default)]
pub(crate) struct Solids(MeshPart);

impl Solids {
    pub(crate) fn part(self, material: usize) -> MeshPart {
        MeshPart { material, ..self.0 }
    }

    fn vertex(&mut self, position_m: Vec3, normal: Vec3, uv: Option<[f64; 2]>) -> u32 {
        let single = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
        self.0.positions_m.push(single(position_m));
        self.0.normals.push(single(normal));
        self.0.uvs.extend(uv.map(|uv| uv.map(|v| v as f32)));
        self.0.positions_m.len() as u32 - 1
    }

    /// A flat four-sided face; corners go round clockwise seen from behind. With texture coordinates, the first corner is the
    /// image's top left.
    fn quad(&mut self, corners_m: [Vec3; 4], textured: bool) {
        let [a, b, _, d] = corners_m;
        let normal = (b - a).cross(&(d - a)).normalize();
        let uv = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        let [a, b, c, d] =
            core::array::from_fn(|k| self.vertex(corners_m[k], normal, textured.then_some(uv[k])));
        self.0.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// A box along the axes. `textured`: each face shows the whole image, upright on those at the sides.
    pub(crate) fn block(&mut self, centre_m: [f64; 3], size_m: [f64; 3], textured: bool) {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let corner = |right: f64, down: f64| {
                    let mut at = Vec3::from(centre_m);
                    // Across and down as seen from outside, down being z where it can be.
                    let (across, along) = [(1, 2), (0, 2), (0, 1)][axis];
                    let turn = if axis == 0 { -sign } else { sign };
                    at[axis] += 0.5 * sign * size_m[axis];
                    at[across] += 0.5 * right * turn * size_m[across];
                    at[along] += 0.5 * down * size_m[along];
                    at
                };
                let mut face = [
                    corner(-1.0, -1.0),
                    corner(-1.0, 1.0),
                    corner(1.0, 1.0),
                    corner(1.0, -1.0),
                ];
                let outwards = (face[1] - face[0]).cross(&(face[3] - face[0]))[axis] * sign;
                if outwards < 0.0 {
                    face.swap(1, 3);
                }
                self.quad(face, textured);
            }
        }
    }

    /// A round bar with flat ends along a path, mitred where the path turns; `sides` facets around, shaded as if round.
    pub(crate) fn bar(&mut self, path_m: &[[f64; 3]], radius_m: f64, sides: u32) {
        let path_m: Vec<Vec3> = path_m.iter().map(|&p| p.into()).collect();
        let last = path_m.len() - 1;
        let leg = |k: usize| (path_m[k + 1] - path_m[k]).normalize();
        let mut side = leg(0)
            .cross(&if leg(0).x.abs() < 0.9 {
                Vec3::x()
            } else {
                Vec3::y()
            })
            .normalize();
        let mut rings = Vec::new();
        for leg_index in 0..last {
            let d = leg(leg_index);
            side = (side - d * side.dot(&d)).normalize();
            let other = d.cross(&side);
            // Each leg has rings of its own, so that bends are creases; they are cut along the plane halfway between the legs.
            for end in [leg_index, leg_index + 1] {
                let before = leg(end.saturating_sub(1));
                let after = leg(end.min(last - 1));
                let cut = (before + after).normalize();
                rings.push(
                    (0..sides)
                        .map(|k| {
                            let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(sides));
                            let normal = side * cos + other * sin;
                            let out = normal * radius_m;
                            let at = path_m[end] + out - d * (out.dot(&cut) / d.dot(&cut));
                            (at, normal)
                        })
                        .collect::<Vec<_>>(),
                );
            }
        }
        for pair in rings.chunks_exact(2) {
            let [from, to] = [&pair[0], &pair[1]].map(|ring| {
                ring.iter()
                    .map(|&(at, normal)| self.vertex(at, normal, None))
                    .collect::<Vec<_>>()
            });
            for k in 0..sides as usize {
                let next = (k + 1) % sides as usize;
                self.0.triangles.push([from[k], from[next], to[next]]);
                self.0.triangles.push([from[k], to[next], to[k]]);
            }
        }
        let ends = [
            (&rings[0], path_m[0], leg(0), false),
            (&rings[2 * last - 1], path_m[last], leg(last - 1), true),
        ];
        for (ring, centre_m, along, is_far_end) in ends {
            let normal = if is_far_end { along } else { -along };
            let middle = self.vertex(centre_m, normal, None);
            let edge: Vec<u32> = ring
                .iter()
                .map(|&(at, _)| self.vertex(at, normal, None))
                .collect();
            for (k, &here) in edge.iter().enumerate() {
                let next = edge[(k + 1) % edge.len()];
                self.0.triangles.push(if is_far_end {
                    [middle, here, next]
                } else {
                    [middle, next, here]
                });
            }
        }
    }

    /// A ball of triangles whose vertices go out as far as `radius_m` says for their direction; shaded smoothly.
    pub(crate) fn boulder(&mut self, depth: u32, radius_m: impl Fn(&Vec3) -> f64) {
        let (directions, triangles) = icosphere(depth);
        let points: Vec<Vec3> = directions.iter().map(|d| d * radius_m(d)).collect();
        let mut normals = vec![Vec3::zeros(); points.len()];
        for corners in &triangles {
            let [a, b, c] = corners.map(|k| points[k as usize]);
            for &k in corners {
                // Weighted by area, which the cross product is.
                normals[k as usize] += (b - a).cross(&(c - a));
            }
        }
        let first = self.0.positions_m.len() as u32;
        for (point, normal) in points.iter().zip(&normals) {
            self.vertex(*point, normal.normalize(), None);
        }
        self.0
            .triangles
            .extend(triangles.iter().map(|t| t.map(|k| first + k)));
    }
}

/// Unit vectors and triangles of an icosahedron, each triangle cut in four `depth` times.
fn icosphere(depth: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut directions = Vec::new();
    for axis in 0..3 {
        for (long, short) in [
            (golden, 1.0),
            (golden, -1.0),
            (-golden, 1.0),
            (-golden, -1.0),
        ] {
            let mut v = Vec3::zeros();
            v[axis] = long;
            v[(axis + 1) % 3] = short;
            directions.push(v.normalize());
        }
    }
    let near = |a: usize, b: usize, directions: &[Vec3]| directions[a].dot(&directions[b]) > 0.4;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b, &directions) && near(b, c, &directions) && near(a, c, &directions) {
                    let [p, q, r] = [a, b, c].map(|k| directions[k]);
                    let outwards = (q - p).cross(&(r - p)).dot(&p) > 0.0;
                    let [b, c] = if outwards { [b, c] } else { [c, b] };
                    triangles.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for _ in 0..depth {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (directions, triangles)
}
