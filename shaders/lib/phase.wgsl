// Phase functions, sr⁻¹: see optics/src/phase.rs.

/// One Henyey–Greenstein lobe, from its constants (amplitude, (1 - g)², 2g) and 1 - cos θ. The printed denominator
/// 1 + g² - 2g cos θ cancels for g near 1, just where the lobe is highest.
fn phase_lobe_per_sr(lobe: vec3<f32>, one_minus_cos: f32) -> f32 {
    let x = lobe.y + lobe.z * one_minus_cos;
    return lobe.x / (x * sqrt(x));
}

/// Place of an angle in the table of a phase function that is no sum of lobes, in [0, 1]: (sin²(θ/2))^(1/8), which spreads the
/// forward peak. The table holds logarithms.
fn phase_table_place(one_minus_cos: f32) -> f32 {
    return sqrt(sqrt(sqrt(clamp(0.5 * one_minus_cos, 0.0, 1.0))));
}
