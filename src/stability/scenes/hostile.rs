//! What numbers make: ties, nothing to tell triangles apart by, no size, all sizes at once.

use super::shapes::{Point, Soup, add, cuboid, direction, quad, scale, sheet, within};
use crate::random::Random;

/// Triangles at 2⁻ⁱ, each in the half of the space that those before it left.
pub fn geometric_series(count: usize) -> Soup {
    const LEVELS: usize = 110;
    let at = |i: usize| {
        let (x, row) = (2f64.powi(-((i % LEVELS) as i32)), (i / LEVELS) as f64);
        [[x, row, 0.0], [0.75 * x, row, 0.0], [x, row, 0.25 * x]]
    };
    (0..count).map(at).collect()
}

/// Triangles of all sizes whose boxes have one centre.
pub fn one_centre(count: usize) -> Soup {
    let mut random = Random::new(5);
    let star = |_| {
        let [x, y, z] = within(&mut random, 0.1, 1.0);
        [[-x, -y, -z], [x, y, z], [x, -y, z]]
    };
    (0..count).map(star).collect()
}

/// One triangle, again and again.
pub fn identical(count: usize) -> Soup {
    vec![[[0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]]; count]
}

/// All but two triangles in a millionth of the scene's width.
pub fn one_cell(count: usize) -> Soup {
    let mut soup = vec![[[-1e6, -1e6, -1e6], [-1e6 + 1.0, -1e6, -1e6], [-1e6, -1e6 + 1.0, -1e6]]];
    soup.push([[1e6, 1e6, 1e6], [1e6 - 1.0, 1e6, 1e6], [1e6, 1e6 - 1.0, 1e6]]);
    let mut random = Random::new(7);
    soup.extend((2..count).map(|_| speck(&mut random, 0.0, 1.0, 0.02)));
    soup
}

/// A small triangle somewhere in a cube.
fn speck(random: &mut Random, low: f64, high: f64, size: f64) -> [Point; 3] {
    let at = within(random, low, high);
    [at, add(at, scale(direction(random), size)), add(at, scale(direction(random), size))]
}

/// Overlapping triangles in one plane across an axis.
pub fn one_plane(count: usize) -> Soup {
    let mut random = Random::new(15);
    let flat = |_| speck(&mut random, -1.0, 1.0, 0.2).map(|[x, y, _]| [x, y, 0.0]);
    (0..count).map(flat).collect()
}

/// Boxes at whole numbers: every plane, edge and corner is where rays along the axes go.
pub fn whole_numbers(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 12) as f64).cbrt().ceil().max(1.0) as usize;
    let all = (0..side).flat_map(|i| (0..side).flat_map(move |j| (0..side).map(move |k| [i, j, k])));
    for corner in all.take((count / 12).max(1)) {
        let low = corner.map(|c| 2.0 * c as f64 - side as f64);
        cuboid(&mut soup, low, low.map(|c| c + 1.0));
    }
    soup
}

/// Points, lines and slivers among whole triangles.
pub fn without_area(count: usize) -> Soup {
    let mut random = Random::new(17);
    let one = |i| {
        let [a, b, c] = speck(&mut random, 0.0, 1.0, 0.1);
        match i % 4 {
            0 => [a, a, a],
            1 => [a, b, scale(add(a, b), 0.5)],
            2 => [a, b, add(b, [1e-9, 0.0, 0.0])],
            _ => [a, b, c],
        }
    };
    (0..count).map(one).collect()
}

/// Triangles of 10⁻²⁰ in a space of 10⁻¹⁸.
pub fn below_every_epsilon(count: usize) -> Soup {
    let mut random = Random::new(19);
    (0..count).map(|_| speck(&mut random, 0.0, 1.0, 0.01).map(|p| scale(p, 1e-18))).collect()
}

/// Specks so small that no float of their size has all its digits, an eighth as many as asked for: rays among them are decided by exact arithmetic, which
/// makes a search
/// over more than its least number of triangles take seconds.
pub fn denormal(count: usize) -> Soup {
    let mut random = Random::new(18);
    (0..count / 8).map(|_| speck(&mut random, 0.0, 1.0, 0.05).map(|p| scale(p, 1e-38))).collect()
}

/// Sixteen triangles in one place, again and again.
pub fn stacks(count: usize) -> Soup {
    let mut random = Random::new(25);
    (0..count / 16).flat_map(|_| [speck(&mut random, -1.0, 1.0, 0.1); 16]).collect()
}

/// A floor whose tiles lean by 10⁻⁷, each to another side.
pub fn almost_parallel(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 2) as f64).sqrt().max(1.0) as usize;
    sheet(&mut soup, side, side, |u, v| {
        let (x, z) = ((u * side as f64).round(), (v * side as f64).round());
        [x, 1e-7 * ((x as i64 * 7 + z as i64 * 13) % 5) as f64, z]
    });
    soup
}

/// Needles across the whole scene, in all directions.
pub fn needles(count: usize) -> Soup {
    let mut random = Random::new(20);
    let one = |_| {
        let (middle, way) = (within(&mut random, -0.2, 0.2), scale(direction(&mut random), 1.0));
        let (from, to) = (add(middle, way), add(middle, scale(way, -1.0)));
        [from, to, add(to, scale(direction(&mut random), 0.002))]
    };
    (0..count).map(one).collect()
}

/// A sheet so far away that floats have whole numbers alone.
pub fn far_away(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 2) as f64).sqrt().max(1.0) as usize;
    sheet(&mut soup, side, side, |u, v| {
        let (x, z) = ((u * side as f64).round() * 4.0, (v * side as f64).round() * 4.0);
        [1e7 + x, 1e7 + ((x as i64 / 4 + z as i64 / 2) % 3) as f64 * 2.0, 1e7 + z]
    });
    soup
}

/// Specks a million units large.
pub fn huge(count: usize) -> Soup {
    let mut random = Random::new(22);
    (0..count).map(|_| speck(&mut random, -1.0, 1.0, 0.1).map(|p| scale(p, 1e6))).collect()
}

/// The same specks a millionth of a unit large.
pub fn tiny(count: usize) -> Soup {
    let mut random = Random::new(22);
    (0..count).map(|_| speck(&mut random, -1.0, 1.0, 0.1).map(|p| scale(p, 1e-6))).collect()
}

/// As many triangles as this has digits for: 0 to 5, by the size asked for.
pub fn few(count: usize) -> Soup {
    let mut random = Random::new(24);
    (0..count % 6).map(|_| speck(&mut random, 0.0, 1.0, 0.5)).collect()
}

/// Equal cubes in a cubic lattice that touch: everything ties with something.
pub fn lattice(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 12) as f64).cbrt().round().max(1.0) as usize;
    for (i, j, k) in (0..side).flat_map(|i| (0..side).flat_map(move |j| (0..side).map(move |k| (i, j, k)))) {
        let low = [i, j, k].map(|c| c as f64);
        cuboid(&mut soup, low, low.map(|c| c + 1.0));
    }
    soup
}

/// Squares in the planes where equal bins end.
pub fn on_split_planes(count: usize) -> Soup {
    let mut soup = Soup::new();
    for i in 0..count / 2 {
        let (plane, axis) = ((i / 3 % 9) as f64 / 8.0, i % 3);
        let (u, v) = ((i / 27 % 8) as f64 / 8.0, (i / 216) as f64 / 8.0);
        let corner = |a: f64, b: f64| {
            let mut p = [plane; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a, b);
            p
        };
        quad(&mut soup, [corner(u, v), corner(u + 0.125, v), corner(u + 0.125, v + 0.125), corner(u, v + 0.125)]);
    }
    soup
}

/// Specks all over a ball: no direction is better than another.
pub fn cloud(count: usize) -> Soup {
    let mut random = Random::new(36);
    let mut soup = Soup::new();
    while soup.len() < count {
        let [a, b, c] = speck(&mut random, -1.0, 1.0, 0.05);
        if a[0] * a[0] + a[1] * a[1] + a[2] * a[2] < 1.0 {
            soup.push([a, b, c]);
        }
    }
    soup
}

/// Boxes within boxes.
pub fn nested(count: usize) -> Soup {
    let mut soup = Soup::new();
    let shells = (count / 12).max(1);
    for shell in 0..shells {
        let reach = 1.0 + shell as f64 / shells as f64;
        cuboid(&mut soup, [-reach; 3], [reach; 3]);
    }
    soup
}
