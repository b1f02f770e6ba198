//! `bvhc view --tree`: the upper levels of a tree as text.

use crate::cli::figures;
use crate::cli::table::Table;
use crate::report::outline::{Outline, OutlineNode};

/// A line a node, with lines from parents to children.
pub fn text(outline: &Outline) -> String {
    let below = if outline.of == "top" { "instances" } else { "references" };
    let mut table = Table::default();
    table.row("node", ["area", "SAH", below, "nodes", "height", "box"].map(str::to_string));
    for (i, node) in outline.nodes.iter().enumerate() {
        let label = format!("{}{}{}", branches(&outline.nodes, i), node.node, if node.is_leaf { " leaf" } else { "" });
        let corner = |p: [f32; 3]| p.map(|c| format!("{c:.4}")).join(" ");
        table.row(
            label,
            [
                percent(node.area_share),
                percent(node.sah_share),
                figures::count(node.references.or(node.instances).unwrap_or(0)),
                figures::count(node.nodes),
                node.height.to_string(),
                format!("{} to {}", corner(node.min), corner(node.max)),
            ],
        );
    }
    table.render()
}

fn percent(share: f64) -> String {
    format!("{:.2} %", share * 100.0)
}

/// The lines that lead from a node's ancestors to it. Of two children one follows the other's nodes on the same depth.
fn branches(nodes: &[OutlineNode], i: usize) -> String {
    let depth = nodes[i].depth;
    let has_sibling_after = |level: u32| {
        let mut after = nodes[i + 1..].iter().take_while(|n| n.depth >= level);
        after.any(|n| n.depth == level)
    };
    let mut text = String::new();
    for level in 1..=depth {
        text.push_str(match (level == depth, has_sibling_after(level)) {
            (false, true) => "│ ",
            (false, false) => "  ",
            (true, true) => "├ ",
            (true, false) => "└ ",
        });
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_lead_to_children() {
        let node = |node: u64, depth: u32| OutlineNode {
            node,
            depth,
            min: [0.0; 3],
            max: [1.0; 3],
            area_share: 1.0,
            sah_share: 1.0,
            references: Some(1),
            instances: None,
            nodes: 1,
            height: 0,
            is_leaf: depth == 2,
        };
        let nodes = vec![node(0, 0), node(2, 1), node(4, 2), node(5, 2), node(3, 1), node(6, 2), node(7, 2)];
        let drawn: Vec<String> = (0..nodes.len()).map(|i| branches(&nodes, i)).collect();
        assert_eq!(drawn, ["", "├ ", "│ ├ ", "│ └ ", "└ ", "  ├ ", "  └ "]);
        let text = text(&Outline { of: "tree", nodes });
        assert!(text.lines().nth(3).is_some_and(|line| line.starts_with("│ ├ 4 leaf")), "{text}");
    }
}
