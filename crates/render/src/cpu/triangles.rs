//! Triangles of all props, in the rig's frame, under one tree.

use rodsight_geometry::{Mat3, Vec3};
use rodsight_scene::Prop;

use super::solid::{Ray, facing};
use crate::bvh::{Bounds, Bvh};
use crate::cpu::texture::Pyramid;

/// What a triangle is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    /// Linear base colour.
    pub(crate) base: [f64; 3],
    pub(crate) metallic: f64,
    pub(crate) roughness: f64,
    /// Which prop has it.
    pub(crate) prop: usize,
    /// Index into [`Triangles::textures`].
    pub(crate) texture: Option<u32>,
}

/// All triangles. Arrays over vertices are of one length, and so are those over triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    pub(crate) vertices_m: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<[f64; 2]>,
    pub(crate) corners: Vec<[u32; 3]>,
    /// The smooth patch of each triangle: edges between patches are creases.
    pub(crate) patches: Vec<u32>,
    /// The paint of each triangle, in `paints`.
    pub(crate) painted: Vec<u32>,
    pub(crate) paints: Vec<Paint>,
    pub(crate) textures: Vec<Pyramid>,
    pub(crate) tree: Bvh,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleHit {
    pub(crate) t_m: f64,
    pub(crate) index: usize,
    /// Weights of the three corners.
    pub(crate) weights: [f64; 3],
}

impl Triangles {
    pub(crate) fn new(props: &[Prop]) -> Self {
        let mut all = Self::default();
        for (index, prop) in props.iter().enumerate() {
            all.add(index, prop);
        }
        let boxes: Vec<Bounds> = all
            .corners
            .iter()
            .map(|&corners| all.bounds(corners))
            .collect();
        all.tree = Bvh::new(&boxes);
        all
    }

    fn add(&mut self, index: usize, prop: &Prop) {
        let (first_paint, first_texture) = (self.paints.len() as u32, self.textures.len() as u32);
        self.textures
            .extend(prop.mesh.textures.iter().map(Pyramid::new));
        self.paints
            .extend(prop.mesh.materials.iter().map(|material| {
                Paint {
                    base: material.base.map(f64::from),
                    metallic: f64::from(material.metallic),
                    roughness: f64::from(material.roughness),
                    prop: index,
                    texture: material
                        .texture
                        .map(|texture| first_texture + texture as u32),
                }
            }));
        let wide = |v: &[f32; 3]| Vec3::from(v.map(f64::from));
        let pose = &prop.rig_from_prop;
        let (first_vertex, first_triangle) = (self.vertices_m.len(), self.corners.len());
        for part in &prop.mesh.parts {
            let base = self.vertices_m.len() as u32;
            let positions = part.positions_m.iter();
            self.vertices_m
                .extend(positions.map(|p| pose.point(&(wide(p) * prop.scale))));
            let normals = part.normals.iter();
            self.normals
                .extend(normals.map(|n| pose.direction(&wide(n))));
            self.uvs.extend(part.uvs.iter().map(|uv| uv.map(f64::from)));
            self.uvs.resize(self.vertices_m.len(), [0.0; 2]);
            let triangles = part.triangles.iter();
            self.corners
                .extend(triangles.map(|corners| corners.map(|corner| base + corner)));
            let paint = first_paint + part.material as u32;
            self.painted.resize(self.corners.len(), paint);
        }
        let patches = self.smooth_patches(first_vertex, first_triangle);
        self.patches.extend(patches);
    }

    /// Triangles that share a vertex with its normal belong to one patch, however often the file repeats the vertex.
    fn smooth_patches(&self, first_vertex: usize, first_triangle: usize) -> Vec<u32> {
        let key = |vertex: usize| {
            let bits = |v: &Vec3| [v.x, v.y, v.z].map(|v| (v + 0.0).to_bits());
            (bits(&self.vertices_m[vertex]), bits(&self.normals[vertex]))
        };
        let mut order: Vec<usize> = (first_vertex..self.vertices_m.len()).collect();
        order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
        let mut root: Vec<u32> = (0..order.len() as u32).collect();
        let find = |root: &mut Vec<u32>, mut at: u32| {
            while root[at as usize] != at {
                root[at as usize] = root[root[at as usize] as usize];
                at = root[at as usize];
            }
            at
        };
        let mut join = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|vertex| find(&mut root, (vertex - first_vertex) as u32));
            root[a.max(b) as usize] = a.min(b);
        };
        for pair in order.windows(2) {
            if key(pair[0]) == key(pair[1]) {
                join(pair[0], pair[1]);
            }
        }
        let corners = &self.corners[first_triangle..];
        for &[a, b, c] in corners {
            join(a as usize, b as usize);
            join(a as usize, c as usize);
        }
        let patch =
            |&[a, ..]: &[u32; 3]| first_vertex as u32 + find(&mut root, a - first_vertex as u32);
        corners.iter().map(patch).collect()
    }

    #[inline]
    fn points(&self, [a, b, c]: [u32; 3]) -> [Vec3; 3] {
        // One by one: the compiler makes calls of an array's `map`, here and in `meet`, in which a third of a render's time went.
        let at = |corner: u32| self.vertices_m[corner as usize];
        [at(a), at(b), at(c)]
    }

    fn bounds(&self, corners: [u32; 3]) -> Bounds {
        let [a, b, c] = self.points(corners);
        Bounds {
            min_m: a.inf(&b).inf(&c),
            max_m: a.sup(&b).sup(&c),
        }
    }

    /// The first triangle on the ray; of two at the very same distance the one that comes first, whatever the tree.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<TriangleHit> {
        if self.corners.is_empty() {
            return None;
        }
        let sheared = Sheared::new(ray);
        let mut first: Option<TriangleHit> = None;
        self.tree.visit(ray, 0.0, f64::INFINITY, |index| {
            if let Some((t_m, weights)) = sheared.meet(self.points(self.corners[index]))
                && first.is_none_or(|f| t_m < f.t_m || (t_m == f.t_m && index < f.index))
            {
                first = Some(TriangleHit {
                    t_m,
                    index,
                    weights,
                });
            }
            first.map_or(f64::INFINITY, |f| f.t_m)
        });
        first
    }

    /// Whether the first `length_m` of the ray meet a triangle.
    pub(crate) fn block(&self, ray: &Ray, length_m: f64) -> bool {
        if self.corners.is_empty() {
            return false;
        }
        let sheared = Sheared::new(ray);
        let mut blocked = false;
        self.tree.visit(ray, 0.0, length_m, |index| {
            let meets = sheared.meet(self.points(self.corners[index]));
            blocked = blocked || meets.is_some_and(|(t_m, _)| t_m < length_m);
            if blocked { f64::NEG_INFINITY } else { length_m }
        });
        blocked
    }

    /// The interpolated normal and the facet's own, both towards where the ray comes from: surfaces have two sides.
    pub(crate) fn normals_at(&self, hit: &TriangleHit, ray: &Ray) -> (Vec3, Vec3) {
        let corners = self.corners[hit.index];
        let [a, b, c] = self.points(corners);
        let mut interpolated = Vec3::zeros();
        for (corner, weight) in corners.into_iter().zip(hit.weights) {
            interpolated += self.normals[corner as usize] * weight;
        }
        normals(
            &(b - a).cross(&(c - a)).normalize(),
            &interpolated,
            &ray.direction,
        )
    }

    /// How fast the interpolated normal turns along the triangle's edges at most, rad/m.
    pub(crate) fn curvature_per_m(&self, index: usize) -> f64 {
        let corners = self.corners[index].map(|corner| corner as usize);
        (0..3).fold(0.0, |most: f64, k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let turn = (self.normals[a] - self.normals[b]).norm();
            most.max(turn / (self.vertices_m[a] - self.vertices_m[b]).norm())
        })
    }

    /// What the triangle of a hit is painted with.
    pub(crate) fn paint(&self, hit: &TriangleHit) -> &Paint {
        &self.paints[self.painted[hit.index] as usize]
    }

    /// Base colour at a hit, seen with samples `footprint_m` apart on the surface.
    pub(crate) fn base(&self, hit: &TriangleHit, footprint_m: f64) -> [f64; 3] {
        let paint = self.paint(hit);
        let Some(texture) = paint.texture else {
            return paint.base;
        };
        let pyramid = &self.textures[texture as usize];
        let corners = self.corners[hit.index];
        let uvs = corners.map(|corner| self.uvs[corner as usize]);
        let at = |k: usize| (0..3).map(|i| hit.weights[i] * uvs[i][k]).sum::<f64>();
        let texel = pyramid.at([at(0), at(1)], footprint_m * self.texels_per_m(hit.index));
        core::array::from_fn(|k| paint.base[k] * texel[k])
    }

    /// Texels per metre on a triangle, in the direction where they are densest; 0 if it has no texture.
    pub(crate) fn texels_per_m(&self, index: usize) -> f64 {
        let Some(texture) = self.paints[self.painted[index] as usize].texture else {
            return 0.0;
        };
        let [size_u, size_v] = self.textures[texture as usize].size_px();
        let corners = self.corners[index];
        let uvs = corners.map(|corner| self.uvs[corner as usize]);
        let [a, b, c] = self.points(corners);
        let texel = |k: usize| {
            [
                (uvs[k][0] - uvs[0][0]) * size_u,
                (uvs[k][1] - uvs[0][1]) * size_v,
            ]
        };
        let ([bu, bv], [cu, cv]) = (texel(1), texel(2));
        let (p, q) = (b - a, c - a);
        // Gradients of the texture's two coordinates on the triangle: g·p and g·q are given, g in its plane.
        let normal = p.cross(&q);
        let gradient = |gp: f64, gq: f64| {
            (q.cross(&normal) * gp + normal.cross(&p) * gq) / normal.norm_squared()
        };
        let (gu, gv) = (gradient(bu, cu), gradient(bv, cv));
        // No direction is denser than the two together.
        (gu.norm_squared() + gv.norm_squared()).sqrt()
    }
}

/// The rounded normal and the facet's, towards where a ray comes from.
pub(crate) fn normals(facet: &Vec3, interpolated: &Vec3, direction: &Vec3) -> (Vec3, Vec3) {
    let along = |n: &Vec3, towards: f64| if towards < 0.0 { -n } else { *n };
    let facet = along(facet, -facet.dot(direction));
    let rounded = along(interpolated, interpolated.dot(&facet));
    (facing(&rounded, direction, &facet), facet)
}

/// A ray turned to look along z (Woop, Benthin and Wald, Watertight Ray/Triangle Intersection, JCGT 2013): neighbours compute their
/// common edge alike, so that no ray slips between them.
pub(crate) struct Sheared {
    origin_m: Vec3,
    pub(crate) axes: [usize; 3],
    pub(crate) shear: [f64; 3],
}

impl Sheared {
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let z = d.iamax();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            core::mem::swap(&mut x, &mut y);
        }
        Self {
            origin_m: ray.origin_m,
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]],
        }
    }

    /// Distance and the weights of the corners.
    #[inline]
    pub(crate) fn meet(&self, [a, b, c]: [Vec3; 3]) -> Option<(f64, [f64; 3])> {
        let [x, y, z] = self.axes;
        let [sx, sy, sz] = self.shear;
        let turned = |point: Vec3| {
            let p = point - self.origin_m;
            [p[x] - sx * p[z], p[y] - sy * p[z], sz * p[z]]
        };
        let (a, b, c) = (turned(a), turned(b), turned(c));
        let edge = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let outside = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let sum = u + v + w;
        if outside || sum == 0.0 {
            return None;
        }
        let weights = [u / sum, v / sum, w / sum];
        let t_m = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        (t_m > 0.0).then_some((t_m, weights))
    }
}

/// What a metallic-roughness surface reflects at normal incidence if it is no metal: n = 1.5 in water, ((1.5 − 1.34)/(1.5 + 1.34))².
pub(crate) const DIELECTRIC: f64 = 0.0032;

impl Paint {
    /// Matt albedo and reflectance at normal incidence for a base colour.
    pub(crate) fn split(&self, base: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        (
            base.map(|b| b * (1.0 - self.metallic)),
            base.map(|b| DIELECTRIC + (b - DIELECTRIC) * self.metallic),
        )
    }
}

/// The columns of a rotation, each times a length.
pub(crate) fn scaled(rotation: &Mat3, lengths_m: &Vec3) -> Mat3 {
    rotation * Mat3::from_diagonal(lengths_m)
}
