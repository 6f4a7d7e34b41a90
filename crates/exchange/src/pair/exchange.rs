//! The prepared state from which the exchange of any pair follows.

use super::periodic_images::PeriodicFactors;
use super::prepared_zone::{PreparedZones, ZoneCaching};
use super::settings::PairSettings;
use super::strip_images::StripImages;
use super::subcells::subcell_table;
use crate::aligned::FactorCache;
use crate::pair::visibility::occlusion::Occlusion;
use crate::pair::visibility::path_media::PathMedia;
use crate::pair::visibility::visibility_uncertainty::VisibilityUncertainty;
use crate::polygon::PreparedPlates;
use zonal_math::Vec3;
use zonal_scene::SUBCELLS;
use zonal_scene::{Scene, VoxelGrid, Zones};
use zonal_transport::Transport;

/// Exchange of the zones of a scene.
pub struct Exchange<'a> {
    pub(super) zones: &'a Zones,
    pub(super) transport: &'a Transport<'a>,
    pub(super) prepared: PreparedZones<'a>,
    pub(super) cache: FactorCache,
    pub(super) settings: PairSettings,
    /// The patches, prepared for pairs in any position.
    pub(super) plates: PreparedPlates,
    pub(super) voxel_grid: Option<&'a VoxelGrid>,
    pub(super) tolerance: f64,
    /// The medium on the paths of each pair.
    pub(super) media: PathMedia<'a>,
    pub(super) occlusion: Occlusion<'a>,
    /// Some pane can stand between two zones.
    pub(super) panes_between: bool,
    /// The factors of a periodic scene.
    pub(super) images: Option<PeriodicFactors>,
    /// The cross-section of a periodic scene without a medium.
    pub(super) strips: Option<StripImages>,
    /// Undetected partial occlusion of pairs whose rays all agree.
    pub(super) uncertainty: VisibilityUncertainty,
    /// Factors of sub-cells by their offset, with the means of r, r² and r³.
    pub(super) subcells: Vec<[f64; 4]>,
}

impl<'a> Exchange<'a> {
    /// Prepares the exchange of `zones`, which were built from `scene`.
    pub fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> Exchange<'a> {
        Exchange::with_settings(scene, zones, transport, PairSettings::default())
    }

    /// Prepares the exchange with given settings.
    pub fn with_settings(
        scene: &'a Scene,
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        settings: PairSettings,
    ) -> Exchange<'a> {
        let cell = scene.voxel_grid().map_or(Vec3::ZERO, |v| v.cell());
        let cache = FactorCache::new(settings.aligned_tolerance);
        let subcells = if zones.voxels.cut_count() > 0 {
            subcell_table(cell * (1.0 / SUBCELLS as f64), &cache)
        } else {
            Vec::new()
        };
        let caching = if settings.keep_zones { ZoneCaching::All } else { ZoneCaching::None };
        let prepared = PreparedZones::new(scene, zones, caching);
        let occlusion = Occlusion::new(transport);
        let uncertainty = VisibilityUncertainty::sampled(&prepared, &occlusion, &settings);
        Exchange {
            zones,
            transport,
            prepared,
            cache,
            settings,
            plates: PreparedPlates::new(&zones.patches.iter().map(|p| p.plate).collect::<Vec<_>>()),
            voxel_grid: scene.voxel_grid(),
            tolerance: scene.options().tolerance,
            media: PathMedia::new(scene, zones, transport),
            occlusion,
            panes_between: transport.has_interior_panes(),
            images: PeriodicFactors::of(scene),
            strips: StripImages::of(scene, zones),
            uncertainty,
            subcells,
        }
    }
}
