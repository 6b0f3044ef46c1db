//! Marine snow.

use rodsight_optics::sphere_share;

use super::{grid, random, steps};
use crate::cpu::snow::disc::{area_in_disc, sector, triangle_in_disc};
use crate::gpu::shader_parity::Row;

/// Two points up to 3 radii from the centre, not where a hair decides on which side the centre lies.
fn edges() -> Vec<Vec<f32>> {
    let all = random(41, 3000, 4).into_iter();
    all.map(|row| row.iter().map(|v| 3.0 * v).collect())
        .filter(|p: &Vec<f32>| {
            let (cross, dot) = (p[0] * p[3] - p[1] * p[2], p[0] * p[2] + p[1] * p[3]);
            cross.abs() > 1e-3 || dot > 0.0
        })
        .collect()
}

/// Corners near discs, and sides of pixels from a fiftieth of a radius to forty.
fn pixels() -> Vec<Vec<f32>> {
    let all = random(42, 600, 4).into_iter();
    all.flat_map(|r| {
        [0.02_f32, 0.3, 2.0, 40.0].map(|side| {
            let reach = 1.5 + side;
            let (a, b) = (side, 0.2 * side * r[2]);
            vec![
                reach * r[0] - 0.5 * side,
                reach * r[1] - 0.5 * side,
                a,
                b,
                -b,
                a,
            ]
        })
    })
    .collect()
}

pub(super) fn rows() -> Vec<Row> {
    let two = |x: &[f64]| ([x[0], x[1]], [x[2], x[3]]);
    vec![
        Row {
            name: "sphere_share",
            body: "y(0u, sphere_share(x(0u)));",
            inputs: grid(&[&steps(-1.0, 1.0, 2001)]),
            twin: Box::new(|x| vec![sphere_share(x[0])]),
            relative: 0.0,
            absolute: 2e-7,
            bounded_by: "an angle to 4e-7",
        },
        Row {
            name: "disc_cross",
            body: "y(0u, disc_cross(vec2<f32>(x(0u), x(1u)), vec2<f32>(x(2u), x(3u))));",
            inputs: random(40, 500, 4),
            twin: Box::new(|x| vec![x[0] * x[3] - x[1] * x[2]]),
            relative: 0.0,
            absolute: 1.2e-7,
            bounded_by: "rounding of products",
        },
        Row {
            name: "disc_sector",
            body: "y(0u, disc_sector(vec2<f32>(x(0u), x(1u)), vec2<f32>(x(2u), x(3u))));",
            inputs: edges(),
            twin: Box::new(move |x| {
                let (p, q) = two(x);
                vec![sector(p, q)]
            }),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "an angle to 4e-7, of vectors that nearly cancel",
        },
        Row {
            name: "disc_triangle",
            body: "y(0u, disc_triangle(vec2<f32>(x(0u), x(1u)), vec2<f32>(x(2u), x(3u))));",
            inputs: edges(),
            twin: Box::new(move |x| {
                let (p, q) = two(x);
                vec![triangle_in_disc(p, q)]
            }),
            relative: 0.0,
            absolute: 2e-6,
            bounded_by: "disc_sector",
        },
        Row {
            name: "disc_area",
            body: "y(0u, disc_area(vec2<f32>(x(0u), x(1u)), vec2<f32>(x(2u), x(3u)), vec2<f32>(x(4u), x(5u))));",
            inputs: pixels(),
            twin: Box::new(|x| {
                let at = |right: f64, down: f64| {
                    [0, 1].map(|k| x[k] + right * x[2 + k] + down * x[4 + k])
                };
                let corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
                vec![area_in_disc(&corners)]
            }),
            relative: 1e-4,
            absolute: 4e-6,
            bounded_by: "four triangles that nearly cancel beside the disc",
        },
    ]
}
