//! Splits of polynomial remainders, their inverses, and tiles; see `convolution`.

use pulp::Simd;

use crate::fft::number::Number;

/// Side of a tile, which is a square block of numbers.
pub(crate) const LANES: usize = 16;
/// Length of a tile: 16 x 16 numbers.
pub(crate) const TILE: usize = LANES * LANES;
/// Number of stored constants per four-way split of a tile: real and imaginary parts of c, c^2 and c^3 for each lane,
/// where y^(4m) - c^4 is the modulus that is split.
pub(crate) const ROOTS: usize = 6 * LANES;

/// A vector of complex numbers.
pub(crate) struct Wide<T: Number, S: Simd> {
    re: T::V<S>,
    im: T::V<S>,
}

impl<T: Number, S: Simd> Clone for Wide<T, S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Number, S: Simd> Copy for Wide<T, S> {}

impl<T: Number, S: Simd> Wide<T, S> {
    /// Vector with the complex number re + i im in every lane.
    #[inline(always)]
    pub(crate) fn splat(s: S, [re, im]: [T; 2]) -> Self {
        Self { re: T::splat(s, re), im: T::splat(s, im) }
    }

    /// Complex product a c, with a = `self`.
    #[inline(always)]
    fn times(self, s: S, c: Self) -> Self {
        Self {
            re: T::difference(s, T::product(s, self.re, c.re), T::product(s, self.im, c.im)),
            im: T::sum(s, T::product(s, self.re, c.im), T::product(s, self.im, c.re)),
        }
    }

    /// Complex product a c*, with a = `self` and c* the conjugate of c.
    #[inline(always)]
    fn times_conjugate(self, s: S, c: Self) -> Self {
        Self {
            re: T::sum(s, T::product(s, self.re, c.re), T::product(s, self.im, c.im)),
            im: T::difference(s, T::product(s, self.im, c.re), T::product(s, self.re, c.im)),
        }
    }

    /// Multiplies each lane by its real factor.
    #[inline(always)]
    fn scaled(self, s: S, factor: T::V<S>) -> Self {
        Self { re: T::product(s, self.re, factor), im: T::product(s, self.im, factor) }
    }

    /// Complex sum a + b, with a = `self`.
    #[inline(always)]
    fn plus(self, s: S, b: Self) -> Self {
        Self { re: T::sum(s, self.re, b.re), im: T::sum(s, self.im, b.im) }
    }

    /// Complex difference a - b, with a = `self`.
    #[inline(always)]
    fn minus(self, s: S, b: Self) -> Self {
        Self { re: T::difference(s, self.re, b.re), im: T::difference(s, self.im, b.im) }
    }

    /// a + i b, with a = `self` and the imaginary unit i.
    #[inline(always)]
    fn plus_i_times(self, s: S, b: Self) -> Self {
        Self { re: T::difference(s, self.re, b.im), im: T::sum(s, self.im, b.re) }
    }

    /// a - i b, with a = `self` and the imaginary unit i.
    #[inline(always)]
    fn minus_i_times(self, s: S, b: Self) -> Self {
        Self { re: T::sum(s, self.re, b.im), im: T::difference(s, self.im, b.re) }
    }

    /// Splits a0 + a1 y^m + a2 y^(2m) + a3 y^(3m) modulo the four factors of y^(4m) - c^4: the remainders for y^m = c,
    /// -c, ic and -ic. `roots` are c, c^2 and c^3.
    #[inline(always)]
    fn split(s: S, [a0, a1, a2, a3]: [Self; 4], roots: [Self; 3]) -> [Self; 4] {
        let (b1, b2, b3) = (a1.times(s, roots[0]), a2.times(s, roots[1]), a3.times(s, roots[2]));
        let (even, even_turned) = (a0.plus(s, b2), a0.minus(s, b2));
        let (odd, odd_turned) = (b1.plus(s, b3), b1.minus(s, b3));
        [
            even.plus(s, odd),
            even.minus(s, odd),
            even_turned.plus_i_times(s, odd_turned),
            even_turned.minus_i_times(s, odd_turned),
        ]
    }

    /// Inverse of [`Self::split`], multiplied by four.
    #[inline(always)]
    fn join(s: S, [a, b, c, d]: [Self; 4], roots: [Self; 3]) -> [Self; 4] {
        let (even, odd) = (a.plus(s, b), a.minus(s, b));
        let (even_turned, odd_turned) = (c.plus(s, d), c.minus(s, d));
        [
            even.plus(s, even_turned),
            odd.minus_i_times(s, odd_turned).times_conjugate(s, roots[0]),
            even.minus(s, even_turned).times_conjugate(s, roots[1]),
            odd.plus_i_times(s, odd_turned).times_conjugate(s, roots[2]),
        ]
    }
}

/// Complex numbers in four equal parts. A split replaces four numbers, one of each part.
struct Quarters<'a, V> {
    re: [&'a mut [V]; 4],
    im: [&'a mut [V]; 4],
    count: usize,
}

impl<'a, V: Copy> Quarters<'a, V> {
    #[inline(always)]
    fn new(re: &'a mut [V], im: &'a mut [V]) -> Self {
        let count = re.len() / 4;
        Self { re: quarters(re, count), im: quarters(im, count), count }
    }

    #[inline(always)]
    fn load<T: Number<V<S> = V>, S: Simd>(&self, n: usize) -> [Wide<T, S>; 4] {
        let ([a, b, c, d], [e, f, g, h]) = (&self.re, &self.im);
        [
            Wide { re: a[n], im: e[n] },
            Wide { re: b[n], im: f[n] },
            Wide { re: c[n], im: g[n] },
            Wide { re: d[n], im: h[n] },
        ]
    }

    #[inline(always)]
    fn store<T: Number<V<S> = V>, S: Simd>(&mut self, n: usize, [p, q, r, s]: [Wide<T, S>; 4]) {
        let ([a, b, c, d], [e, f, g, h]) = (&mut self.re, &mut self.im);
        (a[n], b[n], c[n], d[n]) = (p.re, q.re, r.re, s.re);
        (e[n], f[n], g[n], h[n]) = (p.im, q.im, r.im, s.im);
    }
}

/// Splits a slice into four parts of length `count`.
#[inline(always)]
fn quarters<V>(all: &mut [V], count: usize) -> [&mut [V]; 4] {
    let (a, rest) = all.split_at_mut(count);
    let (b, rest) = rest.split_at_mut(count);
    let (c, rest) = rest.split_at_mut(count);
    [a, b, c, &mut rest[..count]]
}

/// Splits one remainder into four by `Wide::split`, or joins four into one if `back`.
#[inline(always)]
pub(crate) fn radix_4<T: Number, S: Simd>(
    s: S,
    re: &mut [T::V<S>],
    im: &mut [T::V<S>],
    roots: [[T; 2]; 3],
    back: bool,
) {
    let roots = roots.map(|root| Wide::<T, S>::splat(s, root));
    let mut all = Quarters::new(re, im);
    for n in 0..all.count {
        let numbers = all.load(n);
        all.store(n, if back { Wide::join(s, numbers, roots) } else { Wide::split(s, numbers, roots) });
    }
}

/// Splits one remainder into two by y^(2m) - c^2 = (y^m - c)(y^m + c), with c = `root`, or joins two into one if
/// `back`.
#[inline(always)]
pub(crate) fn radix_2<T: Number, S: Simd>(s: S, re: &mut [T::V<S>], im: &mut [T::V<S>], root: [T; 2], back: bool) {
    let c = Wide::<T, S>::splat(s, root);
    let half = re.len() / 2;
    let ((a_re, b_re), (a_im, b_im)) = (re.split_at_mut(half), im.split_at_mut(half));
    for ((a_re, a_im), (b_re, b_im)) in a_re.iter_mut().zip(a_im).zip(b_re.iter_mut().zip(b_im)) {
        let (a, b) = (Wide { re: *a_re, im: *a_im }, Wide { re: *b_re, im: *b_im });
        let (a, b) = if back {
            (a.plus(s, b), a.minus(s, b).times_conjugate(s, c))
        } else {
            let b = b.times(s, c);
            (a.plus(s, b), a.minus(s, b))
        };
        (*a_re, *a_im) = (a.re, a.im);
        (*b_re, *b_im) = (b.re, b.im);
    }
}

/// Loads c, c^2 and c^3 for vector number `lane` of a row of a tile; a row has `row` vectors.
#[inline(always)]
fn roots_at<T: Number, S: Simd>(roots: &[T::V<S>], row: usize, lane: usize) -> [Wide<T, S>; 3] {
    let at = |n: usize| n * row + lane;
    [
        Wide { re: roots[at(0)], im: roots[at(1)] },
        Wide { re: roots[at(2)], im: roots[at(3)] },
        Wide { re: roots[at(4)], im: roots[at(5)] },
    ]
}

/// Filters a tile, which has one remainder of [`LANES`] numbers per column: all splits, multiplication by `factor`, all
/// joins.
#[inline(always)]
pub(crate) fn filter_tile<T: Number, S: Simd>(
    s: S,
    re: &mut [T; TILE],
    im: &mut [T; TILE],
    factor: &[T; TILE],
    roots: &[T; 5 * ROOTS],
) {
    let (re, im, factor) = (T::vectors_mut::<S>(re), T::vectors_mut::<S>(im), T::vectors::<S>(factor));
    let row = re.len() / LANES;
    let (first, second) = roots.split_at(ROOTS);
    let first = T::vectors::<S>(first);
    let mut all = Quarters::new(re, im);
    for n in 0..all.count {
        all.store(n, Wide::split(s, all.load(n), roots_at::<T, S>(first, row, n % row)));
    }
    let parts = re.chunks_exact_mut(4 * row).zip(im.chunks_exact_mut(4 * row));
    for (((re, im), factor), roots) in parts.zip(factor.chunks_exact(4 * row)).zip(second.chunks_exact(ROOTS)) {
        let roots = T::vectors::<S>(roots);
        let mut all = Quarters::new(re, im);
        for n in 0..all.count {
            let roots = roots_at::<T, S>(roots, row, n);
            let [a, b, c, d] = Wide::split(s, all.load(n), roots);
            let waves = [
                a.scaled(s, factor[n]),
                b.scaled(s, factor[row + n]),
                c.scaled(s, factor[2 * row + n]),
                d.scaled(s, factor[3 * row + n]),
            ];
            all.store(n, Wide::join(s, waves, roots));
        }
    }
    let mut all = Quarters::new(re, im);
    for n in 0..all.count {
        all.store(n, Wide::join(s, all.load(n), roots_at::<T, S>(first, row, n % row)));
    }
}

/// Transposes a tile by two rotations of the four base-4 digits of the index.
#[inline(always)]
pub(crate) fn transpose<T: Number>(tile: &mut [T; TILE]) {
    let mut turned = [T::zero(); TILE];
    rotate(tile, &mut turned);
    rotate(&turned, tile);
}

/// Moves the number at index 64 m + n to index 4 n + m, for m = 0..4 and n = 0..64.
#[inline(always)]
fn rotate<T: Copy>(from: &[T; TILE], to: &mut [T; TILE]) {
    let (low, high) = from.split_at(TILE / 2);
    let ((a, b), (c, d)) = (low.split_at(TILE / 4), high.split_at(TILE / 4));
    for ((((four, &a), &b), &c), &d) in to.as_chunks_mut::<4>().0.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *four = [a, b, c, d];
    }
}
