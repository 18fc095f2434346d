use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// The same quantity of `N` worlds. Without an alignment of its own, which would slow down a single world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<const N: usize>(pub(crate) [f64; N]);

/// A decision of every world: all bits set where it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mask<const N: usize>(pub(crate) [u64; N]);

impl<const N: usize> Default for Row<N> {
    fn default() -> Self {
        Self::all(0.0)
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $operator:tt),*) => { $(
        impl<const N: usize> $trait for Row<N> {
            type Output = Self;
            #[inline]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..N {
                    self.0[k] $operator other.0[k];
                }
                self
            }
        }
        impl<const N: usize> $trait<Row<N>> for f64 {
            type Output = Row<N>;
            #[inline]
            fn $method(self, other: Row<N>) -> Row<N> {
                Row::all(self).$method(other)
            }
        }
    )* };
}
lanewise!(Add add +=, Sub sub -=, Mul mul *=, Div div /=);

impl<const N: usize> Neg for Row<N> {
    type Output = Self;
    #[inline]
    fn neg(mut self) -> Self {
        for k in 0..N {
            self.0[k] = -self.0[k];
        }
        self
    }
}

impl<const N: usize> AddAssign for Row<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> Row<N> {
    /// One number in every world.
    #[inline]
    pub(crate) const fn all(x: f64) -> Self {
        Self([x; N])
    }

    #[inline]
    pub(crate) fn abs(mut self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].abs();
        }
        self
    }

    #[inline]
    pub(crate) fn clamp(mut self, least: f64, most: f64) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].clamp(least, most);
        }
        self
    }

    #[inline]
    pub(crate) fn max(mut self, other: f64) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].max(other);
        }
        self
    }

    #[inline]
    pub(crate) fn min(mut self, other: f64) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].min(other);
        }
        self
    }

    #[inline]
    pub(crate) fn copysign(mut self, sign: Self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].copysign(sign.0[k]);
        }
        self
    }

    #[inline]
    pub(crate) fn sqrt(mut self) -> Self {
        for k in 0..N {
            self.0[k] = crate::dispatch::sqrt(self.0[k]);
        }
        self
    }

    #[inline]
    pub(crate) fn less(self, other: Self) -> Mask<N> {
        let mut mask = Mask::NONE;
        for k in 0..N {
            mask.0[k] = if self.0[k] < other.0[k] { !0 } else { 0 };
        }
        mask
    }

    /// Whether it is less or equal.
    #[inline]
    pub(crate) fn at_most(self, other: Self) -> Mask<N> {
        let mut mask = Mask::NONE;
        for k in 0..N {
            mask.0[k] = if self.0[k] <= other.0[k] { !0 } else { 0 };
        }
        mask
    }

    #[inline]
    pub(crate) fn is_finite(self) -> Mask<N> {
        self.abs().at_most(Self::all(f64::MAX))
    }
}

impl<const N: usize> Mask<N> {
    /// In no world.
    pub(crate) const NONE: Self = Self([0; N]);

    /// The first where the mask holds, the second elsewhere.
    #[inline]
    pub(crate) fn select(self, yes: Row<N>, mut no: Row<N>) -> Row<N> {
        for k in 0..N {
            no.0[k] = f64::from_bits((yes.0[k].to_bits() & self.0[k]) | (no.0[k].to_bits() & !self.0[k]));
        }
        no
    }

    /// Whether it holds in any world.
    #[inline]
    pub(crate) fn any(self) -> bool {
        let mut any = 0;
        for k in 0..N {
            any |= self.0[k];
        }
        any != 0
    }

    /// Whether it holds in every world.
    #[inline]
    pub(crate) fn all(self) -> bool {
        !(!self).any()
    }
}

impl<const N: usize> BitAnd for Mask<N> {
    type Output = Self;
    #[inline]
    fn bitand(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] &= other.0[k];
        }
        self
    }
}

impl<const N: usize> BitOr for Mask<N> {
    type Output = Self;
    #[inline]
    fn bitor(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] |= other.0[k];
        }
        self
    }
}

impl<const N: usize> Not for Mask<N> {
    type Output = Self;
    #[inline]
    fn not(mut self) -> Self {
        for k in 0..N {
            self.0[k] = !self.0[k];
        }
        self
    }
}
