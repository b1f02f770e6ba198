//! Pictures put together: beside each other, and with strips above and below.

use super::canvas::Canvas;
use super::scale::{self, BACKGROUND};

/// Pixels between two pictures.
const SEAM: usize = 6;

/// One picture beside the other, from the left, with a seam between them.
pub fn beside(parts: &[Canvas]) -> Canvas {
    let width = parts.iter().map(Canvas::width).sum::<usize>() + SEAM * parts.len().saturating_sub(1);
    let height = parts.iter().map(Canvas::height).max().unwrap_or(0);
    let mut all = Canvas::new(width, height, BACKGROUND);
    let mut left = 0;
    for part in parts {
        all.put([left, 0], part);
        left += part.width() + SEAM;
    }
    all
}

/// One below the other, from the top.
pub fn stacked(parts: &[Canvas]) -> Canvas {
    let width = parts.iter().map(Canvas::width).max().unwrap_or(0);
    let mut all = Canvas::new(width, parts.iter().map(Canvas::height).sum(), BACKGROUND);
    let mut top = 0;
    for part in parts {
        all.put([0, top], part);
        top += part.height();
    }
    all
}

/// A strip of this width with a line of text. Capitals are small, and what few letters there are leave a box for the others.
pub fn heading(width: usize, text: &str) -> Canvas {
    scale::heading(width, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_keep_their_places() {
        let (a, b) = (Canvas::new(3, 2, [1; 3]), Canvas::new(4, 5, [2; 3]));
        let all = beside(&[a.clone(), b.clone()]);
        assert_eq!((all.width(), all.height()), (3 + SEAM + 4, 5));
        assert_eq!(
            [all.get(0, 0), all.get(0, 2), all.get(3, 0), all.get(12, 4)],
            [[1; 3], BACKGROUND, BACKGROUND, [2; 3]]
        );
        let all = stacked(&[a, b]);
        assert_eq!((all.width(), all.height()), (4, 7));
        assert_eq!([all.get(2, 1), all.get(3, 1), all.get(3, 6)], [[1; 3], BACKGROUND, [2; 3]]);
        assert_eq!((beside(&[]).width(), stacked(&[]).height()), (0, 0));
    }
}
