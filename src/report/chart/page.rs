//! One self-contained page of charts, with the figures under each and the command that made it.
//!
//! It asks no network, and says everything without its script, which shows a point's figures where the point is.

use super::inline;
use super::{Chart, Marker, Panel, Point};
use crate::report::html::{escaped, filled};
use std::fmt::Write;

/// What a page shows.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Above everything.
    pub title: String,
    /// Below the title, a paragraph each.
    pub lead: Vec<String>,
    /// What a reader must know before the figures are believed: a run that did not end, recipes that are missing.
    pub warnings: Vec<String>,
    /// From top to bottom.
    pub sections: Vec<Section>,
}

/// A picture with its figures.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Above the picture.
    pub title: String,
    /// The picture; its title is the section's, and its notes stand below it. Its [rows](Point#structfield.row) are those of the table.
    pub chart: Chart,
    /// The figures.
    pub table: Table,
    /// Below the table, a paragraph each.
    pub notes: Vec<String>,
    /// What few readers need, under a heading that opens it; nothing of it without paragraphs.
    pub details: (String, Vec<String>),
    /// What to type to make the picture again.
    pub command: String,
}

/// Figures in rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The heads of the columns, and what stands in them.
    pub columns: Vec<(String, Cell)>,
    /// A cell for each column.
    pub rows: Vec<Vec<String>>,
}

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// What the row is about.
    Name,
    /// A number, to the right.
    Number,
    /// Words.
    Words,
    /// What a user types.
    Code,
}

const TEMPLATE: &str = include_str!("web/page.html");
const STYLE: &str = include_str!("web/page.css");
const CODE: &str = include_str!("web/page.js");

/// Sizes of a picture that stands alone, on wide and on narrow screens, and of one among others.
const WIDE: [f64; 2] = [820.0, 460.0];
const NARROW: [f64; 2] = [350.0, 360.0];
const ONE_OF_SEVERAL: [f64; 2] = [370.0, 310.0];

impl Page {
    /// As an HTML document.
    pub fn html(&self) -> String {
        let title = escaped(&self.title);
        let paragraphs = |class: &str, all: &[String]| -> String {
            all.iter().map(|text| format!("<p class=\"{class}\">{}</p>\n", escaped(text))).collect()
        };
        let head = paragraphs("lead", &self.lead) + &paragraphs("warning", &self.warnings);
        let body: String = self.sections.iter().enumerate().map(|(i, section)| section.html(i)).collect();
        let parts = [("%TITLE%", &*title), ("%STYLE%", STYLE), ("%HEADING%", &title), ("%HEAD%", &head)];
        let parts = parts.into_iter().chain([("%SECTIONS%", &*body), ("%CODE%", CODE)]);
        filled(TEMPLATE, parts)
    }
}

impl Section {
    fn html(&self, number: usize) -> String {
        let mut out = String::new();
        let name = |point: &Point| self.table.told(point);
        let draw = |panel: &Panel, size, class: &str| inline::svg(panel, size, class, &name);
        let pictures: String = match &self.chart.panels[..] {
            [only] => draw(only, WIDE, "wide") + &draw(only, NARROW, "narrow"),
            several => several
                .iter()
                .map(|panel| {
                    let title = escaped(&panel.title);
                    format!("<div class=\"panel\"><h3>{title}</h3>{}</div>", draw(panel, ONE_OF_SEVERAL, "small"))
                })
                .collect(),
        };
        let several = if self.chart.panels.len() > 1 { " several" } else { "" };
        let notes: String = self.chart.notes.iter().map(|note| format!("<p>{}</p>\n", escaped(note))).collect();
        // A string takes everything.
        let _ = write!(
            out,
            "<section id=\"s{number}\">\n<h2>{}</h2>\n<figure>\n<div class=\"pictures{several}\">{pictures}</div>\n{}\
             <figcaption>{notes}</figcaption>\n</figure>\n{}",
            escaped(&self.title),
            self.legend(),
            self.table.html(&self.title),
        );
        for note in &self.notes {
            let _ = writeln!(out, "<p class=\"note\">{}</p>", escaped(note));
        }
        let (heading, paragraphs) = &self.details;
        if !paragraphs.is_empty() {
            let paragraphs: String = paragraphs.iter().map(|text| format!("<p>{}</p>\n", escaped(text))).collect();
            let _ = writeln!(out, "<details><summary>{}</summary>\n{paragraphs}</details>", escaped(heading));
        }
        if !self.command.is_empty() {
            let _ = writeln!(
                out,
                "<p class=\"command\"><span>Made by</span> <code tabindex=\"0\">{}</code></p>",
                escaped(&self.command)
            );
        }
        out + "</section>\n"
    }

    /// Colours first, then markers, as in the chart's own legend.
    fn legend(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        let mut entries = String::new();
        let mut put = |sign: String, name: &str| {
            entries.push_str(&format!("<li>{sign}{}</li>", escaped(name)));
        };
        for series in self.chart.panels.iter().flat_map(|p| &p.series) {
            if series.name.is_empty() || names.contains(&series.name.as_str()) {
                continue;
            }
            names.push(&series.name);
            let marker = if self.chart.markers.is_empty() { series.marker() } else { Marker::Disc };
            put(inline::sign(marker, Some(series.colour)), &series.name);
        }
        self.chart.markers.iter().for_each(|(marker, name)| put(inline::sign(*marker, None), name));
        let front = self.chart.panels.iter().any(|p| p.front);
        if front {
            let line = "<svg class=\"sign\" viewBox=\"0 0 14 14\" aria-hidden=\"true\"><path class=\"front\" d=\"M0 7h14\"/></svg>";
            entries.push_str(&format!("<li>{line}nothing is better in both (Pareto front)</li>"));
        }
        if entries.is_empty() { entries } else { format!("<ul class=\"legend\">{entries}</ul>\n") }
    }
}

impl Table {
    /// The row of a point in words.
    fn told(&self, point: &Point) -> String {
        let Some(row) = point.row.and_then(|row| self.rows.get(row)) else { return point.label.clone() };
        let cells = self.columns.iter().zip(row).filter(|(_, cell)| !cell.is_empty());
        let told = |((head, kind), cell): (&(String, Cell), &String)| match kind {
            Cell::Name => cell.clone(),
            _ => format!("{head} {cell}"),
        };
        cells.map(told).collect::<Vec<_>>().join(", ")
    }

    fn html(&self, caption: &str) -> String {
        let head: String = self
            .columns
            .iter()
            .map(|(head, kind)| format!("<th scope=\"col\" class=\"{}\">{}</th>", kind.class(), escaped(head)))
            .collect();
        let cell = |(kind, text): (Cell, &String)| match kind {
            Cell::Name => format!("<th scope=\"row\">{}</th>", escaped(text)),
            Cell::Code => format!("<td class=\"code\"><code>{}</code></td>", escaped(text)),
            other => format!("<td class=\"{}\">{}</td>", other.class(), escaped(text)),
        };
        let row = |(number, cells): (usize, &Vec<String>)| {
            let cells: String = self.columns.iter().map(|column| column.1).zip(cells).map(cell).collect();
            format!("<tr data-row=\"{number}\">{cells}</tr>\n")
        };
        let rows: String = self.rows.iter().enumerate().map(row).collect();
        let caption = escaped(caption);
        format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Figures: {caption}\"><table>\n\
             <thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
        )
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        // A bar would end the cell, also within code.
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let cell = |(kind, text): (Cell, &String)| match (kind, text.replace('|', "\\|")) {
            (Cell::Code, text) if !text.is_empty() => format!("`{text}`"),
            (_, text) => text,
        };
        let kinds = || self.columns.iter().map(|column| column.1);
        let rules = kinds().map(|kind| if kind == Cell::Number { "--:" } else { "---" }.to_string());
        let head = line(self.columns.iter().map(|column| column.0.clone()).collect());
        let rows: String = self.rows.iter().map(|row| line(kinds().zip(row).map(cell).collect())).collect();
        head + &line(rules.collect()) + &rows
    }
}

impl Cell {
    fn class(self) -> &'static str {
        match self {
            Cell::Name => "name",
            Cell::Number => "number",
            Cell::Words => "words",
            Cell::Code => "code",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Series};
    use super::*;

    fn page() -> Page {
        let point = |x, y, row| Point::new(x, y).named("a<b>").spread([0.9 * x, 1.1 * x]).of_row(row);
        let panel = Panel::new("t", Axis::logarithmic("ms").lower_is_better(), Axis::linear("cost").lower_is_better());
        let panel = panel.with(Series::new("ours", 0, vec![point(2.0, 5.0, 0), point(4.0, 3.0, 1)])).with_front();
        let columns = vec![("recipe".into(), Cell::Name), ("ms".into(), Cell::Number), ("flags".into(), Cell::Code)];
        let row = |name: &str, ms: &str| vec![name.to_string(), ms.to_string(), "--x 'a|b'".to_string()];
        let table = Table { columns, rows: vec![row("</script><b>%CODE%", "2"), row("b", "4")] };
        let chart = Chart { panels: vec![panel], columns: 1, notes: vec!["seen".into()], ..Chart::default() };
        let section = Section {
            title: "One & two".into(),
            chart,
            table,
            command: "bvhc chart 'a b'".into(),
            ..Section::default()
        };
        Page { title: "<i>".into(), sections: vec![section], warnings: vec!["cut".into()], ..Page::default() }
    }

    #[test]
    fn foreign_text_is_text() {
        let html = page().html();
        assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"), "{html}");
        assert_eq!(html.matches("</script>").count(), 1);
        assert!(!html.contains("<b>") && !html.contains("<i>") && html.contains("&lt;i&gt;"));
        assert!(html.contains("bvhc chart &#39;a b&#39;") && html.contains("One &amp; two") && html.contains("cut"));
        // A mark in foreign text is left alone.
        assert!(html.contains("&lt;b&gt;%CODE%"));
        assert!(!html.contains("http://") && !html.contains("https://"));
    }

    #[test]
    fn every_point_leads_to_its_row_on_wide_and_narrow_screens() {
        let html = page().html();
        for row in ["0", "1"] {
            assert_eq!(html.matches(&format!("<tr data-row=\"{row}\">")).count(), 1);
            let point = format!("<g class=\"point c0\" data-row=\"{row}\" tabindex=\"0\"");
            assert_eq!(html.matches(&point).count(), 2, "{row}");
        }
        assert!(html.contains("aria-label=\"b, ms 4, flags --x &#39;a|b&#39;\""), "{html}");
        assert_eq!(html.matches("class=\"spread\"").count(), 4);
        assert_eq!(html.matches("<polyline class=\"front\"").count(), 2);
    }

    #[test]
    fn markdown_has_a_line_for_each_row() {
        let text = page().sections[0].table.markdown();
        assert_eq!(text.lines().count(), 4);
        assert!(text.starts_with("| recipe | ms | flags |\n| --- | --: | --- |\n"), "{text}");
        assert!(text.ends_with("| b | 4 | `--x 'a\\|b'` |\n"), "{text}");
    }
}
