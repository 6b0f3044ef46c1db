// The shadows that rods cast into the water: see cpu/shadow.rs.

/// Sine of the angle between plane and axis from which on a section is short.
const SHADOW_STEEP: f32 = 0.2;

/// A straight piece of a rod as a lamp sees it; vectors are from the lamp.
struct Caster {
    solid: Solid,
    /// A point of each line along which a plane through the lamp touches the side.
    touching_plus_m: vec3<f32>,
    touching_minus_m: vec3<f32>,
    /// 0 if the lamp looks at a cap only.
    touches: u32,
    /// 2 + index of the rod.
    instance: u32,
}

/// The plane of a lamp and a ray.
struct ShadowSection {
    normal: vec3<f32>,
    distance_m: f32,
    /// Unit, from the lamp to the ray's nearest point.
    across: vec3<f32>,
    along: vec3<f32>,
    /// Unit directions (across, along) to where the ray begins and ends.
    begin: vec2<f32>,
    end: vec2<f32>,
}

/// The angles, as directions (across, along), under which a lamp sees something: the first and the last.
struct ShadowSpan {
    first: vec2<f32>,
    last: vec2<f32>,
    empty: bool,
}

fn shadow_see(span: ShadowSpan, section: ShadowSection, point_m: vec3<f32>) -> ShadowSpan {
    let seen = vec2<f32>(dot(section.across, point_m), dot(section.along, point_m));
    if span.empty {
        return ShadowSpan(seen, seen, false);
    }
    let first_turn = span.first.x * seen.y - span.first.y * seen.x;
    let last_turn = span.last.x * seen.y - span.last.y * seen.x;
    return ShadowSpan(
        select(span.first, seen, first_turn < 0.0),
        select(span.last, seen, last_turn > 0.0),
        false,
    );
}

/// Whether a disc in the plane lies beyond the ray or outside the angle under which the lamp sees it.
fn shadow_misses(section: ShadowSection, centre_m: vec3<f32>, radius_m: f32) -> bool {
    let x = dot(section.across, centre_m);
    let y = dot(section.along, centre_m);
    return x - radius_m > section.distance_m
        || section.begin.x * y - section.begin.y * x < -radius_m
        || section.end.y * x - section.end.x * y < -radius_m;
}

/// The part of the ray that looks at the lamp across the piece, by distances from the ray's point nearest to the lamp; empty
/// (x > y) if none of it can be in the piece's shadow. z: 1 if it is for sure, 0 if a probe must tell.
fn shadow_span(caster: Caster, section: ShadowSection) -> vec3<f32> {
    let none = vec3<f32>(1.0, -1.0, 0.0);
    let d = caster.solid.direction;
    let half = caster.solid.half_length_m;
    let radius = caster.solid.radius_m;
    let crossing = dot(section.normal, caster.solid.centre_m);
    let tilt = dot(section.normal, d);
    // Of many rods most are out of it: the plane misses the piece, or the ray the disc that holds the section of a steep one.
    if abs(crossing) > half * abs(tilt) + radius {
        return none;
    }
    if abs(tilt) > SHADOW_STEEP
        && shadow_misses(section, caster.solid.centre_m - d * (crossing / tilt), radius / abs(tilt)) {
        return none;
    }
    var span = ShadowSpan(vec2<f32>(0.0), vec2<f32>(0.0), true);
    if caster.touches != 0u {
        for (var side = 0; side < 2; side++) {
            let line_m = select(caster.touching_minus_m, caster.touching_plus_m, side == 0);
            let off = -dot(section.normal, line_m);
            if abs(off) <= half * abs(tilt) && abs(tilt) > 1e-9 {
                span = shadow_see(span, section, line_m + d * (off / tilt));
            }
        }
    }
    let flat_normal = section.normal - d * tilt;
    let flat2 = dot(flat_normal, flat_normal);
    if flat2 > 1e-12 {
        let sideways = cross(d, section.normal) * inverseSqrt(flat2);
        for (var end = -1.0; end < 2.0; end += 2.0) {
            let cap_m = caster.solid.centre_m + d * (end * half);
            let distance = dot(section.normal, cap_m);
            let chord2 = caster.solid.radius_m * caster.solid.radius_m - distance * distance / flat2;
            if chord2 >= 0.0 {
                let middle = cap_m - flat_normal * (distance / flat2);
                let chord = sideways * sqrt(chord2);
                span = shadow_see(span, section, middle - chord);
                span = shadow_see(span, section, middle + chord);
            }
        }
    }
    let nearer = min(span.first.x, span.last.x);
    let farther = max(span.first.x, span.last.x);
    if span.empty || farther <= 0.0 || nearer >= section.distance_m {
        return none;
    }
    let is_behind = select(0.0, 1.0, farther <= section.distance_m);
    var stretch = vec3<f32>(-SOLID_NONE_M, SOLID_NONE_M, is_behind);
    if span.first.x > 0.0 {
        stretch.x = section.distance_m * span.first.y / span.first.x;
    }
    if span.last.x > 0.0 {
        stretch.y = section.distance_m * span.last.y / span.last.x;
    }
    return stretch;
}
