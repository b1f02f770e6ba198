use super::gauge::rays_for;
use super::ladder::percent;
use super::verdict::harm;
use super::*;
use crate::build::{NoProgress, Purpose};
use crate::scene::Part;

/// `count` triangles along a line, each the same but for its place.
fn row(count: usize, step: f32) -> Mesh {
    let corner = |i: usize, c: [f32; 3]| [c[0] + step * i as f32, c[1], c[2]];
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]];
    Mesh {
        positions: (0..count).flat_map(|i| corners.map(|c| corner(i, c))).collect(),
        triangles: (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        parts: vec![Part { triangle_count: count as u32, prim_count: count as u32, ..Part::default() }],
        ..Mesh::default()
    }
}

fn asked(method: Method) -> BuildOptions {
    BuildOptions { method, ..BuildOptions::default() }
}

fn search(mesh: &Mesh, method: Method) -> (Tree, Choice) {
    build(mesh, &asked(method), &Executor::sequential(), &NoProgress).unwrap()
}

#[test]
fn small_meshes_are_built_unmeasured_and_larger_ones_are_not() {
    for method in [Method::Auto, Method::Best] {
        let (_, small) = search(&row(LEAST_TRIANGLES - 1, 1.0), method);
        assert_eq!((small.trials.len(), small.rays, small.overlap), (1, 0, None));
        let (_, large) = search(&row(LEAST_TRIANGLES, 1.0), method);
        assert!(large.rays >= 300 && large.trials.iter().all(|t| t.cost > 0.0), "{large:?}");
    }
}

#[test]
fn the_trial_of_the_least_worst_regret_is_taken_or_one_alike_and_the_tree_is_that_of_its_recipe() {
    for method in [Method::Auto, Method::Best] {
        for step in [0.02, 0.7] {
            let mesh = row(700, step);
            let (tree, choice) = search(&mesh, method);
            let taken = &choice.trials[choice.taken];
            let regret = choice.regrets[choice.taken].worst;
            let least = choice.regrets.iter().map(|r| r.worst).fold(f64::INFINITY, f64::min);
            assert!(regret <= least + 0.01 && choice.regrets.len() == choice.trials.len(), "{choice:?}");
            let recipe = taken.rung.options(&asked(method), rays_for(&mesh, &Executor::sequential()));
            assert_eq!(tree, recipe_tree(&mesh, &recipe, &Executor::sequential(), &NoProgress).unwrap());
            assert_eq!(choice.options, recipe);
        }
    }
}

#[test]
fn no_ray_is_asked_where_all_triangles_are_points_and_the_sah_decides() {
    let mut mesh = row(600, 0.0);
    mesh.positions.iter_mut().for_each(|p| *p = [3.0; 3]);
    for method in [Method::Auto, Method::Best] {
        let (tree, choice) = search(&mesh, method);
        assert_eq!((tree.refs.len(), choice.rays), (600, 0));
        let notes = notes(&[choice]);
        assert!(notes.len() == 3 && notes[1].contains("by SAH"), "{notes:?}");
    }
}

#[test]
fn what_the_user_sets_for_a_search_reaches_its_recipes() {
    let options = BuildOptions { max_leaf: 3, traversal_cost: 2.0, split_budget: 1.1, bins: 7, ..asked(Method::Best) };
    let all = candidates(&options);
    assert_eq!(all.len(), 5);
    for recipe in all {
        assert_eq!((recipe.max_leaf, recipe.traversal_cost, recipe.split_budget), (3, 2.0, 1.1));
        assert_ne!(recipe.bins, 7);
        assert!(!recipe.method.is_search());
        recipe.validate().unwrap();
    }
}

#[test]
fn a_coarse_recipe_keeps_its_own_smaller_budget() {
    let budgets = |asked_for: f32| {
        let options = BuildOptions { split_budget: asked_for, ..asked(Method::Best) };
        [Start::SbvhMoved, Start::CoarseMoved].map(|start| start.plain().options(&options, 0).split_budget)
    };
    assert_eq!((budgets(2.0), budgets(1.0)), ([2.0, 1.25], [1.0, 1.0]));
}

#[test]
fn auto_tries_as_much_as_best_in_tiny_meshes() {
    let mesh = row(700, 0.7);
    let [auto, best] = [Method::Auto, Method::Best].map(|method| search(&mesh, method));
    assert_eq!((auto.0, auto.1.trials), (best.0, best.1.trials));
    assert!(auto.1.reason.contains("8192"), "{}", auto.1.reason);
}

#[test]
fn a_cancelled_search_ends() {
    struct Cancelled;
    impl Progress for Cancelled {
        fn is_cancelled(&self) -> bool {
            true
        }
    }
    let mesh = row(700, 0.5);
    let ended = build(&mesh, &asked(Method::Best), &Executor::sequential(), &Cancelled);
    assert_eq!(ended.unwrap_err(), BuildError::Cancelled);
}

#[test]
fn progress_sums_up_to_the_triangles() {
    use std::sync::atomic::{AtomicU64, Ordering};
    #[derive(Default)]
    struct Count(AtomicU64);
    impl Progress for Count {
        fn advance(&self, primitives: u64) {
            self.0.fetch_add(primitives, Ordering::Relaxed);
        }
    }
    for method in [Method::Auto, Method::Best] {
        for count in [0, 3, 511, 513, 1000] {
            let seen = Count::default();
            build(&row(count, 0.5), &asked(method), &Executor::sequential(), &seen).unwrap();
            assert_eq!(seen.0.into_inner(), count as u64, "{method}");
        }
    }
}

#[test]
fn notes_of_several_trees_count_recipes_and_write_out_the_largest() {
    let choices: Vec<Choice> =
        [20, 600, 30, 10, 40, 50].map(|count| search(&row(count, 0.5), Method::Auto).1).into_iter().collect();
    let notes = notes(&choices);
    assert!(notes[0].starts_with("auto: of 6 trees took ") && notes[0].contains("sbvh + 8 rounds for "), "{notes:?}");
    assert!(notes[1].starts_with("auto, tree 1: took ") && notes[1].contains("for 600 triangles"), "{notes:?}");
    assert!(notes.iter().all(|note| !note.contains("tree 0:") && !note.contains("tree 3:")), "{notes:?}");
    assert!(super::notes(&[]).is_empty());
}

#[test]
fn where_everything_lies_on_top_of_everything_few_rays_are_asked() {
    let exec = Executor::sequential();
    assert_eq!(rays_for(&row(2000, 1.0), &exec), 500);
    assert_eq!(rays_for(&row(200_000, 1.0), &exec), 2048);
    assert_eq!(rays_for(&row(200_000, 0.0), &exec), 10);
    assert_eq!(rays_for(&row(200_000, 0.0), &Executor::new(3).unwrap()), 10);
    assert_eq!(rays_for(&row(0, 0.0), &exec), 128);
}

#[test]
fn percents() {
    assert_eq!(percent(0.09).to_string(), "9");
    assert_eq!(percent(0.125).to_string(), "12.5");
}

#[test]
fn a_purpose_decides_which_families_are_asked() {
    let mesh = row(700, 0.7);
    let asked = |purpose| {
        let options = BuildOptions { purpose, ..asked(Method::Auto) };
        let choice = build(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap().1;
        assert_eq!(choice.options.purpose, purpose);
        let paid = choice.trials[choice.taken].families;
        (choice.families, paid.iter().filter(|cost| cost.is_finite()).count())
    };
    let all = [Purpose::All, Purpose::Camera, Purpose::Bake, Purpose::Physics].map(asked);
    assert_eq!(all, [(8, 8), (5, 5), (5, 5), (3, 3)]);
}

#[test]
fn a_worse_tree_does_harm_and_a_better_one_does_not() {
    let (mesh, exec) = (row(3000, 0.7), Executor::sequential());
    let options = |method, max_leaf| BuildOptions { method, max_leaf, traversal_cost: 20.0, ..BuildOptions::default() };
    let tree = |options: &BuildOptions| recipe_tree(&mesh, options, &exec, &NoProgress).unwrap();
    let good = tree(&BuildOptions { method: Method::Sweep, ..BuildOptions::default() });
    let bad = tree(&options(Method::Sweep, 60));
    let mut gauge = gauge::Gauge::new(&mesh, 500, &exec);
    let [good, bad] = [good, bad].map(|tree| gauge.measure(&tree));
    assert_eq!(harm(&bad, &good), None);
    let why = harm(&good, &bad).unwrap();
    assert!(why.contains("rays would pay +"), "{why}");
    assert_eq!(harm(&good, &good).as_deref(), Some("rays would gain nothing"));
}

#[test]
fn notes_say_what_each_family_pays_and_how_sure_the_choice_is() {
    let notes = notes(&[search(&row(3000, 0.3), Method::Best).1]);
    assert!(notes.iter().any(|n| n.contains("a ray pays: outside ") && n.contains(", chords ")), "{notes:?}");
    assert!(notes.iter().any(|n| n.contains(" comes next: its rays pay ") && n.contains(" ± ")), "{notes:?}");
    assert!(notes[1].contains("rays of 8 families, worst and mean regret: sbvh "), "{notes:?}");
}
