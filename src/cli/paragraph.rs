//! Sentences that are longer than a line.

/// Columns of a line: those of a terminal that is not maximised.
const WIDTH: usize = 110;

/// The text after a label, in lines that start in the column where it does. Lines end at spaces; a longer word has a line of its own.
pub fn hanging(label: &str, text: &str) -> String {
    let indent = label.chars().count();
    let (mut told, mut column) = (label.to_string(), indent);
    for (i, word) in text.split(' ').enumerate() {
        let length = word.chars().count();
        if i > 0 && column + 1 + length > WIDTH {
            told.truncate(told.trim_end_matches(' ').len());
            told.push('\n');
            told.push_str(&" ".repeat(indent));
            column = indent;
        } else if i > 0 {
            told.push(' ');
            column += 1;
        }
        told.push_str(word);
        column += length;
    }
    told + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_full_and_hold_every_word() {
        let text = (0..100).map(|i| "x".repeat(i % 9 + 1)).collect::<Vec<_>>().join(" ");
        let told = hanging("note  ", &text);
        let lines: Vec<&str> = told.lines().collect();
        assert!(lines.len() > 4 && lines.iter().all(|line| line.chars().count() <= WIDTH), "{told}");
        assert!(lines[..lines.len() - 1].iter().all(|line| line.chars().count() > WIDTH - 10), "{told}");
        assert!(lines[1..].iter().all(|line| line.starts_with("      x")), "{told}");
        assert_eq!(told.split_whitespace().collect::<Vec<_>>().join(" "), format!("note {text}"));
    }

    #[test]
    fn what_fits_or_cannot_be_cut_is_one_line() {
        assert_eq!(hanging("a  ", "b c"), "a  b c\n");
        let long = "x".repeat(200);
        assert_eq!(hanging("a ", &long), format!("a {long}\n"));
    }
}
