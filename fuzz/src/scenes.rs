//! Generator of scene texts from bytes, each byte one choice: mostly valid, small, with the extreme values that readers accept.

use std::fmt::Write;
use std::path::PathBuf;
use zonal_io::input::FilesInMemory;

/// Choices from bytes; when the bytes are exhausted, every choice is the first.
struct ByteChoices<'a> {
    bytes: &'a [u8],
    /// True where all bands have one number.
    grey: bool,
}

impl ByteChoices<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.bytes.split_first() else { return 0 };
        self.bytes = rest;
        *first
    }
    fn index_below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n.max(1)
    }
    fn choose<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.index_below(list.len())]
    }
    fn one_in(&mut self, n: usize) -> bool {
        self.index_below(n) == n - 1
    }
    /// A number from 0 to 1 in steps of 1/255.
    fn unit_number(&mut self) -> f64 {
        f64::from(self.byte()) / 255.0
    }
    fn number_in(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit_number()
    }
    /// A number for all bands, or three.
    fn band_values(&mut self, mut one: impl FnMut(&mut Self) -> f64) -> String {
        if !self.grey && self.one_in(3) {
            let [r, g, b] = [one(self), one(self), one(self)];
            return format!("[{r:?},{g:?},{b:?}]");
        }
        let x = one(self);
        format!("{x:?}")
    }
    fn fraction(&mut self) -> f64 {
        let x = self.unit_number();
        self.choose(&[0.5, x, x, 0.0, 1.0, 1.0 - 1e-12, 1e-300])
    }
    fn power(&mut self) -> f64 {
        let x = self.number_in(0.0, 100.0);
        self.choose(&[1.0, x, x, 0.0, 1e-300, 1e-12, 1e12, 1e29])
    }
    fn extinction(&mut self) -> f64 {
        let x = self.number_in(0.0, 4.0);
        self.choose(&[0.5, x, x, x, 30.0, 0.0, 1e-12, 1e-9, 1e-5, 1000.0, 1e8])
    }
    fn kelvin(&mut self) -> f64 {
        let x = self.number_in(200.0, 2000.0);
        self.choose(&[500.0, x, x, x, 1e-3, 1e6, 3000.0])
    }
    fn flux(&mut self) -> f64 {
        let x = self.number_in(-100.0, 1000.0);
        self.choose(&[0.0, x, x, -1e5, 1e5, 1e-9, 1e17])
    }
}

/// Edges from `a` towards two points, of nonzero area.
fn edges(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let at_least = |x: f64, min: f64| if x.abs() < min { min } else { x };
    let e = [at_least(b[0] - a[0], 0.1), 0.0, b[2] - a[2]];
    (e, [0.0, at_least(c[1] - a[1], 0.1), 0.5 * (c[2] - a[2])])
}

/// The text of a scene under construction.
struct SceneWriter<'a> {
    c: ByteChoices<'a>,
    text: String,
    thermal: bool,
    /// Edges of the bounding box.
    size: [f64; 3],
    names: usize,
    /// Surfaces that emit.
    emitting: Vec<String>,
}

/// The text of a scene, and the files that it refers to.
pub fn scene_text(data: &[u8]) -> (String, FilesInMemory) {
    let mut c = ByteChoices { bytes: data, grey: false };
    let thermal = c.one_in(2);
    c.grey = thermal;
    let unit = c.choose(&[1.0, 1.0, 1.0, 1e-4, 1e5]);
    let size = [0; 3].map(|_| unit * c.choose(&[1.0, 2.0, 1.0, 0.1, 3.7, 1.0 + 1e-9]));
    let mut w = SceneWriter { c, text: String::new(), thermal, size, names: 0, emitting: Vec::new() };
    if w.thermal {
        w.text += "mode='thermal'\n";
    }
    let periodic = w.c.one_in(6);
    let kind = w.c.index_below(4);
    w.settings(periodic);
    if w.thermal && w.c.one_in(4) {
        w.c.grey = false;
        w.text += w.c.choose(&[
            "[thermal]\nband_fractions=[0.2,0.3,0.5]\n",
            "[thermal]\nband_fractions=[0.2,0.3,0.1]\nallow_partial=true\n",
            "[thermal]\nweights=[[0.3,1e-4],[0.2,-1e-5],'rest']\nrange=[300,2500]\n",
        ]);
    }
    let mut files = FilesInMemory::new();
    if periodic {
        w.periodic();
    } else {
        w.surfaces(kind, &mut files);
        if w.c.one_in(2) {
            w.medium(false, &mut files);
        }
        w.lights();
    }
    if w.c.one_in(3) {
        w.camera();
    }
    (w.text, files)
}

impl SceneWriter<'_> {
    fn line(&mut self, text: impl AsRef<str>) {
        self.text += text.as_ref();
        self.text.push('\n');
    }
    fn point(&self, share: [f64; 3]) -> String {
        let [x, y, z] = [0, 1, 2].map(|k| share[k] * self.size[k]);
        format!("[{x:?},{y:?},{z:?}]")
    }
    /// A random point in the box, sometimes on its walls.
    fn random_point(&mut self) -> [f64; 3] {
        [0; 3].map(|_| {
            let x = self.c.number_in(0.05, 0.95);
            self.c.choose(&[x, x, x, 0.5, 0.0, 1.0, 1.0 / 3.0])
        })
    }
    fn name(&mut self) -> String {
        self.names += 1;
        format!("n{}", self.names)
    }

    fn settings(&mut self, periodic: bool) {
        self.line("[solve]\ntolerance=0.1");
        let engine = self.c.choose(&["auto", "dense", "rays", "spectral", "auto"]);
        if !(periodic && engine == "rays") {
            self.line(format!("engine='{engine}'"));
        }
        if periodic || self.c.one_in(3) {
            self.line("patch_rule='voxels'");
        } else if self.c.one_in(3) {
            self.line("patch_rule='area'");
        }
        let thick = self.c.choose(&["auto", "linear", "constant"]);
        self.line(format!("zone_basis='{thick}'"));
        if self.c.one_in(3) {
            self.line("closure='restore'");
        }
        if self.c.one_in(4) {
            let on = self.c.one_in(2);
            self.line(format!("discretization_error={on}"));
        }
        if self.c.one_in(6) {
            let n = 1 + self.c.index_below(5);
            self.line(format!("scattering_orders={n}"));
        }
        if !self.thermal && self.c.one_in(3) {
            let groups = self.c.choose(&["each", "all", "auto"]);
            self.line(format!("light_groups='{groups}'"));
        }
        if self.c.one_in(8) {
            self.line("residual=1e-3\nmax_iterations=3");
        }
    }

    /// The optical or thermal keys of a surface, with a prefix (`faces.z0.` or nothing).
    fn surface_properties(&mut self, name: &str, before: &str) {
        if self.thermal {
            let black = self.c.one_in(3);
            let known = match self.c.index_below(4) {
                0 | 1 => format!("temperature={:?}", self.c.kelvin()),
                2 => format!("heat_flux={:?}", self.c.flux()),
                _ => format!("net_power={:?}", self.c.flux()),
            };
            // A surface of given power needs an emissivity above 0.
            let e = match known.starts_with('t') {
                true => 1.0 - self.c.fraction(),
                false => {
                    if black {
                        1.0
                    } else {
                        self.c.number_in(0.1, 1.0)
                    }
                }
            };
            self.line(format!("{before}{known}\n{before}emissivity={e:?}"));
            return;
        }
        let r = self.c.band_values(ByteChoices::fraction);
        self.line(format!("{before}reflectance={r}"));
        if self.c.one_in(3) {
            let e = self.c.band_values(ByteChoices::power);
            self.line(format!("{before}emission={e}"));
            if e.chars().any(|c| ('1'..='9').contains(&c)) {
                self.emitting.push(name.into());
            }
        }
    }

    fn surfaces(&mut self, kind: usize, files: &mut FilesInMemory) {
        if kind != 3 {
            self.line("[[surface]]\nname='room'");
            let max = self.point([1.0; 3]);
            self.line(format!("room={{min=[0,0,0],max={max}}}"));
            if self.c.one_in(3) {
                let wall = self.c.choose(&["x0", "y1", "z1"]);
                self.line(format!("omit=['{wall}']"));
            }
            self.surface_properties("room.x0", "");
            // A face with its own keys has all keys of a surface.
            self.surface_properties("room.z0", "faces.z0.");
        }
        let more = if kind == 0 { 0 } else { 1 + self.c.index_below(3) };
        for _ in 0..more {
            self.shape(files);
        }
        if self.c.one_in(5) {
            self.pane();
        }
    }

    fn shape(&mut self, files: &mut FilesInMemory) {
        let name = self.name();
        self.line(format!("[[surface]]\nname='{name}'"));
        let (a, b, c) = (self.random_point(), self.random_point(), self.random_point());
        let lo = [0, 1, 2].map(|k| a[k].min(b[k]));
        let hi = [0, 1, 2].map(|k| a[k].max(b[k]).max(lo[k] + 0.05));
        match self.c.index_below(5) {
            0 => {
                let (e, f) = edges(a, b, c);
                let (o, e, f) = (self.point(a), self.point(e), self.point(f));
                self.line(format!("rectangle={{origin={o},edge1={e},edge2={f}}}"));
            }
            1 => {
                let (e, f) = edges(a, b, c);
                let corner = |e: [f64; 3]| self.point([0, 1, 2].map(|k| a[k] + e[k]));
                let (a, b, c) = (self.point(a), corner(e), corner(f));
                self.line(format!("triangle={{corners=[{a},{b},{c}]}}"));
            }
            2 => {
                let (lo, hi) = (self.point(lo), self.point(hi));
                let turn = self.c.choose(&[0.0, 0.0, 90.0, 30.0]);
                self.line(format!("box={{min={lo},max={hi},rotate_z_degrees={turn:?}}}"));
            }
            3 => {
                let o = self.point(lo);
                let axis = self.c.index_below(3);
                let edges = [0, 1, 2].map(|k| {
                    let mut e = [0.0; 3];
                    e[k] = (hi[k] - lo[k]).max(0.1);
                    self.point(e)
                });
                let (e, f) = (&edges[(axis + 1) % 3], &edges[(axis + 2) % 3]);
                self.line(format!("rectangle={{origin={o},edge1={e},edge2={f}}}"));
            }
            _ => {
                let file = format!("{name}.obj");
                let mesh = self.boxes(lo, hi, false);
                files.insert(PathBuf::from(&file), mesh.into_bytes());
                let turn = self.c.choose(&[0.0, 0.0, 30.0]);
                self.line(format!("mesh={{file='{file}',rotate_degrees=[0,0,{turn:?}]}}"));
                if self.c.one_in(4) {
                    self.line("solid=false");
                }
            }
        }
        if self.c.one_in(3) {
            self.line("sides='both'");
        }
        self.surface_properties(&name, "");
    }

    /// One box or two nested ones as OBJ, with outward or inward faces. Unless `closed`, a face may be missing.
    fn boxes(&mut self, lo: [f64; 3], hi: [f64; 3], closed: bool) -> String {
        const BOX_FACES: [[usize; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut out = String::new();
        let nested = self.c.one_in(3);
        let missing = if !closed && self.c.one_in(4) { self.c.index_below(6) } else { 6 };
        for level in 0..1 + usize::from(nested) {
            let inward = self.c.one_in(2) && !closed;
            let cut = 0.25 * level as f64;
            for i in 0..8 {
                let p = [0, 1, 2].map(|k| {
                    let t = if i >> k & 1 == 1 { 1.0 - cut } else { cut };
                    self.size[k] * (lo[k] + t * (hi[k] - lo[k]).max(0.05))
                });
                let _ = writeln!(out, "v {:?} {:?} {:?}", p[0], p[1], p[2]);
            }
            for (_, face) in BOX_FACES.iter().enumerate().filter(|(i, _)| *i != missing) {
                let mut corners = face.map(|i| 8 * level + i + 1);
                if inward {
                    corners.reverse();
                }
                let [a, b, c, d] = corners;
                let _ = writeln!(out, "f {a} {b} {c} {d}");
            }
        }
        out
    }

    fn pane(&mut self) {
        let z = self.c.unit_number();
        let corners: Vec<String> = [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]]
            .iter()
            .map(|[x, y]| self.point([*x, *y, z]))
            .collect();
        let x = self.c.band_values(ByteChoices::extinction);
        self.line(format!(
            "[[pane]]\nname='glass'\npolygon=[{}]\nthickness=0.01\nextinction={x}",
            corners.join(",")
        ));
        if self.c.one_in(2) {
            let a = self.c.band_values(ByteChoices::fraction);
            self.line(format!("albedo={a}"));
        }
        if self.thermal && self.c.one_in(2) {
            let t = self.c.kelvin();
            self.line(format!("temperature={t:?}"));
        }
    }

    fn medium(&mut self, periodic: bool, files: &mut FilesInMemory) {
        let max = self.point([1.0; 3]);
        let cells = match periodic {
            true => [1 + self.c.index_below(2), 1 + self.c.index_below(2), 1 + self.c.index_below(6)],
            false => [0; 3].map(|_| 1 + self.c.index_below(4)),
        };
        let x = self.c.band_values(ByteChoices::extinction);
        self.line(format!("[medium]\nmin=[0,0,0]\nmax={max}\ncells={cells:?}\nextinction={x}"));
        if self.c.one_in(2) {
            let a = self.c.band_values(ByteChoices::fraction);
            self.line(format!("albedo={a}"));
        }
        if self.thermal {
            let known = match self.c.index_below(4) {
                0 => format!("temperature={:?}", self.c.kelvin()),
                1 => format!("heat_source={:?}", self.c.flux()),
                _ => "heat_source=0".into(),
            };
            self.line(known);
        } else if self.c.one_in(3) {
            let e = self.c.band_values(ByteChoices::power);
            self.line(format!("emission={e}"));
        }
        if !periodic && self.c.one_in(3) {
            let (a, b) = (self.random_point(), self.random_point());
            let lo = self.point([0, 1, 2].map(|k| a[k].min(b[k])));
            let hi = self.point([0, 1, 2].map(|k| a[k].max(b[k]) + 0.05));
            let x = self.c.band_values(ByteChoices::extinction);
            self.line("[[medium.region]]");
            if self.c.one_in(3) {
                let mesh = self.boxes([0.2; 3], [0.7, 0.8, 0.9], true);
                files.insert(PathBuf::from("region.obj"), mesh.into_bytes());
                self.line("mesh={file='region.obj'}");
            } else {
                self.line(format!("box={{min={lo},max={hi}}}"));
            }
            self.line(format!("extinction={x}"));
            if self.thermal && self.c.one_in(2) {
                let t = self.c.kelvin();
                self.line(format!("temperature={t:?}"));
            }
        }
    }

    fn periodic(&mut self) {
        let axes = self.c.index_below(6);
        self.line(
            [
                "[boundary]\nx='periodic'\ny='periodic'",
                "[boundary]\nx='periodic'",
                "[boundary]\ny='periodic'",
                "[boundary]\nx='symmetry'\ny='periodic'",
                "[boundary]\nx0='symmetry'",
                "[boundary]\nx1='symmetry'\ny0='symmetry'",
            ][axes],
        );
        let max = self.point([1.0; 3]);
        self.line(format!("[[surface]]\nname='room'\nroom={{min=[0,0,0],max={max}}}"));
        self.line(
            [
                "omit=['x0','x1','y0','y1']",
                "omit=['x0','x1']",
                "omit=['y0','y1']",
                "omit=['x0','x1','y0','y1']",
                "omit=['x0']",
                "omit=['x1','y0']",
            ][axes],
        );
        self.surface_properties("room.z1", "");
        self.surface_properties("room.z0", "faces.z0.");
        self.medium(true, &mut FilesInMemory::new());
    }

    fn lights(&mut self) {
        if self.thermal {
            if self.c.one_in(3) {
                let t = self.c.kelvin();
                self.line(format!("[surroundings]\ntemperature={t:?}"));
            }
            return;
        }
        if self.c.one_in(3) {
            let e = self.c.band_values(ByteChoices::power);
            self.line(format!("[surroundings]\nradiance={e}"));
        }
        for _ in 0..self.c.index_below(3) {
            let e = self.c.band_values(ByteChoices::power);
            match self.c.index_below(3) {
                0 => {
                    let d = self.random_point().map(|x| x - 0.6);
                    let width = self.c.choose(&[0.53, 0.0, 20.0, 170.0]);
                    self.line(format!(
                        "[[light]]\nkind='sun'\ndirection={d:?}\nirradiance={e}\nangular_diameter={width:?}"
                    ));
                }
                1 => self.line(format!("[[light]]\nkind='sky'\nradiance={e}")),
                _ => {
                    let n = self.c.index_below(self.emitting.len());
                    if n < self.emitting.len() {
                        let name = self.emitting.remove(n);
                        self.line(format!("[[light]]\nkind='emitter'\nsurface='{name}'"));
                    }
                }
            }
        }
    }

    fn camera(&mut self) {
        let (from, to) = (self.random_point(), self.random_point());
        let (from, to) = (self.point(from), self.point(to));
        self.line(format!("[[camera]]\nname='c'\norigin={from}\ntarget={to}"));
        if self.c.one_in(4) {
            let f = 0.05 * self.size[0];
            self.line(format!("aperture={f:?}"));
        }
    }
}
