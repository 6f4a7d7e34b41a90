//! The unit cubes of the Monte Carlo tables: scenes and table entries.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal_io::output;
use zonal_report::Failure;

/// A unit cube.
pub struct MonteCarloCube {
    /// Short name.
    pub name: &'static str,
    /// File without its ending.
    pub file: &'static str,
    /// Extinction, 1/m; the table's where it is empty.
    kappa: &'static str,
    albedo: f64,
    rho: f64,
    hot: f64,
    gas: f64,
    /// A diffuse box stands inside.
    pub block: bool,
    /// There is a picture of it.
    pub picture: bool,
}

const BASE_CUBE: MonteCarloCube = MonteCarloCube {
    name: "",
    file: "",
    kappa: "1",
    albedo: 0.5,
    rho: 0.5,
    hot: 1.0,
    gas: 0.0,
    block: false,
    picture: false,
};

/// The cubes.
pub const CUBES: [MonteCarloCube; 7] = [
    MonteCarloCube { name: "c0", file: "c0_K1_a0.90_r0.5", albedo: 0.9, picture: true, ..BASE_CUBE },
    MonteCarloCube { name: "c1", file: "c1_K0.1_a0_r0", kappa: "0.1", albedo: 0.0, rho: 0.0, ..BASE_CUBE },
    MonteCarloCube { name: "c3", file: "c3_K1_a0.50_r0", rho: 0.0, ..BASE_CUBE },
    MonteCarloCube { name: "c5", file: "c5_K5_a0.50_r0.5", kappa: "5", ..BASE_CUBE },
    MonteCarloCube {
        name: "c8",
        file: "c8_het_a0.90_r0.5",
        kappa: "",
        albedo: 0.9,
        picture: true,
        ..BASE_CUBE
    },
    MonteCarloCube { name: "c9", file: "c9_occ_K1_a0.50_r0.5", block: true, ..BASE_CUBE },
    MonteCarloCube { name: "c10", file: "c10_emitting_K1_a0.50_r0.5", hot: 0.0, gas: 1.0, ..BASE_CUBE },
];

/// Edge of the patches on the block at most, m: twelve by twelve or sixteen, whole numbers of them in each cell of the table.
const MAX_BLOCK_PATCH_EDGE: f64 = 0.025;

impl MonteCarloCube {
    /// The scene with n³ voxels and n² patches a wall; `solve` are lines of its `[solve]`, `density` the file of its extinction where
    /// [`MonteCarloCube::varies`].
    pub fn text(&self, n: usize, solve: &str, density: &str) -> String {
        let mut t = format!(
            "name = \"{}\"\n[solve]\npatch_size = {}\n{solve}\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = {}\nfaces.x0 = {{ emission = {} }}\n",
            self.name,
            1.0 / n as f64,
            self.rho,
            self.hot
        );
        if self.block {
            let _ = write!(
                t,
                "[[surface]]\nname = \"block\"\nbox = {{ min = [0.4,0.3,0.2], max = [0.7,0.6,0.6] }}\nreflectance = 0.5\npatch_size = {MAX_BLOCK_PATCH_EDGE}\n"
            );
        }
        let kappa = if self.kappa.is_empty() { "0" } else { self.kappa };
        let _ = write!(
            t,
            "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = {kappa}\nalbedo = {}\nemission = {}\n",
            self.albedo, self.gas
        );
        if self.kappa.is_empty() {
            let _ = write!(
                t,
                "[[medium.region]]\ndensity = {{ file = {:?}, min = [0,0,0], max = [1,1,1], scale = 1.0 }}\nalbedo = {}\n",
                density, self.albedo
            );
        }
        t + "[[camera]]\nname = \"inside\"\norigin = [0.9, 0.9, 0.8]\ntarget = [0.1, 0.3, 0.2]\nup = [0, 0, 1]\nfov = 75\n"
    }

    /// True where the extinction is the table's own.
    pub fn varies(&self) -> bool {
        self.kappa.is_empty()
    }

    /// The extinction of the table: shape, and 1/m.
    pub fn extinction(&self, folder: &Path) -> Result<(Vec<usize>, Vec<f64>), Failure> {
        Ok(output::read_array(&self.table(folder), "sigma_t")?)
    }

    /// The file of its table.
    pub fn table(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.npz", self.file))
    }

    /// A quantity of the table with its standard errors: by symmetry where the cube has one.
    pub fn read(&self, folder: &Path, quantity: &str) -> Result<(Vec<f64>, Vec<f64>), Failure> {
        let file = self.table(folder);
        let pair = |kind: &str| -> Option<(Vec<f64>, Vec<f64>)> {
            let of = |end: &str| output::read_array(&file, &format!("{quantity}_{kind}{end}")).ok();
            Some((of("")?.1, of("_se")?.1))
        };
        let none = || Failure::new(format!("{}: no such table; give --reference FOLDER", file.display()));
        pair("sym").or_else(|| pair("exp")).ok_or_else(none)
    }
}
