// The transfer function of sRGB: see srgb.rs.

/// Encoded value in [0, 1] of a linear value; clips to [0, 1].
fn srgb_encode(linear: f32) -> f32 {
    let x = clamp(linear, 0.0, 1.0);
    let steep = max(x, 0.0031308);
    // x^(5/12), the built-in's answer and one Newton step, which leaves a twelfth of its error's square and of rounding.
    let near = pow(steep, 5.0 / 12.0);
    let near3 = near * near * near;
    let near6 = near3 * near3;
    let square = steep * steep;
    let root = near + near * (square * square * steep / (near6 * near6) - 1.0) / 12.0;
    return select(1.055 * root - 0.055, 12.92 * x, x <= 0.0031308);
}
