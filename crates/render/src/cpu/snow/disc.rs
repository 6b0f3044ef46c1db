//! The exact area of a pixel under a disc.

/// A point in units of the disc's radius, from its centre.
type Point = [f64; 2];

fn cross(p: Point, q: Point) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

fn dot(p: Point, q: Point) -> f64 {
    p[0] * q[0] + p[1] * q[1]
}

/// The area of a convex polygon within the unit disc; negative if its corners go round clockwise.
pub(crate) fn area_in_disc(corners: &[Point; 4]) -> f64 {
    if corners.iter().all(|&p| dot(p, p) <= 1.0) {
        let edges = (0..4).map(|i| cross(corners[i], corners[(i + 1) % 4]));
        return 0.5 * edges.sum::<f64>();
    }
    (0..4)
        .map(|i| triangle_in_disc(corners[i], corners[(i + 1) % 4]))
        .sum()
}

/// The signed area within the unit disc of the triangle of its centre and an edge.
pub(crate) fn triangle_in_disc(p: Point, q: Point) -> f64 {
    let edge = [q[0] - p[0], q[1] - p[1]];
    let (a, b, c) = (dot(edge, edge), dot(p, edge), dot(p, p) - 1.0);
    let root2 = b * b - a * c;
    if !(root2 > 0.0) {
        return sector(p, q);
    }
    let root = root2.sqrt();
    let (enters, leaves) = ((-b - root) / a, (-b + root) / a);
    if enters >= 1.0 || leaves <= 0.0 {
        return sector(p, q);
    }
    let at = |t: f64| [p[0] + t * edge[0], p[1] + t * edge[1]];
    let (from, to) = (at(enters.max(0.0)), at(leaves.min(1.0)));
    let mut area = 0.5 * cross(from, to);
    if enters > 0.0 {
        area += sector(p, from);
    }
    if leaves < 1.0 {
        area += sector(to, q);
    }
    area
}

/// The signed area of the unit disc between two directions.
pub(crate) fn sector(p: Point, q: Point) -> f64 {
    0.5 * libm::atan2(cross(p, q), dot(p, q))
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    fn square(x: f64, y: f64, side: f64) -> [Point; 4] {
        [[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    }

    #[test]
    fn areas_are_those_of_elementary_geometry() {
        let cases = [
            (square(-2.0, -2.0, 4.0), PI, "around the disc"),
            (square(-0.1, -0.1, 0.2), 0.04, "within it"),
            (square(1.0, 1.0, 1.0), 0.0, "beside it"),
            (square(0.0, 0.0, 2.0), PI / 4.0, "a quarter"),
            (square(0.0, -2.0, 4.0), PI / 2.0, "a half"),
            // A cap of height 1/2: acos ½ − ½ √¾.
            (
                square(0.5, -2.0, 4.0),
                PI / 3.0 - 0.75_f64.sqrt() / 2.0,
                "a cap",
            ),
        ];
        for (corners, expected, what) in cases {
            let found = area_in_disc(&corners);
            assert!((found - expected).abs() < 1e-14, "{what}: {found}");
        }
    }

    #[test]
    fn pixels_share_a_disc_out_without_rest() {
        for (radius_px, x, y) in [(0.05, 0.3, 0.99), (0.7, 0.5, 0.1), (5.3, 0.77, 0.21)] {
            let mut sum = 0.0;
            for (column, row) in (-7..8).flat_map(|c| (-7..8).map(move |r| (c, r))) {
                let place = |at: i32, centre: f64| (f64::from(at) - centre) / radius_px;
                sum += area_in_disc(&square(place(column, x), place(row, y), 1.0 / radius_px));
            }
            assert!((sum - PI).abs() < 1e-11, "{radius_px}: {sum}");
        }
    }
}
