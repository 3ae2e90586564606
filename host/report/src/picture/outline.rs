//! The outline of an object: the convex hull of its nodes as they are seen.

/// The corners of the convex hull of points on a picture, in order (Andrew, Another Efficient Algorithm for Convex
/// Hulls in Two Dimensions, 1979). Of points on a line, its two ends.
pub(super) fn convex_hull(mut points: Vec<(i32, i32)>) -> Vec<(i32, i32)> {
    points.sort_unstable();
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut corners = half(points.iter().copied());
    corners.extend(half(points.into_iter().rev()));
    corners
}

/// The corners on one side from the first point to the last, without the last.
fn half(points: impl Iterator<Item = (i32, i32)>) -> Vec<(i32, i32)> {
    let mut corners: Vec<(i32, i32)> = Vec::new();
    for point in points {
        while let [.., before, last] = corners[..]
            && !turns_left(before, last, point)
        {
            corners.pop();
        }
        corners.push(point);
    }
    corners.pop();
    corners
}

fn turns_left(from: (i32, i32), over: (i32, i32), to: (i32, i32)) -> bool {
    let step = |end: (i32, i32)| [end.0, end.1].map(i64::from);
    let ([x, y], [u, v], [p, q]) = (step(from), step(over), step(to));
    (u - x) * (q - y) > (v - y) * (p - x)
}

#[cfg(test)]
mod tests {
    use super::convex_hull;

    #[test]
    fn the_hull_has_the_outer_points_only() {
        let square = vec![(0, 0), (9, 9), (9, 0), (0, 9), (5, 5), (0, 4), (9, 9)];
        assert_eq!(convex_hull(square), [(0, 0), (9, 0), (9, 9), (0, 9)]);
    }

    #[test]
    fn nodes_on_a_line_have_its_ends_as_their_hull() {
        assert_eq!(convex_hull(vec![(4, 2), (0, 0), (2, 1), (6, 3)]), [(0, 0), (6, 3)]);
        assert_eq!(convex_hull(vec![(4, 2), (4, 2)]), [(4, 2)]);
    }
}
