//! Numbers as bytes and back, for the stages that a [`zonal_scene::Vault`] keeps: little-endian, lists with their length first.
//!
//! Whoever keeps stages may lose or damage them; a [`Reader`] that meets anything unexpected gives `None`, and the stage is computed.

use zonal_scene::Bands;

/// Writes a stage.
#[derive(Clone, Debug, Default)]
pub struct Pen(Vec<u8>);

impl Pen {
    /// A whole number.
    pub fn int(&mut self, n: usize) {
        self.0.extend((n as u64).to_le_bytes());
    }
    /// Whole numbers.
    pub fn ints(&mut self, list: &[u64]) {
        self.int(list.len());
        list.iter().for_each(|n| self.0.extend(n.to_le_bytes()));
    }
    /// So many numbers of 32 bits.
    pub fn words(&mut self, number: usize, list: impl Iterator<Item = u32>) {
        self.int(number);
        self.0.reserve(4 * number);
        list.for_each(|n| self.0.extend(n.to_le_bytes()));
    }
    /// Numbers, to the bit.
    pub fn reals(&mut self, list: &[f64]) {
        self.int(list.len());
        self.0.reserve(8 * list.len());
        list.iter().for_each(|x| self.0.extend(x.to_le_bytes()));
    }
    /// Triples of numbers, to the bit.
    pub fn triples(&mut self, list: &[Bands]) {
        self.reals(list.as_flattened());
    }
    /// A text.
    pub fn text(&mut self, text: &str) {
        self.int(text.len());
        self.0.extend(text.bytes());
    }
    /// Bytes as they are, their number first.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.int(bytes.len());
        self.0.extend(bytes);
    }
    /// The stage.
    pub fn bytes(self) -> Vec<u8> {
        self.0
    }
}

/// Reads a stage in the order in which it was written.
#[derive(Clone, Debug)]
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// Reads these bytes.
    pub fn new(bytes: &'a [u8]) -> Reader<'a> {
        Reader(bytes)
    }
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(n)?;
        self.0 = tail;
        Some(head)
    }
    /// A whole number.
    pub fn int(&mut self) -> Option<usize> {
        let n = u64::from_le_bytes(self.take(8)?.try_into().ok()?);
        usize::try_from(n).ok()
    }
    /// Whole numbers.
    pub fn ints(&mut self) -> Option<Vec<u64>> {
        let n = self.int()?.checked_mul(8)?;
        Some(self.take(n)?.as_chunks::<8>().0.iter().map(|c| u64::from_le_bytes(*c)).collect())
    }
    /// Numbers of 32 bits, as their bytes.
    pub fn words(&mut self) -> Option<&'a [[u8; 4]]> {
        let n = self.int()?.checked_mul(4)?;
        Some(self.take(n)?.as_chunks().0)
    }
    /// Numbers.
    pub fn reals(&mut self) -> Option<Vec<f64>> {
        let n = self.int()?.checked_mul(8)?;
        Some(self.take(n)?.as_chunks::<8>().0.iter().map(|c| f64::from_le_bytes(*c)).collect())
    }
    /// Triples of numbers.
    pub fn triples(&mut self) -> Option<Vec<Bands>> {
        let flat = self.reals()?;
        flat.len().is_multiple_of(3).then(|| flat.as_chunks::<3>().0.to_vec())
    }
    /// A text.
    pub fn text(&mut self) -> Option<String> {
        String::from_utf8(self.raw()?.to_vec()).ok()
    }
    /// Bytes that [`Pen::raw`] wrote.
    pub fn raw(&mut self) -> Option<&'a [u8]> {
        let n = self.int()?;
        self.take(n)
    }
    /// True when nothing is left.
    pub fn at_end(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_comes_back_and_what_is_cut_does_not() {
        let mut pen = Pen::default();
        pen.int(7);
        pen.triples(&[[0.1, -0.0, f64::INFINITY]]);
        pen.text("ä");
        pen.ints(&[u64::MAX]);
        let bytes = pen.bytes();
        let read = |b: &[u8]| {
            let mut r = Reader::new(b);
            let all = (r.int()?, r.triples()?, r.text()?, r.ints()?);
            r.at_end().then_some(all)
        };
        assert_eq!(read(&bytes), Some((7, vec![[0.1, -0.0, f64::INFINITY]], "ä".into(), vec![u64::MAX])));
        for cut in 0..bytes.len() {
            assert_eq!(read(&bytes[..cut]), None);
        }
        let mut huge = bytes.clone();
        huge[8..16].fill(0xff);
        assert_eq!(read(&huge), None);
    }
}
