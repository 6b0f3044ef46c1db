// The tabulated airlight: see cpu/airlight_grid.rs.

/// Weights of the cubic through two values and their slopes: value, slope, next value, next slope; x in [0, 1].
fn airlight_grid_hermite(x: f32) -> vec4<f32> {
    let rest = 1.0 - x;
    return vec4<f32>(
        (1.0 + 2.0 * x) * rest * rest,
        x * rest * rest,
        x * x * (3.0 - 2.0 * x),
        -x * x * rest,
    );
}

/// The cell of a coordinate in cells, of so many corners, and the place in it.
fn airlight_grid_cell(at: f32, corners: u32) -> vec2<f32> {
    let index = min(floor(max(at, 0.0)), f32(corners - 2u));
    return vec2<f32>(index, max(at, 0.0) - index);
}

/// Steps along a ray of length t: t/(t + h) of them all.
fn airlight_grid_steps(distance_m: f32, half_way_m: f32, steps: u32) -> f32 {
    return f32(steps) * (1.0 - half_way_m / (distance_m + half_way_m));
}
