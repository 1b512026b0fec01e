//! The order in which the GPU keeps what belongs to a strand's vertices.
//!
//! Files, the CPU solver and chains keep one strand after the other. Where a thread takes a whole strand, threads that run
//! together would then read addresses a strand apart: each reads a line of memory of which it needs a tenth. So rods lie in
//! groups of as many strands as run together, and each number of a vertex lies beside the same number of the others:
//! number `i` of vertex `k` of guide `g` is at `((g / lanes * n_vertices + k) * n_numbers + i) * lanes + g % lanes`.

use std::borrow::Cow;

use bytemuck::Zeroable;
use glam::Vec4;

/// How an array of numbers (of four, or of what a vertex has) lies in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lanes {
    /// Guides side by side; with 1 the order is that of the CPU.
    pub side_by_side: u32,
    /// Of a guide.
    pub vertices: u32,
    /// Of a vertex.
    pub numbers: u32,
}

impl Lanes {
    /// As a buffer has them; where the last group is not full, the rest is zero.
    pub fn lay<T: Copy + Zeroable>(self, numbers: &[T]) -> Cow<'_, [T]> {
        if self.side_by_side == 1 || numbers.is_empty() {
            return Cow::Borrowed(numbers);
        }
        let mut laid = vec![T::zeroed(); self.len(numbers.len())];
        for (idx, &number) in numbers.iter().enumerate() {
            laid[self.place(idx)] = number;
        }
        Cow::Owned(laid)
    }

    /// The first `n` numbers as the CPU has them, from those of a buffer.
    pub fn take_up(self, laid: Vec<Vec4>, n: usize) -> Vec<Vec4> {
        if self.side_by_side == 1 || n == 0 {
            let mut numbers = laid;
            numbers.truncate(n);
            return numbers;
        }
        (0..n).map(|idx| laid[self.place(idx)]).collect()
    }

    /// Numbers that a buffer for `n` of them has.
    fn len(self, n: usize) -> usize {
        n.next_multiple_of(self.of_guide() * self.side_by_side as usize)
    }

    /// Where number `idx` of the CPU's order lies.
    fn place(self, idx: usize) -> usize {
        let (lanes, of_guide) = (self.side_by_side as usize, self.of_guide());
        let (guide_idx, in_guide) = (idx / of_guide, idx % of_guide);
        (guide_idx / lanes * of_guide + in_guide) * lanes + guide_idx % lanes
    }

    fn of_guide(self) -> usize {
        ((self.vertices * self.numbers) as usize).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lie_side_by_side_and_come_back() {
        let lanes = Lanes { side_by_side: 4, vertices: 3, numbers: 2 };
        // Number i of vertex k of guide g is told by its digits.
        let tell = |g: u32, k: u32, i: u32| Vec4::splat((100 * g + 10 * k + i) as f32);
        let numbers: Vec<Vec4> =
            (0..5).flat_map(|g| (0..3).flat_map(move |k| (0..2).map(move |i| tell(g, k, i)))).collect();
        let laid = lanes.lay(&numbers).into_owned();
        assert_eq!(laid.len(), 2 * 4 * 3 * 2);
        assert_eq!(laid[..4], [tell(0, 0, 0), tell(1, 0, 0), tell(2, 0, 0), tell(3, 0, 0)]);
        assert_eq!(laid[4], tell(0, 0, 1));
        assert_eq!(laid[((3 + 2) * 2 + 1) * 4], tell(4, 2, 1));
        assert_eq!(lanes.take_up(laid, numbers.len()), numbers);
        let alone = Lanes { side_by_side: 1, ..lanes };
        assert_eq!(alone.lay(&numbers), numbers);
        assert_eq!(alone.take_up(vec![Vec4::ONE; 9], 2), [Vec4::ONE; 2]);
        assert!(lanes.lay::<Vec4>(&[]).is_empty() && lanes.take_up(vec![Vec4::ONE], 0).is_empty());
    }
}
