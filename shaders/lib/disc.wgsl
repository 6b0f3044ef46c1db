// The area of a pixel under a disc: see cpu/snow/disc.rs. Points are in units of the disc's radius, from its centre.

fn disc_cross(p: vec2<f32>, q: vec2<f32>) -> f32 {
    return p.x * q.y - p.y * q.x;
}

/// The signed area of the unit disc between two directions.
fn disc_sector(p: vec2<f32>, q: vec2<f32>) -> f32 {
    let x = dot(p, q);
    let y = disc_cross(p, q);
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    return 0.5 * maths_atan2(y, x);
}

/// The signed area within the unit disc of the triangle of its centre and an edge.
fn disc_triangle(p: vec2<f32>, q: vec2<f32>) -> f32 {
    let edge = q - p;
    let a = dot(edge, edge);
    let b = dot(p, edge);
    // b² - a (p² - 1), from the edge's distance to the centre: what is left of large squares is noise.
    let off = disc_cross(p, edge);
    let root2 = a - off * off;
    if root2 <= 0.0 {
        return disc_sector(p, q);
    }
    let root = sqrt(root2);
    let enters = (-b - root) / a;
    let leaves = (-b + root) / a;
    if enters >= 1.0 || leaves <= 0.0 {
        return disc_sector(p, q);
    }
    let first = p + max(enters, 0.0) * edge;
    let last = p + min(leaves, 1.0) * edge;
    var area = 0.5 * disc_cross(first, last);
    if enters > 0.0 {
        area += disc_sector(p, first);
    }
    if leaves < 1.0 {
        area += disc_sector(last, q);
    }
    return area;
}

/// The area within the unit disc of a parallelogram with a corner and two sides; negative if it goes round clockwise.
fn disc_area(corner: vec2<f32>, right: vec2<f32>, down: vec2<f32>) -> f32 {
    let b = corner + right;
    let c = b + down;
    let d = corner + down;
    if max(max(dot(corner, corner), dot(b, b)), max(dot(c, c), dot(d, d))) <= 1.0 {
        return disc_cross(right, down);
    }
    return disc_triangle(corner, b) + disc_triangle(b, c) + disc_triangle(c, d) + disc_triangle(d, corner);
}
