//! Daylight.

use rodsight_optics::Daylight;

use super::{grid, steps};
use crate::gpu::shader_parity::Row;

pub(super) fn rows() -> Vec<Row> {
    let daylight = |x: &[f64]| Daylight {
        irradiance_w_per_m2: [x[0]; 3],
        diffuse_attenuation_per_m: [x[1]; 3],
    };
    vec![
        Row {
            name: "daylight_downwelling",
            body: "y(0u, daylight_downwelling(vec3<f32>(x(0u)), vec3<f32>(x(1u)), x(2u)).x);",
            inputs: grid(&[&[0.0, 2.5], &[0.0, 0.05, 0.6], &steps(-3.0, 12.0, 101)]),
            twin: Box::new(move |x| vec![daylight(x).downwelling(x[2])[0]]),
            relative: 2e-6,
            absolute: 0.0,
            bounded_by: "rounding of an exponent up to 8",
        },
        Row {
            name: "daylight_face_share",
            body: "y(0u, daylight_face_share(x(0u)));",
            inputs: grid(&[&steps(-1.0, 1.0, 101)]),
            twin: Box::new(|x| vec![Daylight::face_share(x[0])]),
            relative: 0.0,
            absolute: 1e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "daylight_veil",
            body: "y(0u, daylight_veil(vec3<f32>(x(0u)), vec3<f32>(x(2u)), vec3<f32>(x(3u)), vec3<f32>(x(1u)), x(4u), x(5u)).x);",
            inputs: grid(&[
                &[0.0, 2.5],
                &[0.05, 0.6],
                &[0.1, 0.7],
                &[0.0, 0.08],
                &[-1.0, -0.3, 0.0, 0.8],
                &[0.0, 0.01, 0.2, 1.0, 5.0, 40.0, 3e38],
            ]),
            twin: Box::new(move |x| {
                let veil = daylight(x).veil([&[x[2]; 3], &[x[3]; 3]], 0.0, x[4], x[5]);
                vec![veil[0]]
            }),
            relative: 6e-6,
            absolute: 0.0,
            bounded_by: "maths_rise",
        },
    ]
}
