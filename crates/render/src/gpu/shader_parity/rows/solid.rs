//! Cylinders and boxes.

use rodsight_geometry::Vec3;
use rodsight_scene::{Bend, Finish, Material, Rod};

use super::{grid, random, vec3, yes};
use crate::bvh::{Node, Slabs};
use crate::cpu::rod::Rods;
use crate::cpu::solid::{Capped, Face, Ray, facing};
use crate::gpu::shader_parity::Row;
use crate::gpu::upload::segments;

/// A cylinder and a ray from fourteen numbers.
pub(super) fn ray_at_solid(x: &[f64]) -> (Capped, Ray) {
    let ray = Ray {
        origin_m: vec3(x, 8),
        direction: vec3(x, 11),
    };
    (Capped::new(vec3(x, 0), vec3(x, 4), x[3], x[7]), ray)
}

/// Rays at cylinders, most of which meet them, for which `answer` is the same a tenth of a millimetre beside.
fn clear_cut(seed: u64, answer: fn(&Capped, &Ray) -> u32) -> Vec<Vec<f32>> {
    let at = |numbers: Vec<f32>| -> Vec<f32> {
        let x: Vec<f64> = numbers.into_iter().map(f64::from).collect();
        let (centre, axis) = (vec3(&x, 0) * 0.3, vec3(&x, 3).normalize());
        let origin = vec3(&x, 6) * 3.0;
        let direction = (vec3(&x, 9) * 0.35 - origin).normalize();
        let (half, radius) = ([0.45 + 0.4 * x[12]], [0.08 + 0.06 * x[13]]);
        let all = [
            centre.as_slice(),
            &half,
            axis.as_slice(),
            &radius,
            origin.as_slice(),
            direction.as_slice(),
        ];
        all.concat().into_iter().map(|v| v as f32).collect()
    };
    let is_clear = |row: &Vec<f32>| {
        let (solid, ray) = ray_at_solid(&row.iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
        (0..8).all(|corner| {
            let step = |axis: u32| if corner >> axis & 1 == 1 { 1e-4 } else { -1e-4 };
            let beside = Ray {
                origin_m: ray.origin_m + Vec3::new(step(0), step(1), step(2)),
                ..ray
            };
            answer(&solid, &beside) == answer(&solid, &ray)
        })
    };
    let rows: Vec<Vec<f32>> = random(seed, 4000, 14)
        .into_iter()
        .map(at)
        .filter(is_clear)
        .collect();
    assert!(rows.len() > 2000, "{}", rows.len());
    rows
}

fn solids() -> Vec<Row> {
    vec![
        Row {
            name: "solid_hit",
            body: "let r = solid_hit(Solid(v(0u), x(3u), v(4u), x(7u)), v(8u), v(11u));
                y(0u, select(r.t_m, -1.0, r.t_m == SOLID_NONE_M)); y(1u, select(0.0, 1.0, r.cap));",
            inputs: clear_cut(5, |solid, ray| {
                solid
                    .hit(ray)
                    .map_or(0, |hit| 1 + u32::from(hit.face == Face::Cap))
            }),
            twin: Box::new(|x| {
                let (solid, ray) = ray_at_solid(x);
                let hit = solid.hit(&ray);
                hit.map_or(vec![-1.0, 0.0], |hit| {
                    vec![hit.t_m, yes(hit.face == Face::Cap)[0]]
                })
            }),
            relative: 1e-5,
            absolute: 1e-6,
            bounded_by: "a rounding error of the gap, tens of times larger in the depth beside a limb",
        },
        Row {
            name: "solid_grazes",
            body: "y(0u, select(0.0, 1.0, solid_grazes(Solid(v(0u), x(3u), v(4u), x(7u)), v(8u), v(11u), 0.01)));",
            inputs: clear_cut(6, |solid, ray| solid.grazes(ray, 0.01).into()),
            twin: Box::new(|x| {
                let (solid, ray) = ray_at_solid(x);
                yes(solid.grazes(&ray, 0.01))
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "yes or no, away from where it turns",
        },
        Row {
            name: "solid_is_end",
            body: "var s: Segment; s.ends = u32(x(0u)); y(0u, select(0.0, 1.0, solid_is_end(s, x(1u))));",
            inputs: grid(&[&[0.0, 1.0, 2.0, 3.0], &[-0.5, 0.5]]),
            // A ray that goes along the piece meets the cap at its start.
            twin: Box::new(|x| yes(x[0] as u32 & if x[1] > 0.0 { 1 } else { 2 } != 0)),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "yes or no",
        },
        normals(),
        Row {
            name: "solid_facing",
            body: "w(0u, solid_facing(v(0u), normalize(v(3u)), vec3<f32>(0.0, 0.0, -1.0)));",
            inputs: random(14, 1000, 6)
                .into_iter()
                .chain([vec![0.0, 0.5, 0.0, 0.0, 1.0, 0.0]])
                .collect(),
            twin: Box::new(|x| {
                let normal = facing(&vec3(x, 0), &vec3(x, 3).normalize(), &-Vec3::z());
                normal.as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 1e-5,
            bounded_by: "normals as long as what is taken from them",
        },
    ]
}

/// Normals where rays meet a straight rod, rods bent more and less, and one that is hardly bent.
fn normals() -> Row {
    let rod = |sagitta_m: f64| Rod {
        id: "r".to_owned(),
        centre_m: Vec3::new(2.0, 0.1, -0.2),
        direction: Vec3::new(0.0, 0.0, 1.0),
        length_m: 2.0,
        radius_m: 0.03,
        bend: (sagitta_m > 0.0).then(|| Bend {
            sagitta_m,
            towards: Vec3::y(),
        }),
        material: Material::Flat([1.0; 3]),
        finish: Finish::default(),
        fouling: None,
    };
    let all = [0.0, 1e-4, 0.05, 0.4].map(|sagitta_m| Rods::new(&[rod(sagitta_m)]));
    let mut inputs = Vec::new();
    for (index, rods) in all.iter().enumerate() {
        let pieces = segments(rods, &Vec3::zeros());
        for numbers in random(7, 2000, 2) {
            let axis = rods.solids[0].arc.at(0.95 * f64::from(numbers[0]));
            let across = axis.direction.cross(&Vec3::x()).normalize();
            let aim = axis.point_m + across * (0.029 * f64::from(numbers[1]));
            // The piece whose middle is nearest is not always the one that is hit; any near one has the same arc.
            let near = |piece: &&crate::gpu::layout::Segment| {
                let [x, y, z] = piece.solid.centre_m.as_ref().map(f64::from);
                ((Vec3::new(x, y, z) - aim).norm() * 1e6) as u64
            };
            let s = pieces.iter().min_by_key(near).unwrap();
            let point =
                aim - Vec3::x() * (0.03 * 0.03 - (0.029 * f64::from(numbers[1])).powi(2)).sqrt();
            let mut row = Vec::new();
            for (three, one) in [
                (s.solid.centre_m, s.solid.half_length_m),
                (s.solid.direction, s.solid.radius_m),
                (s.arc_m, s.curvature_per_m),
                (s.inward, index as f32),
            ] {
                row.extend(three.as_ref());
                row.push(one);
            }
            row.extend(point.iter().map(|v| *v as f32));
            inputs.push(row);
        }
    }
    Row {
        name: "solid_normal",
        body: "let s = Segment(Solid(v(0u), x(3u), v(4u), x(7u)), v(8u), x(11u), v(12u), 2u, 0u); w(0u, solid_normal(s, v(16u)));",
        inputs,
        twin: Box::new(move |x| {
            let arc = &all[x[15] as usize].solids[0].arc;
            let point = vec3(x, 16);
            let normal = (point - arc.at(arc.parameter_of(&point)).point_m).normalize();
            normal.as_slice().to_vec()
        }),
        relative: 0.0,
        absolute: 5e-6,
        bounded_by: "points 2 m away, rounded to 2e-7 m, on a radius of 3 cm",
    }
}

fn boxes() -> Vec<Row> {
    let rows = random(8, 4000, 11).into_iter().map(|r| {
        let size = [0.3, 0.2, 0.5];
        let mut row: Vec<f32> = r[..3].to_vec();
        row.extend((0..3).map(|k| r[k] + size[k]));
        row.extend((3..6).map(|k| 3.0 * r[k]));
        // Towards the box, more or less.
        row.extend((0..3).map(|k| r[k] + 0.5 * r[6 + k] - 3.0 * r[3 + k]));
        row.extend([0.02 * r[9].abs(), 2.0 * r[10].abs()]);
        row
    });
    vec![
        Row {
            name: "bvh_per_direction",
            body: "w(0u, bvh_per_direction(v(0u)));",
            inputs: random(9, 500, 3),
            twin: Box::new(|x| x.iter().map(|v| 1.0 / v).collect()),
            relative: 3e-7,
            absolute: 0.0,
            bounded_by: "a division",
        },
        Row {
            name: "bvh_meets",
            body: "let n = BvhNode(v(0u), 0u, v(3u), 1u);
                y(0u, select(0.0, 1.0, bvh_meets(n, v(6u), bvh_per_direction(v(9u)), x(12u), x(13u))));",
            inputs: rows.collect(),
            twin: Box::new(|x| {
                let corner = |k: usize| [x[k] as f32, x[k + 1] as f32, x[k + 2] as f32];
                let node = Node {
                    min_m: corner(0),
                    first: 0,
                    max_m: corner(3),
                    count: 1,
                };
                let ray = Ray {
                    origin_m: vec3(x, 6),
                    direction: vec3(x, 9),
                };
                yes(Slabs::new(&ray, x[12]).enter_m(&node) < x[13])
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "yes or no",
        },
    ]
}

pub(super) fn rows() -> Vec<Row> {
    let mut rows = solids();
    rows.extend(boxes());
    rows
}
