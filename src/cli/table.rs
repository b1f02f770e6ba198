//! Text tables: columns as wide as their widest cell, the first to the left, the others to the right.

use std::iter::once;

/// Rows of cells; a row may be shorter than the widest.
#[derive(Clone, Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    pub fn row(&mut self, label: impl Into<String>, cells: impl IntoIterator<Item = String>) {
        self.rows.push(once(label.into()).chain(cells).collect());
    }

    /// An empty line.
    pub fn gap(&mut self) {
        self.rows.push(Vec::new());
    }

    pub fn render(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| self.rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::new();
            for (c, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[c] - cell.chars().count());
                line.push_str(&if c == 0 { format!("{cell}{pad}") } else { format!("  {pad}{cell}") });
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

/// Comma-separated values (RFC 4180): a cell is quoted if it holds a comma, a quote or a line break.
pub fn csv_line<'a>(cells: impl IntoIterator<Item = &'a str>) -> String {
    let quote = |cell: &str| {
        if cell.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell.to_string()
        }
    };
    cells.into_iter().map(quote).collect::<Vec<_>>().join(",") + "\r\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_whatever_the_script() {
        let mut t = Table::default();
        t.row("", ["a".into(), "größe".into()]);
        t.row("nodes", ["91,377".into(), "1".into()]);
        assert_eq!(t.render(), "            a  größe\nnodes  91,377      1\n");
    }

    #[test]
    fn csv_cells_are_quoted_where_needed() {
        assert_eq!(csv_line(["a", "b,c", "d\"e"]), "a,\"b,c\",\"d\"\"e\"\r\n");
    }
}
