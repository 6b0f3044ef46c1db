// Stripes and grain of a rod's side, in the rod's own coordinates: see cpu/finish.rs.

const FINISH_TURN_RAD: f32 = 6.28318530717959;

struct Finish {
    /// Albedo of the stripes.
    stripe: vec3<f32>,
    /// From one stripe to the next, m; 0 for none.
    period_m: f32,
    /// Share of the rod that they cover.
    share: f32,
    /// 0: rings; n: n interleaved right-handed helices.
    starts: f32,
    /// Greatest relative departure of the grain from the mean; 0 for none.
    contrast: f32,
    /// Size of the coarsest grains, m.
    scale_m: f32,
    seed: u32,
    /// Of the rod, m.
    radius_m: f32,
}

/// A place on a rod's side, and how large a sample is there.
struct FinishPlace {
    along_m: f32,
    /// Right-handed about the axis.
    angle_rad: f32,
    axis: vec3<f32>,
    around: vec3<f32>,
    normal: vec3<f32>,
    eye: vec3<f32>,
    /// Across the ray, m.
    footprint_m: f32,
}

fn finish_place(arc: Arc, point_m: vec3<f32>, normal: vec3<f32>, direction: vec3<f32>, footprint_m: f32) -> FinishPlace {
    let along = arc_parameter_of(arc, point_m);
    let axis = arc_at(arc, along);
    let out = point_m - axis.point_m;
    let angle = maths_atan2(dot(out, arc.side), dot(out, cross(arc.side, axis.direction)));
    return FinishPlace(along, angle, axis.direction, cross(axis.direction, normal), normal, direction, footprint_m);
}

/// How much a quantity of this gradient, per metre along the surface, changes within a sample at most.
fn finish_change(place: FinishPlace, gradient: vec3<f32>) -> f32 {
    let facing = dot(place.normal, place.eye);
    let kept = select(max(facing, 1e-3), min(facing, -1e-3), facing < 0.0);
    return length(gradient - place.normal * (dot(gradient, place.eye) / kept)) * place.footprint_m;
}

/// The integral up to x of a square wave of period 1 that begins each period high.
fn finish_up_to(share: f32, x: f32) -> f32 {
    let whole = floor(x);
    return whole * share + min(x - whole, share);
}

/// The share of a sample that stripes cover: the mean of the square wave over the sample's width.
fn finish_covered(finish: Finish, place: FinishPlace) -> f32 {
    let turns = finish.starts * place.angle_rad / FINISH_TURN_RAD;
    let phase = place.along_m / finish.period_m - turns;
    let gradient = place.axis / finish.period_m
        - place.around * (finish.starts / (FINISH_TURN_RAD * finish.radius_m));
    // From a period near this place, and never narrower than rounding.
    let local = phase - floor(phase);
    let half = max(0.5 * finish_change(place, gradient), 1e-6);
    let sum = finish_up_to(finish.share, local + half) - finish_up_to(finish.share, local - half);
    return clamp(sum / (2.0 * half), 0.0, 1.0);
}

/// Smooth noise in [-1, 1] with a node at every integer, of period `cells` in y.
fn finish_value_noise(seed: u32, octave: u32, at: vec2<f32>, cells: u32) -> f32 {
    let node = floor(at);
    let s = at - node;
    let smooth_s = s * s * s * (s * (6.0 * s - 15.0) + 10.0);
    var corners: array<f32, 4>;
    for (var k = 0u; k < 4u; k++) {
        let row = (u32(max(node.y, 0.0)) + (k >> 1u)) % cells;
        let column = lattice_pcg(u32(i32(node.x) + i32(k & 1u)) + lattice_pcg(octave + seed));
        corners[k] = f32(lattice_pcg(row + column) >> 8u) / 8388608.0 - 1.0;
    }
    return mix(mix(corners[0], corners[1], smooth_s.x), mix(corners[2], corners[3], smooth_s.x), smooth_s.y);
}

/// Octaves of value noise in [-1, 1]; those finer than two samples are left out.
fn finish_relief(finish: Finish, place: FinishPlace) -> f32 {
    var wavelength = finish.scale_m;
    var amplitude = 0.4;
    var relief = 0.0;
    let sample = max(finish_change(place, place.axis), finish_change(place, place.around));
    for (var octave = 0u; octave < 8u; octave++) {
        let fade = clamp(wavelength / (2.0 * sample) - 1.0, 0.0, 1.0);
        if fade == 0.0 {
            break;
        }
        // A whole number of cells around, or the seam would show.
        let cells = max(round(FINISH_TURN_RAD * finish.radius_m / wavelength), 3.0);
        let at = vec2<f32>(place.along_m / wavelength, (place.angle_rad / FINISH_TURN_RAD + 0.5) * cells);
        relief += fade * amplitude * finish_value_noise(finish.seed, octave, at, u32(cells));
        wavelength *= 0.5;
        amplitude *= 0.6;
    }
    return relief;
}

/// Albedo of a rod's side of a plain albedo.
fn finish_albedo(finish: Finish, plain: vec3<f32>, place: FinishPlace) -> vec3<f32> {
    var colour = plain;
    if finish.period_m > 0.0 {
        colour = mix(plain, finish.stripe, finish_covered(finish, place));
    }
    if finish.contrast > 0.0 {
        colour *= 1.0 + finish.contrast * finish_relief(finish, place);
    }
    return colour;
}
