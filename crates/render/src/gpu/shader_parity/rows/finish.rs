//! Axes, stripes and grain of rods, coats.

use rodsight_geometry::Vec3;
use rodsight_optics::{Coat, Cosines};
use rodsight_scene::{Bend, Finish, Grain, Material, Rod, Stripes};

use super::{grid, random, steps, vec3};
use crate::cpu::arc::Arc;
use crate::cpu::finish::{self, Place};
use crate::cpu::solid::Ray;
use crate::gpu::shader_parity::Row;

const RADIUS_M: f64 = 0.05;
/// A scene's seed whose word for the first rod is a finite number as bits of `f32`, in which the tests carry it.
const SEED: u64 = 5;

fn rod(sagitta_m: f64) -> Rod {
    let direction = Vec3::new(0.1, 0.2, 1.0).normalize();
    Rod {
        id: "r".to_owned(),
        centre_m: Vec3::new(2.0, 0.1, -0.2),
        direction,
        length_m: 3.0,
        radius_m: RADIUS_M,
        bend: (sagitta_m > 0.0).then(|| Bend {
            sagitta_m,
            towards: direction.cross(&Vec3::x()).normalize(),
        }),
        material: Material::Lambert([0.25, 0.5, 0.75]),
        finish: Finish {
            stripes: Some(stripes()),
            grain: Some(grain()),
            gloss: None,
        },
        fouling: None,
    }
}

fn stripes() -> Stripes {
    Stripes {
        period_m: 0.125,
        albedo: [0.875, 0.5, 0.125],
        share: 0.25,
        starts: 2,
    }
}

fn grain() -> Grain {
    Grain {
        contrast: 0.5,
        scale_m: 0.0625,
    }
}

/// Reads an arc from sixteen numbers, and the finish of the rods here with the seed in the seventeenth.
const READ: &str = "let arc = Arc(v(0u), x(3u), v(4u), v(8u), v(12u));
    let f = Finish(vec3<f32>(0.875, 0.5, 0.125), 0.125, 0.25, 2.0, 0.5, 0.0625, u(16u), 0.05);";

fn bends() -> [Rod; 4] {
    [0.0, 1e-4, 0.05, 0.4].map(rod)
}

fn seed() -> f32 {
    let word = f32::from_bits(finish::seed_word(SEED, 0));
    assert!(word.is_finite(), "another seed");
    word
}

/// An arc as `READ` takes it, with its number after the curvature's vector.
fn arc_numbers(index: usize, rod: &Rod) -> Vec<f32> {
    let arc = Arc::of(rod);
    let middle = arc.at(0.0);
    let (inward, [_, side]) = (arc.inward(&middle.direction), arc.across(0.0));
    let all = [
        middle.point_m.as_slice(),
        &[arc.curvature_per_m],
        middle.direction.as_slice(),
        &[index as f64],
        inward.as_slice(),
        &[0.0],
        side.as_slice(),
        &[0.0, 0.0],
    ];
    let mut row: Vec<f32> = all.concat().into_iter().map(|v| v as f32).collect();
    row[16] = seed();
    row
}

/// Arcs of all bends, then a point, a normal, a direction and a footprint (0 to 10 mm) on their sides.
fn on_sides() -> Vec<Vec<f32>> {
    let mut rows = Vec::new();
    for (index, rod) in bends().iter().enumerate() {
        let arc = Arc::of(rod);
        for r in random(20, 1000, 5) {
            let [along, turn, a, b, width] = [0, 1, 2, 3, 4].map(|k| f64::from(r[k]));
            let s_m = 1.4 * along;
            let [e1, e2] = arc.across(s_m);
            let (sin, cos) = libm::sincos(3.1 * turn);
            let normal = e1 * cos + e2 * sin;
            let axis = arc.at(s_m);
            let sideways = axis.direction * a + axis.direction.cross(&normal) * b;
            let direction = (sideways - normal).normalize();
            let point_m = axis.point_m + normal * RADIUS_M;
            let all = [
                point_m.as_slice(),
                normal.as_slice(),
                direction.as_slice(),
                &[5e-3 * (1.0 + width)],
            ];
            let mut row = arc_numbers(index, rod);
            row.extend(all.concat().into_iter().map(|v| v as f32));
            rows.push(row);
        }
    }
    rows
}

fn place(x: &[f64]) -> (Rod, Arc, Place) {
    let rod = bends()[x[7] as usize].clone();
    let arc = Arc::of(&rod);
    let place = Place::new(&arc, &vec3(x, 17), &vec3(x, 20), &vec3(x, 23), x[26]);
    (rod, arc, place)
}

const PLACE: &str = "let p = finish_place(arc, v(17u), v(20u), v(23u), x(26u));";

/// Reads arc, finish and place, then does more.
fn with_place(more: &str) -> &'static str {
    Box::leak(format!("{READ}{PLACE}{more}").into_boxed_str())
}

fn arcs() -> Vec<Row> {
    let along = bends().into_iter().enumerate().flat_map(|(index, rod)| {
        let with = move |s_m: f32| [arc_numbers(index, &rod), vec![s_m]].concat();
        steps(-1.4, 1.4, 301).into_iter().map(with)
    });
    vec![
        Row {
            name: "arc_at",
            body: with_read("let p = arc_at(arc, x(17u)); w(0u, p.point_m); w(3u, p.direction);"),
            inputs: along.collect(),
            twin: Box::new(|x| {
                let at = Arc::of(&bends()[x[7] as usize]).at(x[17]);
                [at.point_m.as_slice(), at.direction.as_slice()].concat()
            }),
            relative: 3e-7,
            absolute: 3e-7,
            bounded_by: "places 2 m away",
        },
        Row {
            name: "arc_parameter_of",
            body: with_read("y(0u, arc_parameter_of(arc, v(17u)));"),
            inputs: on_sides(),
            twin: Box::new(|x| vec![Arc::of(&bends()[x[7] as usize]).parameter_of(&vec3(x, 17))]),
            relative: 3e-7,
            absolute: 6e-7,
            bounded_by: "points 2 m away, to 2e-7 m",
        },
    ]
}

fn with_read(more: &str) -> &'static str {
    Box::leak(format!("{READ}{more}").into_boxed_str())
}

/// Whether a stripe's edge is nearer than rounding, in periods, to either end of a sample.
fn at_an_edge(x: &[f64]) -> bool {
    let (_, _, place) = place(x);
    let s = stripes();
    place.change(&(place.axis / s.period_m)) < 1e-3
}

fn finishes() -> Vec<Row> {
    let noise: Vec<Vec<f32>> = grid(&[&[seed()], &steps(-9.3, 11.4, 61), &steps(0.0, 5.0, 41)]);
    vec![
        Row {
            name: "finish_place",
            body: with_place(
                "y(0u, p.along_m); y(1u, p.angle_rad); w(2u, p.axis); w(5u, p.around);",
            ),
            inputs: on_sides(),
            twin: Box::new(|x| {
                let (_, _, p) = place(x);
                let lone = [p.along_m, p.angle_rad];
                [&lone, p.axis.as_slice(), p.around.as_slice()].concat()
            }),
            relative: 0.0,
            absolute: 2e-5,
            bounded_by: "points 2 m away, to 3e-7 m, on a radius of 5 cm",
        },
        Row {
            name: "finish_change",
            body: with_place("y(0u, finish_change(p, p.axis)); y(1u, finish_change(p, p.around));"),
            inputs: on_sides(),
            twin: Box::new(|x| {
                let (_, _, p) = place(x);
                vec![p.change(&p.axis), p.change(&p.around)]
            }),
            relative: 2e-6,
            absolute: 1e-8,
            bounded_by: "finish_place",
        },
        Row {
            name: "finish_up_to",
            body: "y(0u, finish_up_to(0.25, x(0u)));",
            inputs: grid(&[&steps(-1.9, 2.0, 201)]),
            twin: Box::new(|x| vec![finish::up_to(0.25, x[0])]),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "finish_covered",
            body: with_place("y(0u, finish_covered(f, p));"),
            inputs: on_sides()
                .into_iter()
                .filter(|row| !at_an_edge(&row.iter().map(|v| f64::from(*v)).collect::<Vec<_>>()))
                .collect(),
            twin: Box::new(|x| {
                let (_, _, p) = place(x);
                vec![finish::covered(&stripes(), &p, RADIUS_M)]
            }),
            relative: 0.0,
            absolute: 1e-3,
            bounded_by: "1e-6 of a period in a sample of a thousandth of one",
        },
        Row {
            name: "finish_value_noise",
            body: "y(0u, finish_value_noise(u(0u), 2u, vec2<f32>(x(1u), x(2u)), 5u));",
            inputs: noise,
            twin: Box::new(|x| {
                let word = (x[0] as f32).to_bits();
                vec![finish::value_noise(word, 2, x[1], x[2], 5)]
            }),
            relative: 0.0,
            absolute: 4e-6,
            bounded_by: "places between nodes ten away, to 1e-6",
        },
        Row {
            name: "finish_relief",
            body: with_place("y(0u, finish_relief(f, p));"),
            inputs: on_sides(),
            twin: Box::new(|x| {
                let (_, _, p) = place(x);
                vec![finish::relief(
                    &grain(),
                    &p,
                    RADIUS_M,
                    finish::seed_word(SEED, 0),
                )]
            }),
            relative: 0.0,
            absolute: 1e-4,
            bounded_by: "the finest octave's places, hundreds of nodes away, to 1e-4",
        },
        Row {
            name: "finish_albedo",
            body: with_place("w(0u, finish_albedo(f, vec3<f32>(0.25, 0.5, 0.75), p));"),
            inputs: on_sides(),
            twin: Box::new(|x| {
                let (rod, arc, _) = place(x);
                let ray = Ray {
                    origin_m: vec3(x, 17),
                    direction: vec3(x, 23),
                };
                let seed_word = finish::seed_word(SEED, 0);
                let at = (&ray, 0.0, &vec3(x, 20));
                finish::albedo((&rod, &arc), &[0.25, 0.5, 0.75], seed_word, at, x[26]).to_vec()
            }),
            relative: 0.0,
            absolute: 1e-3,
            bounded_by: "finish_covered and finish_relief",
        },
    ]
}

/// sin² and cosine of the half vector's angle to the normal, and the other cosines.
fn lights() -> Vec<Vec<f32>> {
    let widths: &[f32] = &[0.05, 0.3, 1.0];
    let angles: &[f32] = &[0.0, 1e-3, 0.01, 0.2, 1.3];
    grid(&[
        widths,
        angles,
        &[0.01, 0.4, 1.0],
        &[0.02, 0.9],
        &[0.05, 1.0],
        &[0.0, 0.02, 0.9],
    ])
}

fn coats() -> Vec<Row> {
    vec![
        Row {
            name: "gloss_coat",
            body: "let c = gloss_coat(x(0u), vec3<f32>(1.0), x(1u)); y(0u, c.width2); w(1u, c.reflectance);",
            inputs: grid(&[&[0.05, 0.3, 0.9, 1.0], &[0.0, 0.01, 0.3, 5.0]]),
            // A perfect mirror of that width sends 1/(4α²) straight back.
            twin: Box::new(|x| {
                let at = Cosines {
                    light: 1.0,
                    eye: 1.0,
                    half: 1.0,
                    ray_half: 1.0,
                };
                let peak = Coat::new(x[0], [1.0; 3], x[1]).reflection(&[0.0; 3], &at)[0];
                vec![0.25 / peak, 1.0, 1.0, 1.0]
            }),
            relative: 1e-6,
            absolute: 0.0,
            bounded_by: "rounding",
        },
        Row {
            name: "gloss_schlick",
            body: "w(0u, gloss_schlick(vec3<f32>(0.0, 0.25, 1.0), x(0u)));",
            inputs: grid(&[&steps(0.0, 1.0, 101)]),
            twin: Box::new(|x| {
                let rest = libm::pow(1.0 - x[0], 5.0);
                [0.0, 0.25, 1.0].map(|r| r + (1.0 - r) * rest).to_vec()
            }),
            relative: 1e-6,
            absolute: 1e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "gloss_reflection",
            body: "let c = gloss_coat(x(0u), vec3<f32>(0.0, 0.25, x(5u)), 0.0); let s = maths_sincos(x(1u)).x;
                w(0u, gloss_reflection(c, vec3<f32>(0.5, 0.25, 0.125), GlossCosines(x(2u), x(3u), s * s, x(4u))));",
            inputs: lights(),
            twin: Box::new(|x| {
                let at = Cosines {
                    light: x[2],
                    eye: x[3],
                    half: libm::cos(x[1]),
                    ray_half: x[4],
                };
                let coat = Coat::new(x[0], [0.0, 0.25, x[5]], 0.0);
                coat.reflection(&[0.5, 0.25, 0.125], &at).to_vec()
            }),
            relative: 5e-6,
            absolute: 1e-7,
            bounded_by: "rounding, ten times over",
        },
    ]
}

pub(super) fn rows() -> Vec<Row> {
    let mut rows = arcs();
    rows.extend(finishes());
    rows.extend(coats());
    rows
}
