//! Water, lamps, floors, shadows.

use rodsight_geometry::Vec3;
use rodsight_optics::{EquiAngular, Phase, transmittance};
use rodsight_scene::{Lamp, Seabed};

use super::{grid, random, steps, vec3};
use crate::cpu::airlight_grid::Hermite;
use crate::cpu::light::{LampLight, cone};
use crate::cpu::penumbra::Rectangle;
use crate::cpu::seabed;
use crate::cpu::shadow::{Caster, Direction, Section, Shadows};
use crate::cpu::solid::Capped;
use crate::gpu::shader_parity::Row;

fn media() -> Vec<Row> {
    let lobes = [-0.55, 0.0, 0.88, 0.988, 0.997]
        .into_iter()
        .flat_map(|g: f32| {
            let of_lobe = move |at: f32| {
                let g = f64::from(g);
                let amplitude = (1.0 - g * g) / (4.0 * core::f64::consts::PI);
                vec![
                    amplitude as f32,
                    ((1.0 - g) * (1.0 - g)) as f32,
                    (2.0 * g) as f32,
                    2.0 * at * at * at,
                    g as f32,
                ]
            };
            steps(0.0, 1.0, 201).into_iter().map(of_lobe)
        });
    vec![
        Row {
            name: "medium_transmittance",
            body: "w(0u, medium_transmittance(v(0u), x(3u)));",
            inputs: grid(&[&[0.0, 0.05, 1.3], &[0.2], &[0.7], &steps(0.0, 12.0, 101)]),
            twin: Box::new(|x| transmittance(&[x[0], x[1], x[2]], x[3]).to_vec()),
            relative: 3e-6,
            absolute: 0.0,
            bounded_by: "rounding of an exponent up to 16",
        },
        Row {
            name: "phase_lobe_per_sr",
            body: "y(0u, phase_lobe_per_sr(v(0u), x(3u)));",
            inputs: lobes.collect(),
            twin: Box::new(|x| {
                let phase = Phase::henyey_greenstein(x[4]).unwrap();
                vec![phase.value_per_sr(1.0 - x[3])]
            }),
            relative: 1e-6,
            absolute: 0.0,
            bounded_by: "rounding to the power of 3/2",
        },
        Row {
            name: "phase_table_place",
            body: "y(0u, phase_table_place(x(0u)));",
            inputs: grid(&[&steps(0.0, 2.0, 401)]),
            twin: Box::new(|x| vec![libm::pow(0.5 * x[0], 0.125)]),
            relative: 3e-7,
            absolute: 0.0,
            bounded_by: "three square roots",
        },
    ]
}

/// A scene's seed whose word is a finite number as bits of `f32`, in which the tests carry it.
const SEED: u64 = 12;

fn floors() -> Vec<Row> {
    let nodes: &[f32] = &[-7.0, -1.0, 0.0, 1.0, 400.0];
    let seed = f32::from_bits(seabed::seed_word(SEED));
    assert!(seed.is_finite(), "another seed");
    let word = |x: f64| (x as f32).to_bits();
    vec![
        Row {
            name: "seabed_hash",
            body: "y(0u, seabed_hash(u(0u), u32(x(1u)), i32(x(2u)), i32(x(3u))));",
            inputs: grid(&[&[seed], &[0.0, 1.0, 7.0], nodes, nodes]),
            twin: Box::new(move |x| {
                vec![seabed::hash(
                    word(x[0]),
                    x[1] as u32,
                    x[2] as i64,
                    x[3] as i64,
                )]
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "24 bits",
        },
        Row {
            name: "seabed_value_noise",
            body: "y(0u, seabed_value_noise(u(0u), 2u, vec2<f32>(x(1u), x(2u))));",
            inputs: grid(&[&[seed], &steps(-9.3, 11.4, 83), &steps(-5.0, 7.2, 37)]),
            twin: Box::new(move |x| vec![seabed::value_noise(word(x[0]), 2, x[1], x[2])]),
            relative: 0.0,
            absolute: 4e-6,
            bounded_by: "places between nodes ten away, to 1e-6",
        },
        Row {
            name: "seabed_factor",
            body: "y(0u, seabed_factor(u(0u), 0.25, 0.125, vec2<f32>(x(1u), x(2u)), x(3u)));",
            inputs: grid(&[
                &[seed],
                &steps(-3.0, 4.0, 43),
                &steps(1.0, 9.0, 29),
                &[1e-4, 0.002, 0.03, 0.3],
            ]),
            twin: Box::new(|x| {
                let floor = Seabed {
                    z_m: 0.0,
                    albedo: [0.25; 3],
                    texture_contrast: 0.25,
                    texture_scale_m: 0.125,
                    ripples: None,
                    clutter: None,
                };
                let point = Vec3::new(x[1], x[2], 0.0);
                vec![4.0 * seabed::albedo(&floor, SEED, &point, x[3])[0]]
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "the finest octave's places, thousands of nodes away, to 5e-4",
        },
    ]
}

fn lamps() -> Vec<Row> {
    let angles = grid(&[&steps(0.0, core::f32::consts::PI, 301), &[0.3, 1.2]]);
    let cones = angles.into_iter().map(|row| {
        let (sin, cos) = libm::sincos(f64::from(row[0]));
        let (inner, outer) = (f64::from(row[1]), f64::from(row[1]) + 0.3);
        let (cos_inner, cos_outer) = (libm::cos(inner) as f32, libm::cos(outer) as f32);
        vec![cos_inner, cos_outer, sin as f32, 0.0, cos as f32, row[1]]
    });
    vec![
        Row {
            name: "light_cone",
            body: "var lamp: Lamp; lamp.direction = vec3<f32>(0.0, 0.0, 1.0); lamp.cos_inner = x(0u); lamp.cos_outer = x(1u);
                y(0u, light_cone(lamp, v(2u)));",
            inputs: cones.collect(),
            twin: Box::new(|x| {
                let lamp = Lamp {
                    position_m: Vec3::zeros(),
                    direction: Vec3::z(),
                    radiant_intensity_w_per_sr: [1.0; 3],
                    inner_half_angle_rad: x[5],
                    outer_half_angle_rad: x[5] + 0.3,
                };
                let light = LampLight::new(&lamp, core::iter::empty());
                vec![cone(&light, &vec3(x, 2))]
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "cosines to 6e-8, stretched over the edge of the beam",
        },
        Row {
            name: "airlight_nodes",
            body: "let n = airlight_nodes(v(0u), v(3u), x(6u), 16u); w(0u, n.across); y(3u, n.nearest_t_m);
                y(4u, n.weight_per_m * n.distance_to_ray_m); y(5u, n.distance_to_ray_m);",
            inputs: rays_by_lamps(),
            // What the twin tells of its first node.
            twin: Box::new(|x| {
                let mut nodes = EquiAngular::new(&vec3(x, 0), &vec3(x, 3), x[6], 16);
                let node = nodes.next().unwrap();
                let direction = vec3(x, 3);
                let along = node.from_lamp.dot(&direction);
                let h = node.r_m * (1.0 - along * along).sqrt();
                let across = (node.from_lamp - direction * along).normalize();
                let nearest = node.t_m - node.r_m * along;
                vec![across.x, across.y, across.z, nearest, node.weight_per_m * h, h]
            }),
            relative: 1e-6,
            absolute: 2e-6,
            bounded_by: "lamps 0.3 m from rays, 2 m away, to 2e-7 m",
        },
        Row {
            name: "airlight_node",
            body: "let n = airlight_nodes(v(0u), v(3u), x(6u), 16u); let s = airlight_node(n, u32(x(7u)));
                w(0u, n.across * s.y + v(3u) * s.x); y(3u, n.distance_to_ray_m / s.y);",
            inputs: with_index(&rays_by_lamps()),
            twin: Box::new(|x| {
                let node = EquiAngular::new(&vec3(x, 0), &vec3(x, 3), x[6], 16)
                    .nth(x[7] as usize)
                    .unwrap();
                vec![node.from_lamp.x, node.from_lamp.y, node.from_lamp.z, node.r_m]
            }),
            relative: 1e-5,
            absolute: 2e-6,
            bounded_by: "airlight_nodes, and the tangent of its angle",
        },
        Row {
            name: "airlight_one_minus_cos",
            body: "let n = airlight_nodes(v(0u), v(3u), x(6u), 16u); y(0u, airlight_one_minus_cos(airlight_node(n, u32(x(7u)))));",
            inputs: with_index(&rays_by_lamps()),
            twin: Box::new(|x| {
                let node = EquiAngular::new(&vec3(x, 0), &vec3(x, 3), x[6], 16).nth(x[7] as usize);
                vec![1.0 - node.unwrap().cos_scatter]
            }),
            relative: 1e-6,
            absolute: 4e-7,
            bounded_by: "airlight_node",
        },
    ]
}

/// Lamps from 0.3 m off the ray on, ahead and behind, and lengths of the ray.
fn rays_by_lamps() -> Vec<Vec<f32>> {
    let row = |r: Vec<f32>| -> Option<Vec<f32>> {
        let x: Vec<f64> = r.iter().map(|v| f64::from(*v)).collect();
        let (lamp, direction) = (vec3(&x, 0) * 2.0, vec3(&x, 3).normalize());
        (lamp.cross(&direction).norm() > 0.3).then(|| {
            let all = [lamp.as_slice(), direction.as_slice(), &[3.0 + 2.9 * x[6]]].concat();
            all.into_iter().map(|v| v as f32).collect()
        })
    };
    random(10, 1000, 7).into_iter().filter_map(row).collect()
}

fn with_index(rows: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let indices = [0.0, 7.0, 15.0];
    let all = rows
        .iter()
        .flat_map(|row| indices.map(|i| [&row[..], &[i]].concat()));
    all.collect()
}

fn tables() -> Vec<Row> {
    vec![
        Row {
            name: "airlight_grid_hermite",
            body: "let h = airlight_grid_hermite(x(0u)); w(0u, h.xyz); y(3u, h.w);",
            inputs: grid(&[&steps(0.0, 1.0, 101)]),
            twin: Box::new(|x| Hermite::new(x[0]).0.to_vec()),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "airlight_grid_cell",
            body: "let c = airlight_grid_cell(x(0u), 8u); y(0u, c.x); y(1u, c.y);",
            inputs: grid(&[&[-0.5, 0.0, 0.25, 1.0, 3.7, 6.0, 6.5, 7.0]]),
            twin: Box::new(|x| {
                let at = x[0].max(0.0);
                let index = libm::floor(at).min(6.0);
                vec![index, at - index]
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "rounding",
        },
        Row {
            name: "airlight_grid_steps",
            body: "y(0u, airlight_grid_steps(x(0u), 0.75, 32u));",
            inputs: grid(&[&[0.0, 0.01, 0.5, 2.0, 9.0, 1e4, 3e38]]),
            twin: Box::new(|x| vec![32.0 * x[0] / (x[0] + 0.75)]),
            relative: 1e-6,
            absolute: 4e-6,
            bounded_by: "a share of 32 steps",
        },
    ]
}

/// Most of the ray.
const SEEN: [Direction; 2] = [(0.28, -0.96), (0.28, 0.96)];

/// The caster and the section of a row, as the twin has them.
fn shadow_of(x: &[f64]) -> (Caster, Section) {
    let piece = Capped::new(vec3(x, 0), vec3(x, 4), x[3], x[7]);
    let mut shadows = Shadows::new(Vec3::zeros(), core::iter::once((0, piece)));
    let section = Section {
        normal: vec3(x, 16).cross(&vec3(x, 19)),
        across: vec3(x, 16),
        along: vec3(x, 19),
        distance_m: x[22],
        ends: SEEN,
    };
    (shadows.casters.remove(0), section)
}

/// Pieces of rods about a lamp at the origin and rays that pass behind them, not where a hair decides.
fn shadows_of_pieces() -> Vec<Vec<f32>> {
    let row = |r: Vec<f32>| -> Option<Vec<f32>> {
        let x: Vec<f64> = r.iter().map(|v| f64::from(*v)).collect();
        let (centre, axis) = (
            vec3(&x, 0).normalize() * (1.0 + 0.4 * x[12]),
            vec3(&x, 3).normalize(),
        );
        let (half, radius) = (0.5 + 0.3 * x[13], 0.1 + 0.05 * x[14]);
        let aim = centre * 2.0 + vec3(&x, 6) * 0.8;
        let direction = vec3(&x, 9).normalize();
        let foot = aim - direction * aim.dot(&direction);
        let all = [
            centre.as_slice(),
            &[half],
            axis.as_slice(),
            &[radius],
            &[0.0; 8],
            foot.normalize().as_slice(),
            direction.as_slice(),
            &[foot.norm()],
        ]
        .concat();
        let mut row: Vec<f32> = all.into_iter().map(|v| v as f32).collect();
        let exact = |row: &[f32]| row.iter().map(|v| f64::from(*v)).collect::<Vec<_>>();
        let (caster, section) = shadow_of(&exact(&row));
        let [plus, minus] = caster.touching_m.unwrap_or_default();
        for (k, value) in plus.iter().chain(&minus).enumerate() {
            row[8 + k] = *value as f32;
        }
        row[15] = f32::from(u8::from(caster.touching_m.is_some()));
        // The same stretch, nearly, from a section tilted by a hair.
        let tilted = Section {
            normal: (section.normal + axis * 1e-4).normalize(),
            ..section
        };
        let same = |a: f64, b: f64| a == b || (a - b).abs() < 0.05 * a.abs().max(1.0);
        let is_clear = match (caster.span(&section), caster.span(&tilted)) {
            (Some(a), Some(b)) => {
                same(a.from_m, b.from_m)
                    && same(a.to_m, b.to_m)
                    && a.is_behind == b.is_behind
                    && a.from_m.abs().min(a.to_m.abs()) < 50.0
            }
            (None, None) => true,
            _ => false,
        };
        is_clear.then_some(row)
    };
    let rows: Vec<Vec<f32>> = random(11, 3000, 15).into_iter().filter_map(row).collect();
    assert!(rows.len() > 1500, "{}", rows.len());
    rows
}

fn shadows() -> Vec<Row> {
    vec![
        Row {
            name: "shadow_see",
            body: "let section = ShadowSection(vec3<f32>(0.0), 1.0, vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), vec2<f32>(0.0), vec2<f32>(0.0));
                let span = ShadowSpan(vec2<f32>(1.0, -0.5), vec2<f32>(1.0, 0.5), false);
                let s = shadow_see(span, section, v(0u)); y(0u, s.first.x); y(1u, s.first.y); y(2u, s.last.x); y(3u, s.last.y);",
            inputs: grid(&[&[0.7, 1.3], &[-2.0, -0.3, 0.1, 0.4, 3.0], &[0.0, 1.0]]),
            twin: Box::new(|x| {
                let slope = x[1] / x[0];
                let first = if slope < -0.5 { [x[0], x[1]] } else { [1.0, -0.5] };
                let last = if slope > 0.5 { [x[0], x[1]] } else { [1.0, 0.5] };
                [first, last].concat()
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "nothing is computed",
        },
        Row {
            name: "shadow_misses",
            body: "let section = ShadowSection(vec3<f32>(0.0), 1.0, vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), vec2<f32>(0.28, -0.96), vec2<f32>(0.28, 0.96));
                y(0u, f32(shadow_misses(section, v(0u), x(3u))));",
            inputs: grid(&[&[-0.4, 0.13, 0.7, 1.3], &[-2.0, -0.3, 0.1, 1.4], &[0.0], &[0.05, 0.25, 0.71]]),
            twin: Box::new(|x| {
                let beside = 0.28 * x[1].abs() - 0.96 * x[0];
                vec![f64::from(u8::from(beside > x[3] || x[0] - x[3] > 1.0))]
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "yes or no",
        },
        Row {
            name: "shadow_span",
            body: "let section = ShadowSection(cross(v(16u), v(19u)), x(22u), v(16u), v(19u), vec2<f32>(0.28, -0.96), vec2<f32>(0.28, 0.96));
                let caster = Caster(Solid(v(0u), x(3u), v(4u), x(7u)), v(8u), v(11u), u32(x(15u)), 2u);
                let s = shadow_span(caster, section); y(0u, s.x); y(1u, s.y); y(2u, s.z);",
            inputs: shadows_of_pieces(),
            twin: Box::new(|x| {
                let (caster, section) = shadow_of(x);
                let far = f64::from(3e38_f32);
                caster
                    .span(&section)
                    .map_or(vec![1.0, -1.0, 0.0], |span| {
                        let is_behind = f64::from(u8::from(span.is_behind));
                        vec![span.from_m.max(-far), span.to_m.min(far), is_behind]
                    })
            }),
            relative: 1e-4,
            absolute: 3e-5,
            bounded_by: "where a plane nearly touches a side or a rim",
        },
    ]
}

/// A piece and a point as `rectangle` takes them, the lamp at the origin.
fn rectangle(x: &[f64]) -> Option<Rectangle> {
    let piece = Capped::new(vec3(x, 0), vec3(x, 4), x[3], x[7]);
    Rectangle::of(&piece, &vec3(x, 8), &Vec3::zeros())
}

/// Pieces of rods between a lamp at the origin and points, where no limb, end or lamp is just beside the view.
fn rods_before_lamps() -> Vec<Vec<f32>> {
    let row = |r: Vec<f32>| -> Option<Vec<f32>> {
        let x: Vec<f64> = r.iter().map(|v| f64::from(*v)).collect();
        let point = vec3(&x, 0).normalize() * 2.0;
        let centre = point * (0.5 + 0.3 * x[9]) + vec3(&x, 3) * 0.4;
        let axis = vec3(&x, 6).normalize();
        let all = [
            centre.as_slice(),
            &[0.4 + 0.2 * x[10]],
            axis.as_slice(),
            &[0.08 + 0.06 * x[11]],
            point.as_slice(),
        ]
        .concat();
        let row: Vec<f32> = all.into_iter().map(|v| v as f32).collect();
        let exact: Vec<f64> = row.iter().map(|v| f64::from(*v)).collect();
        let found = rectangle(&exact)?;
        let tame = |v: [f64; 2]| v.iter().all(|v| v.abs() < 3.0);
        (tame(found.across) && tame(found.along)).then_some(row)
    };
    let rows: Vec<Vec<f32>> = random(12, 3000, 12).into_iter().filter_map(row).collect();
    assert!(rows.len() > 1500, "{}", rows.len());
    rows
}

fn penumbras() -> Vec<Row> {
    let tangents: &[f32] = &[-2.0, -0.3, -0.01, 0.0, 0.02, 0.7, 1e4];
    let boxes = grid(&[tangents, tangents, tangents, tangents, &[0.006, 0.06]]);
    vec![
        Row {
            name: "penumbra_end_on",
            body: "let s = penumbra_end_on(x(0u), v(1u), v(4u), x(7u)); y(0u, s.across.x); y(1u, s.across.y); y(2u, s.along.x); y(3u, s.along.y);",
            inputs: vec![
                vec![0.1, 0.6, 0.0, 0.8, 0.3, 0.2, 1.0, 0.98],
                vec![0.02, 0.0, -1.0, 0.0, 0.1, -0.5, -0.2, 0.5],
                vec![0.3, 0.48, 0.6, 0.64, 1.0, 1.0, 1.0, 1.72],
            ],
            twin: Box::new(|x| {
                let cap = (vec3(x, 4), x[7]);
                let behind = (vec3(x, 4), x[7] + 1.0);
                let seen = Rectangle::end_on(x[0], &vec3(x, 1), [behind, cap]);
                [seen.across, seen.along].concat()
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "rounding",
        },
        Row {
            name: "penumbra_rectangle",
            body: "let s = penumbra_rectangle(Solid(v(0u), x(3u), v(4u), x(7u)), v(8u));
                y(0u, s.across.x); y(1u, s.across.y); y(2u, s.along.x); y(3u, s.along.y);",
            inputs: rods_before_lamps(),
            twin: Box::new(|x| {
                let seen = rectangle(x).unwrap();
                [seen.across, seen.along].concat()
            }),
            relative: 1e-4,
            absolute: 2e-5,
            bounded_by: "axes that pass near the point, and ends near it",
        },
        Row {
            name: "penumbra_share",
            body: "y(0u, penumbra_share(PenumbraRectangle(vec2<f32>(x(0u), x(1u)), vec2<f32>(x(2u), x(3u))), x(4u)));",
            inputs: boxes
                .into_iter()
                .filter(|x| x[0] < x[1] && x[2] < x[3])
                .collect(),
            twin: Box::new(|x| {
                let rectangle = Rectangle {
                    across: [x[0], x[1]],
                    along: [x[2], x[3]],
                };
                vec![rectangle.share(x[4])]
            }),
            relative: 0.0,
            absolute: 2e-6,
            bounded_by: "an arc tangent",
        },
    ]
}

pub(super) fn rows() -> Vec<Row> {
    let mut rows = media();
    rows.extend(floors());
    rows.extend(lamps());
    rows.extend(tables());
    rows.extend(shadows());
    rows.extend(penumbras());
    rows
}
