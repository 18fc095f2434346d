/// A number or a plain structure of numbers of which several worlds, or several drives, have one each.
pub(crate) trait Abreast: Copy {
    /// Every field of all of them side by side.
    type Rows<const N: usize>: Clone + core::fmt::Debug;

    /// The same in all.
    fn repeated<const N: usize>(self) -> Self::Rows<N>;

    /// That of one.
    fn at<const N: usize>(rows: &Self::Rows<N>, k: usize) -> Self;

    /// Sets that of one.
    fn set<const N: usize>(self, rows: &mut Self::Rows<N>, k: usize);
}

/// Types that stand side by side as they are.
macro_rules! abreast_as_it_is {
    ($($kind:ty),+) => { $(
        impl $crate::lanes::Abreast for $kind {
            type Rows<const N: usize> = [$kind; N];
            #[inline(always)]
            fn repeated<const N: usize>(self) -> [$kind; N] {
                [self; N]
            }
            #[inline(always)]
            fn at<const N: usize>(rows: &[$kind; N], k: usize) -> Self {
                rows[k]
            }
            #[inline(always)]
            fn set<const N: usize>(self, rows: &mut [$kind; N], k: usize) {
                rows[k] = self;
            }
        }
    )+ };
}
abreast_as_it_is!(f64, u8, bool);
pub(crate) use abreast_as_it_is;

/// `abreast!(PointRows of Point { f64: x y; bool: fixed })`: a structure with these fields, and its rows.
macro_rules! abreast {
    ($rows:ident of $one:ident { $($kind:ty: $($field:ident)+);+ }) => {
        #[derive(Debug, Clone)]
        pub(crate) struct $rows<const N: usize> {
            $($(pub(super) $field: <$kind as $crate::lanes::Abreast>::Rows<N>,)+)+
        }

        impl $crate::lanes::Abreast for $one {
            type Rows<const N: usize> = $rows<N>;
            #[inline(always)]
            fn repeated<const N: usize>(self) -> $rows<N> {
                $rows { $($($field: <$kind as $crate::lanes::Abreast>::repeated(self.$field),)+)+ }
            }
            #[inline(always)]
            fn at<const N: usize>(rows: &$rows<N>, k: usize) -> Self {
                $one { $($($field: <$kind as $crate::lanes::Abreast>::at(&rows.$field, k),)+)+ }
            }
            #[inline(always)]
            fn set<const N: usize>(self, rows: &mut $rows<N>, k: usize) {
                $($(<$kind as $crate::lanes::Abreast>::set(self.$field, &mut rows.$field, k);)+)+
            }
        }
    };
}
pub(crate) use abreast;
