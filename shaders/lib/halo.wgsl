// Light that the water scatters forwards: see optics/src/wells.rs and cpu/plane.rs.

/// MTF(0, z) - e^(-c z): the part of a surface's light that arrives scattered; `regained_per_m` is what small angles give back of c.
fn halo_total(attenuation_per_m: vec3<f32>, regained_per_m: vec3<f32>, range_m: f32) -> vec3<f32> {
    return medium_transmittance(attenuation_per_m - regained_per_m, range_m) * maths_rise(regained_per_m * range_m);
}

/// Where a range lies among the knots of the table of shares.
fn halo_place(range_m: f32, longest_m: f32, last_knot: u32) -> f32 {
    return min(sqrt(range_m / longest_m), 1.0) * f32(last_knot);
}

/// The cell of half the resolution that a cell lies in, and the next nearest.
fn halo_parents(at: i32) -> vec2<i32> {
    let near = at >> 1u;
    return vec2<i32>(near, select(near + 1, near - 1, (at & 1) == 0));
}
