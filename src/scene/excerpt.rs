/// A text from a file as a message shows it: cut where it is long, and not shown where it looks like data, which may be megabytes.
pub(super) fn clipped(text: &str) -> String {
    const MOST: usize = 120;
    let is_data = text.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("data"))
        && matches!(text.as_bytes().get(4), Some(b':' | b';' | b','));
    let most = if is_data { "data:".len() } else { MOST };
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
