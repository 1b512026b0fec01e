//! What a solver goes on from: its clock and its arrays, read out at one moment and put back at another.
//!
//! CPU and GPU solver keep the same arrays, so that either goes on from the other's state. Put back on the device that it
//! was read from, the same inputs give the same frames again, bit for bit.

use glam::Vec4;

use crate::clock::Clock;
use crate::pose::Pose;

/// Arrays of a state, each of its own length.
type Arrays<'a> = &'a [Vec<Vec4>];

/// A moment of a solver.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverState {
    pub(crate) clock: Clock,
    /// The head at the end of the last frame.
    pub(crate) pose: Pose,
    /// Every array of every layer, in the solver's own order; then those of the air.
    pub(crate) arrays: Vec<Vec<Vec4>>,
}

/// Numbers before the arrays' lengths.
const N_CLOCK: usize = Clock::N_NUMBERS + Pose::N_NUMBERS;

impl SolverState {
    /// Bytes that [`SolverState::from_bytes`] reads: little-endian, the clock first.
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = self.clock.to_numbers().into_iter().chain(self.pose.to_numbers());
        let mut bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
        bytes.extend((self.arrays.len() as u32).to_le_bytes());
        for array in &self.arrays {
            bytes.extend((array.len() as u32).to_le_bytes());
            bytes.extend(array.iter().flat_map(Vec4::to_array).flat_map(f32::to_le_bytes));
        }
        bytes
    }

    /// `None` where the bytes are no state.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (clock, mut rest) = bytes.split_at_checked(8 * N_CLOCK)?;
        let mut numbers = [0.0; N_CLOCK];
        for (number, bytes) in numbers.iter_mut().zip(clock.chunks_exact(8)) {
            *number = f64::from_le_bytes(bytes.try_into().ok()?);
        }
        let (clock, pose) = numbers.split_at(Clock::N_NUMBERS);
        let n_arrays = take_u32(&mut rest)?;
        let mut arrays = Vec::new();
        for _ in 0..n_arrays {
            let n = take_u32(&mut rest)? as usize;
            let (array, behind) = rest.split_at_checked(n.checked_mul(16)?)?;
            rest = behind;
            let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            let vertex =
                |v: &[u8]| Vec4::new(number(&v[0..4]), number(&v[4..8]), number(&v[8..12]), number(&v[12..16]));
            arrays.push(array.chunks_exact(16).map(vertex).collect());
        }
        rest.is_empty().then_some(Self { clock: Clock::of_numbers(clock)?, pose: Pose::of_numbers(pose)?, arrays })
    }

    /// The arrays of these lengths, which come first, and those of the air; `None` where the first have other lengths.
    pub(crate) fn split(&self, lengths: impl Iterator<Item = usize>) -> Option<(Arrays<'_>, Arrays<'_>)> {
        let lengths: Vec<usize> = lengths.collect();
        let (hair, air) = self.arrays.split_at_checked(lengths.len())?;
        // The air begins with its time, one vector; no strand is that short.
        let is_air = air.first().is_none_or(|time| time.len() == 1);
        (is_air && hair.iter().map(Vec::len).eq(lengths)).then_some((hair, air))
    }
}

fn take_u32(rest: &mut &[u8]) -> Option<u32> {
    let (number, behind) = rest.split_at_checked(4)?;
    *rest = behind;
    Some(u32::from_le_bytes(number.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_the_same_after_its_bytes_and_what_is_no_state_is_refused() {
        let state = SolverState {
            clock: Clock::new(Pose::IDENTITY),
            pose: Pose { rotation: glam::Quat::from_rotation_y(0.3), translation: glam::Vec3::new(1.0, 0.1, -3.0) },
            arrays: vec![vec![Vec4::new(0.1, -2.0, f32::MIN_POSITIVE, 4.0); 3], Vec::new(), vec![Vec4::ONE]],
        };
        let bytes = state.to_bytes();
        assert_eq!(SolverState::from_bytes(&bytes).as_ref(), Some(&state));
        for n in 0..bytes.len() {
            assert_eq!(SolverState::from_bytes(&bytes[..n]), None, "{n}");
        }
        let (hair, air) = state.split([3, 0].into_iter()).unwrap();
        assert!(hair.len() == 2 && air == [vec![Vec4::ONE]]);
        assert!(state.split([3].into_iter()).is_none() && state.split([3, 1].into_iter()).is_none());
        assert!(state.split([3, 0, 1, 0].into_iter()).is_none());
    }
}
