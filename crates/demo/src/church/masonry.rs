//! Walls, vaults, arcades, supports and furniture, bay by bay.

use super::arch::{PointedArch, rib};
use super::furniture::{self, CAPITAL_HEIGHT};
use super::glass::{self, ChurchWindow, GLASS_SCHEMES};
use super::layout::Church;
use super::model::{ChurchMaterial, ChurchModel};
use super::plan::{
    AISLE_VAULT_RISE, ARCADE_ARCH, BAY_LENGTH, NAVE_VAULT, NAVE_WALL_OFFSETS, OUTER_WALL_OFFSET, SIDES,
};
use super::wall::{BorderLine, WallFrame, WallOpening, WallSection};
use zonal_math::{Vec3, vec3};

impl Church<'_> {
    pub(super) fn floor(&self, m: &mut ChurchModel) {
        let l = self.end();
        let up = vec3(0.0, 0.0, 5.0);
        for (a, b, stuff) in [
            (-OUTER_WALL_OFFSET, -0.75, ChurchMaterial::Tiles),
            (-0.75, 0.75, ChurchMaterial::Carpet),
            (0.75, OUTER_WALL_OFFSET, ChurchMaterial::Tiles),
        ] {
            m.polygon(stuff, &[vec3(a, 0.0, 0.0), vec3(b, 0.0, 0.0), vec3(b, l, 0.0), vec3(a, l, 0.0)], up);
        }
        m.polygon(ChurchMaterial::Tiles, &self.choir(NAVE_WALL_OFFSETS.0, 0.0), up);
    }

    pub(super) fn nave_bay(&self, m: &mut ChurchModel, bay: usize) {
        let vault = self.vault(bay, -NAVE_WALL_OFFSETS.0, NAVE_WALL_OFFSETS.0, NAVE_VAULT.0, NAVE_VAULT.1);
        vault.webs(m);
        m.within(&self.nave(), |m| {
            vault.diagonals(m, &rib(0.22, 0.24));
            vault.transverse(m, self.border(bay + 1), &rib(0.34, 0.32));
        });
        for s in SIDES {
            let frame = self.side(s, NAVE_WALL_OFFSETS.0, bay);
            let head = self.head(0.85, 1.3);
            let window = ChurchWindow {
                frame,
                centre: 0.0,
                sill: 9.75,
                spring: 11.35,
                head,
                lights: 2,
                cell: self.plan.cell,
                leaded: self.plan.fine,
                scheme: &GLASS_SCHEMES[(bay + if s > 0.0 { 0 } else { 3 }) % GLASS_SCHEMES.len()],
            };
            let arcade = self.head(ARCADE_ARCH.0, ARCADE_ARCH.1);
            let wall = WallSection {
                frame,
                ends: (-0.5 * BAY_LENGTH, 0.5 * BAY_LENGTH),
                lower: BorderLine::arch(&arcade, CAPITAL_HEIGHT),
                upper: BorderLine(vault.edge()),
                opening: Some(window.opening()),
            };
            wall.build(m);
            window.build(m);
            let (y0, y1, x) = (self.border(bay), self.border(bay + 1), NAVE_WALL_OFFSETS.0);
            let (a, b) = ((s * (x - 0.09)).min(s * x), (s * (x - 0.09)).max(s * x));
            m.block(ChurchMaterial::Dressed, vec3(a, y0, 8.98), vec3(b, y1, 9.14));
        }
    }

    pub(super) fn aisle_bay(&self, m: &mut ChurchModel, s: f64, bay: usize) {
        let (x0, x1) = if s > 0.0 {
            (NAVE_WALL_OFFSETS.1, OUTER_WALL_OFFSET)
        } else {
            (-OUTER_WALL_OFFSET, -NAVE_WALL_OFFSETS.1)
        };
        let vault = self.vault(bay, x0, x1, CAPITAL_HEIGHT, AISLE_VAULT_RISE);
        vault.webs(m);
        m.within(&self.aisle(s), |m| {
            vault.diagonals(m, &rib(0.16, 0.18));
            if bay + 1 < self.plan.bays {
                vault.transverse(m, self.border(bay + 1), &rib(0.26, 0.24));
            }
        });
        let frame = self.side(s, OUTER_WALL_OFFSET, bay);
        let window = ChurchWindow {
            frame,
            centre: 0.0,
            sill: 1.5,
            spring: 4.6,
            head: self.head(1.0, 1.6),
            lights: 2,
            cell: self.plan.cell,
            leaded: self.plan.fine,
            scheme: &GLASS_SCHEMES[(2 * bay + if s > 0.0 { 1 } else { 2 }) % GLASS_SCHEMES.len()],
        };
        let wall = WallSection {
            frame,
            ends: (-0.5 * BAY_LENGTH, 0.5 * BAY_LENGTH),
            lower: BorderLine::level(0.0),
            upper: BorderLine(vault.edge()),
            opening: Some(window.opening()),
        };
        wall.build(m);
        window.build(m);
    }

    /// The arcade's wall on the side of the aisle, the soffit of its arch, and the moulding towards the nave.
    pub(super) fn arcade(&self, m: &mut ChurchModel, s: f64, bay: usize) {
        let middle = self.border(bay) + 0.5 * BAY_LENGTH;
        let frame = WallFrame::new(
            vec3(s * NAVE_WALL_OFFSETS.1, middle, 0.0),
            vec3(0.0, 1.0, 0.0),
            vec3(s, 0.0, 0.0),
        );
        let arch = self.head(ARCADE_ARCH.0, ARCADE_ARCH.1);
        let vault = self.vault(bay, NAVE_WALL_OFFSETS.1, OUTER_WALL_OFFSET, CAPITAL_HEIGHT, AISLE_VAULT_RISE);
        let wall = WallSection {
            frame,
            ends: (-0.5 * BAY_LENGTH, 0.5 * BAY_LENGTH),
            lower: BorderLine::arch(&arch, CAPITAL_HEIGHT),
            upper: BorderLine(vault.edge()),
            opening: None,
        };
        wall.build(m);
        let points = arch.points();
        let depth = NAVE_WALL_OFFSETS.1 - NAVE_WALL_OFFSETS.0;
        for w in points.windows(2) {
            let at = |p: [f64; 2], d: f64| frame.at(p[0], CAPITAL_HEIGHT + p[1], d);
            m.polygon(
                ChurchMaterial::Dressed,
                &[at(w[0], 0.0), at(w[1], 0.0), at(w[1], depth), at(w[0], depth)],
                frame.at(0.0, CAPITAL_HEIGHT, 0.5 * depth),
            );
        }
        let line: Vec<Vec3> =
            points.iter().map(|p| frame.at(p[0] * 1.03, CAPITAL_HEIGHT + p[1] * 1.03, depth)).collect();
        let profile = [[-0.06, -0.05], [0.02, -0.05], [0.02, 0.09], [-0.03, 0.09], [-0.06, 0.05]];
        m.within(&self.nave(), |m| m.sweep(ChurchMaterial::Dressed, &line, frame.inward, &profile));
    }

    /// Columns, shafts before the walls, and the half piers at both ends of the arcades.
    pub(super) fn supports(&self, m: &mut ChurchModel) {
        let (l, sides) = (self.end(), self.plan.sides);
        for s in SIDES {
            for bay in 1..self.plan.bays {
                let y = self.border(bay);
                furniture::column(
                    m,
                    vec3(s * 0.5 * (NAVE_WALL_OFFSETS.0 + NAVE_WALL_OFFSETS.1), y, 0.0),
                    sides,
                );
                m.within(&self.nave(), |m| {
                    furniture::shaft(
                        m,
                        vec3(s * NAVE_WALL_OFFSETS.0, y, 0.0),
                        CAPITAL_HEIGHT + 0.4,
                        NAVE_VAULT.0,
                        sides / 2,
                    );
                });
                m.within(&self.aisle(s), |m| {
                    furniture::shaft(m, vec3(s * OUTER_WALL_OFFSET, y, 0.0), 0.35, CAPITAL_HEIGHT, sides / 2);
                });
            }
            let (x0, x1) = (
                (s * NAVE_WALL_OFFSETS.0).min(s * NAVE_WALL_OFFSETS.1),
                (s * NAVE_WALL_OFFSETS.0).max(s * NAVE_WALL_OFFSETS.1),
            );
            m.block(ChurchMaterial::Dressed, vec3(x0, 0.0, 0.0), vec3(x1, 0.4, CAPITAL_HEIGHT));
            m.block(ChurchMaterial::Dressed, vec3(x0, l - 0.4, 0.0), vec3(x1, l, CAPITAL_HEIGHT));
        }
        m.within(&self.nave(), |m| {
            for corner in self.choir(NAVE_WALL_OFFSETS.0, 0.0) {
                furniture::shaft(m, corner, 0.35, NAVE_VAULT.0, sides / 2);
            }
        });
    }

    pub(super) fn west(&self, m: &mut ChurchModel) {
        let frame = WallFrame::new(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let rose = WallOpening::Round { centre: 0.0, height: 10.3, radius: 2.4, sides: 4 * self.plan.arc };
        let top = PointedArch::new(NAVE_WALL_OFFSETS.0, NAVE_VAULT.1, self.plan.pieces);
        let door = self.head(1.15, 1.5);
        let portal = WallOpening::Pointed { centre: 0.0, sill: 0.0, spring: 2.4, head: door };
        let (above, crown) = (BorderLine::level(5.0), BorderLine::arch(&top, NAVE_VAULT.0));
        for (lower, upper, opening) in
            [(BorderLine::level(0.0), above.clone(), portal), (above.clone(), crown.clone(), rose)]
        {
            WallSection {
                frame,
                ends: (-NAVE_WALL_OFFSETS.0, NAVE_WALL_OFFSETS.0),
                lower,
                upper,
                opening: Some(opening),
            }
            .build(m);
        }
        glass::rose(m, &frame, &rose, self.plan);
        SIDES.iter().for_each(|s| self.aisle_end(m, *s, 0.0, vec3(0.0, 1.0, 0.0), None));
        let mut leaf = vec![[-1.15, 0.0], [1.15, 0.0]];
        leaf.extend(door.points().into_iter().rev().map(|[x, z]| [x, 2.4 + z]));
        let base: Vec<Vec3> = leaf.iter().map(|p| vec3(p[0], 0.0, p[1])).collect();
        m.prism(ChurchMaterial::Oak, &base, vec3(0.0, 0.1, 0.0));
        let arch: Vec<Vec3> = leaf[2..].iter().map(|p| vec3(p[0], 0.0, p[1])).collect();
        let mut jambs = vec![vec3(1.15, 0.0, 0.0)];
        jambs.extend(arch);
        jambs.push(vec3(-1.15, 0.0, 0.0));
        m.sweep(
            ChurchMaterial::Dressed,
            &jambs,
            vec3(0.0, 1.0, 0.0),
            &[[0.0, -0.2], [0.2, -0.2], [0.2, -0.12], [0.12, 0.0], [0.0, 0.0]],
        );
    }

    /// The end wall of an aisle.
    pub(super) fn aisle_end(
        &self,
        m: &mut ChurchModel,
        s: f64,
        y: f64,
        inward: Vec3,
        window: Option<ChurchWindow>,
    ) {
        let (frame, top) = self.end_of_aisle(s, y, inward);
        let wall = WallSection {
            frame,
            ends: (-top.half, top.half),
            lower: BorderLine::level(0.0),
            upper: BorderLine::arch(&top, CAPITAL_HEIGHT),
            opening: window.as_ref().map(ChurchWindow::opening),
        };
        wall.build(m);
        if let Some(w) = window {
            w.build(m);
        }
    }

    pub(super) fn aisle_east(&self, m: &mut ChurchModel, s: f64) {
        let inward = vec3(0.0, -1.0, 0.0);
        let window = ChurchWindow {
            frame: self.end_of_aisle(s, self.end(), inward).0,
            centre: 0.0,
            sill: 1.6,
            spring: 4.3,
            head: self.head(0.6, 1.0),
            lights: 1,
            cell: self.plan.cell,
            leaded: self.plan.fine,
            scheme: &GLASS_SCHEMES[if s > 0.0 { 4 } else { 0 }],
        };
        self.aisle_end(m, s, self.end(), inward, Some(window));
    }

    pub(super) fn apse(&self, m: &mut ChurchModel) {
        let corners = self.choir(NAVE_WALL_OFFSETS.0, 0.0);
        let axis = vec3(0.0, self.end(), 0.0);
        for k in 0..5 {
            let (a, b) = (corners[k], corners[k + 1]);
            let middle = (a + b) * 0.5;
            let frame = WallFrame::new(middle, b - a, axis - middle);
            let half = 0.5 * (b - a).length();
            let window = ChurchWindow {
                frame,
                centre: 0.0,
                sill: 2.4,
                spring: 7.5,
                head: self.head(0.66, 1.3),
                lights: 1,
                cell: self.plan.cell,
                leaded: self.plan.fine,
                scheme: &GLASS_SCHEMES[[1, 3, 0, 2, 5][k]],
            };
            let wall = WallSection {
                frame,
                ends: (-half, half),
                lower: BorderLine::level(0.0),
                upper: BorderLine::level(NAVE_VAULT.0),
                opening: Some(window.opening()),
            };
            wall.build(m);
            window.build(m);
        }
        self.apse_vault(m);
    }

    pub(super) fn apse_vault(&self, m: &mut ChurchModel) {
        let profile = PointedArch::new(NAVE_WALL_OFFSETS.0, NAVE_VAULT.1, self.plan.pieces);
        let levels: Vec<f64> = profile.points()[..=self.plan.pieces].iter().map(|p| p[1]).collect();
        let below = vec3(0.0, self.end() + 1.0, NAVE_VAULT.0 - 1.0);
        let rings: Vec<Vec<Vec3>> =
            levels.iter().map(|z| self.choir(profile.width(*z), NAVE_VAULT.0 + z)).collect();
        let mut course = 0.0;
        for w in rings.windows(2) {
            let step = (w[1][2] - w[0][2]).length();
            for k in 0..5 {
                let side = |i: usize, r: usize| {
                    (w[r][i], [w[r][i].x + w[r][i].y, course + if r == 0 { 0.0 } else { step }])
                };
                m.textured(
                    ChurchMaterial::Web,
                    &[side(k, 0), side(k + 1, 0), side(k + 1, 1), side(k, 1)],
                    below,
                );
            }
            course += step;
        }
        for k in 1..5 {
            let line: Vec<Vec3> = rings.iter().map(|r| r[k]).collect();
            let out = line[0] - vec3(0.0, self.end(), line[0].z);
            let side = vec3(out.y, -out.x, 0.0).normalized();
            m.within(&self.nave(), |m| m.sweep(ChurchMaterial::Dressed, &line, side, &rib(0.22, 0.24)));
        }
        m.turned(
            ChurchMaterial::Dressed,
            vec3(0.0, self.end(), NAVE_VAULT.0 + NAVE_VAULT.1),
            &[(0.12, -0.42), (0.3, -0.32), (0.32, -0.1), (0.25, 0.01)],
            12,
        );
    }

    pub(super) fn furnish(&self, m: &mut ChurchModel) {
        let l = self.end();
        for (scale, z) in [(0.86, 0.0), (0.64, 0.17)] {
            let mut plan = self.choir(scale * NAVE_WALL_OFFSETS.0, z);
            plan.push(vec3(-scale * NAVE_WALL_OFFSETS.0, l - 1.6 * scale, z));
            plan.push(vec3(scale * NAVE_WALL_OFFSETS.0, l - 1.6 * scale, z));
            m.prism(ChurchMaterial::Dressed, &plan, vec3(0.0, 0.0, 0.17));
        }
        furniture::altar(m, vec3(0.0, l + 0.5, 0.34));
        SIDES.iter().for_each(|s| furniture::candelabrum(m, vec3(s * 1.75, l - 0.3, 0.34)));
        let rows = ((l - 7.0) / 0.98).floor().max(0.0) as usize;
        for row in 0..rows {
            let y = 4.0 + 0.98 * row as f64;
            furniture::bench(m, -3.1, -0.95, y);
            furniture::bench(m, 0.95, 3.1, y);
        }
        for bay in (1..self.plan.bays).step_by(2) {
            let y = self.border(bay) + 0.5 * BAY_LENGTH;
            furniture::chandelier(m, vec3(0.0, y, 4.9), NAVE_VAULT.0 + NAVE_VAULT.1, 8);
        }
    }
}
