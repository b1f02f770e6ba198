use super::boxes::{check_tight, show};
use super::identity::Bits;
use super::topology::TreePlace;
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::geom::{Aabb, Affine};
use crate::layout::{GeomRecord, InstanceRecord, NO_NODE, SectionKind, View, orientation};

/// For each tree the lowest and the highest of the nodes whose transforms its parts say were baked into them; `None` where none says so.
pub fn baked_nodes(geoms: &[GeomRecord], trees: usize) -> Vec<Option<(u32, u32)>> {
    let mut nodes: Vec<Option<(u32, u32)>> = vec![None; trees]; // as many as there are rows in memory
    for geom in geoms.iter().filter(|geom| geom.baked_node != NO_NODE) {
        let Some(of_tree) = nodes.get_mut(geom.blas as usize) else { continue };
        let (low, high) = of_tree.unwrap_or((geom.baked_node, geom.baked_node));
        *of_tree = Some((low.min(geom.baked_node), high.max(geom.baked_node)));
    }
    nodes
}

/// Check each instance by itself, and the instances against each other and the trees, of which `baked` are the [`baked_nodes`].
pub fn check(view: &View<'_>, baked: &[Option<(u32, u32)>], out: &mut Report) {
    let count = view.instances.len() as u64;
    let Some(mut ids) = Bits::new(count) else {
        out.starve(Place::section(SectionKind::INST), "Whether the instances have different numbers");
        return;
    };
    for (i, instance) in view.instances.iter().enumerate() {
        let place = Place::record(SectionKind::INST, i as u64);
        check_matrices(instance, place, out);
        if instance.reserved != [0; 3] {
            out.add(&rules::E0506, place, || ("zero".into(), format!("they are {:?}", instance.reserved)));
        }

        if instance.mask == 0 {
            out.add(&rules::W0503, place, || ("one bit at least".into(), "0".into()));
        }

        let of_parts = baked.get(instance.blas as usize).copied().flatten();
        if let Some((low, high)) = of_parts.filter(|_| instance.node != NO_NODE)
            && (low, high) != (instance.node, instance.node)
        {
            let named = if low == high { low.to_string() } else { format!("none, for those from {low} to {high}") };
            out.add(&rules::E0509, place, || (named, instance.node.to_string()));
        }

        // Each number below the count stands there once.
        let id = u64::from(instance.id);
        if id >= count {
            out.add(&rules::E0504, place, || (format!("id must be < {count}"), format!("it is {id}")));
        } else if ids.set(id) {
            out.add(&rules::E0504, place, || ("each id once".into(), format!("{id} stands there already")));
        }
        match view.blases.get(instance.blas as usize) {
            None => out.add(&rules::E0503, place, || (view.blases.len().to_string(), instance.blas.to_string())),
            Some(blas) => {
                if blas.node_count == 0 {
                    out.add(&rules::W0501, place, || ("triangles".into(), instance.blas.to_string()));
                }
            }
        }
    }
}

/// Every tree is shown somewhere. There are `trees` of them, each with a row of this kind.
pub fn check_used<'i>(
    instances: impl Iterator<Item = &'i InstanceRecord>,
    trees: usize,
    rows: SectionKind,
    out: &mut Report,
) {
    let Some(mut used) = Bits::new(trees as u64) else {
        out.starve(Place::section(rows), "Whether every tree has an instance");
        return;
    };
    for instance in instances.filter(|i| (i.blas as usize) < trees) {
        used.set(instance.blas.into());
    }
    for tree in 0..trees as u64 {
        if !used.get(tree) {
            out.add(&rules::W0502, Place::record(rows, tree), || ("one".into(), tree.to_string()));
        }
    }
}

fn check_matrices(instance: &InstanceRecord, place: Place, out: &mut Report) {
    let all = || instance.object_to_world.iter().chain(&instance.world_to_object);
    if let Some(entry) = all().position(|v| !v.is_finite()) {
        let value = || all().nth(entry).map_or(f32::NAN, |v| *v);
        out.add(&rules::E0501, place, || ("finite".into(), format!("entry {entry} is {}", value())));
        return;
    }
    let to_world = Affine::from_f32(&instance.object_to_world);
    let to_object = Affine::from_f32(&instance.world_to_object);
    let mirrors = orientation(&instance.object_to_world).is_lt();
    let expected = if mirrors { InstanceRecord::MIRRORED } else { 0 };
    if instance.flags != expected {
        out.add(&rules::E0505, place, || (format!("{expected:#x}"), format!("{:#x}", instance.flags)));
    }
    if orientation(&instance.object_to_world).is_eq() {
        out.add(&rules::E0502, place, || {
            ("object_to_world must have an inverse".into(), "its determinant is 0".into())
        });
    } else if !to_world.is_invertible_in_f64() {
        out.add(&rules::E0502, place, || {
            let (det, terms) = to_world.determinant_and_terms();
            let expected = format!("the determinant of object_to_world must be more than {:e}", terms * Affine::LOST);
            (expected, format!("it is {det:e}, as good as 0 in f64"))
        });
    } else if let Some(Off { row, column, error, allowed }) = worst_product(&to_world, &to_object) {
        out.add(&rules::E0502, place, || {
            let expected = format!("the product must be the identity within {allowed:e}");
            (expected, format!("row {row}, column {column} is off by {error:e}"))
        });
    } else if let Some(Off { row, column, error, allowed }) = worst_entry(&to_world, &to_object) {
        out.add(&rules::E0502, place, || {
            let expected = format!("world_to_object must be the inverse within {allowed:e}");
            (expected, format!("row {row}, column {column} is off by {error:e}"))
        });
    }
}

/// The entry of a matrix that is farthest off, measured by what it may be off by.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Off {
    row: usize,
    column: usize,
    error: f64,
    allowed: f64,
}

impl Off {
    /// The worse of the two; NaN, which finite entries cannot give in `f64`, would be off too.
    fn worse(worst: Option<Off>, row: usize, column: usize, error: f64, allowed: f64) -> Option<Off> {
        let fits = error <= allowed || worst.is_some_and(|w| error / allowed <= w.error / w.allowed);
        if fits { worst } else { Some(Off { row, column, error, allowed }) }
    }
}

/// How far each entry of `o2w · w2o` may be from the identity, relative to the terms that it is summed from.
///
/// `w2o` is rounded to `f32` once, an error of at most 2⁻²⁴ of each of its entries, so each term of a product's entry is off by at
/// most 2⁻²⁴ of itself. Four times that leaves room for writers that invert in `f32`. An absolute bound could not work: an
/// instance 10⁷ units away has a translation whose own `f32` step is 1, and no matrix would pass 10⁻⁴ there; relative to the terms,
/// far instances are held to the very accuracy that their coordinates have. A matrix of large scale makes an inverse below the
/// normal range of `f32`, where rounding errs by up to 2⁻¹⁵⁰ absolutely; the last summand is that.
const RELATIVE: f64 = 1.0 / (1u64 << 22) as f64;

fn worst_product(to_world: &Affine, to_object: &Affine) -> Option<Off> {
    let (a, b) = (&to_world.rows, &to_object.rows);
    let subnormal = f64::from(f32::from_bits(1));
    let mut worst = None;
    for r in 0..3 {
        for c in 0..4 {
            let identity = if r == c { 1.0 } else { 0.0 };
            let (mut sum, mut terms, mut scale) = (-identity, identity, 0.0);
            for k in 0..3 {
                sum += a[r][k] * b[k][c];
                terms += (a[r][k] * b[k][c]).abs();
                scale += a[r][k].abs();
            }
            if c == 3 {
                sum += a[r][3];
                terms += a[r][3].abs();
            }
            let allowed = terms * RELATIVE + scale * subnormal;
            worst = Off::worse(worst, r, c, sum.abs(), allowed);
        }
    }
    worst
}

/// How far each entry of `w2o` is from that of the inverse. The product alone does not tell: where its terms are large and cancel, it may be
/// far from the identity in terms of 1 and near it in terms of them, and `w2o` anything.
///
/// The inverse in `f64` is itself off where the determinant cancels. By how much follows from the magnitudes of the products that it and the
/// cofactors are made of: each product of `f32` is exact, and each sum rounds once.
fn worst_entry(to_world: &Affine, to_object: &Affine) -> Option<Off> {
    let m = &to_world.rows;
    let (det, terms) = to_world.determinant_and_terms();
    let subnormal = f64::from(f32::from_bits(1));
    let mut worst = None;
    for r in 0..3 {
        let (mut moved, mut lost_moved) = (0.0, 0.0);
        for c in 0..3 {
            let (value, magnitude) = to_world.cofactor(c, r);
            let entry = value / det;
            let lost = Affine::LOST * (magnitude + entry.abs() * terms) / det.abs();
            let allowed = entry.abs() * RELATIVE + lost + subnormal;
            worst = Off::worse(worst, r, c, (to_object.rows[r][c] - entry).abs(), allowed);
            moved -= entry * m[c][3];
            lost_moved += (lost + Affine::LOST * entry.abs()) * m[c][3].abs();
        }
        let allowed = moved.abs() * RELATIVE + lost_moved + subnormal;
        worst = Off::worse(worst, r, 3, (to_object.rows[r][3] - moved).abs(), allowed);
    }
    worst
}

/// Each leaf of the top level contains the world box of its instances, rounded outward as [`Affine::transform_box`] does, and is no larger than
/// these boxes together. The box of an empty tree is zero: of its instance a leaf may hold the place, and need not.
///
/// `tiled`: the leaves are known to tile the instances.
pub fn check_leaves(view: &View<'_>, tiled: bool, at: TreePlace, out: &mut Report) {
    if !tiled {
        out.skip("Whether the instances lie in their leaves: the leaves of the top level do not tile them.");
        return;
    }
    for (i, node) in view.tlas_nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()) {
        let bounds = node.bounds();
        let first = node.first as usize;
        let range = first..first.saturating_add(node.count as usize);
        let Some(instances) = view.instances.get(range).filter(|_| bounds.is_valid()) else { continue };
        let mut below = Aabb::EMPTY;
        for (k, instance) in instances.iter().enumerate() {
            let blas = view.blases.get(instance.blas as usize);
            let root = blas.map(|b| Aabb { min: b.min, max: b.max });
            let finite = instance.object_to_world.iter().all(|v| v.is_finite());
            let Some(root) = root.filter(|root| finite && root.is_valid()) else {
                // It is told of by another rule.
                below = below.union(bounds);
                continue;
            };
            let world = Affine::from_f32(&instance.object_to_world).transform_box(&root);
            below = below.union(world);
            if !bounds.contains(&world) && blas.is_some_and(|b| b.node_count > 0) {
                below = below.union(bounds);
                let place = Place::record(SectionKind::INST, (first + k) as u64);
                out.add(&rules::E0507, place, || (format!("{} ({})", show(&bounds), at.node(i)), show(&world)));
            }
        }
        check_tight(&rules::E0508, &bounds, &below, at.node(i), out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_inverse(to_world: [[f64; 4]; 3]) -> bool {
        let rounded = Affine::from_f32(&Affine { rows: to_world }.to_f32());
        let back = Affine::from_f32(&rounded.inverse().unwrap().to_f32());
        worst_product(&rounded, &back).is_none() && worst_entry(&rounded, &back).is_none()
    }

    #[test]
    fn far_large_small_and_skewed_instances_pass() {
        let at = |s: f64, t: f64| [[s, 0.1 * s, 0.0, t], [-0.1 * s, s, 0.3 * s, -t], [0.0, 0.0, 2.0 * s, t / 3.0]];
        for s in [1e-30f64, 1e-6, 1.0, 3.7, 1e6, 1e30] {
            for t in [0.0f64, 1.0, 1e7, -1e12] {
                if (t / s).abs() < 1e38 {
                    assert!(is_inverse(at(s, t)), "scale {s}, translation {t}");
                }
            }
        }
        assert!(is_inverse([[1.0, 1.0, 1.0, 0.0], [1.0, 1.0001, 1.0, 5.0], [1.0, 1.0, 1.0002, 9.0]]));
    }

    #[test]
    fn an_inverse_that_is_off_by_a_thousandth_fails() {
        let to_world = Affine { rows: [[2.0, 0.0, 0.0, 1e7], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]] };
        let mut back = to_world.inverse().unwrap();
        assert!(worst_product(&to_world, &back).is_none());
        back.rows[1][1] *= 1.001;
        assert_eq!(worst_product(&to_world, &back).map(|w| (w.row, w.column)), Some((1, 1)));
        assert!(worst_product(&to_world, &Affine::IDENTITY).is_some());
    }

    /// Terms of 10⁸ that cancel let the product off by 50, and with it a matrix that is no inverse at all.
    #[test]
    fn a_product_whose_terms_cancel_does_not_hide_a_wrong_inverse() {
        let next = f64::from(1e4f32.next_up());
        let to_world = Affine { rows: [[1e4, 1e4, 0.0, 0.0], [1e4, next, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
        let right = Affine::from_f32(&to_world.inverse().unwrap().to_f32());
        assert_eq!((worst_product(&to_world, &right), worst_entry(&to_world, &right)), (None, None));
        let mut wrong = right;
        wrong.rows[0] = [1e4, -1e4, 0.0, 0.0];
        wrong.rows[1] = [-1e4, 1e4, 0.0, 0.0];
        assert_eq!(worst_product(&to_world, &wrong), None, "the product does not tell");
        assert!(worst_entry(&to_world, &wrong).is_some());
    }
}
