//! Light scattered forwards.

use rodsight_optics::{Halo, Wells, water};

use super::{grid, steps};
use crate::cpu::plane::parents;
use crate::gpu::shader_parity::Row;

pub(super) fn rows() -> Vec<Row> {
    let medium = water::by_name("1C").expect("a row of the table").medium();
    let halo = Halo::new(&medium, 196.0);
    let c = medium.beam_attenuation_per_m().map(|c| c as f32);
    let regained = Wells::of(&medium).map(|band| band.regained_per_m(0.0) as f32);
    let (knots, longest_m) = halo.knots();
    let last = (knots.len() - 1) as f32;
    vec![
        Row {
            name: "maths_rise",
            body: "y(0u, maths_rise(vec3<f32>(x(0u))).x);",
            inputs: grid(&[&[&steps(0.0, 0.1, 201)[..], &steps(0.1, 30.0, 201), &[3e38]].concat()]),
            twin: Box::new(|x| vec![-libm::expm1(-x[0])]),
            relative: 6e-6,
            absolute: 0.0,
            bounded_by: "from 0.05 on an exponential to 3e-7 is taken from 1",
        },
        Row {
            name: "halo_total",
            body: "w(0u, halo_total(v(0u), v(3u), x(6u)));",
            inputs: grid(&[
                &[c[0]],
                &[c[1]],
                &[c[2]],
                &[regained[0]],
                &[regained[1]],
                &[regained[2]],
                &[&steps(0.0, 0.2, 41)[..], &steps(0.2, 12.0, 101)].concat(),
            ]),
            twin: Box::new(move |x| halo.total(x[6]).to_vec()),
            relative: 5e-6,
            absolute: 1e-9,
            bounded_by: "maths_rise, and coefficients rounded to f32",
        },
        Row {
            name: "halo_place",
            body: "y(0u, halo_place(x(0u), x(1u), u32(x(2u))));",
            inputs: grid(&[
                &[0.0, 0.01, 1.0, 7.7, 1e4, 3e38],
                &[longest_m as f32],
                &[last],
            ]),
            twin: Box::new(|x| vec![(x[0] / x[1]).sqrt().min(1.0) * x[2]]),
            relative: 3e-7,
            absolute: 0.0,
            bounded_by: "rounding",
        },
        Row {
            name: "halo_parents",
            body: "let p = halo_parents(i32(x(0u))); y(0u, f32(p.x)); y(1u, f32(p.y));",
            inputs: grid(&[&[-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 501.0]]),
            twin: Box::new(|x| {
                let (near, next) = parents(x[0] as isize);
                vec![near as f64, next as f64]
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "whole numbers",
        },
    ]
}
