// Elementary functions where WGSL's own may be too coarse for a hundredth of a pixel: it lets sine and cosine be wrong by
// 2^-11 and atan2 by 4096 units in the last place.

/// (sin x, cos x) for |x| ≤ π, within 4e-7: Taylor's series of x/2 and the double angle.
fn maths_sincos(x: f32) -> vec2<f32> {
    let h = 0.5 * x;
    let q = h * h;
    let s = h * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0
        + q * (1.0 / 362880.0 + q * (-1.0 / 39916800.0 + q * (1.0 / 6227020800.0)))))));
    let c = 1.0 + q * (-1.0 / 2.0 + q * (1.0 / 24.0 + q * (-1.0 / 720.0
        + q * (1.0 / 40320.0 + q * (-1.0 / 3628800.0 + q * (1.0 / 479001600.0))))));
    return vec2<f32>(2.0 * s * c, (c - s) * (c + s));
}

/// The angle of (x, y) ≠ 0, rad in [-π, π]: the built-in's answer and one Newton step.
fn maths_atan2(y: f32, x: f32) -> f32 {
    let near = atan2(y, x);
    let turn = maths_sincos(near);
    return near + (y * turn.y - x * turn.x) / length(vec2<f32>(x, y));
}

/// 1 - e^(-x) for x >= 0, by its series where the difference would cancel.
fn maths_rise(x: vec3<f32>) -> vec3<f32> {
    let series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)));
    return select(1.0 - exp(-x), series, x < vec3<f32>(0.05));
}
