//! The table: each function's grid, twin and tolerance.

mod camera;
mod content;
mod daylight;
mod finish;
mod halo;
mod light;
mod port;
mod sensor;
mod snow;
mod solid;

use super::Row;
use crate::noise::Philox;
use rodsight_geometry::Vec3;

pub(super) fn all() -> Vec<Row> {
    let mut rows = camera::rows();
    rows.extend(solid::rows());
    rows.extend(light::rows());
    rows.extend(halo::rows());
    rows.extend(port::rows());
    rows.extend(snow::rows());
    rows.extend(daylight::rows());
    rows.extend(finish::rows());
    rows.extend(content::rows());
    rows.extend(sensor::rows());
    rows
}

fn vec3(x: &[f64], at: usize) -> Vec3 {
    Vec3::new(x[at], x[at + 1], x[at + 2])
}

fn yes(is_so: bool) -> Vec<f64> {
    vec![f64::from(u8::from(is_so))]
}

/// Every combination of the values.
fn grid(axes: &[&[f32]]) -> Vec<Vec<f32>> {
    axes.iter().fold(vec![Vec::new()], |rows, axis| {
        let longer = rows.iter().flat_map(|row| {
            axis.iter().map(move |value| {
                let mut row = row.clone();
                row.push(*value);
                row
            })
        });
        longer.collect()
    })
}

/// So many values from one to another, both included.
fn steps(from: f32, to: f32, count: u16) -> Vec<f32> {
    let share = |i: u16| f32::from(i) / f32::from(count - 1);
    (0..count).map(|i| from + (to - from) * share(i)).collect()
}

/// Rows of numbers in [−1, 1), the same in every run.
fn random(seed: u64, rows: u32, columns: u32) -> Vec<Vec<f32>> {
    let row = |i: u32| {
        let number = |k: u32| Philox::new(seed).uniforms([i, k, 0, 0])[0];
        (0..columns)
            .map(|k| (2.0 * number(k) - 1.0) as f32)
            .collect()
    };
    (0..rows).map(row).collect()
}
