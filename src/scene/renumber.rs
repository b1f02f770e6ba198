//! New numbers for what is left when the rest goes.

/// The new number of each thing that is kept, in the order of all of them; `None` for those that go.
pub(crate) fn renumber(kept: impl IntoIterator<Item = bool>) -> Vec<Option<u32>> {
    let mut next = 0;
    let number = |keep: bool| {
        let number = keep.then_some(next);
        next += u32::from(keep);
        number
    };
    kept.into_iter().map(number).collect()
}

/// Keep the things that have a number.
pub(crate) fn retain_numbered<T>(things: &mut Vec<T>, numbers: &[Option<u32>]) {
    let mut numbers = numbers.iter();
    things.retain(|_| numbers.next().is_some_and(|number| number.is_some()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_numbered_in_its_order() {
        let numbers = renumber([false, true, true, false, true]);
        assert_eq!(numbers, [None, Some(0), Some(1), None, Some(2)]);
        let mut things = vec!["a", "b", "c", "d", "e"];
        retain_numbered(&mut things, &numbers);
        assert_eq!(things, ["b", "c", "e"]);
    }
}
