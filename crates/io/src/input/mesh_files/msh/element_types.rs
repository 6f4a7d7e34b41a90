//! Gmsh's types of elements: shape and number of nodes. The corners of an element are its first nodes.

/// The shape of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementShape {
    Point,
    Line,
    Triangle,
    Quadrilateral,
    Tetrahedron,
    Hexahedron,
    Prism,
    Pyramid,
}

impl ElementShape {
    /// Dimension of the shape.
    pub(super) fn dimension(self) -> u8 {
        use ElementShape::*;
        match self {
            Point => 0,
            Line => 1,
            Triangle | Quadrilateral => 2,
            Tetrahedron | Hexahedron | Prism | Pyramid => 3,
        }
    }

    /// Number of corners.
    pub(super) fn corners(self) -> usize {
        use ElementShape::*;
        match self {
            Point => 1,
            Line => 2,
            Triangle => 3,
            Quadrilateral | Tetrahedron => 4,
            Pyramid => 5,
            Prism => 6,
            Hexahedron => 8,
        }
    }

    /// The sides of a volume by the indices of its corners, counter-clockwise from outside where the volume is positive.
    pub(super) fn sides(self) -> &'static [&'static [usize]] {
        match self {
            ElementShape::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            ElementShape::Hexahedron => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
            ElementShape::Prism => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            ElementShape::Pyramid => &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            _ => &[],
        }
    }
}

/// A type of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MshElementType {
    pub(super) shape: ElementShape,
    /// Number of nodes.
    pub(super) nodes: usize,
}

/// Numbers of the types of each shape with their nodes.
const ELEMENT_TYPES: [(ElementShape, &[(i64, usize)]); 8] = [
    (ElementShape::Point, &[(15, 1)]),
    (
        ElementShape::Line,
        &[(1, 2), (8, 3), (26, 4), (27, 5), (28, 6), (62, 7), (63, 8), (64, 9), (65, 10), (66, 11)],
    ),
    (
        ElementShape::Triangle,
        &[
            (2, 3),
            (9, 6),
            (20, 9),
            (21, 10),
            (22, 12),
            (23, 15),
            (24, 15),
            (25, 21),
            (42, 28),
            (43, 36),
            (44, 45),
            (45, 55),
            (46, 66),
            (52, 18),
            (53, 21),
            (54, 24),
            (55, 27),
            (56, 30),
        ],
    ),
    (
        ElementShape::Quadrilateral,
        &[
            (3, 4),
            (10, 9),
            (16, 8),
            (36, 16),
            (37, 25),
            (38, 36),
            (39, 12),
            (40, 16),
            (41, 20),
            (47, 49),
            (48, 64),
            (49, 81),
            (50, 100),
            (51, 121),
            (57, 24),
            (58, 28),
            (59, 32),
            (60, 36),
            (61, 40),
        ],
    ),
    (ElementShape::Tetrahedron, &[(4, 4), (11, 10), (29, 20), (30, 35), (31, 56), (32, 22), (33, 28)]),
    (ElementShape::Hexahedron, &[(5, 8), (12, 27), (17, 20)]),
    (ElementShape::Prism, &[(6, 6), (13, 18), (18, 15)]),
    (ElementShape::Pyramid, &[(7, 5), (14, 14), (19, 13)]),
];

impl MshElementType {
    /// The type of a number; none for types that are not read.
    pub(super) fn of_number(number: i64) -> Option<MshElementType> {
        let find = |(shape, types): &(ElementShape, &[(i64, usize)])| {
            let (_, nodes) = types.iter().find(|(n, _)| *n == number)?;
            Some(MshElementType { shape: *shape, nodes: *nodes })
        };
        ELEMENT_TYPES.iter().find_map(find)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_volumes_close() {
        use ElementShape::*;
        for shape in [Tetrahedron, Hexahedron, Prism, Pyramid] {
            let mut edges = Vec::new();
            for side in shape.sides() {
                edges.extend((0..side.len()).map(|k| (side[k], side[(k + 1) % side.len()])));
            }
            assert!(edges.iter().all(|(a, b)| edges.iter().filter(|e| **e == (*b, *a)).count() == 1));
            assert!(edges.iter().all(|(a, _)| *a < shape.corners()));
        }
        assert_eq!(MshElementType::of_number(11), Some(MshElementType { shape: Tetrahedron, nodes: 10 }));
        assert_eq!(MshElementType::of_number(34), None);
    }
}
