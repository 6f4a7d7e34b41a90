//! Solves of the cubes of the Monte Carlo tables against the tables, finer than `zonal validate` and by any engine.
//!
//! Our zones are averaged down to the tables' 10×10 patches a wall and 10³ voxels, and compared with `*_sym` where it exists. Each field has four
//! errors: root mean square and largest of the relative difference over all entries above zero; L2 (RMS of the difference over RMS of the table);
//! and pointwise (RMS of the relative difference over entries above a tenth of the mean). Times are those of the processor for the whole command.

use crate::harness::process::ZonalCommand;
use crate::harness::{Outcome, ScratchFolder, SharedData, is_wanted, percent};
use crate::scenes::table_cubes;
use zonal_io::output;
use zonal_validation::validate::comparisons::montecarlo::cubes::CUBES;
use zonal_validation::validate::comparisons::montecarlo::{TableComparison, TableDifference};

#[derive(clap::Args)]
pub(crate) struct TableCampaign {
    #[command(flatten)]
    data: SharedData,
    #[command(flatten)]
    command: ZonalCommand,
    /// Names of cubes; all by default
    #[arg(long, value_delimiter = ',')]
    cases: Vec<String>,
    /// Voxels along an edge
    #[arg(long, value_delimiter = ',', default_value = "10,20")]
    sizes: Vec<usize>,
    #[arg(long, default_value = "dense")]
    engine: String,
    #[arg(long, default_value_t = 0.01)]
    tolerance: f64,
    #[arg(long, default_value = "auto")]
    zone_basis: String,
}

impl TableCampaign {
    pub(crate) fn run(&self) -> Outcome {
        let tables = self.data.shared.join("reference/montecarlo");
        let scratch = ScratchFolder::new("montecarlo")?;
        let TableCampaign { engine, tolerance, zone_basis, .. } = self;
        let residual = if engine == "dense" { "residual = 1e-12\n" } else { "" };
        let settings = format!("{residual}tolerance = {tolerance}\nzone_basis = \"{zone_basis}\"");
        println!(
            "| case | n³ | zones | s | H rms, max, L2, pointwise | G | block | s.e. H, G | closure rms |"
        );
        println!("|---|---|---|---|---|---|---|---|---|");
        let wanted = CUBES.iter().filter(|c| is_wanted(&self.cases, c.name));
        for (c, n) in wanted.flat_map(|c| self.sizes.iter().map(move |n| (c, *n))) {
            let text = table_cubes::text(c, n, &settings, &tables, &scratch)?;
            let (_, cost, run) = self.command.solve_text(&scratch, &text, &["--engine", engine])?;
            let s = output::read_solution(&run)?;
            let d = TableComparison::new(&s, c, &tables)?;
            let errors = |e: &TableDifference| [e.all.0, e.all.1, e.l2, e.pointwise].map(percent).join(", ");
            let (h, g, block) = (errors(&d.h), errors(&d.g), d.block.as_ref().map_or("–".into(), errors));
            let noise = [d.h.noise, d.g.noise].map(percent).join(", ");
            let (name, zones, seconds) = (c.name, s.zones.len(), cost.processor);
            let closure = s.report.closure.rms.first();
            println!(
                "| {name} | {n} | {zones} | {seconds:.2} | {h} | {g} | {block} | {noise} | {closure:.1e} |"
            );
        }
        Ok(true)
    }
}
