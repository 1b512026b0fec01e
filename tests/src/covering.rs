//! Covering arrays: few lists of choices in which every pair of choices of two slots occurs. All combinations of ten slots
//! of the look would be a million; what goes wrong between techniques mostly goes wrong between two of them.

use std::collections::BTreeSet;

/// Lists with a choice for each slot (slot `i` has `n_choices[i]` of them, at least one), such that every pair of choices of
/// two slots is in one of the lists. Made greedily: about as many lists as the two largest slots have pairs.
pub fn covering(n_choices: &[usize]) -> Vec<Vec<usize>> {
    let mut open: BTreeSet<[usize; 4]> = BTreeSet::new();
    for (a, &n_of_a) in n_choices.iter().enumerate() {
        for (b, &n_of_b) in n_choices.iter().enumerate().skip(a + 1) {
            open.extend((0..n_of_a).flat_map(|i| (0..n_of_b).map(move |j| [a, i, b, j])));
        }
    }
    if n_choices.len() < 2 {
        return (0..n_choices.first().copied().unwrap_or(1)).map(|i| vec![i; n_choices.len()]).collect();
    }
    let mut rows = Vec::new();
    while let Some(&[a, i, b, j]) = open.first() {
        let mut row: Vec<Option<usize>> = vec![None; n_choices.len()];
        (row[a], row[b]) = (Some(i), Some(j));
        for slot in 0..n_choices.len() {
            if row[slot].is_some() {
                continue;
            }
            // What pairs the most with what is chosen already.
            let news = |choice: usize| {
                let is_new = |(other, chosen): (usize, &Option<usize>)| {
                    chosen.is_some_and(|chosen| {
                        let pair =
                            if other < slot { [other, chosen, slot, choice] } else { [slot, choice, other, chosen] };
                        open.contains(&pair)
                    })
                };
                row.iter().enumerate().filter(|&pair| is_new(pair)).count()
            };
            row[slot] = (0..n_choices[slot]).rev().max_by_key(|&choice| news(choice));
        }
        let row: Vec<usize> = row.into_iter().flatten().collect();
        open.retain(|&[a, i, b, j]| row[a] != i || row[b] != j);
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::covering;

    #[test]
    fn a_covering_array_has_every_pair() {
        let n_choices = [3, 1, 5, 2, 4];
        let rows = covering(&n_choices);
        assert!(rows.len() >= 20 && rows.len() < 40, "{}", rows.len());
        for a in 0..n_choices.len() {
            for b in a + 1..n_choices.len() {
                for (i, j) in (0..n_choices[a]).flat_map(|i| (0..n_choices[b]).map(move |j| (i, j))) {
                    assert!(rows.iter().any(|row| row[a] == i && row[b] == j), "slots {a}, {b}: {i}, {j}");
                }
            }
        }
        assert_eq!(covering(&[]), [Vec::<usize>::new()]);
        assert_eq!(covering(&n_choices[..1]), [[0], [1], [2]]);
    }
}
