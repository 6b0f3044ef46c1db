// A tree of boxes over the pieces of rods: see bvh.rs. Nodes stand in the order in which a walk meets them, so that it needs no
// stack: a box that is missed says where to go on.

struct BvhNode {
    min_m: vec3<f32>,
    /// Of a leaf the first piece, of an inner node the node after all those inside.
    first: u32,
    max_m: vec3<f32>,
    /// Pieces in a leaf; 0 for an inner node, whose first child comes next.
    count: u32,
}

/// 1/v with something large for the inverse of zero.
fn bvh_per_direction(direction: vec3<f32>) -> vec3<f32> {
    let tiny = select(vec3<f32>(1e-30), vec3<f32>(-1e-30), direction < vec3<f32>(0.0));
    return 1.0 / select(direction, tiny, abs(direction) < vec3<f32>(1e-30));
}

/// Whether a ray meets a box, grown by `margin_rad` times the distance of its farthest point, before `limit_m`.
fn bvh_meets(node: BvhNode, origin_m: vec3<f32>, per_direction: vec3<f32>, margin_rad: f32, limit_m: f32) -> bool {
    let low = node.min_m - origin_m;
    let high = node.max_m - origin_m;
    let margin = margin_rad * length(max(abs(low), abs(high)));
    let a = (low - margin) * per_direction;
    let b = (high + margin) * per_direction;
    let entries = min(a, b);
    let exits = max(a, b);
    let enter = max(max(entries.x, entries.y), max(entries.z, 0.0));
    let leave = min(min(exits.x, exits.y), exits.z);
    // Rounding must not open a seam between two boxes.
    return enter <= leave * 1.000001 && enter < limit_m;
}
