use super::row::{Mask, Row};
use core::ops::{Add, Index, IndexMut, Mul, Sub};

/// A vector in space in every world.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Vector<const N: usize>(pub(crate) [Row<N>; 3]);

/// Axes of a frame, as columns in the frame they are written in, in every world.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Frame<const N: usize>(pub(crate) [Vector<N>; 3]);

impl<const N: usize> Index<usize> for Vector<N> {
    type Output = Row<N>;
    #[inline(always)]
    fn index(&self, k: usize) -> &Row<N> {
        &self.0[k]
    }
}

impl<const N: usize> IndexMut<usize> for Vector<N> {
    #[inline(always)]
    fn index_mut(&mut self, k: usize) -> &mut Row<N> {
        &mut self.0[k]
    }
}

impl<const N: usize> Add for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self([self[0] + b[0], self[1] + b[1], self[2] + b[2]])
    }
}

impl<const N: usize> Sub for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self([self[0] - b[0], self[1] - b[1], self[2] - b[2]])
    }
}

impl<const N: usize> Mul<Vector<N>> for Row<N> {
    type Output = Vector<N>;
    #[inline(always)]
    fn mul(self, a: Vector<N>) -> Vector<N> {
        Vector([self * a[0], self * a[1], self * a[2]])
    }
}

impl<const N: usize> Vector<N> {
    /// One vector in every world.
    #[inline(always)]
    pub(crate) fn all([x, y, z]: [f64; 3]) -> Self {
        Self([Row::all(x), Row::all(y), Row::all(z)])
    }

    /// That of one world.
    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> [f64; 3] {
        [self[0].0[k], self[1].0[k], self[2].0[k]]
    }

    /// Sets that of one world.
    #[inline(always)]
    pub(crate) fn set(&mut self, k: usize, [x, y, z]: [f64; 3]) {
        (self[0].0[k], self[1].0[k], self[2].0[k]) = (x, y, z);
    }

    #[inline(always)]
    pub(crate) fn dot(self, b: Self) -> Row<N> {
        self[0] * b[0] + self[1] * b[1] + self[2] * b[2]
    }

    #[inline(always)]
    pub(crate) fn cross(self, b: Self) -> Self {
        let a = self;
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    #[inline(always)]
    pub(crate) fn norm(self) -> Row<N> {
        self.dot(self).sqrt()
    }

    /// The first where the mask holds, the second elsewhere.
    #[inline(always)]
    pub(crate) fn select(mask: Mask<N>, yes: Self, no: Self) -> Self {
        let pick = |k: usize| mask.select(yes[k], no[k]);
        Self([pick(0), pick(1), pick(2)])
    }
}

impl<const N: usize> Frame<N> {
    /// Sets that of one world.
    #[inline(always)]
    pub(crate) fn set(&mut self, k: usize, frame: [[f64; 3]; 3]) {
        for (axis, world) in self.0.iter_mut().zip(frame) {
            axis.set(k, world);
        }
    }

    /// That of one world.
    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> [[f64; 3]; 3] {
        [self.0[0].at(k), self.0[1].at(k), self.0[2].at(k)]
    }

    /// `F v`: from the frame to the frame in which its axes are given.
    #[inline(always)]
    pub(crate) fn rotate(&self, v: Vector<N>) -> Vector<N> {
        let [x, y, z] = self.0;
        Vector([
            x[0] * v[0] + y[0] * v[1] + z[0] * v[2],
            x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
            x[2] * v[0] + y[2] * v[1] + z[2] * v[2],
        ])
    }

    /// `F^T v`, the inverse of [`rotate`](Self::rotate).
    #[inline(always)]
    pub(crate) fn unrotate(&self, v: Vector<N>) -> Vector<N> {
        Vector([self.0[0].dot(v), self.0[1].dot(v), self.0[2].dot(v)])
    }

    /// Product of two rotations: the axes of `inner` are given in this frame.
    #[inline(always)]
    pub(crate) fn compose(&self, inner: &Self) -> Self {
        Self([self.rotate(inner.0[0]), self.rotate(inner.0[1]), self.rotate(inner.0[2])])
    }

    #[inline(always)]
    pub(crate) fn transpose(&self) -> Self {
        let row = |k: usize| Vector([self.0[0][k], self.0[1][k], self.0[2][k]]);
        Self([row(0), row(1), row(2)])
    }

    /// Turned about its own z by an angle given as (sine, cosine).
    #[inline(always)]
    pub(crate) fn turn_about_z(&self, (sine, cosine): (Row<N>, Row<N>)) -> Self {
        let [x, y, z] = self.0;
        Self([cosine * x + sine * y, cosine * y + -sine * x, z])
    }
}
