//! The glass before a camera.

use rodsight_geometry::Vec3;
use rodsight_geometry::port::{DomePort, FlatPort, Port, PortShape};

use super::{grid, random, steps, vec3};
use crate::gpu::shader_parity::Row;

const GLASS: f64 = 1.49;

fn flat(inner_m: f64, water_index: f64) -> Port {
    let plate = FlatPort {
        normal: Vec3::new(0.28, 0.0, 0.96),
        distance_m: inner_m,
        thickness_m: 0.01,
    };
    Port::new(PortShape::Flat(plate), GLASS, [water_index; 3]).expect("a port")
}

fn dome(centre_m: Vec3, water_index: f64) -> Port {
    let shell = DomePort {
        centre_m,
        inner_radius_m: 0.06,
        thickness_m: 0.006,
    };
    Port::new(PortShape::Dome(shell), GLASS, [water_index; 3]).expect("a port")
}

fn of_ray(port: &Port, air: &Vec3) -> Vec<f64> {
    let ray = port.water_ray(air).expect("all look at the port");
    let gain = [ray.gain];
    [ray.origin_m.as_slice(), ray.direction.as_slice(), &gain].concat()
}

/// Unit directions up to `steepest` times the axis to either side, with what a port is given by.
fn ahead(steepest: f64, rest: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let directions = random(31, 400, 2).into_iter().map(|r| {
        let direction =
            Vec3::new(steepest * f64::from(r[0]), steepest * f64::from(r[1]), 1.0).normalize();
        direction.iter().map(|v| *v as f32).collect::<Vec<_>>()
    });
    let rows = directions.flat_map(|d| rest.iter().map(move |rest| [&d[..], rest].concat()));
    rows.collect()
}

/// Points in the water, 0.2 m to 8 m away. Steeper ones are seen along the plate, where a hair's breadth of them is a degree.
fn points(rest: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let rows = ahead(0.5, rest)
        .into_iter()
        .enumerate()
        .map(|(i, mut row)| {
            let range_m = 0.2 * [1.0, 1.8, 3.4, 6.3, 11.7, 21.6, 40.0][i % 7];
            row[..3].iter_mut().for_each(|v| *v *= range_m);
            row
        });
    rows.collect()
}

fn plates() -> Vec<Vec<f32>> {
    grid(&[&[0.0, 0.02, 0.1], &[1.33, 1.345]])
}

/// Water's index and the dome's centre.
fn shells() -> Vec<Vec<f32>> {
    let centres = [
        [0.0; 3],
        [0.0, 0.0, 2e-3],
        [1e-3, -2e-3, -5e-3],
        [0.02, 0.01, 0.03],
    ];
    let row = |index: f32| centres.map(|c| vec![index, c[0], c[1], c[2]]);
    [1.33, 1.345].into_iter().flat_map(row).collect()
}

pub(super) fn rows() -> Vec<Row> {
    vec![
        Row {
            name: "port_refract",
            body: "let r = port_refract(v(0u), vec3<f32>(0.0, 0.0, 1.0), 1.0, x(3u)); w(0u, r.xyz); y(3u, r.w);",
            inputs: ahead(0.75, &grid(&[&[1.0, 1.33, 1.49]])),
            // Behind a plate of nothing.
            twin: Box::new(|x| {
                let plate = FlatPort {
                    normal: Vec3::z(),
                    distance_m: 0.0,
                    thickness_m: 0.0,
                };
                let port = Port::new(PortShape::Flat(plate), 1.0, [x[3]; 3]).unwrap();
                let ray = port.water_ray(&vec3(x, 0)).unwrap();
                let passed = [ray.gain * x[3] * x[3]];
                [ray.direction.as_slice(), &passed].concat()
            }),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "port_leave",
            body: "w(0u, port_leave(v(0u) * x(6u), v(3u), 0.06));",
            inputs: random(32, 2000, 7)
                .into_iter()
                .map(|r| {
                    let x: Vec<f64> = r.iter().map(|v| f64::from(*v)).collect();
                    let (start, direction) = (vec3(&x, 0).normalize(), vec3(&x, 3).normalize());
                    let all = [start.as_slice(), direction.as_slice(), &[0.057 * x[6].abs()]].concat();
                    all.into_iter().map(|v| v as f32).collect()
                })
                .collect(),
            twin: Box::new(|x| {
                let (start, direction) = (vec3(x, 0) * x[6], vec3(x, 3));
                let along = start.dot(&direction);
                let t = (along * along - start.norm_squared() + 0.06 * 0.06).sqrt() - along;
                (start + direction * t).as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 4e-8,
            bounded_by: "6 cm to 2e-7; directions of a length of 1 to 1e-7",
        },
        Row {
            name: "port_flat_ray",
            body: "let port = Port(vec3<f32>(0.28, 0.0, 0.96), x(3u), 0.01, 1.49, x(4u));
                let r = port_flat_ray(port, v(0u)); w(0u, r.origin_m); w(3u, r.direction); y(6u, r.gain);",
            inputs: ahead(0.75, &plates()),
            twin: Box::new(|x| of_ray(&flat(x[3], x[4]), &vec3(x, 0))),
            relative: 0.0,
            absolute: 4e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "port_dome_ray",
            body: "let port = Port(v(4u), 0.06, 0.006, 1.49, x(3u));
                let r = port_dome_ray(port, v(0u)); w(0u, r.origin_m); w(3u, r.direction); y(6u, r.gain);",
            inputs: ahead(0.75, &shells()),
            twin: Box::new(|x| of_ray(&dome(vec3(x, 4), x[3]), &vec3(x, 0))),
            relative: 0.0,
            absolute: 4e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "port_flat_seen",
            body: "let port = Port(vec3<f32>(0.28, 0.0, 0.96), x(3u), 0.01, 1.49, x(4u));
                w(0u, port_flat_seen(port, v(0u)));",
            inputs: points(&plates()),
            twin: Box::new(|x| {
                let seen = flat(x[3], x[4]).air_direction(&vec3(x, 0));
                seen.unwrap_or_default().as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 4e-7,
            bounded_by: "1e-3 px of a lens of 2500 px",
        },
        Row {
            name: "port_turned",
            body: "let r = port_turned(vec2<f32>(x(0u), x(1u)), x(2u)); y(0u, r.x); y(1u, r.y);",
            inputs: grid(&[&[0.6], &[0.8], &steps(-0.99, 0.99, 101)]),
            twin: Box::new(|x| {
                let angle = libm::atan2(x[1], x[0]) + libm::asin(x[2]);
                vec![libm::cos(angle), libm::sin(angle)]
            }),
            relative: 0.0,
            absolute: 2e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "port_dome_seen",
            body: "let port = Port(v(4u), 0.06, 0.006, 1.49, x(3u));
                w(0u, port_dome_seen(port, v(0u)));",
            inputs: points(&shells()),
            twin: Box::new(|x| {
                let seen = dome(vec3(x, 4), x[3]).air_direction(&vec3(x, 0));
                seen.unwrap_or_default().as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 4e-7,
            bounded_by: "1e-3 px of a lens of 2500 px",
        },
    ]
}
