//! STL as text: `solid NAME`, then for each facet its normal and three vertices, then `endsolid`. Keywords in any case, blanks and line ends anywhere.

use super::facets::StlBuilder;
use crate::input::reading::error::FileFault;
use zonal_math::Vec3;

/// Reads all solids of a text.
pub(super) fn read(file: &str, text: &str, builder: &mut StlBuilder) -> Result<(), FileFault> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = AsciiReader { file, lines: text.lines(), rest: "", line: 0 };
    while let Some(word) = reader.next_word() {
        if !word.eq_ignore_ascii_case("solid") {
            return Err(reader.unexpected(word, "solid"));
        }
        let part = builder.part(reader.rest_of_line());
        loop {
            match reader.require("facet or endsolid")? {
                word if word.eq_ignore_ascii_case("endsolid") => break,
                word if word.eq_ignore_ascii_case("facet") => {
                    let (normal, corners) = reader.facet()?;
                    builder.push(part, normal, corners);
                }
                word => return Err(reader.unexpected(word, "facet or endsolid")),
            }
        }
        reader.rest_of_line();
    }
    Ok(())
}

/// The words of a text with the number of their line.
struct AsciiReader<'a> {
    file: &'a str,
    lines: std::str::Lines<'a>,
    /// What is left of the current line.
    rest: &'a str,
    /// Number of the current line, from 1.
    line: usize,
}

impl<'a> AsciiReader<'a> {
    fn fault(&self, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.file, self.line.max(1), message)
    }

    fn unexpected(&self, word: &str, wanted: &str) -> FileFault {
        self.fault(format!("'{word}' stands where STL has {wanted}; mend this line or export the mesh again"))
    }

    fn next_word(&mut self) -> Option<&'a str> {
        loop {
            self.rest = self.rest.trim_start();
            if !self.rest.is_empty() {
                let end = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
                let (word, rest) = self.rest.split_at(end);
                self.rest = rest;
                return Some(word);
            }
            self.rest = self.lines.next()?;
            self.line += 1;
        }
    }

    /// The rest of the line, without blanks around it.
    fn rest_of_line(&mut self) -> &'a str {
        std::mem::take(&mut self.rest).trim()
    }

    /// The next word; an error names what is missing.
    fn require(&mut self, wanted: &str) -> Result<&'a str, FileFault> {
        self.next_word().ok_or_else(|| {
            self.fault(format!("this file is cut short: {wanted} is missing; export the mesh again"))
        })
    }

    fn keyword(&mut self, wanted: &str) -> Result<(), FileFault> {
        match self.require(wanted)? {
            word if word.eq_ignore_ascii_case(wanted) => Ok(()),
            word => Err(self.unexpected(word, wanted)),
        }
    }

    /// Three numbers, finite or not.
    fn numbers(&mut self) -> Result<Vec3, FileFault> {
        let mut out = [0.0; 3];
        for x in &mut out {
            let word = self.require("a number")?;
            *x = word.parse().map_err(|_| self.unexpected(word, "a number"))?;
        }
        Ok(Vec3::from_array(out))
    }

    /// Normal and corners behind the word `facet`.
    fn facet(&mut self) -> Result<(Vec3, [Vec3; 3]), FileFault> {
        self.keyword("normal")?;
        let normal = self.numbers()?;
        self.keyword("outer")?;
        self.keyword("loop")?;
        let mut corners = [Vec3::ZERO; 3];
        for corner in &mut corners {
            self.keyword("vertex")?;
            *corner = self.numbers()?;
            if !corner.is_finite() {
                return Err(self.fault("a vertex is not finite; mend this line or export the mesh again"));
            }
        }
        self.keyword("endloop")?;
        self.keyword("endfacet")?;
        Ok((normal, corners))
    }
}
