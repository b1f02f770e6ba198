//! What is done where too few clusters are each other's best match.

/// In a round at least one cluster in so many must merge, or pairs are made of clusters that are not each other's best match. Growing boxes
/// in a row, each of which likes the smaller one before it, would otherwise take a round for every merge.
pub(in crate::build) const FEWEST: usize = 16;

/// Beside the mutual best matches, pair in order every cluster that is left with its best match if that is left too. At least one in
/// `4·radius + 2` clusters merges then, and in practice a third. Where areas are no numbers, pair neighbours.
///
/// Clusters without a match have their own number. `taken` is scratch, as long and all `false`.
pub(in crate::build) fn pair_the_rest(partners: &mut [u32], taken: &mut [bool]) {
    for i in 0..partners.len() {
        let partner = partners[i] as usize;
        taken[i] = partner != i && partners[partner] as usize == i;
    }
    for i in 0..partners.len() {
        let partner = partners[i] as usize;
        if partner != i && !taken[i] && !taken[partner] {
            (taken[i], taken[partner]) = (true, true);
            partners[partner] = i as u32;
        }
    }
    if !taken.contains(&true) {
        for (i, partner) in partners.iter_mut().enumerate() {
            *partner = i as u32 ^ 1;
        }
        // Of an odd number the last has none.
        let count = partners.len();
        if let [.., last] = partners
            && count % 2 == 1
        {
            *last = count as u32 - 1;
        }
    }
}
