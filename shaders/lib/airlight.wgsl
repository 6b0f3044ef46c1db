// The light of a lamp that the water scatters into a ray: see optics/src/airlight.rs.

/// The lamp's distance from the ray is never taken smaller, m.
const AIRLIGHT_NEAREST_M: f32 = 1e-3;

/// The equi-angular midpoints of one ray and one lamp: `t = t₀ + h tan θ`, equal steps in θ.
struct AirlightNodes {
    across: vec3<f32>,
    nearest_t_m: f32,
    distance_to_ray_m: f32,
    /// Sine and cosine of θ where the ray begins.
    start: vec2<f32>,
    step_rad: f32,
    /// dθ/h of every node, m⁻¹.
    weight_per_m: f32,
}

/// Nodes on the first `distance_m` of a ray.
fn airlight_nodes(lamp_from_origin_m: vec3<f32>, direction: vec3<f32>, distance_m: f32, points: u32) -> AirlightNodes {
    let t0 = dot(lamp_from_origin_m, direction);
    let foot = direction * t0 - lamp_from_origin_m;
    let true_h = length(foot);
    let axis = select(vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(1.0, 0.0, 0.0), abs(direction.x) < 0.5);
    var across = normalize(cross(direction, axis));
    if true_h > 1e-6 {
        across = foot / true_h;
    }
    let h = max(true_h, AIRLIGHT_NEAREST_M);
    let span = maths_atan2(h * distance_m, h * h - t0 * (distance_m - t0));
    let step = span / f32(points);
    return AirlightNodes(across, t0, h, vec2<f32>(-t0, h) / length(vec2<f32>(t0, h)), step, step / h);
}

/// Sine and cosine of θ at a midpoint. Not by turning from node to node: a hundred roundings would move the last ones.
fn airlight_node(nodes: AirlightNodes, index: u32) -> vec2<f32> {
    let turn = maths_sincos((f32(index) + 0.5) * nodes.step_rad);
    return vec2<f32>(
        nodes.start.x * turn.y + nodes.start.y * turn.x,
        nodes.start.y * turn.y - nodes.start.x * turn.x,
    );
}

/// 1 - cos μ of a node, cos μ = -sin θ: by cos²θ/(1 - sin θ) where the light goes on, nearly forwards.
fn airlight_one_minus_cos(node: vec2<f32>) -> f32 {
    if node.x < 0.0 {
        return node.y * node.y / (1.0 - node.x);
    }
    return 1.0 + node.x;
}
