// Axes of rods, straight or along circular arcs: see cpu/arc.rs.

struct Arc {
    centre_m: vec3<f32>,
    /// 1/R; zero for a straight rod.
    curvature_per_m: f32,
    /// Unit tangent at the centre.
    direction: vec3<f32>,
    /// Unit vector from there to the arc's centre; zero for a straight rod.
    towards: vec3<f32>,
    /// Unit vector across the tangent, the same all along.
    side: vec3<f32>,
}

/// A point of an arc and the unit tangent there.
struct ArcPoint {
    point_m: vec3<f32>,
    direction: vec3<f32>,
}

/// At arc length `s_m` from the middle.
fn arc_at(arc: Arc, s_m: f32) -> ArcPoint {
    if arc.curvature_per_m == 0.0 {
        return ArcPoint(arc.centre_m + arc.direction * s_m, arc.direction);
    }
    let half = maths_sincos(0.5 * arc.curvature_per_m * s_m);
    let sin = 2.0 * half.x * half.y;
    // 1 - cos: a slight bend must not cancel.
    let versine = 2.0 * half.x * half.x;
    return ArcPoint(
        arc.centre_m + (arc.direction * sin + arc.towards * versine) / arc.curvature_per_m,
        arc.direction * (1.0 - versine) + arc.towards * sin,
    );
}

/// Arc length of the point of the curve nearest to `point_m`.
fn arc_parameter_of(arc: Arc, point_m: vec3<f32>) -> f32 {
    let w = point_m - arc.centre_m;
    let along = dot(w, arc.direction);
    if arc.curvature_per_m == 0.0 {
        return along;
    }
    return maths_atan2(along, 1.0 / arc.curvature_per_m - dot(w, arc.towards)) / arc.curvature_per_m;
}
