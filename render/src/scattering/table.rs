//! A picture of numbers that formulas are baked into: bilinear like a texture, with mip maps, on the CPU.

/// `width` times `height` texels of four numbers, row by row. The corner texels' centres are the ends of the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<[f32; 4]>,
}

impl Table {
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, texels: vec![[0.0; 4]; width * height] }
    }

    /// The value at `x` and `y`, 0-1 along the axes.
    pub fn sample(&self, x: f32, y: f32) -> [f32; 4] {
        let place = |v: f32, n: usize| {
            let v = v.clamp(0.0, 1.0) * (n - 1) as f32;
            let low = (v as usize).min(n.saturating_sub(2));
            (low, (low + 1).min(n - 1), v - low as f32)
        };
        let ((x0, x1, tx), (y0, y1, ty)) = (place(x, self.width), place(y, self.height));
        let at = |x: usize, y: usize| self.texels[y * self.width + x];
        std::array::from_fn(|i| {
            let top = at(x0, y0)[i] * (1.0 - tx) + at(x1, y0)[i] * tx;
            let bottom = at(x0, y1)[i] * (1.0 - tx) + at(x1, y1)[i] * tx;
            top * (1.0 - ty) + bottom * ty
        })
    }

    /// The table and its halves down to one texel: means of two by two.
    pub fn mips(self) -> Vec<Self> {
        let mut mips = vec![self];
        while let Some(last) = mips.last()
            && (last.width > 1 || last.height > 1)
        {
            let (width, height) = ((last.width / 2).max(1), (last.height / 2).max(1));
            let mut next = Self::new(width, height);
            for (i, texel) in next.texels.iter_mut().enumerate() {
                let (x, y) = (i % width, i / width);
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (x, y) = ((2 * x + dx).min(last.width - 1), (2 * y + dy).min(last.height - 1));
                    for (sum, value) in texel.iter_mut().zip(last.texels[y * last.width + x]) {
                        *sum += 0.25 * value;
                    }
                }
            }
            mips.push(next);
        }
        mips
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_exact_for_planes_and_its_last_mip_is_the_mean() {
        let mut table = Table::new(8, 4);
        for (i, texel) in table.texels.iter_mut().enumerate() {
            *texel = [(i % 8) as f32 / 7.0, (i / 8) as f32 / 3.0, 1.0, 0.0];
        }
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.37, 0.81), (2.0, -1.0)] {
            let [u, v, one, _] = table.sample(x, y);
            assert!((u - x.clamp(0.0, 1.0)).abs() < 1e-6 && (v - y.clamp(0.0, 1.0)).abs() < 1e-6 && one == 1.0);
        }
        let mips = table.mips();
        assert_eq!(
            mips.iter().map(|mip| (mip.width, mip.height)).collect::<Vec<_>>(),
            [(8, 4), (4, 2), (2, 1), (1, 1)]
        );
        assert!((mips[3].texels[0][0] - 0.5).abs() < 1e-6 && (mips[3].texels[0][1] - 0.5).abs() < 1e-6);
    }
}
