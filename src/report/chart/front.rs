//! The Pareto front: points that no other point beats.

use super::{Panel, Point};

/// The points than which no other is at least as good in both quantities and better in one, ascending in x; of equal ones the first.
pub fn of(panel: &Panel) -> Vec<&Point> {
    let score = |p: &Point| {
        let sign = |higher: bool| if higher { 1.0 } else { -1.0 };
        [p.x * sign(panel.x.higher_is_better), p.y * sign(panel.y.higher_is_better)]
    };
    let mut points: Vec<&Point> = panel.points().collect();
    points.sort_by(|a, b| {
        let ([ax, ay], [bx, by]) = (score(a), score(b));
        bx.total_cmp(&ax).then(by.total_cmp(&ay))
    });

    // From the best x on, only a better y makes a point worth having.
    let mut best = f64::NEG_INFINITY;
    let mut front = Vec::new();
    for point in points {
        let [_, y] = score(point);
        if y > best {
            best = y;
            front.push(point);
        }
    }
    front.sort_by(|a, b| a.x.total_cmp(&b.x));
    front
}
