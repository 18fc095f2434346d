//! One table of fields per packet: structure, encoder, decoder and documentation derive from it.

/// A field of a packet or record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// `u8`, `u64`, `f64[3]`, ...
    pub kind: &'static str,
    /// Bytes.
    pub size: usize,
    /// Its unit; `1` where it has none.
    pub unit: &'static str,
    /// What it means, with its domain.
    pub meaning: &'static str,
}

/// A number and its name, of a list of codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// On the wire.
    pub number: u8,
    /// In the documentation.
    pub name: &'static str,
}

/// What a field can be: little endian, without padding.
pub(crate) trait Scalar: Copy {
    const KIND: &'static str;
    const SIZE: usize;
    fn put(self, out: &mut [u8]);
    fn take(bytes: &[u8]) -> Option<Self>;
}

macro_rules! scalars {
    ($($kind:ty)*) => {$(
        impl Scalar for $kind {
            const KIND: &'static str = stringify!($kind);
            const SIZE: usize = size_of::<$kind>();
            fn put(self, out: &mut [u8]) {
                out.copy_from_slice(&self.to_le_bytes());
            }
            fn take(bytes: &[u8]) -> Option<Self> {
                bytes.try_into().ok().map(<$kind>::from_le_bytes)
            }
        }
    )*};
}
scalars!(u8 u16 u32 u64 f64);

macro_rules! byte_arrays {
    ($($size:literal)*) => {$(
        impl Scalar for [u8; $size] {
            const KIND: &'static str = concat!("u8[", $size, "]");
            const SIZE: usize = $size;
            fn put(self, out: &mut [u8]) {
                out.copy_from_slice(&self);
            }
            fn take(bytes: &[u8]) -> Option<Self> {
                bytes.try_into().ok()
            }
        }
    )*};
}
byte_arrays!(1 2 4 7 16 32 56 87);

impl Scalar for [f64; 3] {
    const KIND: &'static str = "f64[3]";
    const SIZE: usize = 24;
    fn put(self, out: &mut [u8]) {
        for (out, x) in out.chunks_exact_mut(8).zip(self) {
            x.put(out);
        }
    }
    fn take(bytes: &[u8]) -> Option<Self> {
        Some([f64::take(bytes.get(..8)?)?, f64::take(bytes.get(8..16)?)?, f64::take(bytes.get(16..24)?)?])
    }
}

/// Appends to a buffer.
#[derive(Debug)]
pub(crate) struct Writer<'a> {
    out: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(out: &'a mut [u8]) -> Self {
        Self { out, at: 0 }
    }

    /// None where the buffer is full.
    pub(crate) fn put<T: Scalar>(&mut self, value: T) -> Option<()> {
        value.put(self.out.get_mut(self.at..self.at + T::SIZE)?);
        self.at += T::SIZE;
        Some(())
    }

    pub(crate) fn written(&self) -> usize {
        self.at
    }
}

/// Takes from the front of a buffer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// None where the buffer is empty.
    pub(crate) fn take<T: Scalar>(&mut self) -> Option<T> {
        let (front, rest) = self.bytes.split_at_checked(T::SIZE)?;
        self.bytes = rest;
        T::take(front)
    }

    /// Passes over bytes; none where there are fewer.
    pub(crate) fn skip(&mut self, count: usize) -> Option<()> {
        self.bytes = self.bytes.get(count..)?;
        Some(())
    }

    pub(crate) fn is_empty(self) -> bool {
        self.bytes.is_empty()
    }
}

macro_rules! packet {
    ($(#[$about:meta])* $name:ident { $($field:ident : $kind:ty, $unit:literal, $meaning:literal;)* }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name { $(#[doc = $meaning] pub $field: $kind,)* }

        impl $name {
            /// Bytes on the wire.
            pub const SIZE: usize = 0 $(+ <$kind as Scalar>::SIZE)*;

            /// Its fields, in the order of the wire.
            pub const FIELDS: &'static [Field] = &[$(Field {
                name: stringify!($field),
                kind: <$kind as Scalar>::KIND,
                size: <$kind as Scalar>::SIZE,
                unit: $unit,
                meaning: $meaning,
            },)*];

            /// None where the buffer is too short.
            pub(crate) fn write(&self, writer: &mut Writer<'_>) -> Option<()> {
                $(writer.put(self.$field)?;)*
                Some(())
            }

            /// None where the buffer is too short.
            pub(crate) fn read(reader: &mut Reader<'_>) -> Option<Self> {
                Some(Self { $($field: reader.take()?,)* })
            }
        }
    };
}
pub(crate) use packet;

/// A packet of numbers alone, which are missing at first.
macro_rules! record {
    ($(#[$about:meta])* $name:ident { $($field:ident : $unit:literal, $meaning:literal;)* }) => {
        packet! { $(#[$about])* $name { $($field: f64, $unit, $meaning;)* } }

        impl $name {
            /// Its numbers, in the order of [`FIELDS`](Self::FIELDS).
            pub fn numbers_mut(&mut self) -> [&mut f64; Self::SIZE / 8] {
                [$(&mut self.$field,)*]
            }

            /// The same.
            #[must_use]
            pub fn numbers(&self) -> [f64; Self::SIZE / 8] {
                [$(self.$field,)*]
            }

            /// None where the buffer is too short, or its records of `size` bytes lack a number.
            pub(crate) fn read_from(reader: &mut Reader<'_>, size: u16) -> Option<Self> {
                let known = Self::read(reader)?;
                reader.skip(usize::from(size).checked_sub(Self::SIZE)?)?;
                Some(known)
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: f64::NAN,)* }
            }
        }
    };
}
pub(crate) use record;
