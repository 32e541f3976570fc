//! Who is next to whom in an image: Delaunay neighbours, traced clockwise (Tone 2020, "Marker ID recognition").

use glam::DVec2;
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// For every point, the indices of its Delaunay neighbours, clockwise from twelve o'clock.
///
/// Points are in image coordinates, x right and y down, in any unit. Fewer than two points, or points that are not
/// finite, have no neighbours; of points in one place only the first takes part.
pub fn clockwise_neighbours(points: &[DVec2]) -> Vec<Vec<usize>> {
    let mut triangulation: DelaunayTriangulation<Tagged> = DelaunayTriangulation::new();
    for (index, point) in points.iter().enumerate().filter(|(_, point)| point.is_finite()) {
        let tagged = Tagged { at: Point2::new(point.x, point.y), index };
        let before = triangulation.num_vertices();
        // Refused only for coordinates beyond spade's range: such a point has no neighbours either.
        let Ok(vertex) = triangulation.insert(tagged) else { continue };
        if triangulation.num_vertices() == before {
            // A twin has taken the place of the first, which alone takes part.
            let first = points.iter().position(|p| p == point).expect("the point itself at the latest");
            triangulation.vertex_data_mut(vertex).index = first;
        }
    }
    let mut neighbours = vec![Vec::new(); points.len()];
    for vertex in triangulation.vertices() {
        let here = vertex.data().index;
        neighbours[here] = vertex.out_edges().map(|edge| edge.to().data().index).collect();
        sort_clockwise(&mut neighbours[here], points[here], points);
    }
    neighbours
}

/// Sorts by the angle at `centre`, clockwise from straight up, of directions in an image whose y points down.
fn sort_clockwise(neighbours: &mut [usize], centre: DVec2, points: &[DVec2]) {
    let clock = |index: usize| {
        let arm = points[index] - centre;
        let angle = libm::atan2(arm.x, -arm.y);
        if angle < 0.0 { angle + std::f64::consts::TAU } else { angle }
    };
    let mut timed: Vec<(f64, usize)> = neighbours.iter().map(|&index| (clock(index), index)).collect();
    timed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    neighbours.iter_mut().zip(timed).for_each(|(place, (_, index))| *place = index);
}

struct Tagged {
    at: Point2<f64>,
    index: usize,
}

impl spade::HasPosition for Tagged {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(points: &[[f64; 2]], of: usize, expected: &[usize]) {
        let points: Vec<DVec2> = points.iter().map(|&p| p.into()).collect();
        assert_eq!(clockwise_neighbours(&points)[of], expected);
    }

    #[test]
    fn cross_is_traced_from_the_top() {
        let cross = [[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, -1.0]];
        check(&cross, 0, &[4, 3, 2, 1]);
        check(&cross, 4, &[3, 0, 1]);
    }

    #[test]
    fn few_points_and_lines_have_neighbours_too() {
        check(&[[3.0, 3.0]], 0, &[]);
        check(&[[0.0, 0.0], [2.0, 0.0]], 0, &[1]);
        check(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 1, &[2, 0]);
    }

    #[test]
    fn twins_and_nonsense_stand_aside() {
        check(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0]], 0, &[2]);
        check(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0]], 1, &[]);
        check(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0]], 3, &[]);
    }
}
