//! What pages have in common.

/// Foreign text as HTML, in elements and in attributes.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// A template whose marks, in the order in which they stand there, are replaced by texts: no mark is looked for in what was put in.
pub fn filled<'a>(template: &str, parts: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let (mut out, mut rest) = (String::new(), template);
    for (mark, text) in parts {
        if let Some((before, after)) = rest.split_once(mark) {
            out.extend([before, text]);
            rest = after;
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_not_looked_into() {
        assert_eq!(filled("<%A%> %B%!", [("%A%", "%B%"), ("%B%", "b")]), "<%B%> b!");
        assert_eq!(escaped("<a href=\"x\">'&'"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;");
    }
}
