//! A polygon mesh that writes itself as OBJ, the shapes the scenes are made of, and arithmetic that no libm touches.

pub type Vec3 = [f64; 3];

/// Cosine and sine of an angle given in turns.
///
/// The angle is reduced to an eighth of a turn, where the Taylor series to the 17th power is exact to the last digit written.
pub fn turn(turns: f64) -> (f64, f64) {
    let turns = turns - turns.floor();
    let quarter = (turns * 4.0 + 0.5).floor();
    let x = (turns - quarter / 4.0) * std::f64::consts::TAU;
    let (mut cos, mut sin, mut term) = (0.0, 0.0, 1.0);
    for n in 0..18 {
        match n % 4 {
            0 => cos += term,
            1 => sin += term,
            2 => cos -= term,
            _ => sin -= term,
        }
        term = term * x / f64::from(n + 1);
    }
    match quarter as i64 % 4 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn scale(a: Vec3, s: f64) -> Vec3 {
    a.map(|c| c * s)
}

/// The point `p` turned about the vertical axis.
pub fn spin(p: Vec3, (cos, sin): (f64, f64)) -> Vec3 {
    [p[0] * cos + p[2] * sin, p[1], p[2] * cos - p[0] * sin]
}

/// The point `p` turned about the x axis.
pub fn pitch(p: Vec3, (cos, sin): (f64, f64)) -> Vec3 {
    [p[0], p[1] * cos - p[2] * sin, p[1] * sin + p[2] * cos]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Vec3) -> Vec3 {
    scale(a, 1.0 / (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt())
}

/// Pseudo-random numbers in 0..1 (SplitMix64: Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Positions, faces of three or four corners, and the groups the faces stand in.
#[derive(Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub faces: Vec<Vec<usize>>,
    /// (name, first face)
    groups: Vec<(String, usize)>,
}

impl Mesh {
    pub fn group(&mut self, name: &str) {
        self.groups.push((name.to_string(), self.faces.len()));
    }

    pub fn point(&mut self, p: Vec3) -> usize {
        self.positions.push(p);
        self.positions.len() - 1
    }

    /// A flat quadrilateral.
    pub fn quad(&mut self, corners: [Vec3; 4]) {
        let face = corners.iter().map(|&p| self.point(p)).collect();
        self.faces.push(face);
    }

    /// A sheet of `columns` × `rows` cells, two triangles each, over `surface(u, v)` with u and v in 0..=1. `around` joins
    /// the last column to the first.
    pub fn sheet(&mut self, columns: usize, rows: usize, around: bool, surface: impl Fn(f64, f64) -> Vec3) {
        let start = self.positions.len();
        let width = if around { columns } else { columns + 1 };
        for row in 0..=rows {
            for column in 0..width {
                self.point(surface(column as f64 / columns as f64, row as f64 / rows as f64));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let next = (column + 1) % width;
                let [a, b] = [start + row * width + column, start + row * width + next];
                self.faces.push(vec![a, b, b + width]);
                self.faces.push(vec![a, b + width, a + width]);
            }
        }
    }

    /// A profile of (radius, height) turned about the vertical line through `foot`.
    pub fn lathe(&mut self, foot: Vec3, profile: &[(f64, f64)], segments: usize) {
        let rows = profile.len() - 1;
        self.sheet(segments, rows, true, |u, v| {
            let (radius, height) = profile[(v * rows as f64 + 0.5).floor() as usize];
            let (cos, sin) = turn(u);
            add(foot, [radius * cos, height, -radius * sin])
        });
    }

    /// A box with edges along `x`, `y` and `z` from its corner.
    pub fn block(&mut self, corner: Vec3, x: Vec3, y: Vec3, z: Vec3) {
        let p = |i: usize| {
            let mut p = corner;
            for (bit, edge) in [x, y, z].into_iter().enumerate() {
                if i >> bit & 1 == 1 {
                    p = add(p, edge);
                }
            }
            p
        };
        let start = self.positions.len();
        for i in 0..8 {
            self.point(p(i));
        }
        for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            self.faces.push(face.iter().map(|i| start + i).collect());
        }
    }

    /// An axis-aligned box between two corners.
    pub fn cuboid(&mut self, low: Vec3, high: Vec3) {
        let d = |a: usize| high[a] - low[a];
        self.block(low, [d(0), 0.0, 0.0], [0.0, d(1), 0.0], [0.0, 0.0, d(2)]);
    }

    /// A straight round bar without caps, in as few triangles as it takes: two a side, as long as the bar.
    pub fn bar(&mut self, from: Vec3, to: Vec3, radius: f64, sides: usize) {
        let along = add(to, scale(from, -1.0));
        let helper =
            if along[1].abs() * 2.0 > along[0].abs() + along[2].abs() { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let right = unit(cross(along, helper));
        let up = unit(cross(right, along));
        self.sheet(sides, 1, true, |u, v| {
            let (cos, sin) = turn(u);
            let ring = add(scale(right, radius * cos), scale(up, radius * sin));
            add(add(from, scale(along, v)), ring)
        });
    }

    /// Append a copy of `other` moved by `map`.
    pub fn append(&mut self, other: &Mesh, map: impl Fn(Vec3) -> Vec3) {
        let start = self.positions.len();
        self.positions.extend(other.positions.iter().map(|&p| map(p)));
        self.faces.extend(other.faces.iter().map(|face| face.iter().map(|i| start + i).collect()));
    }

    /// The mesh as OBJ text with four decimals.
    pub fn to_obj(&self) -> Vec<u8> {
        let mut text = String::from("# made by: cargo run --release --example samples\n");
        for p in &self.positions {
            text.push('v');
            for c in p {
                text.push(' ');
                text.push_str(&decimal(*c));
            }
            text.push('\n');
        }
        let mut groups = self.groups.iter().peekable();
        for (number, face) in self.faces.iter().enumerate() {
            while let Some((name, _)) = groups.next_if(|(_, first)| *first == number) {
                text.push_str("g ");
                text.push_str(name);
                text.push('\n');
            }
            text.push('f');
            for i in face {
                text.push(' ');
                text.push_str(&(i + 1).to_string());
            }
            text.push('\n');
        }
        text.into_bytes()
    }
}

/// A number with at most four decimals, without trailing zeros and without a negative zero.
pub fn decimal(c: f64) -> String {
    let units = (c * 10_000.0 + 0.5).floor() as i64;
    let (sign, size) = if units < 0 { ("-", -units) } else { ("", units) };
    let text = format!("{sign}{}.{:04}", size / 10_000, size % 10_000);
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
