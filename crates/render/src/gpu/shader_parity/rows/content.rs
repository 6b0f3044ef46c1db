//! Balls, cubes, triangles, textures, ripples.

use core::f64::consts::TAU;

use rodsight_geometry::{Mat3, Vec3, rotation_from_rpy};
use rodsight_scene::{Ripples, Wrap};

use super::{grid, random, steps, vec3};
use crate::cpu::lump::{self, Lump};
use crate::cpu::seabed;
use crate::cpu::solid::Ray;
use crate::cpu::texture;
use crate::cpu::triangles::{self, Paint, Sheared};
use crate::gpu::content;
use crate::gpu::shader_parity::Row;

fn lump_of(is_cube: bool) -> Lump {
    let axes_m = rotation_from_rpy(0.4, -0.9, 2.0) * Mat3::from_diagonal(&Vec3::new(0.3, 0.1, 0.2));
    Lump::new(Vec3::new(0.1, -0.2, 0.05), &axes_m, is_cube)
}

/// A lump as the shader takes it, and its number; then rays at and beside it.
fn rays_at_lumps(reach: f64) -> Vec<Vec<f32>> {
    let mut rows = Vec::new();
    for is_cube in [false, true] {
        let lump = content::lump(&lump_of(is_cube), &Vec3::zeros());
        let [cube, zero] = [f32::from(u8::from(is_cube)), 0.0];
        let numbers = [
            (lump.centre_m, cube),
            (lump.to_unit_x, zero),
            (lump.to_unit_y, zero),
            (lump.to_unit_z, zero),
        ];
        let numbers: Vec<f32> = numbers
            .iter()
            .flat_map(|(three, one)| [three.as_ref().as_slice(), &[*one]].concat())
            .collect();
        for r in random(30, 3000, 6) {
            let x: Vec<f64> = r.into_iter().map(f64::from).collect();
            let origin_m = vec3(&x, 0).normalize() * 2.0;
            let direction =
                (lump_of(is_cube).centre_m + vec3(&x, 3) * reach - origin_m).normalize();
            let ray = [origin_m, direction].map(|v| v.map(|v| v as f32));
            let row = [&numbers, ray[0].as_slice(), ray[1].as_slice()].concat();
            if is_clear(&row) {
                rows.push(row);
            }
        }
    }
    assert!(rows.len() > 2000, "{}", rows.len());
    rows
}

fn hit_of(x: &[f64]) -> Option<(f64, Vec3)> {
    let ray = Ray {
        origin_m: vec3(x, 16),
        direction: vec3(x, 19),
    };
    let hit = lump_of(x[3] == 1.0).hit(&ray)?;
    Some((hit.t_m, hit.normal))
}

/// Whether a tenth of a millimetre beside nothing else is hit.
fn is_clear(row: &[f32]) -> bool {
    let x: Vec<f64> = row.iter().map(|v| f64::from(*v)).collect();
    let here = hit_of(&x);
    (0..6).all(|k| {
        let mut beside = x.clone();
        beside[16 + k % 3] += if k < 3 { 1e-4 } else { -1e-4 };
        match (here, hit_of(&beside)) {
            (None, None) => true,
            (Some(a), Some(b)) => a.1.dot(&b.1) > 0.99,
            _ => false,
        }
    })
}

const LUMP: &str = "let l = Lump(v(0u), u32(x(3u)), v(4u), v(8u), v(12u));";

fn with_lump(more: &str) -> &'static str {
    Box::leak(format!("{LUMP}{more}").into_boxed_str())
}

/// Starts outside the unit and directions towards it.
fn in_unit() -> Vec<Vec<f32>> {
    let row = |r: Vec<f32>| {
        let start = [3.0 * r[0], 3.0 * r[1], 4.0];
        let aim = [0.5 * r[2], 0.5 * r[3], 0.4 * r[4]];
        let along: Vec<f32> = (0..3).map(|k| 0.7 * (aim[k] - start[k])).collect();
        [start.as_slice(), &along].concat()
    };
    random(31, 2000, 5).into_iter().map(row).collect()
}

fn in_unit_twin(meet: fn(&Vec3, &Vec3) -> Option<(f64, Vec3)>) -> impl Fn(&[f64]) -> Vec<f64> {
    move |x| {
        let (t, normal) = meet(&vec3(x, 0), &vec3(x, 3)).expect("it looks at the unit");
        vec![normal.x, normal.y, normal.z, t]
    }
}

fn lumps() -> Vec<Row> {
    vec![
        Row {
            name: "lump_ball",
            body: "let r = lump_ball(v(0u), v(3u)); w(0u, r.xyz); y(3u, r.w);",
            inputs: in_unit(),
            twin: Box::new(in_unit_twin(lump::ball)),
            relative: 0.0,
            absolute: 1e-5,
            bounded_by: "five units away, beside the limb",
        },
        Row {
            name: "lump_cube",
            body: "let r = lump_cube(v(0u), v(3u)); w(0u, r.xyz); y(3u, r.w);",
            inputs: in_unit(),
            twin: Box::new(in_unit_twin(lump::cube)),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "rounding",
        },
        Row {
            name: "lump_hit",
            body: with_lump(
                "let r = lump_hit(l, v(16u), v(19u)); y(0u, select(r.w, -1.0, r.w == SOLID_NONE_M));",
            ),
            inputs: rays_at_lumps(0.2),
            twin: Box::new(|x| vec![hit_of(x).map_or(-1.0, |hit| hit.0)]),
            relative: 0.0,
            absolute: 1e-5,
            bounded_by: "a rounding error of the gap, tens of times larger in the depth beside a limb",
        },
        Row {
            name: "lump_normal",
            body: with_lump("let r = lump_hit(l, v(16u), v(19u)); w(0u, lump_normal(l, r.xyz));"),
            inputs: rays_at_lumps(0.05),
            twin: Box::new(|x| hit_of(x).expect("it is hit").1.as_slice().to_vec()),
            relative: 0.0,
            absolute: 1e-5,
            bounded_by: "places 2 m away, to 2e-7 m, on half axes of 0.1 m",
        },
    ]
}

/// Rays from anywhere at triangles a metre across, not nearer than a hundredth of it to their edges.
fn rays_at_triangles() -> Vec<Vec<f32>> {
    let row = |r: Vec<f32>| -> Option<Vec<f32>> {
        let x: Vec<f64> = r.iter().map(|v| f64::from(*v)).collect();
        let (origin, aim) = (vec3(&x, 9) * 3.0, vec3(&x, 12) * 0.5);
        let direction = (aim - origin).try_normalize(1e-3)?.map(|v| v as f32);
        let row = [
            &r[..9],
            &[3.0 * r[9], 3.0 * r[10], 3.0 * r[11]],
            direction.as_slice(),
        ]
        .concat();
        let exact: Vec<f64> = row.iter().map(|v| f64::from(*v)).collect();
        let p: [Vec3; 3] = [0, 3, 6].map(|k| vec3(&exact, k));
        let size = (p[1] - p[0]).cross(&(p[2] - p[0]));
        let facing = size.dot(&vec3(&exact, 12)).abs();
        // The plane's hit, whether inside or not.
        let weights = weights(&exact);
        let clear = weights.iter().all(|w| w.abs() > 0.01);
        (facing > 0.05 && clear).then_some(row)
    };
    let rows: Vec<Vec<f32>> = random(32, 4000, 15).into_iter().filter_map(row).collect();
    assert!(rows.len() > 1000, "{}", rows.len());
    rows
}

/// Weights of the corners where the ray's line meets the plane, by areas.
fn weights(x: &[f64]) -> [f64; 3] {
    let p: [Vec3; 3] = [0, 3, 6].map(|k| vec3(x, k));
    let (origin, direction) = (vec3(x, 9), vec3(x, 12));
    let volume = |a: &Vec3, b: &Vec3| (a - origin).cross(&(b - origin)).dot(&direction);
    let all = [
        volume(&p[1], &p[2]),
        volume(&p[2], &p[0]),
        volume(&p[0], &p[1]),
    ];
    let sum: f64 = all.iter().sum();
    all.map(|v| v / sum)
}

fn meets() -> Vec<Row> {
    let of_direction = |x: &[f64], at: usize| {
        Sheared::new(&Ray {
            origin_m: Vec3::zeros(),
            direction: vec3(x, at),
        })
    };
    vec![
        Row {
            name: "triangles_turned",
            body: "let r = triangles_ray(vec3<f32>(0.0), v(0u)); w(0u, triangles_turned(r.axis, r.is_mirrored, v(3u)));",
            inputs: random(33, 500, 6),
            twin: Box::new(move |x| of_direction(x, 0).axes.map(|k| x[3 + k]).to_vec()),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "nothing is computed",
        },
        Row {
            name: "triangles_ray",
            body: "w(0u, triangles_ray(vec3<f32>(0.0), v(0u)).shear);",
            inputs: random(34, 500, 3),
            twin: Box::new(move |x| of_direction(x, 0).shear.to_vec()),
            relative: 3e-7,
            absolute: 0.0,
            bounded_by: "a division",
        },
        Row {
            name: "triangles_edge",
            body: "let p = vec2<f32>(x(0u), x(1u)); let q = vec2<f32>(x(2u), x(3u));
                y(0u, triangles_edge(p, q)); y(1u, triangles_edge(p, q) + triangles_edge(q, p));",
            inputs: random(35, 1000, 4),
            twin: Box::new(|x| vec![x[0] * x[3] - x[1] * x[2], 0.0]),
            relative: 0.0,
            absolute: 1.2e-7,
            bounded_by: "rounding; seen from either side it is the same to the last bit",
        },
        Row {
            name: "triangles_meet",
            body: "let r = triangles_meet(triangles_ray(v(9u), v(12u)), v(0u), v(3u), v(6u));
                y(0u, select(r.w, -1.0, r.w == SOLID_NONE_M)); w(1u, select(r.xyz, vec3<f32>(0.0), r.w == SOLID_NONE_M));",
            inputs: rays_at_triangles(),
            twin: Box::new(|x| {
                let ray = Ray {
                    origin_m: vec3(x, 9),
                    direction: vec3(x, 12),
                };
                let met = Sheared::new(&ray).meet([0, 3, 6].map(|k| vec3(x, k)));
                met.map_or(vec![-1.0, 0.0, 0.0, 0.0], |(t_m, w)| vec![t_m, w[0], w[1], w[2]])
            }),
            relative: 0.0,
            absolute: 3e-5,
            bounded_by: "3 m away, seen at a slant of 3°",
        },
        Row {
            name: "triangles_normals",
            body: "let n = triangles_normals(normalize(v(0u)), v(3u), normalize(v(6u))); w(0u, n.rounded); w(3u, n.facet);",
            inputs: random(36, 1000, 9)
                .into_iter()
                .filter(|r| {
                    let x: Vec<f64> = r.iter().map(|v| f64::from(*v)).collect();
                    let facet = vec3(&x, 0).normalize();
                    facet.dot(&vec3(&x, 3)).abs() > 1e-3 && facet.dot(&vec3(&x, 6)).abs() > 1e-3
                        && vec3(&x, 3).cross(&vec3(&x, 6)).norm() > 0.05
                })
                .collect(),
            twin: Box::new(|x| {
                let [facet, direction] = [0, 6].map(|k| vec3(x, k).normalize());
                let (rounded, facet) = triangles::normals(&facet, &vec3(x, 3), &direction);
                [rounded.as_slice(), facet.as_slice()].concat()
            }),
            relative: 0.0,
            absolute: 1e-5,
            bounded_by: "short normals beside rays along them",
        },
        Row {
            name: "triangles_split",
            body: "let s = triangles_split(v(0u), x(3u)); w(0u, s.albedo); w(3u, s.reflectance);",
            inputs: grid(&[&[0.0, 0.3], &[0.5], &[1.0], &[0.0, 0.25, 1.0]]),
            twin: Box::new(|x| {
                let paint = Paint {
                    base: [1.0; 3],
                    metallic: x[3],
                    roughness: 1.0,
                    prop: 0,
                    texture: None,
                };
                let (albedo, reflectance) = paint.split([x[0], x[1], x[2]]);
                [albedo, reflectance].concat()
            }),
            relative: 1e-6,
            absolute: 1e-8,
            bounded_by: "rounding",
        },
    ]
}

fn textures() -> Vec<Row> {
    let off_steps = |footprint: &f32| (footprint.log2() - footprint.log2().round()).abs() > 1e-5;
    let footprints: Vec<f32> = steps(0.1, 300.0, 997)
        .into_iter()
        .filter(off_steps)
        .collect();
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    vec![
        Row {
            name: "texture_level",
            body: "let l = texture_level(x(0u), 7u); y(0u, l.x); y(1u, l.y);",
            inputs: grid(&[&footprints]),
            twin: Box::new(|x| {
                let (lower, share) = texture::level(x[0], 7);
                vec![lower as f64, share]
            }),
            relative: 0.0,
            absolute: 3e-6,
            bounded_by: "a logarithm up to 8",
        },
        Row {
            name: "texture_wrapped",
            body: "y(0u, f32(texture_wrapped(x(0u), 6u, u32(x(1u)))));",
            inputs: grid(&[&steps(-20.0, 20.0, 41), &[0.0, 1.0, 2.0]]),
            twin: Box::new(move |x| vec![texture::wrapped(x[0], 6, wraps[x[1] as usize]) as f64]),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "integers",
        },
    ]
}

fn ripples() -> Vec<Row> {
    let sand = Ripples {
        wavelength_m: 0.25,
        height_m: 0.03125,
        heading_rad: 0.4,
    };
    let heading = content::ripples(&sand).heading;
    let [cos, sin] = *heading.as_ref();
    let rays = grid(&[
        &[cos],
        &[sin],
        &steps(-9.0, 7.0, 37),
        &steps(-3.0, 5.0, 29),
        &[0.05, 0.9],
        &[1e-3, 0.06, 0.2],
    ]);
    let ray = |x: &[f64]| {
        let slope = (1.0 - x[4] * x[4]).sqrt();
        let direction = Vec3::new(0.6 * slope, 0.8 * slope, x[4]);
        Ray {
            origin_m: Vec3::new(x[2], x[3], 0.0) - direction,
            direction,
        }
    };
    vec![
        Row {
            name: "seabed_wave",
            body: "let s = seabed_wave(x(0u)); y(0u, s.x); y(1u, s.y);",
            inputs: grid(&[&steps(-40.0, 31.0, 1997)]),
            twin: Box::new(|x| vec![libm::sin(TAU * x[0]), libm::cos(TAU * x[0])]),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "maths_sincos",
        },
        Row {
            name: "seabed_rippled_normal",
            body: "let slope = sqrt(1.0 - x(4u) * x(4u)); let d = vec3<f32>(0.6 * slope, 0.8 * slope, x(4u));
                let r = SeabedRipples(0.25, 0.03125, vec2<f32>(x(0u), x(1u)));
                w(0u, seabed_rippled_normal(r, vec2<f32>(x(2u), x(3u)), d, x(5u)));",
            inputs: rays,
            twin: Box::new(move |x| {
                let normal = seabed::rippled_normal(&sand, &ray(x), 1.0, x[5]);
                normal.as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 2e-5,
            bounded_by: "forty wavelengths away, to 4e-6 of one",
        },
    ]
}

pub(super) fn rows() -> Vec<Row> {
    let mut rows = lumps();
    rows.extend(meets());
    rows.extend(textures());
    rows.extend(ripples());
    rows
}
