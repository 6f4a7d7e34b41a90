//! Values in messages between processes.

use zonal_fourier::Complex64;
use zonal_scene::{Band, Bands};

/// A value of fixed size in messages.
pub(crate) trait Message: Sized + Send {
    /// Bytes of a value.
    fn size() -> usize;
    /// Appends the bytes.
    fn put(&self, out: &mut Vec<u8>);
    /// The value of bytes of that size.
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! number_message {
    ($($t:ty),*) => {$(
        impl Message for $t {
            fn size() -> usize {
                size_of::<$t>()
            }
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn get(bytes: &[u8]) -> Self {
                bytes.try_into().map_or(Self::default(), Self::from_le_bytes)
            }
        }
    )*};
}
number_message!(f64, f32, u64, u32, u16, u8);

impl Message for bool {
    fn size() -> usize {
        1
    }
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }
    fn get(bytes: &[u8]) -> bool {
        bytes.first().is_some_and(|b| *b != 0)
    }
}

impl Message for Bands {
    fn size() -> usize {
        8 * Band::count()
    }
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|x| x.put(out));
    }
    fn get(bytes: &[u8]) -> Bands {
        let mut numbers = bytes.chunks_exact(8).map(f64::get);
        Bands::from_fn(|_| numbers.next().unwrap_or_default())
    }
}

impl Message for Complex64 {
    fn size() -> usize {
        16
    }
    fn put(&self, out: &mut Vec<u8>) {
        [self.re, self.im].put(out);
    }
    fn get(bytes: &[u8]) -> Complex64 {
        let [re, im] = <[f64; 2]>::get(bytes);
        Complex64 { re, im }
    }
}

impl<T: Message, const N: usize> Message for [T; N] {
    fn size() -> usize {
        N * T::size()
    }
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|x| x.put(out));
    }
    fn get(bytes: &[u8]) -> [T; N] {
        std::array::from_fn(|k| T::get(&bytes[k * T::size()..(k + 1) * T::size()]))
    }
}

impl<A: Message, B: Message> Message for (A, B) {
    fn size() -> usize {
        A::size() + B::size()
    }
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
        self.1.put(out);
    }
    fn get(bytes: &[u8]) -> (A, B) {
        let (a, b) = bytes.split_at(A::size());
        (A::get(a), B::get(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_survive_messages() {
        fn check<T: Message + PartialEq + std::fmt::Debug>(value: T) {
            let mut bytes = Vec::new();
            value.put(&mut bytes);
            assert_eq!(bytes.len(), T::size());
            assert_eq!(T::get(&bytes), value);
        }
        check(1.5f64);
        check((7u32, [0.25f32, -3.0]));
        check((Bands::splat(2.0), (true, 9u16)));
    }
}
